#include "facetsort/mesh/text.h"

#include <cmath>
#include <limits>
#include <system_error>

namespace facetsort::text {

std::optional<float> parse_float(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* const last = word.data() + word.size();
  float value = 0;
  auto [end, error] = std::from_chars(word.data(), last, value);
  if (end != last || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc{}) return value;
  // Out of float's range, on which side from_chars does not say. A double reaches far enough to tell, or else the
  // exponent does.
  double wide = 0;
  error = std::from_chars(word.data(), last, wide).ec;
  const bool large =
      error == std::errc{} ? std::abs(wide) > 1 : word.find("e-") == word.npos && word.find("E-") == word.npos;
  const float magnitude = large ? std::numeric_limits<float>::infinity() : std::abs(static_cast<float>(wide));
  return word[0] == '-' ? -magnitude : magnitude;
}

Lines::Lines(std::string_view text, Syntax syntax)
    : text_(text), syntax_(syntax), newline_(text.find('\n') == text.npos ? '\r' : '\n') {}

bool Lines::next() {
  words_.clear();
  bool continued = false;
  while (offset_ < text_.size()) {
    ++number_;
    std::size_t end = text_.find(newline_, offset_);
    cut_ = end == text_.npos;
    if (cut_) end = text_.size();
    std::string_view line = text_.substr(offset_, end - offset_);
    offset_ = cut_ ? end : end + 1;
    if (syntax_.comment != '\0') line = line.substr(0, line.find(syntax_.comment));
    while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
    continued = syntax_.continuation && !line.empty() && line.back() == '\\';
    if (continued) line.remove_suffix(1);
    for (std::size_t begin = 0; begin < line.size();) {
      if (is_space(line[begin])) {
        ++begin;
        continue;
      }
      std::size_t word_end = begin;
      while (word_end < line.size() && !is_space(line[word_end])) ++word_end;
      words_.push_back(line.substr(begin, word_end - begin));
      begin = word_end;
    }
    if (!words_.empty() && !continued) return true;
  }
  return !words_.empty();
}

std::string_view Lines::rest_after(std::size_t i) const {
  if (i + 1 >= words_.size()) return {};
  const char* const begin = words_[i + 1].data();
  const char* const end = words_.back().data() + words_.back().size();
  return {begin, static_cast<std::size_t>(end - begin)};
}

}  // namespace facetsort::text
