// The colour of a fragment: the mesh's own, or the project's default colours; lit by a headlight.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Alpha of facets without colours of their own.
inline constexpr float default_alpha = 0.5f;
// Opaque black, premultiplied.
inline constexpr glm::vec4 background{0, 0, 0, 1};

// Whether each facet has one colour: its own, its material's or the default for a mesh without either. Vertex colours
// count only where there are no facet colours.
bool has_one_colour_per_facet(const MeshView& mesh);

// Linear RGB and straight alpha at a corner (0, 1 or 2), before any texture: the facet's or the vertex's colour, or
// white, times the material's; alpha 1 where the material is opaque. Precondition: the mesh has colours or materials.
glm::vec4 corner_colour(const MeshView& mesh, std::uint32_t facet, int corner);

// A facet's material, or null.
inline const Material* material_of(const MeshView& mesh, std::uint32_t facet) {
  return mesh.facet_materials.empty() ? nullptr : &mesh.materials[mesh.facet_materials[facet]];
}

// The texture of a facet's material, or null.
inline const Texture* texture_of(const MeshView& mesh, std::uint32_t facet) {
  const Material* material = material_of(mesh, facet);
  return material == nullptr || material->texture == Material::no_texture ? nullptr : &mesh.textures[material->texture];
}

// Linear RGB and straight alpha of a facet in a mesh without colours: one hue a facet, from a hash of its id, so that
// any swap of two facets shows.
glm::vec4 default_facet_colour(std::uint32_t facet);

// Light on a facet: 0.25 + 0.75 |cos| of the angle between its normal and the direction from its centroid to the eye
// (a headlight, both sides lit). 1 for a degenerate facet.
float headlight(const MeshView& mesh, std::uint32_t facet, const glm::vec4& homogeneous_eye);

// Premultiplied colour of a facet, lit. Precondition: has_one_colour_per_facet(mesh).
glm::vec4 facet_colour(const MeshView& mesh, std::uint32_t facet, const glm::vec4& homogeneous_eye);

// Premultiplied colour where `ray` meets a facet: facet_colour, or the corners' colours interpolated in perspective
// (barycentric coordinates in double from the float32 corners; straight alpha is interpolated) times the texture's,
// then premultiplied. Where a material of AlphaMode::mask leaves the fragment out: all 0, which changes nothing.
glm::vec4 fragment_colour(const MeshView& mesh, std::uint32_t facet, const Ray& ray, const glm::vec4& homogeneous_eye);

// facet_colour of every facet, with its precondition; parallel in the caller's task arena.
void facet_colours(const MeshView& mesh, const glm::vec4& homogeneous_eye, std::vector<glm::vec4>& colours);

}  // namespace facetsort
