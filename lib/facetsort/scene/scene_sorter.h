// The facets of many objects in one back-to-front order, as index buffer and draw calls.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "facetsort/base/status.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/order/method.h"
#include "facetsort/order/sorter.h"
#include "facetsort/scene/draw_runs.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

struct SceneSorterOptions {
  // A depth key of depth_key_methods(), or an exact method, which sorts what has to be sorted together and no more.
  Method method = Method::exact;
  // Of depth keys.
  Precision precision = Precision::quantised;
  // Of exact orders, for each group of objects.
  double max_growth = 64;
  // Bring triangles of an object together (see RunGrouper): the same picture in fewer draws. Off: runs are those of the
  // order as it was found.
  bool group_runs = true;
};

// What is to be drawn, back to front. Valid until the next call on the sorter that made it.
struct SceneOrder {
  std::span<const std::uint32_t> indices;   // three a triangle: positions of the merged mesh, then cut_vertices
  std::span<const std::uint32_t> facets;    // of the merged mesh: which each triangle is, or is part of
  std::span<const CutVertex> cut_vertices;  // their facets are the merged mesh's too
  std::span<const DrawRun> runs;
};

// Times are wall clock.
struct SceneStatistics {
  std::size_t objects = 0;
  std::size_t facets = 0;
  std::size_t groups = 0;           // that were sorted apart from each other; 1 by depth keys
  std::size_t prepared_groups = 0;  // of those, new since the last sort
  std::size_t triangles = 0;
  std::size_t runs_as_found = 0;  // before triangles of an object were brought together
  std::size_t runs = 0;
  double merge_ms = 0;    // once
  double prepare_ms = 0;  // by depth keys, after updates: new keys; exact: groups that are new
  double sort_ms = 0;
  double group_runs_ms = 0;
};

// Sorts objects of a scene together for many views. By depth keys nothing is allocated once warm, and after updates what
// is known of the other objects stays (see Sorter::set_positions()).
//
// Exact: objects that none of thirteen directions' planes parts are sorted together, each such group by an ExactSorter
// of its own; groups are drawn one after the other as planes between objects ask for, and from the first view on in
// which planes put some into a cycle, those are one group. The order has no fragment after one that it should hide
// behind, as ExactSorter's. Groups are sorted at the same time where there are threads, and an update prepares only the
// groups that have the object, or that it brings together.
//
// One thread at a time; works in parallel in the caller's task arena. Keeps no reference to the scene.
class SceneSorter {
 public:
  // Preconditions: validate(scene) is ok; `objects` are some of its objects, each once; they may be none.
  // Faults: those of merge(), and too_many_facets where an index buffer would have 2^32 indices and more.
  static Result<SceneSorter> create(const Scene& scene, std::span<const std::uint32_t> objects,
                                    const SceneSorterOptions& options = {});
  SceneSorter(SceneSorter&&) noexcept;
  SceneSorter& operator=(SceneSorter&&) noexcept;
  ~SceneSorter();

  // The objects' facets in world space. Changed by update() alone.
  const MergedMesh& merged() const;

  // As the functions of that name in merge.h: `k` is of merged().objects.
  Status update(const Scene& scene, std::size_t k);
  Status update(const Scene& scene, std::size_t k, std::span<const glm::vec3> positions);

  // The view is in world space; clip_planes are not used. Precondition: as ExactSorter's and Sorter's.
  SceneOrder sort(const SortView& view);

  // Of the last sort().
  const SceneStatistics& statistics() const;
  std::size_t memory_bytes() const;

 private:
  struct State;
  explicit SceneSorter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace facetsort
