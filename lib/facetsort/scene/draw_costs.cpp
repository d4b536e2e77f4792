#include "facetsort/scene/draw_costs.h"

#include <cstdint>
#include <utility>

#include "facetsort/scene/scene_sorter.h"

namespace facetsort {

Result<std::vector<DrawCost>> draw_costs(const Scene& scene, const SortView& view) {
  const std::vector<std::uint32_t> objects = blended_objects(scene);
  DrawCost whole{.choice = "whole_objects", .draws = objects.size(), .draws_as_found = objects.size()};
  for (const std::uint32_t object : objects) whole.triangles += scene.mesh_of(object).triangles.size();
  whole.groups = objects.size();
  std::vector<DrawCost> costs{whole};
  for (const Method method : {Method::centroid_distance, Method::exact}) {
    Result<SceneSorter> sorter = SceneSorter::create(scene, objects, {.method = method});
    if (!sorter.ok()) return sorter.status();
    sorter.value().sort(view);  // prepares groups, and memory
    sorter.value().sort(view);
    const SceneStatistics& statistics = sorter.value().statistics();
    const std::string name(method_name(method));
    costs.push_back({.choice = is_exact(method) ? name : "facet_sort:" + name,
                     .draws = statistics.runs,
                     .draws_as_found = statistics.runs_as_found,
                     .triangles = statistics.triangles,
                     .groups = statistics.groups,
                     .order_ms = statistics.sort_ms + statistics.group_runs_ms});
  }
  return costs;
}

}  // namespace facetsort
