#include "facetsort/blend/texture.h"

#include <cassert>
#include <cmath>

namespace facetsort {
namespace {

// Two texels that a place lies between along one axis, and how near it is to the second.
struct Neighbours {
  int first, second;
  float share;
};

// For a texel of an endless row of textures, side by side or mirrored, or only the row's end: its place in the texture.
int wrapped(double texel, int size, Wrap wrap) {
  if (wrap == Wrap::clamp_to_edge) return static_cast<int>(std::fmin(std::fmax(texel, 0), size - 1));
  const double period = wrap == Wrap::repeat ? size : 2.0 * size;
  const double remainder = std::fmod(texel, period);  // exact
  const int within = static_cast<int>(remainder < 0 ? remainder + period : remainder);
  return within < size ? within : 2 * size - 1 - within;
}

Neighbours neighbours(double coordinate, int size, Wrap wrap) {
  const double place = coordinate * size - 0.5, before = std::floor(place);
  return {wrapped(before, size, wrap), wrapped(before + 1, size, wrap), static_cast<float>(place - before)};
}

}  // namespace

glm::vec4 sample(const Texture& texture, const glm::dvec2& texture_coordinates) {
  assert(!texture.texels.empty());
  const Neighbours u = neighbours(texture_coordinates.x, texture.width, texture.wrap_u);
  const Neighbours v = neighbours(texture_coordinates.y, texture.height, texture.wrap_v);
  const auto row = [&](int y) {
    const glm::vec4* texels =
        texture.texels.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(texture.width);
    return glm::mix(texels[u.first], texels[u.second], u.share);
  };
  return glm::mix(row(v.first), row(v.second), v.share);
}

}  // namespace facetsort
