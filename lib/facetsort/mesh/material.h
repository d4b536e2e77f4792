// What a facet looks like beyond its own or its vertices' colours, in the words of glTF 2.0.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace facetsort {

// What alpha does to what lies behind.
enum class AlphaMode {
  opaque,  // nothing shows through; alpha counts as 1
  mask,    // a fragment whose alpha is below the cutoff is not drawn; any other is opaque
  blend,   // source-over
};

enum class Wrap { repeat, mirrored_repeat, clamp_to_edge };

// Sampled bilinearly, without mip maps. Texel (i, j) has its centre at ((i + 1/2) / width, (j + 1/2) / height) in
// texture coordinates, whose origin is the picture's upper left corner.
struct Texture {
  int width = 0, height = 0;
  std::vector<glm::vec4> texels{};  // linear RGB, straight alpha, row after row, the upper first
  Wrap wrap_u = Wrap::repeat, wrap_v = Wrap::repeat;
};

// The colour of a fragment is the product of this colour, the facet's or vertices' own (white where the mesh has none)
// and the texture's.
struct Material {
  static constexpr std::uint32_t no_texture = 0xffffffffu;

  glm::vec4 base_colour{1};  // linear RGB, straight alpha
  AlphaMode alpha_mode = AlphaMode::blend;
  float alpha_cutoff = 0.5f;           // of AlphaMode::mask
  bool double_sided = true;            // if not, facets seen from behind are not drawn
  std::uint32_t texture = no_texture;  // of MeshView::textures
};

}  // namespace facetsort
