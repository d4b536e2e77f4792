#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/check/verdict.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/facets/facets.h"
#include "facetsort/order/method.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr int picture_size = 512;  // of the check

void sort_frames(benchmark::State& state, const Subject& subject, OrderFrom from, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<View> frames = frames_around(mesh, picture_size);
  tbb::task_arena arena(threads);
  ExactSorter sorter(mesh.view(), {.from = from});
  std::span<const std::uint32_t> order;
  std::size_t frame = 0;
  arena.execute([&] {
    order = sorter.sort({frames.back().homogeneous_eye(), frames.back().forward()});
    for (auto _ : state) {
      const View& view = frames[frame++ % frames.size()];
      order = sorter.sort({view.homogeneous_eye(), view.forward()});
      benchmark::DoNotOptimize(order.data());
    }
  });
  const View& last = frames[(frame + frames.size() - 1) % frames.size()];
  const FragmentLists lists = collect_fragments(mesh.view(), last);
  const std::vector<std::uint32_t> ranks = fragment_ranks(mesh.view(), last, lists, order, sorter.pieces());
  const Verdict verdict =
      judge_drawing(lists, ranks, {.bounding_radius = facet_bounds(mesh.view()).radius()});
  if (verdict.inverted_pixels > 0 || verdict.uncovered_fragments > 0) state.SkipWithError("not back to front");
  const ExactStatistics& statistics = sorter.statistics();
  state.counters["pieces"] = static_cast<double>(statistics.pieces);
  state.counters["triangles"] = static_cast<double>(statistics.triangles);
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_exact_benchmarks() {
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& knot : knots(10000, 1000000)) subjects.push_back(knot);
  for (const Subject& subject : subjects) {
    for (const Method method : all_methods()) {
      if (!is_exact(method)) continue;
      const std::string name = std::string(method_name(method)) + "/" + subject.name();
      register_per_thread_count(name, [=](benchmark::State& state, int threads) {
        sort_frames(state, subject, order_from(method), threads);
      });
    }
  }
}

}  // namespace facetsort::bench
