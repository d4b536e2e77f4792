// Timing of phases.
#pragma once

#include <chrono>
#include <utility>

namespace facetsort {

class Stopwatch {
 public:
  // Milliseconds of wall clock since it was made, or since the last lap.
  double lap() {
    const Clock::time_point now = Clock::now();
    return std::chrono::duration<double, std::milli>(now - std::exchange(start_, now)).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace facetsort
