// Internal to scene: glTF 2.0 in.
#pragma once

#include <filesystem>

#include "facetsort/scene/scene.h"

namespace facetsort::scene_internal {

// Throws SceneError, and std::bad_alloc.
Scene read_gltf(const std::filesystem::path& path);

}  // namespace facetsort::scene_internal
