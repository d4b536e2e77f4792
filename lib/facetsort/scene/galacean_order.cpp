#include "facetsort/scene/galacean_order.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "facetsort/scene/comparator_sort.h"

namespace facetsort {
namespace {

// JavaScript's truth of a number.
bool is_true(double value) {
  return value != 0 && !std::isnan(value);
}

double dot(const glm::dvec3& a, const glm::dvec3& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

// Of one coordinate: BoundingBox.getCenter takes a box without bounds to be at 0.
double centre(double lowest, double highest) {
  const double sum = highest + lowest;
  return std::isnan(sum) ? 0 : sum * 0.5;
}

Faces faces_of(GalaceanRenderFace face) {
  if (face == GalaceanRenderFace::double_sided) return Faces::all;
  return face == GalaceanRenderFace::front ? Faces::front : Faces::back;
}

ObjectDraw draw_of(std::uint32_t item, const GalaceanMaterial& material) {
  return {.item = item,
          .faces = faces_of(material.render_face),
          .depth_test = material.depth_test,
          .depth_write = material.depth_write.value_or(!material.is_transparent),
          .alpha_cutoff = material.alpha_cutoff};
}

}  // namespace

GalaceanQueue galacean_queue(const GalaceanMaterial& material) {
  if (material.is_transparent) return GalaceanQueue::transparent;
  return is_true(material.alpha_cutoff) ? GalaceanQueue::alpha_test : GalaceanQueue::opaque;
}

double galacean_distance_for_sort(const GalaceanItem& item, const GalaceanCamera& camera) {
  const glm::dvec3 bounds_centre{centre(item.bounds_min.x, item.bounds_max.x),
                                 centre(item.bounds_min.y, item.bounds_max.y),
                                 centre(item.bounds_min.z, item.bounds_max.z)};
  const glm::dvec3 to_centre = bounds_centre - camera.position;
  return camera.is_orthographic ? dot(to_centre, camera.forward) : dot(to_centre, to_centre);
}

double galacean_compare_for_opaque(const GalaceanElement& a, const GalaceanElement& b) {
  const double by_priority = a.priority - b.priority;
  return is_true(by_priority) ? by_priority : a.distance_for_sort - b.distance_for_sort;
}

double galacean_compare_for_transparent(const GalaceanElement& a, const GalaceanElement& b) {
  const double by_priority = a.priority - b.priority;
  return is_true(by_priority) ? by_priority : b.distance_for_sort - a.distance_for_sort;
}

std::vector<ObjectDraw> galacean_draw_order(std::span<const GalaceanItem> items, const GalaceanCamera& camera) {
  std::array<std::vector<GalaceanElement>, 3> queues;
  for (std::size_t i = 0; i < items.size(); ++i) {
    queues[static_cast<std::size_t>(galacean_queue(items[i].material))].push_back(
        {static_cast<std::uint32_t>(i), items[i].priority, galacean_distance_for_sort(items[i], camera)});
  }
  auto& [opaque, alpha_test, transparent] = queues;
  scene_internal::sort_by_comparator(opaque, galacean_compare_for_opaque);
  scene_internal::sort_by_comparator(alpha_test, galacean_compare_for_opaque);
  scene_internal::sort_by_comparator(transparent, galacean_compare_for_transparent);

  std::vector<ObjectDraw> draws;
  draws.reserve(items.size());
  for (const std::vector<GalaceanElement>& queue : queues) {
    for (const GalaceanElement& element : queue) draws.push_back(draw_of(element.item, items[element.item].material));
  }
  return draws;
}

}  // namespace facetsort
