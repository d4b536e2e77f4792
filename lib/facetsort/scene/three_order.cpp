#include "facetsort/scene/three_order.h"

#include <array>
#include <cstddef>

#include "facetsort/scene/comparator_sort.h"

namespace facetsort {
namespace {

// Vector4.applyMatrix4 and Matrix4.multiplyMatrices. GLM's own products add in another order.
glm::dvec4 transformed(const glm::dmat4& m, const glm::dvec4& v) {
  glm::dvec4 result;
  for (int row = 0; row < 4; ++row) {
    result[row] = m[0][row] * v.x + m[1][row] * v.y + m[2][row] * v.z + m[3][row] * v.w;
  }
  return result;
}

glm::dmat4 product(const glm::dmat4& a, const glm::dmat4& b) {
  return {transformed(a, b[0]), transformed(a, b[1]), transformed(a, b[2]), transformed(a, b[3])};
}

double clip_z(const ThreeItem& item, const glm::dmat4& projection_view) {
  const glm::dvec4 centre(item.bounding_sphere_centre, 1);
  return transformed(projection_view, transformed(item.matrix_world, centre)).z;
}

Faces faces_of(ThreeSide side) {
  if (side == ThreeSide::double_side) return Faces::all;
  return side == ThreeSide::front ? Faces::front : Faces::back;
}

using RenderList = std::vector<ThreeRenderItem>;

std::array<RenderList, 3> listed(std::span<const ThreeItem> items, const ThreeCamera& camera) {
  const glm::dmat4 projection_view = product(camera.projection_matrix, camera.matrix_world_inverse);
  std::array<RenderList, 3> lists;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const ThreeItem& item = items[i];
    lists[static_cast<std::size_t>(three_list(item.material))].push_back({.item = static_cast<std::uint32_t>(i),
                                                                          .id = item.id,
                                                                          .group_order = item.group_order,
                                                                          .render_order = item.render_order,
                                                                          .material_id = item.material.id,
                                                                          .z = clip_z(item, projection_view)});
  }
  return lists;
}

// Draws of one target, with what their materials say.
class Draws {
 public:
  Draws(std::span<const ThreeItem> items, std::vector<ObjectDraw>& draws) : items_(items), draws_(draws) {}

  void add(std::uint32_t item, Faces faces, bool transmission_pass) {
    const ThreeMaterial& material = items_[item].material;
    draws_.push_back({.item = item,
                      .faces = faces,
                      .depth_test = material.depth_test,
                      .depth_write = material.depth_write,
                      .transmission_pass = transmission_pass,
                      .alpha_cutoff = material.alpha_test});
  }

  void add(const RenderList& list, bool transmission_pass) {
    for (const ThreeRenderItem& listed : list) {
      const ThreeMaterial& material = items_[listed.item].material;
      if (material.transparent && material.side == ThreeSide::double_side && !material.force_single_pass) {
        add(listed.item, Faces::back, transmission_pass);
        add(listed.item, Faces::front, transmission_pass);
      } else {
        add(listed.item, faces_of(material.side), transmission_pass);
      }
    }
  }

  void add_transmission_pass(const RenderList& opaque, const RenderList& transmissive) {
    add(opaque, true);
    for (const ThreeRenderItem& listed : transmissive) {
      if (items_[listed.item].material.side == ThreeSide::double_side) add(listed.item, Faces::back, true);
    }
  }

 private:
  std::span<const ThreeItem> items_;
  std::vector<ObjectDraw>& draws_;
};

}  // namespace

ThreeList three_list(const ThreeMaterial& material) {
  if (material.transmission > 0) return ThreeList::transmissive;
  return material.transparent ? ThreeList::transparent : ThreeList::opaque;
}

double three_clip_z(const ThreeItem& item, const ThreeCamera& camera) {
  return clip_z(item, product(camera.projection_matrix, camera.matrix_world_inverse));
}

double three_painter_sort_stable(const ThreeRenderItem& a, const ThreeRenderItem& b) {
  if (a.group_order != b.group_order) return a.group_order - b.group_order;
  if (a.render_order != b.render_order) return a.render_order - b.render_order;
  if (a.material_id != b.material_id) return static_cast<double>(a.material_id) - b.material_id;
  if (a.z != b.z) return a.z - b.z;
  return static_cast<double>(a.id) - b.id;
}

double three_reverse_painter_sort_stable(const ThreeRenderItem& a, const ThreeRenderItem& b) {
  if (a.group_order != b.group_order) return a.group_order - b.group_order;
  if (a.render_order != b.render_order) return a.render_order - b.render_order;
  if (a.z != b.z) return b.z - a.z;
  return static_cast<double>(a.id) - b.id;
}

std::vector<ObjectDraw> three_draw_order(std::span<const ThreeItem> items, const ThreeCamera& camera,
                                         const ThreeSettings& settings) {
  auto [opaque, transmissive, transparent] = listed(items, camera);
  if (settings.sort_objects) {
    using scene_internal::sort_by_comparator;
    const ThreeComparator opaque_sort = settings.opaque_sort ? settings.opaque_sort : three_painter_sort_stable;
    const ThreeComparator transparent_sort =
        settings.transparent_sort ? settings.transparent_sort : three_reverse_painter_sort_stable;
    sort_by_comparator(opaque, opaque_sort);
    sort_by_comparator(transmissive, transparent_sort);
    sort_by_comparator(transparent, transparent_sort);
  }

  std::vector<ObjectDraw> sequence;
  Draws draws(items, sequence);
  if (!transmissive.empty()) draws.add_transmission_pass(opaque, transmissive);
  for (const RenderList* list : {&opaque, &transmissive, &transparent}) draws.add(*list, false);
  return sequence;
}

}  // namespace facetsort
