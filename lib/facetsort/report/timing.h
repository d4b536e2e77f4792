// Run times that can be compared: medians of repeated runs, with their spread.
#pragma once

#include <chrono>
#include <cstddef>
#include <utility>
#include <vector>

#include "facetsort/report/row.h"

namespace facetsort {

// Median of the samples and the distance between their quartiles, both interpolated between neighbours.
// Precondition: at least one sample.
Timing median_and_spread(std::vector<double> milliseconds);

// Calls `run` at least `min_repeats` times, and again until `max_seconds` have passed in all, and times each call by
// the steady clock. There is no untimed call first: where the first one allocates, make it before.
// Precondition: min_repeats >= 1.
template <typename Callable>
Timing time_median(Callable&& run, std::size_t min_repeats, double max_seconds) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> milliseconds;
  const Clock::time_point begin = Clock::now();
  Clock::time_point now = begin;
  while (milliseconds.size() < min_repeats || std::chrono::duration<double>(now - begin).count() < max_seconds) {
    const Clock::time_point start = Clock::now();
    run();
    now = Clock::now();
    milliseconds.push_back(std::chrono::duration<double, std::milli>(now - start).count());
  }
  return median_and_spread(std::move(milliseconds));
}

// The same, but calls `run` at most `most_repeats` times, once at least, and not again when `max_seconds` have passed:
// for what may take too long to be repeated often.
// Precondition: most_repeats >= 1.
template <typename Callable>
Timing time_median_within(Callable&& run, std::size_t most_repeats, double max_seconds) {
  using Clock = std::chrono::steady_clock;
  std::vector<double> milliseconds;
  const Clock::time_point begin = Clock::now();
  Clock::time_point now = begin;
  do {
    const Clock::time_point start = Clock::now();
    run();
    now = Clock::now();
    milliseconds.push_back(std::chrono::duration<double, std::milli>(now - start).count());
  } while (milliseconds.size() < most_repeats && std::chrono::duration<double>(now - begin).count() < max_seconds);
  return median_and_spread(std::move(milliseconds));
}

}  // namespace facetsort
