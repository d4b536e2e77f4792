#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "facetsort/check/verdict.h"
#include "facetsort/order/method.h"
#include "facetsort/plan/plan.h"
#include "facetsort/scene/scene_sorter.h"
#include "shapes.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr std::uint32_t knots = 50;
constexpr std::size_t facets_of_knot = 10000;
constexpr int picture_size = 512;  // of the check

// Knots of radius 1 in a cube of `side`, turned any way: the smaller the cube, the more of them overlap.
Scene scattered_knots(double side, AlphaMode mode = AlphaMode::blend) {
  Scene scene;
  scene.materials.push_back(
      {.name = "glass", .material = {.base_colour = glm::vec4(1, 1, 1, 0.5f), .alpha_mode = mode}});
  Mesh knot = shapes::torus_knot(facets_of_knot);
  scene.meshes.push_back(
      {.name = "knot", .positions = std::move(knot.positions), .triangles = std::move(knot.triangles)});
  std::mt19937 random(7);
  const auto below_one = [&] { return static_cast<double>(random()) * 0x1p-32; };
  for (std::uint32_t i = 0; i < knots; ++i) {
    const double turn = 2 * 3.14159265358979 * below_one(), tilt = 3.14159265358979 * below_one();
    const double c = std::cos(turn), s = std::sin(turn), ct = std::cos(tilt), st = std::sin(tilt);
    const glm::dmat4 turned(glm::dvec4(c, s, 0, 0), glm::dvec4(-s * ct, c * ct, st, 0),
                            glm::dvec4(s * st, -c * st, ct, 0), glm::dvec4(0, 0, 0, 1));
    glm::dmat4 world = turned;
    for (int axis = 0; axis < 3; ++axis) world[3][axis] = side * below_one();
    scene.objects.push_back({.name = "knot " + std::to_string(i), .mesh = 0, .world = world});
  }
  return scene;
}

bool is_back_to_front(const MergedMesh& merged, const SceneOrder& order, const View& view) {
  Mesh drawn;
  drawn.positions = merged.mesh.positions;
  for (const CutVertex& vertex : order.cut_vertices) drawn.positions.push_back(vertex.position);
  for (std::size_t i = 0; i < order.indices.size(); i += 3) {
    drawn.triangles.emplace_back(order.indices[i], order.indices[i + 1], order.indices[i + 2]);
  }
  std::vector<std::uint32_t> rank(drawn.triangles.size());
  std::iota(rank.begin(), rank.end(), 0u);
  const Verdict verdict = judge_order(collect_fragments(drawn.view(), view), rank,
                                      {.bounding_radius = facet_bounds(drawn.view()).radius()});
  return verdict.covered_pixels > 0 && verdict.inverted_pixels == 0;
}

// What one call costs, and its parts; of an exact order, checked.
void sort_scene(benchmark::State& state, double side, const SceneSorterOptions& options, int threads) {
  const Scene scene = scattered_knots(side);
  std::vector<std::uint32_t> objects(scene.objects.size());
  std::iota(objects.begin(), objects.end(), 0u);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Result<SceneSorter> made = SceneSorter::create(scene, objects, options);
    if (!made.ok()) return state.SkipWithError(made.status().message.c_str());
    SceneSorter& sorter = made.value();
    const MergedMesh& merged = sorter.merged();
    std::vector<View> frames = views_around(facet_bounds(merged.mesh.view()), 16, 2.5f, Projection::perspective);
    for (View& view : frames) view.width = view.height = picture_size;
    SceneOrder order;
    std::size_t frame = 0;
    const auto sort_next = [&] {
      const View& view = frames[frame++ % frames.size()];
      order = sorter.sort({view.homogeneous_eye(), view.forward()});
      benchmark::DoNotOptimize(order.indices.data());
    };
    sort_next();
    state.counters["merge_ms"] = sorter.statistics().merge_ms;
    state.counters["prepare_ms"] = sorter.statistics().prepare_ms;
    SceneStatistics sum;
    for (auto _ : state) {
      sort_next();
      const SceneStatistics& statistics = sorter.statistics();
      sum.sort_ms += statistics.sort_ms;
      sum.group_runs_ms += statistics.group_runs_ms;
      sum.runs_as_found += statistics.runs_as_found;
      sum.runs += statistics.runs;
      sum.triangles += statistics.triangles;
      sum.groups += statistics.groups;
    }
    const auto mean = [&](auto total) {
      return benchmark::Counter(static_cast<double>(total), benchmark::Counter::kAvgIterations);
    };
    state.counters["sort_ms"] = mean(sum.sort_ms);
    state.counters["group_runs_ms"] = mean(sum.group_runs_ms);
    state.counters["runs_as_found"] = mean(sum.runs_as_found);
    state.counters["runs"] = mean(sum.runs);
    state.counters["triangles"] = mean(sum.triangles);
    state.counters["groups"] = mean(sum.groups);
    const View& last = frames[(frame - 1) % frames.size()];
    if (is_exact(options.method) && !is_back_to_front(merged, order, last)) state.SkipWithError("not back to front");
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(knots * facets_of_knot));
}

double median_ms(const std::function<void()>& run) {
  using Clock = std::chrono::steady_clock;
  std::array<double, 5> samples;
  for (double& sample : samples) {
    const Clock::time_point begin = Clock::now();
    run();
    sample = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  }
  std::sort(samples.begin(), samples.end());
  return samples[samples.size() / 2];
}

// The plan of a scene in which nothing needs sorting, beside one frame of what it spares: the sort by depth keys, the
// cheapest there is, of the same facets.
void plan_opaque_scene(benchmark::State& state, int threads) {
  const Scene scene = scattered_knots(12, AlphaMode::opaque);
  std::vector<std::uint32_t> objects(scene.objects.size());
  std::iota(objects.begin(), objects.end(), 0u);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Result<SceneSorter> sorter = SceneSorter::create(scene, objects, {.method = Method::centroid_distance});
    if (!sorter.ok()) return state.SkipWithError(sorter.status().message.c_str());
    float turn = 0;
    const double sort_ms = median_ms([&] { sorter.value().sort({glm::vec4(40, turn += 1, 40, 1), glm::vec3(0, 0, -1)}); });
    for (auto _ : state) {
      const Result<Plan> plan = plan_scene(scene);
      if (!plan.ok() || plan.value().blended_objects != 0) return state.SkipWithError("the plan sorts");
    }
    const double plan_ms = median_ms([&] { benchmark::DoNotOptimize(plan_scene(scene)); });
    state.counters["sort_ms"] = sort_ms;
    state.counters["share_of_sort"] = plan_ms / sort_ms;
  });
}

}  // namespace

void register_scene_benchmarks() {
  register_per_thread_count("plan_50_opaque_knots", plan_opaque_scene);
  for (const double side : {6.0, 12.0}) {
    for (const Method method : {Method::centroid_distance, Method::exact}) {
      for (const bool group_runs : {false, true}) {
        const std::string name = std::string("scene_50_knots/side_") + std::to_string(static_cast<int>(side)) + "/" +
                                 std::string(method_name(method)) + (group_runs ? "" : "_as_found");
        register_per_thread_count(name, [=](benchmark::State& state, int threads) {
          sort_scene(state, side, {.method = method, .group_runs = group_runs}, threads);
        });
      }
    }
  }
}

}  // namespace facetsort::bench
