#include "facetsort/scene/gltf_nodes.h"

#include <algorithm>
#include <cmath>

#include "facetsort/scene/gltf_file.h"

namespace facetsort::scene_internal {
namespace {

constexpr double degrees_per_radian = 57.29577951308232;

std::string name_of(std::size_t node) {
  return "node " + std::to_string(node);
}

glm::dmat4 rotation_of(const std::vector<double>& quaternion) {
  const glm::dvec4 given(quaternion[0], quaternion[1], quaternion[2], quaternion[3]);
  const double length = glm::length(given);
  const glm::dvec4 q = length > 0 ? given / length : glm::dvec4(0, 0, 0, 1);
  const double x = q.x, y = q.y, z = q.z, w = q.w;
  return {glm::dvec4(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 0),
          glm::dvec4(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w), 0),
          glm::dvec4(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y), 0), glm::dvec4(0, 0, 0, 1)};
}

// From the node's space to its parent's.
glm::dmat4 local_of(const tinygltf::Node& node, std::size_t index) {
  const auto check = [&](const std::vector<double>& list, std::size_t size, const char* what) {
    if (list.empty() || list.size() == size) return;
    throw SceneError{Fault::malformed,
                     name_of(index) + ": a " + what + " of " + std::to_string(list.size()) + " numbers"};
  };
  check(node.matrix, 16, "matrix");
  check(node.translation, 3, "translation");
  check(node.rotation, 4, "rotation");
  check(node.scale, 3, "scale");
  glm::dmat4 local(1);
  if (!node.matrix.empty()) {
    for (int i = 0; i < 16; ++i) local[i / 4][i % 4] = node.matrix[static_cast<std::size_t>(i)];
    return local;
  }
  if (!node.rotation.empty()) local = rotation_of(node.rotation);
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    if (!node.scale.empty()) local[axis] *= node.scale[i];
    if (!node.translation.empty()) local[3][axis] = node.translation[i];
  }
  return local;
}

void check_world(const glm::dmat4& world, std::size_t index) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const double expected = column == 3 ? 1 : 0;  // of the last row
      if (std::isfinite(world[column][row]) && (row < 3 || world[column][row] == expected)) continue;
      throw SceneError{Fault::malformed, name_of(index) + ": a place that is not finite or not affine"};
    }
  }
}

std::vector<int> roots_of(const tinygltf::Model& model) {
  if (!model.scenes.empty()) return model.scenes[shown_scene(model)].nodes;
  std::vector<bool> is_child(model.nodes.size(), false);
  for (const tinygltf::Node& node : model.nodes) {
    for (const int child : node.children) {
      if (child >= 0 && static_cast<std::size_t>(child) < is_child.size())
        is_child[static_cast<std::size_t>(child)] = true;
    }
  }
  std::vector<int> roots;
  for (std::size_t i = 0; i < is_child.size(); ++i) {
    if (!is_child[i]) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

}  // namespace

std::size_t shown_scene(const tinygltf::Model& model) {
  const auto scene = static_cast<std::size_t>(std::max(model.defaultScene, 0));
  if (scene < model.scenes.size()) return scene;
  throw SceneError{Fault::index_out_of_range,
                   "the default scene is " + std::to_string(scene) + " of " + std::to_string(model.scenes.size())};
}

SceneCamera read_camera(const tinygltf::Model& model, const tinygltf::Node& node, const glm::dmat4& world,
                        const std::string& place) {
  if (static_cast<std::size_t>(node.camera) >= model.cameras.size()) {
    throw SceneError{Fault::index_out_of_range, place + " names camera " + std::to_string(node.camera) + " of " +
                                                    std::to_string(model.cameras.size())};
  }
  const tinygltf::Camera& from = model.cameras[static_cast<std::size_t>(node.camera)];
  SceneCamera camera;
  camera.name = from.name.empty() ? node.name : from.name;
  // Cameras look along their own -z.
  camera.eye = glm::dvec3(world[3]);
  camera.at = camera.eye - glm::dvec3(world[2]);
  camera.up = glm::dvec3(world[1]);
  camera.perspective = from.type != "orthographic";
  if (camera.perspective) {
    camera.vertical_fov_degrees = from.perspective.yfov * degrees_per_radian;
    camera.near_distance = from.perspective.znear;
  } else {
    camera.height_in_units = 2 * from.orthographic.ymag;
    camera.near_distance = from.orthographic.znear;
  }
  return camera;
}

std::vector<PlacedNode> placed_nodes(const tinygltf::Model& model) {
  struct Waiting {
    int node;
    glm::dmat4 parent;
  };
  std::vector<Waiting> waiting;  // the next last
  const auto add = [&](const std::vector<int>& nodes, const glm::dmat4& parent) {
    for (auto node = nodes.rbegin(); node != nodes.rend(); ++node) waiting.push_back({*node, parent});
  };
  add(roots_of(model), glm::dmat4(1));
  std::vector<bool> is_placed(model.nodes.size(), false);
  std::vector<PlacedNode> placed;
  while (!waiting.empty()) {
    const Waiting next = waiting.back();
    waiting.pop_back();
    if (next.node < 0 || static_cast<std::size_t>(next.node) >= model.nodes.size()) {
      throw SceneError{Fault::index_out_of_range, "a scene or node names node " + std::to_string(next.node) + " of " +
                                                      std::to_string(model.nodes.size())};
    }
    const auto index = static_cast<std::size_t>(next.node);
    if (is_placed[index]) {
      throw SceneError{Fault::malformed, name_of(index) + " is reached twice: by a cycle or from two parents"};
    }
    is_placed[index] = true;
    const glm::dmat4 world = next.parent * local_of(model.nodes[index], index);
    check_world(world, index);
    placed.push_back({index, world});
    add(model.nodes[index].children, world);
  }
  return placed;
}

}  // namespace facetsort::scene_internal
