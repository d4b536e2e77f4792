// Run times that can be compared: medians of repeated runs, with their spread.
#pragma once

#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include "facetsort/report/row.h"

namespace facetsort {

// What runs as long as this is not repeated again: its time is known well enough, and people wait.
inline constexpr double most_repeating_seconds = 1;

// Median of the samples and the distance between their quartiles, both interpolated between neighbours.
// Precondition: at least one sample.
Timing median_and_spread(std::vector<double> milliseconds);

// Calls `run` `repeats` times, or fewer, but at least once, where `max_seconds` have passed in all, and times each call
// by the steady clock. There is no untimed call first: where the first one allocates, make it before.
// Precondition: repeats >= 1.
template <typename Callable>
Timing time_median(Callable&& run, std::size_t repeats, double max_seconds = most_repeating_seconds) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> milliseconds;
  const Clock::time_point begin = Clock::now();
  Clock::time_point now = begin;
  do {
    const Clock::time_point start = Clock::now();
    run();
    now = Clock::now();
    milliseconds.push_back(std::chrono::duration<double, std::milli>(now - start).count());
  } while (milliseconds.size() < repeats && std::chrono::duration<double>(now - begin).count() < max_seconds);
  return median_and_spread(std::move(milliseconds));
}

}  // namespace facetsort
