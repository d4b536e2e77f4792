// Premultiplied source-over, one fragment at a time, rounding as the blend target of a format does.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

#include "facetsort/blend/image.h"

namespace facetsort {

// Colours between clear() and finish() are in units of the format: 1 for rgba32f, 1/255 for rgba8.
class SourceOver {
 public:
  explicit SourceOver(PixelFormat format) : eight_bits_(format == PixelFormat::rgba8) {}

  glm::vec4 clear(const glm::vec4& colour) const { return rounded(colour * scale()); }
  glm::vec4 over(const glm::vec4& source, const glm::vec4& below) const {
    return rounded(source * scale() + below * (1.0f - source.a));
  }
  glm::vec4 finish(const glm::vec4& colour) const { return eight_bits_ ? colour * (1.0f / 255.0f) : colour; }

 private:
  float scale() const { return eight_bits_ ? 255.0f : 1.0f; }
  glm::vec4 rounded(glm::vec4 colour) const {
    for (int k = 0; k < 4 && eight_bits_; ++k) colour[k] = std::nearbyint(colour[k]);
    return colour;
  }

  bool eight_bits_;
};

}  // namespace facetsort
