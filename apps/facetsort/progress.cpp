#include "progress.h"

#include <unistd.h>

#include <cmath>
#include <iostream>

#include "output.h"

namespace facetsort {
namespace {

constexpr const char* erase_line = "\r\x1b[K";
// Before this much is done an estimate would be a guess.
constexpr double least_done = 0.02;

std::string time_left_text(double seconds) {
  const long left = std::lround(seconds);
  return left < 90 ? std::to_string(left) + " s" : std::to_string((left + 30) / 60) + " min";
}

}  // namespace

Progress::Progress(double work) : work_(work), is_terminal_(isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() {
  if (is_terminal_) std::cerr << erase_line << std::flush;
}

void Progress::show(const std::string& step) {
  if (!is_terminal_) return;
  const double share = done_ / work_;
  std::string line = std::to_string(std::lround(100 * share)) + " %";
  if (share >= least_done) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    line += ", about " + time_left_text(seconds * (1 - share) / share) + " left";
  }
  std::cerr << erase_line << printable(line + ": " + step) << std::flush;
}

}  // namespace facetsort
