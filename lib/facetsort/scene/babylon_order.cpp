#include "facetsort/scene/babylon_order.h"

#include <cmath>
#include <cstddef>
#include <utility>

#include "facetsort/scene/comparator_sort.h"

namespace facetsort {
namespace {

using Mode = BabylonTransparencyMode;

bool blends(Mode mode) {
  return mode == Mode::alpha_blend || mode == Mode::alpha_test_and_blend;
}

bool tests(Mode mode) {
  return mode == Mode::alpha_test || mode == Mode::alpha_test_and_blend;
}

bool has_alpha_channel(const BabylonMaterial& material) {
  return material.diffuse_texture_has_alpha || material.has_opacity_texture;
}

// What there is to blend by.
bool has_alpha_to_blend(const BabylonSubMesh& sub_mesh) {
  const BabylonMaterial& material = sub_mesh.material;
  return sub_mesh.has_vertex_alpha || material.alpha < 1 || material.has_opacity_texture ||
         (material.diffuse_texture_has_alpha && material.use_alpha_from_diffuse_texture);
}

// The queues of a rendering group; empty ones draw nothing.
struct Queues {
  std::vector<BabylonSortItem> depth_only, opaque, alpha_test, transparent;
};

class FrameDraws {
 public:
  FrameDraws(std::span<const BabylonSubMesh> sub_meshes, const BabylonScene& scene)
      : sub_meshes_(sub_meshes), scene_(scene), queues_(scene.rendering_groups.size()) {}

  std::vector<ObjectDraw> draws() {
    for (std::size_t i = 0; i < sub_meshes_.size(); ++i) dispatch(static_cast<std::uint32_t>(i));
    for (std::size_t group = 0; group < queues_.size(); ++group) draw_group(group);
    return std::move(draws_);
  }

 private:
  enum class Target { depth, colour, blended_colour };

  void dispatch(std::uint32_t item) {
    const BabylonSubMesh& sub_mesh = sub_meshes_[item];
    if (sub_mesh.rendering_group_id >= queues_.size()) return;
    Queues& queues = queues_[sub_mesh.rendering_group_id];
    BabylonSortItem entry{.item = item, .sub_mesh = &sub_mesh};
    const BabylonCategory category = babylon_category(sub_mesh, scene_.transparency_rule);
    if (category == BabylonCategory::transparent) {
      entry.alpha_index = sub_mesh.alpha_index;
      entry.distance_to_camera = babylon_distance_to_camera(sub_mesh, scene_.camera_global_position);
      queues.transparent.push_back(entry);
      return;
    }
    if (has_depth_pre_pass(sub_mesh.material)) queues.depth_only.push_back(entry);
    (category == BabylonCategory::opaque ? queues.opaque : queues.alpha_test).push_back(entry);
  }

  void draw_group(std::size_t index) {
    const BabylonRenderingGroup& group = scene_.rendering_groups[index];
    Queues& queues = queues_[index];
    const std::size_t first = draws_.size();
    sort(queues.depth_only, group.alpha_test_sort_compare, babylon_painter_sort_compare);
    sort(queues.opaque, group.opaque_sort_compare, babylon_painter_sort_compare);
    sort(queues.alpha_test, group.alpha_test_sort_compare, babylon_painter_sort_compare);
    sort(queues.transparent, group.transparent_sort_compare, babylon_default_transparent_sort_compare);
    for (const BabylonSortItem& entry : queues.depth_only) draw(entry.item, Target::depth);
    for (const BabylonSortItem& entry : queues.opaque) draw(entry.item, Target::colour);
    for (const BabylonSortItem& entry : queues.alpha_test) draw(entry.item, Target::colour);
    for (const BabylonSortItem& entry : queues.transparent) {
      if (has_depth_pre_pass(entry.sub_mesh->material)) draw(entry.item, Target::depth);
      draw(entry.item, Target::blended_colour);
    }
    if (draws_.size() > first) draws_[first].clear_depth = index > 0 && group.auto_clear_depth;
  }

  bool has_depth_pre_pass(const BabylonMaterial& material) const {
    return material.need_depth_pre_pass && !scene_.disable_depth_pre_pass;
  }

