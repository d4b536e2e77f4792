// The little of oneTBB that the library uses. Work runs in the caller's task arena: to choose a thread count, call
// the library from tbb::task_arena(n).execute(...).
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace facetsort {

// Calls body(begin, end) on disjoint ranges that together are [0, count), none shorter than `grain` unless count is.
template <typename Body>
void parallel_ranges(std::size_t count, std::size_t grain, const Body& body) {
  if (count == 0) return;
  if (count <= grain) return body(std::size_t{0}, count);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, grain),
                    [&](const tbb::blocked_range<std::size_t>& range) { body(range.begin(), range.end()); });
}

}  // namespace facetsort
