#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/view.h"
#include "facetsort/order/method.h"
#include "facetsort/order/sorter.h"
#include "subjects.h"

namespace facetsort::bench {
namespace {

SortView sort_view(const View& view) {
  return {view.homogeneous_eye(), view.forward()};
}

// A permutation of all facets, farther keys first, equal keys by smaller id.
bool is_back_to_front(std::span<const std::uint32_t> order, std::span<const float> keys) {
  if (order.size() != keys.size()) return false;
  std::vector<unsigned char> seen(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i] >= order.size() || seen[order[i]]++) return false;
    if (i == 0) continue;
    const std::uint32_t before = order[i - 1], here = order[i];
    if (!(keys[before] > keys[here] || (keys[before] == keys[here] && before < here))) return false;
  }
  return true;
}

bool has_corners_in_order(std::span<const std::uint32_t> indices, std::span<const glm::uvec3> triangles,
                          std::span<const std::uint32_t> order) {
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (indices[3 * i + corner] != triangles[order[i]][corner]) return false;
    }
  }
  return true;
}

void sort_frames(benchmark::State& state, const Subject& subject, Method method, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<View> frames = frames_around(mesh, 1);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view(), method);
    std::span<const std::uint32_t> order = sorter.sort(sort_view(frames.back()));
    std::size_t frame = 0;
    for (auto _ : state) {
      order = sorter.sort(sort_view(frames[frame++ % frames.size()]));
      benchmark::DoNotOptimize(order.data());
    }
    if (!is_back_to_front(order, sorter.keys())) state.SkipWithError("not back to front");
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

void sort_index_buffers(benchmark::State& state, const Subject& subject, Method method, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<View> frames = frames_around(mesh, 1);
  std::vector<std::uint32_t> indices(3 * mesh.triangles.size());
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view(), method);
    sorter.sort_indices(sort_view(frames.back()), mesh.triangles, indices);
    std::size_t frame = 0;
    for (auto _ : state) {
      sorter.sort_indices(sort_view(frames[frame++ % frames.size()]), mesh.triangles, indices);
      benchmark::ClobberMemory();
    }
    const std::size_t last = frame == 0 ? frames.size() - 1 : (frame - 1) % frames.size();
    const std::span<const std::uint32_t> order = sorter.sort(sort_view(frames[last]));
    if (!is_back_to_front(order, sorter.keys()) || !has_corners_in_order(indices, mesh.triangles, order)) {
      state.SkipWithError("not back to front");
    }
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_sort_benchmarks() {
  const auto add = [](const std::string& name, auto run, const Subject& subject, Method method) {
    for (const int threads : thread_counts()) {
      const std::string full =
          name + "/" + std::string(method_name(method)) + "/" + subject.name() + "/threads:" + std::to_string(threads);
      benchmark::RegisterBenchmark(full.c_str(), run, subject, method, threads)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    }
  };
  for (const Subject& knot : knots(1000, 1000000)) {
    for (const Method method : depth_key_methods()) add("sort", sort_frames, knot, method);
    add("sort_indices", sort_index_buffers, knot, Method::centroid_distance);
  }
}

}  // namespace facetsort::bench
