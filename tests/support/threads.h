// Running a piece of a test on a stated number of threads, also above what the machine has.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <utility>

namespace facetsort {

template <typename Body>
auto with_threads(int threads, Body&& body) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute(std::forward<Body>(body));
}

}  // namespace facetsort
