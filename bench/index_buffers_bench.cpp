#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/base/parallel.h"
#include "facetsort/blend/view.h"
#include "facetsort/facets/facets.h"
#include "facetsort/presort/index_buffers.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr std::size_t buffer_count = 10;
constexpr std::size_t judged_views = 100;

// From random directions, at 3 bounding radii, 512 x 512; none that the buffers were made for.
std::vector<View> random_views(const MeshView& mesh) {
  const Box box = facet_bounds(mesh);
  std::mt19937 random(1);
  std::vector<View> views;
  while (views.size() < judged_views) {
    glm::vec3 point;
    for (int axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(random()) * 0x1p-31f - 1;
    const float length = glm::length(point);
    if (length < 0.1f || length > 1) continue;
    views.push_back(default_view(box, box.centre() + point * (3 * box.radius() / length)));
  }
  return views;
}

void make_buffers(benchmark::State& state, const Subject& subject, bool with_culling, int threads) {
  const MeshView mesh = subject.mesh().view();
  tbb::task_arena arena(threads);
  IndexBuffers buffers;
  for (auto _ : state) {
    buffers = arena.execute(
        [&] { return make_index_buffers(mesh, {.most_buffers = buffer_count, .with_culling = with_culling}); });
  }
  const std::vector<View> views = random_views(mesh);
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
