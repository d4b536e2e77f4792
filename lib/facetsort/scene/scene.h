// Several meshes with materials, placed in one world: what a glTF file or a folder of mesh files describes.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/mesh/material.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/scene/engine_settings.h"
#include "facetsort/scene/panda3d_order.h"

namespace facetsort {

struct SceneMaterial {
  std::string name{};
  Material material{};
  // KHR_materials_transmission with a factor above 0: light comes through the surface itself, whatever alpha says.
  bool transmissive = false;
};

// Facets of one material, in a space of their own: a glTF primitive. Any number of objects may show the same.
struct SceneMesh {
  std::string name{};
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<glm::vec4> facet_colours{}, vertex_colours{};  // see MeshView
  std::vector<glm::vec2> texture_coordinates{};              // of the material's texture; empty, or one a vertex
  std::uint32_t material = 0;                                // of Scene::materials
};

// A mesh at its place in the world.
struct SceneObject {
  std::string name{};
  std::uint32_t mesh = 0;  // of Scene::meshes
  glm::dmat4 world{1};     // from the mesh's space; affine
  EngineSettings settings{};
};

// See View in blend/view.h, whose words these are.
struct SceneCamera {
  std::string name{};
  glm::dvec3 eye{0, 0, 3}, at{0, 0, 0}, up{0, 1, 0};
  bool perspective = true;
  double vertical_fov_degrees = 45;
  double height_in_units = 2;
  double near_distance = 1e-4;
};

struct Scene {
  std::vector<SceneMesh> meshes;
  std::vector<SceneMaterial> materials;
  std::vector<Texture> textures;
  std::vector<SceneObject> objects;
  std::vector<SceneCamera> cameras;
  std::vector<Panda3DBin> panda3d_bins{};  // beside panda3d_default_bins(), for the objects' settings
  std::vector<std::string> notes;  // of the reader: what the file has and the scene has not, a line each

  const SceneMesh& mesh_of(std::uint32_t object) const { return meshes[objects[object].mesh]; }
  const SceneMaterial& material_of(std::uint32_t object) const { return materials[mesh_of(object).material]; }
};

// Checks what all that take a scene count on: every mesh is valid (see validate(MeshView)) and has a material,
// materials have their textures, objects have their meshes, finite, affine places, finite settings, and bins that are
// there once. The fault names the part that has it. A scene without objects is sound.
Status validate(const Scene& scene);

// Those whose material is blended, by number: what has to be drawn back to front. Precondition: validate(scene) is ok.
std::vector<std::uint32_t> blended_objects(const Scene& scene);
// Those, and then all others.
std::vector<std::uint32_t> blended_first(const Scene& scene);

}  // namespace facetsort
