#include "facetsort/plan/plan.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <utility>

#include "facetsort/base/stopwatch.h"
#include "facetsort/blend/view.h"
#include "facetsort/plan/convex_parts.h"
#include "facetsort/plan/planned_mesh.h"
#include "facetsort/scene/merge.h"

namespace facetsort {
namespace {

MeshView facets_of(const MeshView& mesh, const MergedObject& object) {
  MeshView part = mesh;
  part.triangles = mesh.triangles.subspan(object.first_facet, object.facet_count);
  const auto cut = [&](auto& values) {
    if (!values.empty()) values = values.subspan(object.first_facet, object.facet_count);
  };
  cut(part.facet_colours);
  cut(part.facet_materials);
  return part;
}

// The most spheres of a chain in which each overlaps the next.
std::size_t largest_group(std::span<const Sphere> spheres, const glm::vec4& eye) {
  std::vector<std::size_t> group(spheres.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    for (std::size_t j = i + 1; j < spheres.size(); ++j) {
      if (group[i] == group[j] || are_apart(spheres[i], spheres[j], eye)) continue;
      std::replace(group.begin(), group.end(), std::size_t{group[j]}, std::size_t{group[i]});
    }
  }
  std::vector<std::size_t> members(spheres.size());
  for (const std::size_t of : group) ++members[of];
  return members.empty() ? 0 : *std::max_element(members.begin(), members.end());
}

MeshPlan plan_object(const Scene& scene, std::uint32_t object, const MeshView& facets, const PlanOptions& options) {
  MeshPlan plan = plan_internal::make_plan(facets, options, {}, false).plan;
  plan.name = scene.objects[object].name;
  return plan;
}

void plan_objects(const Scene& scene, const MergedMesh& merged, const PlanOptions& options, Plan& plan) {
  const MeshView mesh = merged.mesh.view();
  plan.objects.resize(scene.objects.size());
  std::vector<Sphere> spheres;
  for (std::size_t k = 0; k < merged.objects.size(); ++k) {
    const MeshView facets = facets_of(mesh, merged.objects[k]);
    const std::uint32_t object = merged.objects[k].object;
    plan.objects[object] = plan_object(scene, object, facets, options);
    if (k < plan.blended_objects) spheres.push_back(bounding_sphere(facets));
  }
  for (const View& view : views_around(facet_bounds(mesh), options.views, options.radii, Projection::perspective)) {
    plan.most_overlapping = std::max(plan.most_overlapping, largest_group(spheres, view.homogeneous_eye()));
  }
}

}  // namespace

MeshPlan plan_mesh(const MeshView& mesh, const PlanOptions& options, const PresortedInput& presorted) {
  return plan_internal::make_plan(mesh, options, presorted, true).plan;
}

Result<Plan> plan_scene(const Scene& scene, const PlanOptions& options) {
  Stopwatch stopwatch;
  Plan plan;
  plan.blended_objects = blended_objects(scene).size();
  if (plan.blended_objects == 0) {
    plan.whole.reason = "no object is blended: a depth buffer is all it takes";
    plan.whole.left_out = {{"merging, sorting, cuts and presorting", "no object is blended"}};
    for (const SceneObject& object : scene.objects) {
      MeshPlan& of = plan.objects.emplace_back();
      of.name = object.name;
      of.reason = plan.whole.reason;
    }
  } else {
    Result<MergedMesh> merged = merge(scene, blended_first(scene));
    if (!merged.ok()) return merged.status();
    plan_objects(scene, merged.value(), options, plan);
    plan.whole = plan_mesh(merged.value().mesh.view(), options);
    if (plan.most_overlapping <= 1) {
      plan.whole.left_out.push_back({"an order of objects", "none overlap on the screen in the views looked at"});
    }
  }
  plan.plan_ms = stopwatch.lap();
  return plan;
}

}  // namespace facetsort
