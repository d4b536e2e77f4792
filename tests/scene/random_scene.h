// Small scenes that no code chose: a few shapes, shown by many objects that are moved, turned, stretched and mirrored.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <utility>

#include "facetsort/blend/view.h"
#include "facetsort/scene/scene.h"
#include "shapes.h"

namespace facetsort {

class RandomNumbers {
 public:
  explicit RandomNumbers(std::uint32_t seed) : generator_(seed) {}
  double between(double low, double high) { return low + (high - low) * static_cast<double>(generator_()) * 0x1p-32; }
  std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(generator_()) % end; }
  glm::dvec3 point(double reach) {
    return glm::dvec3{between(-reach, reach), between(-reach, reach), between(-reach, reach)};
  }

 private:
  std::mt19937 generator_;
};

inline void add_mesh(Scene& scene, const std::string& name, Mesh mesh) {
  scene.meshes.push_back(
      {.name = name, .positions = std::move(mesh.positions), .triangles = std::move(mesh.triangles)});
}

// Objects of about 1 across in a cube that reaches to `reach` from the origin: the smaller, the more overlap.
inline Scene random_scene(std::uint32_t objects, double reach, std::uint32_t seed) {
  Scene scene;
  scene.materials.push_back({.name = "glass"});
  add_mesh(scene, "box", shapes::box());
  add_mesh(scene, "soup", shapes::soup(20, seed));
  add_mesh(scene, "shell", shapes::nested_shells(1, 0.5f, 1));
  add_mesh(scene, "cycle", shapes::triangle_cycle(3));
  RandomNumbers random(seed);
  for (std::uint32_t i = 0; i < objects; ++i) {
    glm::dmat4 world(1);
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) world[column][row] = random.between(-0.6, 0.6);
    }
    world[3] = glm::dvec4(random.point(reach), 1);
    scene.objects.push_back({.name = "object " + std::to_string(i), .mesh = random.below(4), .world = world});
  }
  return scene;
}

// From outside, from within, along a direction.
inline std::vector<View> looks_at(const Box& box, std::uint32_t seed, int size) {
  RandomNumbers random(seed);
  const glm::vec3 aside(glm::normalize(random.point(1)));
  std::vector<View> views{default_view(box, box.centre() + 2.5f * box.radius() * aside),
                          default_view(box, box.centre() + 2.5f * box.radius() * aside, Projection::orthographic)};
  for (const View& face : cube_views(box, box.centre() + 0.2f * box.radius() * aside)) views.push_back(face);
  for (View& view : views) view.width = view.height = size;
  return views;
}

}  // namespace facetsort
