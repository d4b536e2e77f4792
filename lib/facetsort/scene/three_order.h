// The order in which Three.js draws whole objects, r176 (three@0.176.0): src/renderers/webgl/WebGLRenderLists.js and,
// in src/renderers/WebGLRenderer.js, projectObject, renderTransmissionPass, renderScene and renderObject. Later
// releases sort by more.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/scene/object_draw.h"

namespace facetsort {

enum class ThreeSide { front, back, double_side };

// A Material, as far as the order reads it, with its defaults.
struct ThreeMaterial {
  std::uint32_t id = 0;  // counts materials as they are made
  double transmission = 0;
  bool transparent = false;
  ThreeSide side = ThreeSide::front;
  bool force_single_pass = false;
  bool depth_test = true;
  bool depth_write = true;  // transparent or not
  double alpha_test = 0;
};

// A mesh, or a group of its geometry where it has several materials.
struct ThreeItem {
  std::uint32_t id = 0;     // of the object; counts objects as they are made
  double group_order = 0;   // renderOrder of the nearest Group above it, 0 if there is none
  double render_order = 0;  // of the object itself
  glm::dmat4 matrix_world{1};
  glm::dvec3 bounding_sphere_centre{0};  // of its geometry, in its own space
  ThreeMaterial material = {};
};

struct ThreeCamera {
  glm::dmat4 projection_matrix{1};
  glm::dmat4 matrix_world_inverse{1};
};

enum class ThreeList { opaque, transmissive, transparent };

// Transmission is asked first: a transparent material that transmits is in the transmissive list.
ThreeList three_list(const ThreeMaterial& material);

// Clip-space z of the centre of the object's bounding sphere, before the divide by w. In double, each sum from left to
// right, as three.js has it: equal to the engine's own to the bit.
double three_clip_z(const ThreeItem& item, const ThreeCamera& camera);

// What a list sorts.
struct ThreeRenderItem {
  std::uint32_t item = 0;
  std::uint32_t id = 0;
  double group_order = 0;
  double render_order = 0;
  std::uint32_t material_id = 0;
  double z = 0;
};
// Below 0 where `a` is drawn first, above 0 where `b` is, else (NaN too) the earlier. It may contradict itself: the
// draws are then in some order.
using ThreeComparator = std::function<double(const ThreeRenderItem& a, const ThreeRenderItem& b)>;

// painterSortStable, of the opaque list: group order, render order, material, near to far, id.
double three_painter_sort_stable(const ThreeRenderItem& a, const ThreeRenderItem& b);
// reversePainterSortStable, of the transmissive and of the transparent list: group order, render order, far to near,
// id.
double three_reverse_painter_sort_stable(const ThreeRenderItem& a, const ThreeRenderItem& b);

// Of the WebGLRenderer.
struct ThreeSettings {
  bool sort_objects = true;               // off: each list in the order of the scene graph
  ThreeComparator opaque_sort = {};       // setOpaqueSort; empty: three_painter_sort_stable
  ThreeComparator transparent_sort = {};  // setTransparentSort, of both other lists; empty: the reverse
};

// The draws of a frame. Where something transmits, first a transmission pass: the opaque list, then the back faces of
// double-sided transmissive items. Then the picture: opaque, transmissive, transparent; a transparent double-sided
// material without force_single_pass is drawn twice, back faces and then front faces. Items are given in the order of
// the scene graph (depth first), groups of a geometry after each other, which decides where all keys tie.
// Allocates; safe from several threads at once, as far as the settings' comparators are.
std::vector<ObjectDraw> three_draw_order(std::span<const ThreeItem> items, const ThreeCamera& camera,
                                         const ThreeSettings& settings = {});

}  // namespace facetsort
