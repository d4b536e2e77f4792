// Benchmarks that run once with each number of threads.
#pragma once

#include <benchmark/benchmark.h>

#include <functional>
#include <string>
#include <vector>

#include "subjects.h"

namespace facetsort::bench {

enum class Clock { wall, manual };

// Registers `name`/threads:N for each N of `counts`.
inline void register_per_thread_count(const std::string& name, const std::function<void(benchmark::State&, int)>& run,
                                      Clock clock = Clock::wall, const std::vector<int>& counts = thread_counts()) {
  for (const int threads : counts) {
    benchmark::internal::Benchmark* registered = benchmark::RegisterBenchmark(
        (name + "/threads:" + std::to_string(threads)).c_str(), [=](benchmark::State& state) { run(state, threads); });
    registered->Unit(benchmark::kMillisecond);
    clock == Clock::wall ? registered->UseRealTime() : registered->UseManualTime();
  }
}

}  // namespace facetsort::bench
