#include "sort_bench.h"

#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/order/method.h"
#include "sort_subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

// Of the facets in `order`, those that are also in `whole`, in that order; all of `order`?
bool is_subsequence(std::span<const std::uint32_t> order, std::span<const std::uint32_t> whole) {
  std::size_t k = 0;
  for (const std::uint32_t id : whole) k += k < order.size() && order[k] == id;
  return k == order.size();
}

// As Sorter promises of quantised keys: the same facets, none far from the place that its whole key gives it.
bool is_near(std::span<const std::uint32_t> order, std::span<const std::uint32_t> expected, std::size_t facets) {
  if (order.size() != expected.size()) return false;
  const std::size_t most_places_off = std::max<std::size_t>(48, 16 + facets / 4096);
  constexpr std::uint32_t nowhere = 0xffffffff;
  std::vector<std::uint32_t> places(facets, nowhere);
  for (std::size_t k = 0; k < expected.size(); ++k) places[expected[k]] = static_cast<std::uint32_t>(k);
  for (std::size_t k = 0; k < order.size(); ++k) {
    const std::size_t place = std::exchange(places[order[k]], nowhere);
    if (place == nowhere || std::max(place, k) - std::min(place, k) > most_places_off) return false;
  }
  return true;
}

// Whether `order` is what the options ask for, by sorters of whole keys.
bool is_right(std::span<const std::uint32_t> order, const Mesh& mesh, const SortView& view, SorterOptions options) {
  Sorter whole(mesh.view(), {.method = options.method, .precision = Precision::whole});
  const std::span<const std::uint32_t> all = whole.sort(view);
  const bool is_quantised = options.precision == Precision::quantised;
  options.precision = Precision::whole;
  Sorter sorter(mesh.view(), options);
  const std::span<const std::uint32_t> expected = sorter.sort(view);
  return is_back_to_front(all, whole.keys()) && is_subsequence(expected, all) &&
         (options.cull_back_faces || expected.size() == all.size()) &&
         (is_quantised ? is_near(order, expected, all.size())
                       : std::equal(order.begin(), order.end(), expected.begin(), expected.end()));
}

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
    const SortView& last = views[frame == 0 ? views.size() - 1 : (frame - 1) % views.size()];
    if (!is_right(order, mesh, last, {.method = method})) state.SkipWithError("not back to front");
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

// Facets of `order` that change places with the one that follows them, from its places to the next frame's.
template <typename Counts>
std::size_t count_exchanges(std::span<const std::uint32_t> order, const std::vector<std::uint32_t>& next_places,
                            const Counts& counts) {
  std::size_t exchanges = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    exchanges += next_places[order[k - 1]] > next_places[order[k]] && counts(order[k - 1], order[k]);
  }
  return exchanges;
}

std::vector<std::uint32_t> places_in(std::span<const std::uint32_t> order) {
  std::vector<std::uint32_t> places(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) places[order[k]] = static_cast<std::uint32_t>(k);
  return places;
}

// A camera that turns by a tenth of a degree a frame. Counters, as shares of the facets in a frame: `exchanges`, those
// that change places with their neighbour in the order, by whole keys and by quantised ones; `needless`, those of the
// latter whose whole keys do not ask for it.
void sort_orbit(benchmark::State& state, const Subject& subject, int threads) {
  constexpr double step = 3.14159265358979323846 / 1800;
  const Mesh& mesh = subject.mesh();
  const Box box = facet_bounds(mesh.view());
  std::size_t frame = 0;
  const auto next_view = [&] {
    const double angle = step * static_cast<double>(frame++);
    const glm::dvec3 direction = glm::normalize(glm::dvec3(std::sin(angle), 0.25, std::cos(angle)));
    const glm::vec3 eye(glm::dvec3(box.centre()) + 2.5 * static_cast<double>(box.radius()) * direction);
    return SortView{glm::vec4(eye, 1), glm::vec3(-direction)};
  };
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view());
    for (auto _ : state) benchmark::DoNotOptimize(sorter.sort(next_view()).data());

    Sorter whole(mesh.view(), {.precision = Precision::whole});
    std::size_t of_whole = 0, of_quantised = 0, needless = 0;
    constexpr int counted_frames = 8;
    SortView view = next_view();
    for (int k = 0; k < counted_frames; ++k) {
      const std::vector<std::uint32_t> before(sorter.sort(view).begin(), sorter.sort(view).end());
      const std::vector<std::uint32_t> whole_before(whole.sort(view).begin(), whole.sort(view).end());
      view = next_view();
      const std::vector<std::uint32_t> places = places_in(sorter.sort(view)), whole_places = places_in(whole.sort(view)),
                                       old_whole_places = places_in(whole_before);
      const auto all = [](std::uint32_t, std::uint32_t) { return true; };
      of_whole += count_exchanges(whole_before, whole_places, all);
      of_quantised += count_exchanges(before, places, all);
      needless += count_exchanges(before, places, [&](std::uint32_t a, std::uint32_t b) {
        return (old_whole_places[a] < old_whole_places[b]) == (whole_places[a] < whole_places[b]);
      });
    }
    const auto share = [&](std::size_t count) {
      return static_cast<double>(count) / static_cast<double>(mesh.triangles.size()) / counted_frames;
    };
    state.counters["exchanges_whole"] = share(of_whole);
    state.counters["exchanges_quantised"] = share(of_quantised);
    state.counters["needless"] = share(needless);
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
    const std::span<const std::uint32_t> order = sorter.sort(last);
    if (order.size() != drawn || !is_right(order, mesh, last, options) ||
        !has_corners_in_order(indices, mesh.triangles, order)) {
      state.SkipWithError("not back to front");
    }
  });
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

void register_sort_benchmarks() {
  const auto add = [](const std::string& name, const Subject& subject, const auto& run) {
    register_per_thread_count(name + "/" + subject.name(),
                              [=](benchmark::State& state, int threads) { run(state, subject, threads); });
  };
  for (const Subject& subject : sort_subjects()) {
    add("sort_indices/centroid_distance", subject,
        [](benchmark::State& state, const Subject& of, int threads) { sort_index_buffers(state, of, {}, threads); });
    add("sort_indices_whole_keys/centroid_distance", subject,
        [](benchmark::State& state, const Subject& of, int threads) {
          sort_index_buffers(state, of, {.precision = Precision::whole}, threads);
        });
  }
  for (const Subject& subject : spatial_subjects()) {
    for (const Method method : depth_key_methods()) {
      add("sort/" + std::string(method_name(method)), subject,
          [=](benchmark::State& state, const Subject& of, int threads) { sort_frames(state, of, method, threads); });
    }
    add("sort_indices_culled/centroid_distance", subject, [](benchmark::State& state, const Subject& of, int threads) {
      sort_index_buffers(state, of, {.cull_back_faces = true}, threads);
    });
    add("sort_orbit/centroid_distance", subject, sort_orbit);
    add("set_positions/centroid_distance", subject, move_positions);
  }
}

}  // namespace facetsort::bench
