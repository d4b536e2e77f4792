// A mesh that owns its arrays: what the readers and the generators give.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  std::vector<glm::vec4> facet_colours;   // empty, or one a facet; linear RGB, straight alpha
  std::vector<glm::vec4> vertex_colours;  // empty, or one a vertex; linear RGB, straight alpha

  // See MeshView.
  std::vector<std::uint32_t> facet_materials{};
  std::vector<Material> materials{};
  std::vector<Texture> textures{};
  std::vector<glm::vec2> texture_coordinates{};

  // Valid until this mesh's arrays change or move.
  MeshView view() const {
    return {positions,       triangles, facet_colours, vertex_colours,
            facet_materials, materials, textures,      texture_coordinates};
  }
};

}  // namespace facetsort
