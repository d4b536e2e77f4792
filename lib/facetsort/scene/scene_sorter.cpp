#include "facetsort/scene/scene_sorter.h"

#include <cassert>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/base/stopwatch.h"
#include "facetsort/scene/exact_groups.h"

namespace facetsort {

using scene_internal::ExactGroups, scene_internal::MergedOrder;

namespace {

constexpr std::size_t triangles_per_task = 16384;

}  // namespace

struct SceneSorter::State {
  SceneSorterOptions options;
  MergedMesh merged;
  std::optional<Sorter> sorter;    // by depth keys
  std::vector<std::uint32_t> moved;  // objects with positions that the sorter does not know, each once
  std::vector<unsigned char> has_moved;
  std::unique_ptr<ExactGroups> exact;
  RunGrouper grouper;
  SceneStatistics statistics;

  MergedOrder order;                   // as found
  std::vector<std::uint32_t> objects;  // of its triangles
  std::vector<glm::vec3> positions;    // of the merged mesh and the cut vertices, where there are some
  // As drawn.
  std::vector<std::uint32_t> indices, facets;
  std::vector<DrawRun> runs;

  void take_new_positions();
  void sort_by_keys(const SortView& view);
  void sort_exactly(const SortView& view);
  void find_objects(std::span<const std::uint32_t> of_facets);
  std::span<const glm::vec3> all_positions();
  void write(std::span<const std::uint32_t> places);
};

void SceneSorter::State::take_new_positions() {
  const Mesh& mesh = merged.mesh;
  const StridedPositions in_world(mesh.positions);
  std::size_t count = 0;
  for (const std::uint32_t k : moved) count += merged.objects[k].facet_count;
  if (2 * count > mesh.triangles.size()) {
    sorter->set_positions(mesh.triangles, in_world);
  } else {
    for (const std::uint32_t k : moved) {
      sorter->set_positions(mesh.triangles, in_world, {merged.objects[k].first_facet, merged.objects[k].facet_count});
    }
  }
  for (const std::uint32_t k : moved) has_moved[k] = 0;
  moved.clear();
}

void SceneSorter::State::sort_by_keys(const SortView& view) {
  Stopwatch stopwatch;
  const Mesh& mesh = merged.mesh;
  take_new_positions();
  statistics.prepare_ms = stopwatch.lap();
  order.triangles.resize(mesh.triangles.size());
  order.facets.resize(mesh.triangles.size());
  sorter->sort_indices({.eye = view.eye, .forward = view.forward}, mesh.triangles,
                       std::span(&order.triangles.data()->x, 3 * order.triangles.size()), order.facets);
  statistics.groups = 1;
  statistics.sort_ms = stopwatch.lap();
}

void SceneSorter::State::sort_exactly(const SortView& view) {
  const ExactGroups::Found found = exact->sort(merged, view, order);
  statistics.groups = found.groups;
  statistics.prepared_groups = found.prepared_groups;
  statistics.prepare_ms = found.prepare_ms;
  statistics.sort_ms = found.sort_ms;
}

void SceneSorter::State::find_objects(std::span<const std::uint32_t> of_facets) {
  objects.resize(of_facets.size());
  parallel_ranges(objects.size(), triangles_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) objects[k] = merged.facet_objects[of_facets[k]];
  });
}

std::span<const glm::vec3> SceneSorter::State::all_positions() {
  if (order.cut_vertices.empty()) return merged.mesh.positions;
  positions.assign(merged.mesh.positions.begin(), merged.mesh.positions.end());
  for (const CutVertex& vertex : order.cut_vertices) positions.push_back(vertex.position);
  return positions;
}

// Triangles of the order found, in another order; in the same where `places` is empty.
void SceneSorter::State::write(std::span<const std::uint32_t> places) {
  indices.resize(3 * order.triangles.size());
  facets.resize(order.triangles.size());
  parallel_ranges(facets.size(), triangles_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::size_t place = places.empty() ? k : places[k];
      for (int i = 0; i < 3; ++i) indices[3 * k + i] = order.triangles[place][i];
      facets[k] = order.facets[place];
    }
  });
  find_objects(facets);
  find_draw_runs(objects, runs);
}

