// What benchmarks of other groups time beside their own.
#pragma once

#include <benchmark/benchmark.h>

#include "facetsort/order/sorter.h"
#include "subjects.h"

namespace facetsort::bench {

// The mesh sorted from eye to eye, its index buffer reordered.
void sort_index_buffers(benchmark::State& state, const Subject& subject, const SorterOptions& options, int threads);

}  // namespace facetsort::bench
