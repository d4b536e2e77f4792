// Internal to scene: engines' settings in the `extras` of glTF's nodes and scenes, under "facetsort" (see
// read_scene.h).
#pragma once

#include <tiny_gltf.h>

#include <string>
#include <vector>

#include "facetsort/scene/engine_settings.h"
#include "facetsort/scene/panda3d_order.h"

namespace facetsort::scene_internal {

// Of a node, whose extras are this JSON, or empty; the defaults where they have none. Throws SceneError for what is no
// setting, or of another type.
EngineSettings read_settings(const std::string& extras, const std::string& place);
// Of a scene: Panda3D's bins beside its own. Throws SceneError.
std::vector<Panda3DBin> read_bins(const std::string& extras, const std::string& place);

// Null where all are as they are by default.
tinygltf::Value extras_of(const EngineSettings& settings);
tinygltf::Value extras_of(const std::vector<Panda3DBin>& bins);

}  // namespace facetsort::scene_internal