Result<SceneSorter> SceneSorter::create(const Scene& scene, std::span<const std::uint32_t> objects,
                                        const SceneSorterOptions& options) {
  Stopwatch stopwatch;
  auto state = std::make_unique<State>();
  Result<MergedMesh> merged = merge(scene, objects);
  if (!merged.ok()) return merged.status();
  state->options = options;
  state->merged = std::move(merged).value();
  const Mesh& mesh = state->merged.mesh;
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max() / 3) {
    return Status{Fault::too_many_facets,
                  std::to_string(mesh.triangles.size()) + " facets: an index buffer has fewer than 2^32 indices"};
  }
  state->statistics.objects = objects.size();
  state->statistics.facets = mesh.triangles.size();
  state->statistics.merge_ms = stopwatch.lap();
  if (mesh.triangles.empty()) return SceneSorter(std::move(state));
  if (is_exact(options.method)) {
    state->exact = std::make_unique<ExactGroups>(
        state->merged, ExactOptions{.max_growth = options.max_growth, .from = order_from(options.method)});
  } else {
    state->sorter.emplace(mesh.view(), SorterOptions{.method = options.method, .precision = options.precision});
    state->runs.reserve(mesh.triangles.size());  // so many there may be from some eye
    state->moved.reserve(objects.size());
    state->has_moved.assign(objects.size(), 0);
  }
  return SceneSorter(std::move(state));
}

SceneSorter::SceneSorter(std::unique_ptr<State> state) : state_(std::move(state)) {}
SceneSorter::SceneSorter(SceneSorter&&) noexcept = default;
SceneSorter& SceneSorter::operator=(SceneSorter&&) noexcept = default;
SceneSorter::~SceneSorter() = default;

const MergedMesh& SceneSorter::merged() const {
  return state_->merged;
}

Status SceneSorter::update(const Scene& scene, std::size_t k) {
  return update(scene, k, scene.mesh_of(state_->merged.objects[k].object).positions);
}

Status SceneSorter::update(const Scene& scene, std::size_t k, std::span<const glm::vec3> positions) {
  Status status = facetsort::update(state_->merged, scene, k, positions);
  if (!status.ok()) return status;
  if (state_->exact) {
    state_->exact->update(state_->merged, static_cast<std::uint32_t>(k));
  } else {
    if (std::exchange(state_->has_moved[k], 1) == 0) state_->moved.push_back(static_cast<std::uint32_t>(k));
  }
  return status;
}

SceneOrder SceneSorter::sort(const SortView& view) {
  State& state = *state_;
  if (state.merged.mesh.triangles.empty()) return {};
  if (state.exact) {
    state.sort_exactly(view);
  } else {
    state.sort_by_keys(view);
  }
  Stopwatch stopwatch;
  state.find_objects(state.order.facets);
  SceneStatistics& statistics = state.statistics;
  statistics.triangles = state.order.triangles.size();
  statistics.runs_as_found = count_draw_runs(state.objects);
  std::span<const std::uint32_t> places;
  if (state.options.group_runs && state.merged.objects.size() > 1) {
    places = state.grouper.group(view.eye, {state.all_positions(), state.order.triangles, state.objects},
                                 state.merged.objects.size());
  }
  state.write(places);
  statistics.runs = state.runs.size();
  statistics.group_runs_ms = stopwatch.lap();
  return {state.indices, state.facets, state.order.cut_vertices, state.runs};
}

const SceneStatistics& SceneSorter::statistics() const {
  return state_->statistics;
}

std::size_t SceneSorter::memory_bytes() const {
  const State& s = *state_;
  return bytes_of(s.order.triangles, s.order.facets, s.order.cut_vertices, s.objects, s.positions, s.indices, s.facets,
                  s.runs, s.moved, s.has_moved, s.merged.mesh.positions, s.merged.mesh.triangles,
                  s.merged.facet_objects) +
         s.grouper.memory_bytes() + (s.sorter ? s.sorter->memory_bytes() : 0) + (s.exact ? s.exact->memory_bytes() : 0);
}

}  // namespace facetsort
