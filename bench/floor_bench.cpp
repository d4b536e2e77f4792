// The least that a frame's sort can do to memory: read a facet's centroid and its indices, write its indices, all in
// the order in which they lie.
#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/base/parallel.h"
#include "sort_subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr std::size_t facets_per_task = 8192;

void stream(benchmark::State& state, const Subject& subject, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::size_t count = mesh.triangles.size();
  const PointArrays points = facet_centroids(mesh.view(), {});
  std::vector<glm::uvec3> indices(count);
  std::atomic<std::uint32_t> bits{0};
  const auto stream_range = [&](std::size_t begin, std::size_t end) {
    // Of the bits, since sums of floats may not be taken in another order, and so not in vectors.
    std::uint32_t sum = 0;
    for (const std::vector<float>* axis : {&points.x, &points.y, &points.z}) {
      for (std::size_t facet = begin; facet < end; ++facet) sum ^= std::bit_cast<std::uint32_t>((*axis)[facet]);
    }
    bits.fetch_xor(sum, std::memory_order_relaxed);
    std::memcpy(&indices[begin], &mesh.triangles[begin], (end - begin) * sizeof(glm::uvec3));
  };
  tbb::task_arena arena(threads);
  arena.execute([&] {
    for (auto _ : state) {
      // One task of one thread, as in the sort.
      if (threads == 1) {
        for (std::size_t begin = 0; begin < count; begin += facets_per_task) {
          stream_range(begin, std::min(begin + facets_per_task, count));
        }
      } else {
        parallel_ranges(count, facets_per_task, stream_range);
      }
      benchmark::ClobberMemory();
    }
  });
  benchmark::DoNotOptimize(bits.load());
  if (indices != mesh.triangles) state.SkipWithError("not what was streamed");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(count));
}

}  // namespace

void register_floor_benchmarks() {
  for (const Subject& subject : spatial_subjects()) {
    register_per_thread_count("floor/" + subject.name(),
                              [=](benchmark::State& state, int threads) { stream(state, subject, threads); });
  }
}

}  // namespace facetsort::bench
