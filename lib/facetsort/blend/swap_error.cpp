#include "facetsort/blend/swap_error.h"

#include <cstddef>
#include <limits>

namespace facetsort {
namespace {

// Infinite where a layer adds light without covering anything: it has no straight colour.
glm::vec3 range_of_averages(std::span<const glm::vec4> layers) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  glm::vec3 lowest(infinity), highest(-infinity);
  float transparency = 1;
  for (const glm::vec4& layer : layers) {
    const glm::vec3 premultiplied(layer);
    if (layer.a <= 0) {
      if (premultiplied != glm::vec3(0)) return glm::vec3(infinity);
      continue;
    }
    lowest = glm::min(lowest, premultiplied / layer.a);
    highest = glm::max(highest, premultiplied / layer.a);
    transparency *= 1 - layer.a;
  }
  return transparency < 1 ? (1 - transparency) * (highest - lowest) : glm::vec3(0);
}

}  // namespace

glm::vec3 swap_error(const glm::vec4& layer1, const glm::vec4& layer2) {
  return glm::abs(layer1.a * glm::vec3(layer2) - layer2.a * glm::vec3(layer1));
}

glm::vec3 order_error_bound(std::span<const glm::vec4> layers) {
  glm::vec3 of_swaps(0);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    for (std::size_t j = i + 1; j < layers.size(); ++j) of_swaps += swap_error(layers[i], layers[j]);
  }
  return glm::min(of_swaps, range_of_averages(layers));
}

}  // namespace facetsort
