// The objects of a scene in the order in which an engine draws them.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/object_draw.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

enum class DrawOrderRule { galacean, babylon, three, panda3d };

std::vector<DrawOrderRule> all_draw_order_rules();
// "galacean", "babylon", "three", "panda3d".
std::string_view draw_order_rule_name(DrawOrderRule rule);
std::optional<DrawOrderRule> draw_order_rule_from_name(std::string_view name);

// The draws of a frame by an engine's rule, with the objects' settings (SceneObject::settings), in the order of the
// scene where they tie. What a material is to an engine:
//
// - Galacean: isTransparent where it blends, alphaCutoff where it masks, renderFace by its sides;
// - Babylon.js: transparencyMode by the alpha mode, alphaCutOff, backFaceCulling by its sides;
// - Three.js: transparent where it blends (with depth written unless its settings say not to), alphaTest where
//   it masks, side by its sides, transmission;
// - Panda3D: transparency on where it blends, two-sided by its sides.
//
// Draws into a transmission texture, which no picture here has, are left out.
class SceneDrawOrder {
 public:
  // Bounds the objects' meshes, once. The scene and the array must outlive this. Preconditions: validate(scene) is ok, and
  // `objects`, as merge() placed them, are of it.
  SceneDrawOrder(const Scene& scene, std::span<const MergedObject> objects);

  // ObjectDraw::item is of `objects`. Allocates; safe from several threads at once.
  std::vector<ObjectDraw> find(DrawOrderRule rule, const SceneCamera& camera) const;

 private:
  const Scene* scene_;
  std::span<const MergedObject> objects_;
  std::vector<Box> boxes_;  // of each object's vertices, in its mesh's space
};

}  // namespace facetsort
