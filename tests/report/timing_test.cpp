#include "facetsort/report/timing.h"

#include <gtest/gtest.h>

namespace facetsort {
namespace {

TEST(MedianAndSpread, Quartiles) {
  const Timing odd = median_and_spread({5, 1, 4, 2, 3});
  EXPECT_EQ(odd.median_ms, 3);
  EXPECT_EQ(odd.spread_ms, 2);  // 4 - 2
  const Timing even = median_and_spread({4, 1, 3, 2});
  EXPECT_EQ(even.median_ms, 2.5);
  EXPECT_EQ(even.spread_ms, 1.5);  // 3.25 - 1.75
  const Timing one = median_and_spread({7});
  EXPECT_EQ(one.median_ms, 7);
  EXPECT_EQ(one.spread_ms, 0);
}

TEST(MedianAndSpread, OneSlowRunChangesNothing) {
  EXPECT_EQ(median_and_spread({1, 1, 1, 1, 1000}).median_ms, 1);
  EXPECT_EQ(median_and_spread({1, 1, 1, 1, 1000}).spread_ms, 0);
}

TEST(TimeMedian, RunsAsOftenAsAsked) {
  int runs = 0;
  const Timing timing = time_median([&] { ++runs; }, 5);
  EXPECT_EQ(runs, 5);
  EXPECT_GE(timing.median_ms, 0);
  EXPECT_GE(timing.spread_ms, 0);
}

TEST(TimeMedian, RunsOnceWhereThereIsNoTime) {
  int runs = 0;
  time_median([&] { ++runs; }, 5, 0);
  EXPECT_EQ(runs, 1);
}

TEST(TimeMedian, CountsOnlyTheRuns) {
  // A clock that sees at least the time for which each run waits by the same clock.
  const Timing timing = time_median(
      [] {
        const auto begin = std::chrono::steady_clock::now();
        while (std::chrono::steady_clock::now() - begin < std::chrono::milliseconds(2)) {
        }
      },
      3);
  EXPECT_GE(timing.median_ms, 2);
}

}  // namespace
}  // namespace facetsort
