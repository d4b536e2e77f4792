// Internal to scene: where the nodes of a glTF file are, and its cameras.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "facetsort/scene/scene.h"

namespace facetsort::scene_internal {

struct PlacedNode {
  std::size_t node;
  glm::dmat4 world;
};

// The default scene, the first where the file names none. Throws SceneError. Precondition: the model has scenes.
std::size_t shown_scene(const tinygltf::Model& model);

// Of the default scene (of the first where the file names none, of all nodes where it has none), parents before
// children, each in the order of the file. Throws SceneError, where a node is reached twice too.
std::vector<PlacedNode> placed_nodes(const tinygltf::Model& model);

// Throws SceneError.
SceneCamera read_camera(const tinygltf::Model& model, const tinygltf::Node& node, const glm::dmat4& world,
                        const std::string& place);

}  // namespace facetsort::scene_internal