  static void sort(std::vector<BabylonSortItem>& queue, const BabylonComparator& custom,
                   double (*usual)(const BabylonSortItem&, const BabylonSortItem&)) {
    if (custom) {
      scene_internal::sort_by_comparator(queue, custom);
    } else {
      scene_internal::sort_by_comparator(queue, usual);
    }
  }

  void draw(std::uint32_t item, Target target) {
    const BabylonMaterial& material = sub_meshes_[item].material;
    const bool blended = target == Target::blended_colour && material.alpha_mode != babylon_alpha_disable;
    const bool tested = babylon_needs_alpha_testing(sub_meshes_[item], scene_.transparency_rule);
    ObjectDraw draw{.item = item,
                    .faces = Faces::all,
                    .colour_write = target != Target::depth,
                    .depth_write = !material.disable_depth_write && (!blended || material.force_depth_write),
                    .alpha_cutoff = tested ? material.alpha_cut_off : 0};
    const Faces culled_to = material.cull_back_faces ? Faces::front : Faces::back;
    if (material.back_face_culling) {
      draw.faces = culled_to;
    } else if (material.separate_culling_pass) {
      draw.faces = material.cull_back_faces ? Faces::back : Faces::front;
      draws_.push_back(draw);
      draw.faces = culled_to;
    }
    draws_.push_back(draw);
  }

  std::span<const BabylonSubMesh> sub_meshes_;
  const BabylonScene& scene_;
  std::vector<Queues> queues_;
  std::vector<ObjectDraw> draws_;
};

}  // namespace

bool babylon_needs_alpha_blending(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule) {
  const std::optional<Mode>& mode = sub_mesh.material.transparency_mode;
  if (mode && rule == BabylonTransparencyRule::mode_first) return blends(*mode);
  if (sub_mesh.visibility < 1) return true;
  if (mode && !blends(*mode)) return false;
  return has_alpha_to_blend(sub_mesh);
}

bool babylon_needs_alpha_testing(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule) {
  const std::optional<Mode>& mode = sub_mesh.material.transparency_mode;
  if (mode && rule == BabylonTransparencyRule::mode_first) return tests(*mode);
  if (mode == Mode::alpha_test_and_blend) return true;
  if (babylon_needs_alpha_blending(sub_mesh, rule)) return false;
  return has_alpha_channel(sub_mesh.material) && mode.value_or(Mode::alpha_test) == Mode::alpha_test;
}

BabylonCategory babylon_category(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule) {
  if (babylon_needs_alpha_blending(sub_mesh, rule)) return BabylonCategory::transparent;
  return babylon_needs_alpha_testing(sub_mesh, rule) ? BabylonCategory::alpha_test : BabylonCategory::opaque;
}

double babylon_distance_to_camera(const BabylonSubMesh& sub_mesh, const glm::dvec3& camera_global_position) {
  const glm::dvec3 difference = sub_mesh.bounding_sphere_centre_world - camera_global_position;
  return std::sqrt(difference.x * difference.x + difference.y * difference.y + difference.z * difference.z);
}

double babylon_painter_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b) {
  const std::optional<std::uint32_t> a_material = a.sub_mesh->mesh_material_unique_id;
  const std::optional<std::uint32_t> b_material = b.sub_mesh->mesh_material_unique_id;
  if (a_material && b_material) return static_cast<double>(*a_material) - *b_material;
  return static_cast<double>(a.sub_mesh->mesh_unique_id) - b.sub_mesh->mesh_unique_id;
}

double babylon_default_transparent_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b) {
  if (a.alpha_index > b.alpha_index) return 1;
  if (a.alpha_index < b.alpha_index) return -1;
  return babylon_back_to_front_sort_compare(a, b);
}

double babylon_back_to_front_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b) {
  return babylon_front_to_back_sort_compare(b, a);
}

double babylon_front_to_back_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b) {
  if (a.distance_to_camera < b.distance_to_camera) return -1;
  return a.distance_to_camera > b.distance_to_camera ? 1 : 0;
}

std::vector<ObjectDraw> babylon_draw_order(std::span<const BabylonSubMesh> sub_meshes, const BabylonScene& scene) {
  return FrameDraws(sub_meshes, scene).draws();
}

}  // namespace facetsort
