// The order in which Babylon.js draws whole objects. Read from @babylonjs/core 9.34.0: Rendering/renderingManager,
// Rendering/renderingGroup, Materials/material, Materials/standardMaterial and Mesh.render in Meshes/mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "facetsort/scene/object_draw.h"

namespace facetsort {

enum class BabylonTransparencyMode { opaque, alpha_test, alpha_blend, alpha_test_and_blend };

// Engine.ALPHA_DISABLE: what is drawn replaces what is there, and writes depth. Engine.ALPHA_COMBINE: source over.
// Other modes blend otherwise and are no different to the order.
inline constexpr int babylon_alpha_disable = 0, babylon_alpha_combine = 2;

// A StandardMaterial, as far as the order reads it, with its defaults.
struct BabylonMaterial {
  double alpha = 1;
  std::optional<BabylonTransparencyMode> transparency_mode = {};  // unset: from what follows
  bool diffuse_texture_has_alpha = false;
  bool use_alpha_from_diffuse_texture = false;  // to blend by it; otherwise it is tested
  bool has_opacity_texture = false;
  double alpha_cut_off = 0.4;
  int alpha_mode = babylon_alpha_combine;
  bool need_depth_pre_pass = false;
  bool back_face_culling = true;
  bool separate_culling_pass = false;  // without back_face_culling: back faces, then front faces
  bool cull_back_faces = true;         // off: where faces are culled, it is the front faces
  bool force_depth_write = false;      // where it blends, too
  bool disable_depth_write = false;
};

// A sub-mesh and what it has from its mesh.
struct BabylonSubMesh {
  BabylonMaterial material = {};
  std::uint32_t mesh_unique_id = 0;
  std::optional<std::uint32_t> mesh_material_unique_id = {};  // of mesh.material (a MultiMaterial's own), if any
  std::uint32_t rendering_group_id = 0;
  double alpha_index = std::numeric_limits<double>::max();
  double visibility = 1;
  bool has_vertex_alpha = false;
  glm::dvec3 bounding_sphere_centre_world{0};  // of the sub-mesh
};

// Which of two statements about a material wins.
enum class BabylonTransparencyRule {
  mode_first,        // a transparency mode that is set (by 7.54.3; recorded from 9.34.0)
  visibility_first,  // mesh.visibility below 1 blends, whatever the mode; a mode that blends, or alpha_test, only lets
                     // a material do so that has an alpha for it (recorded from 7.0.0)
};

// Visibility below 1 forces blending and turns alpha test off (under mode_first: where no mode is set).
bool babylon_needs_alpha_blending(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule);
// True together with blending for alpha_test_and_blend, and for nothing else.
bool babylon_needs_alpha_testing(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule);

enum class BabylonCategory { opaque, alpha_test, transparent };
BabylonCategory babylon_category(const BabylonSubMesh& sub_mesh, BabylonTransparencyRule rule);

// Straight from the camera to the centre of the bounding sphere, in double, from left to right under the square root as
// Vector3.Distance has it: distances that it rounds to the same number tie.
double babylon_distance_to_camera(const BabylonSubMesh& sub_mesh, const glm::dvec3& camera_global_position);

// What a queue sorts. The engine sets alpha index and distance for the transparent queue alone: they are 0 in others.
struct BabylonSortItem {
  std::uint32_t item = 0;
  const BabylonSubMesh* sub_mesh = nullptr;
  double alpha_index = 0;
  double distance_to_camera = 0;
};
// Below 0 where `a` is drawn first, above 0 where `b` is, else (NaN too) the earlier. It may contradict itself: the
// draws are then in some order.
using BabylonComparator = std::function<double(const BabylonSortItem& a, const BabylonSortItem& b)>;

// RenderingGroup's: PainterSortCompare by the materials of both meshes, by the meshes where one has none (which is no
// order where some have); defaultTransparentSortCompare by alpha index, then back to front.
double babylon_painter_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b);
double babylon_default_transparent_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b);
double babylon_back_to_front_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b);
double babylon_front_to_back_sort_compare(const BabylonSortItem& a, const BabylonSortItem& b);

struct BabylonRenderingGroup {
  bool auto_clear_depth = true;  // before it is drawn, but for group 0
  // setRenderingOrder; empty: painter for opaque and for alpha test, default_transparent for transparent. That of alpha
  // test sorts the depth pre-pass, too.
  BabylonComparator opaque_sort_compare = {};
  BabylonComparator alpha_test_sort_compare = {};
  BabylonComparator transparent_sort_compare = {};
};

struct BabylonScene {
  glm::dvec3 camera_global_position{0};  // perspective and orthographic alike
  // RenderingManager.MAX_RENDERINGGROUPS of them. What is in a group beyond is not drawn.
  std::vector<BabylonRenderingGroup> rendering_groups = std::vector<BabylonRenderingGroup>(4);
  bool disable_depth_pre_pass = false;
  BabylonTransparencyRule transparency_rule = BabylonTransparencyRule::mode_first;
};

// The draws of a frame, group after group. Within one: depth of those opaque and alpha-tested sub-meshes that need a
// depth pre-pass; opaque; alpha test; transparent, each just after its own depth pre-pass if it needs one. Where faces
// are culled in separate passes each of these is two draws. Sub-meshes are given in the order of the scene's meshes,
// which decides ties. Allocates; safe from several threads at once, as far as the groups' comparators are.
std::vector<ObjectDraw> babylon_draw_order(std::span<const BabylonSubMesh> sub_meshes, const BabylonScene& scene);

}  // namespace facetsort
