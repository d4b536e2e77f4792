#include "facetsort/report/number_text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace facetsort {
namespace {

// Three significant digits, but no more than `most_decimals` after the point.
std::string three_digits(double value, int most_decimals) {
  const double unit = std::pow(10, std::floor(std::log10(value)) - 2);  // of the third digit
  const double magnitude = std::floor(std::log10(value + unit / 2));    // 9.996 becomes 10.0, not 10.00
  return fixed_text(value, std::clamp(2 - static_cast<int>(magnitude), 0, most_decimals));
}

}  // namespace

std::string fixed_text(double value, int decimals) {
  std::array<char, 400> buffer;  // the largest double has 309 digits before the point
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, decimals);
  return {buffer.data(), end.ptr};
}

std::string percent_text(double rate) {
  const double percent = 100 * rate;
  if (percent == 0) return "0";
  if (percent < 0.0001) return "<0.0001";
  if (percent < 100 && percent >= 99.95) return ">99.9";
  return three_digits(percent, 4);
}

std::string milliseconds_text(double milliseconds) {
  if (milliseconds == 0) return "0";
  if (milliseconds < 0.001) return "<0.001";
  return three_digits(milliseconds, 3);
}

std::string bytes_text(std::size_t bytes) {
  if (bytes < 1024) return std::to_string(bytes) + " B";
  double value = static_cast<double>(bytes) / 1024;
  const char* unit = " KiB";
  for (const char* larger : {" MiB", " GiB", " TiB"}) {
    if (value < 1024) break;
    value /= 1024;
    unit = larger;
  }
  return fixed_text(value, value < 10 ? 1 : 0) + unit;
}

std::string count_text(std::size_t count) {
  std::string text = std::to_string(count);
  for (std::size_t place = text.size(); place > 3; place -= 3) text.insert(place - 3, 1, ',');
  return text;
}

}  // namespace facetsort
