// Text mesh files as lines of words, and numbers out of words: independent of any locale, and strict, so that "12abc"
// is no number. Internal to the readers.
#pragma once

#include <charconv>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace facetsort::text {

inline bool is_space(char c) {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

// The whole word as an integer; a leading + is allowed.
template <typename Integer>
std::optional<Integer> parse_integer(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  Integer value{};
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return value;
}

// The whole word as the nearest float: nan and inf are numbers here, what is too large is infinite, what is too small
// is 0.
std::optional<float> parse_float(std::string_view word);

// Iterates over the lines that have a word on them. The text must outlive it.
class Lines {
 public:
  struct Syntax {
    char comment = '\0';        // starts a comment that runs to the end of its line
    bool continuation = false;  // a backslash at the end of a line joins the next one to it
  };

  explicit Lines(std::string_view text) : Lines(text, Syntax{}) {}
  Lines(std::string_view text, Syntax syntax);

  // Goes to the next line that has a word; false at the end.
  bool next();
  const std::vector<std::string_view>& words() const { return words_; }
  // What stands behind word i, up to the last word: names may have spaces in them.
  std::string_view rest_after(std::size_t i) const;
  // Of the current line, from 1. At the end, of the last line.
  std::size_t number() const { return number_; }
  // Whether the text ended before this line did: it may be cut short.
  bool is_cut() const { return cut_; }

 private:
  std::string_view text_;
  Syntax syntax_;
  char newline_;
  std::size_t offset_ = 0, number_ = 0;
  bool cut_ = false;
  std::vector<std::string_view> words_;
};

}  // namespace facetsort::text
