// Views that no code chose.
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "facetsort/blend/view.h"
#include "facetsort/facets/facets.h"

namespace facetsort {

// From random directions, at 3 bounding radii, 512 x 512; the same for the same seed.
inline std::vector<View> random_views(const MeshView& mesh, std::size_t count, std::uint32_t seed) {
  const Box box = facet_bounds(mesh);
  std::mt19937 random(seed);
  std::vector<View> views;
  while (views.size() < count) {
    glm::vec3 point;
    for (int axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(random()) * 0x1p-31f - 1;
    const float length = glm::length(point);
    if (length < 0.1f || length > 1) continue;
    views.push_back(default_view(box, box.centre() + point * (3 * box.radius() / length)));
  }
  return views;
}

}  // namespace facetsort
