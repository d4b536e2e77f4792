#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/base/parallel.h"
#include "facetsort/presort/index_buffers.h"
#include "subjects.h"
#include "support/random_views.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr std::size_t buffer_count = 10;
constexpr std::size_t judged_views = 100;
constexpr std::uint32_t seed_of_views = 1;

void make_buffers(benchmark::State& state, const Subject& subject, bool with_culling, int threads) {
  const MeshView mesh = subject.mesh().view();
  tbb::task_arena arena(threads);
  IndexBuffers buffers;
  for (auto _ : state) {
    buffers = arena.execute(
        [&] { return make_index_buffers(mesh, {.most_buffers = buffer_count, .with_culling = with_culling}); });
  }
  // None that the buffers were made for.
  const std::vector<View> views = random_views(mesh, judged_views, seed_of_views);
  std::vector<double> rates(views.size());
  parallel_ranges(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) rates[i] = inverted_rate(mesh, views[i], buffers);
  });
  double sum = 0;
  for (const double rate : rates) sum += rate;
  state.counters["buffers"] = static_cast<double>(buffers.buffer_count);
  state.counters["mean_%"] = 100 * sum / static_cast<double>(rates.size());
  state.counters["worst_%"] = 100 * *std::max_element(rates.begin(), rates.end());
  state.counters["stated_mean_%"] = 100 * buffers.mean_inverted_rate;
  if (buffers.facets.size() != buffers.buffer_count * mesh.facet_count()) state.SkipWithError("facets are missing");
}

}  // namespace

void register_index_buffers_benchmarks() {
  for (const Subject& subject : shipped_meshes()) {
    for (const bool with_culling : {false, true}) {
      const std::string name = (with_culling ? "index_buffers_culled/" : "index_buffers/") + subject.name();
      register_per_thread_count(
          name, [=](benchmark::State& state, int threads) { make_buffers(state, subject, with_culling, threads); });
    }
  }
}

}  // namespace facetsort::bench
