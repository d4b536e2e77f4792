// Where a picture is wrong and by how much, for human eyes.
#pragma once

#include <glm/glm.hpp>

#include "facetsort/blend/image.h"

namespace facetsort {

// Two pictures differ at a pixel when some channel differs by more than this: one step of an 8-bit display.
inline constexpr float display_step = 1.0f / 255;

// sRGB-encoded colour of a difference, violet over red and orange to pale yellow, ever lighter. Logarithmic, from
// display_step to 1, so that small differences can be told from none. Differences outside that range take the colour
// at its end.
glm::vec3 difference_colour(float difference);

// Pixels that differ (see display_step; the largest difference of the four channels counts) in difference_colour, on
// the reference in dark grey. Opaque; linear, as every Image. Precondition: same size.
Image difference_image(const Image& image, const Image& reference);

}  // namespace facetsort
