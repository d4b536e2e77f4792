// The objects of a scene in the order in which an engine draws them.
#pragma once

#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "facetsort/scene/merge.h"
#include "facetsort/scene/object_draw.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

enum class DrawOrderRule { galacean, babylon, three, panda3d };

std::vector<DrawOrderRule> all_draw_order_rules();
// "galacean", "babylon", "three", "panda3d".
std::string_view draw_order_rule_name(DrawOrderRule rule);
std::optional<DrawOrderRule> draw_order_rule_from_name(std::string_view name);

// The draws of a frame by an engine's rule, with its defaults: every object in group, priority and render order 0, in
// the order of the scene. ObjectDraw::item is of `objects`, as merge() placed them. What a material is to an engine:
//
// - Galacean: isTransparent where it blends, alphaCutoff where it masks, renderFace by its sides;
// - Babylon.js: transparencyMode by the alpha mode, alphaCutOff, backFaceCulling by its sides;
// - Three.js: transparent where it blends (with depth written, as its materials do unless told not to), alphaTest where
//   it masks, side by its sides, transmission;
// - Panda3D: transparency on where it blends, two-sided by its sides.
//
// Draws into a transmission texture, which no picture here has, are left out. Preconditions: validate(scene) is ok, and
// `objects` are of it. Allocates; safe from several threads at once.
std::vector<ObjectDraw> scene_draw_order(DrawOrderRule rule, const Scene& scene, std::span<const MergedObject> objects,
                                         const SceneCamera& camera);

}  // namespace facetsort
