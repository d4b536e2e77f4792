// Reading textures.
#pragma once

#include <glm/glm.hpp>

#include "facetsort/mesh/material.h"

namespace facetsort {

// Bilinear (glTF 2.0's LINEAR): the four texels whose centres surround the place, weighted, places outside the texture
// as its wrap modes say. Linear RGB and straight alpha, each interpolated by itself. Precondition: the texture has
// texels; texture coordinates are finite.
glm::vec4 sample(const Texture& texture, const glm::dvec2& texture_coordinates);

}  // namespace facetsort
