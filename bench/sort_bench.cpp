#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/order/method.h"
#include "facetsort/order/sorter.h"
#include "sort_subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

void sort_frames(benchmark::State& state, const Subject& subject, Method method, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<SortView> views = sort_views(mesh);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view(), method);
    std::span<const std::uint32_t> order = sorter.sort(views.back());
    std::size_t frame = 0;
    for (auto _ : state) {
      order = sorter.sort(views[frame++ % views.size()]);
      benchmark::DoNotOptimize(order.data());
    }
    if (!is_back_to_front(order, sorter.keys())) state.SkipWithError("not back to front");
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

// Of the facets in `order`, those that are also in `whole`, in that order; all of `order`?
bool is_subsequence(std::span<const std::uint32_t> order, std::span<const std::uint32_t> whole) {
  std::size_t k = 0;
  for (const std::uint32_t id : whole) k += k < order.size() && order[k] == id;
  return k == order.size();
}

void sort_index_buffers(benchmark::State& state, const Subject& subject, const SorterOptions& options, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<SortView> views = sort_views(mesh);
  std::vector<std::uint32_t> indices(3 * mesh.triangles.size());
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view(), options);
    sorter.sort_indices(views.back(), mesh.triangles, indices);
    std::size_t frame = 0, drawn = 0;
    for (auto _ : state) {
      drawn = sorter.sort_indices(views[frame++ % views.size()], mesh.triangles, indices);
      benchmark::ClobberMemory();
    }
    const SortView& last = views[frame == 0 ? views.size() - 1 : (frame - 1) % views.size()];
    Sorter whole(mesh.view(), options.method);
    const std::span<const std::uint32_t> all = whole.sort(last), order = sorter.sort(last);
    if (!is_back_to_front(all, whole.keys()) || !is_subsequence(order, all) || order.size() != drawn ||
        (!options.cull_back_faces && drawn != all.size()) || !has_corners_in_order(indices, mesh.triangles, order)) {
      state.SkipWithError("not back to front");
    }
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

void move_positions(benchmark::State& state, const Subject& subject, int threads) {
  const Mesh& mesh = subject.mesh();
  const SortView view = sort_views(mesh).front();
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view()), fresh(mesh.view());
    for (auto _ : state) sorter.set_positions(mesh.triangles, StridedPositions(mesh.positions));
    const std::span<const std::uint32_t> order = sorter.sort(view), expected = fresh.sort(view);
    if (!std::equal(order.begin(), order.end(), expected.begin(), expected.end())) state.SkipWithError("another order");
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_sort_benchmarks() {
  const auto add = [](const std::string& name, const Subject& subject, const auto& run) {
    register_per_thread_count(name + "/" + subject.name(),
                              [=](benchmark::State& state, int threads) { run(state, subject, threads); });
  };
  for (const Subject& subject : sort_subjects()) {
    add("sort_indices/centroid_distance", subject,
        [](benchmark::State& state, const Subject& of, int threads) { sort_index_buffers(state, of, {}, threads); });
  }
  for (const Subject& subject : spatial_subjects()) {
    for (const Method method : depth_key_methods()) {
      add("sort/" + std::string(method_name(method)), subject,
          [=](benchmark::State& state, const Subject& of, int threads) { sort_frames(state, of, method, threads); });
    }
    add("sort_indices_culled/centroid_distance", subject, [](benchmark::State& state, const Subject& of, int threads) {
      sort_index_buffers(state, of, {.cull_back_faces = true}, threads);
    });
    add("set_positions/centroid_distance", subject, move_positions);
  }
}

}  // namespace facetsort::bench
