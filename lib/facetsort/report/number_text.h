// Numbers for people: a few significant digits, no exponents, the same in every locale. Internal to report and
// our programs.
#pragma once

#include <cstddef>
#include <string>

namespace facetsort {

// `value` with exactly `decimals` digits after the point.
std::string fixed_text(double value, int decimals);
// A share as percent without the sign: "0" for exactly 0 and nothing else, "<0.0001", "0.0082", "4.63", "54.3",
// ">99.9", "100" for exactly 1.
std::string percent_text(double rate);
// "0", "<0.001", "0.123", "4.63", "54.3", "1240".
std::string milliseconds_text(double milliseconds);
// "512 B", "3.4 KiB", "1.2 GiB".
std::string bytes_text(std::size_t bytes);
// "70,580".
std::string count_text(std::size_t count);

}  // namespace facetsort
