// The mesh as every stage sees it: borrowed, indexed triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "facetsort/mesh/material.h"

namespace facetsort {

// Borrows a triangle mesh; owns nothing, copies cheaply, and is valid as long as the arrays are.
// Right-handed coordinates; a facet whose corners run counter-clockwise as seen from the eye faces it.
// A facet's id is its position in `triangles`.
//
// Preconditions of every function that takes a MeshView, unless it says otherwise: validate(mesh) is ok.
struct MeshView {
  std::span<const glm::vec3> positions;
  std::span<const glm::uvec3> triangles;      // indices into positions
  std::span<const glm::vec4> facet_colours;   // linear RGB and straight alpha, one a facet, or empty
  std::span<const glm::vec4> vertex_colours;  // linear RGB and straight alpha, one a vertex, or empty
  // What every facet's material is; without, all are blended, double-sided and untextured, and a mesh that has no
  // colours either gets the default ones (see blend/shading.h).
  std::span<const std::uint32_t> facet_materials{};  // indices into materials, one a facet, or empty
  std::span<const Material> materials{};
  std::span<const Texture> textures{};
  std::span<const glm::vec2> texture_coordinates{};  // one a vertex, or empty where no facet has a texture

  std::size_t facet_count() const { return triangles.size(); }
  std::size_t vertex_count() const { return positions.size(); }
  glm::vec3 corner(std::size_t facet, int i) const { return positions[triangles[facet][i]]; }
};

// Whether a facet is drawn only where it is seen from the front.
inline bool is_single_sided(const MeshView& mesh, std::size_t facet) {
  return !mesh.facet_materials.empty() && !mesh.materials[mesh.facet_materials[facet]].double_sided;
}

}  // namespace facetsort
