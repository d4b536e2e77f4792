// Hilbert, "Ueber die stetige Abbildung einer Linie auf ein Flaechenstueck", 1891, in three dimensions by the transpose
// of Skilling, "Programming the Hilbert curve", 2004.
#include "facetsort/order/spatial_order.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cstddef>
#include <glm/glm.hpp>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/facets/facets.h"

namespace facetsort {
namespace {

constexpr int axis_bits = 21;  // three axes in 64 bits
constexpr std::size_t facets_per_task = 16384;

// Place along the curve of a cell of the cube [0, 2^21)^3.
std::uint64_t hilbert_index(glm::uvec3 cell) {
  // Undo the turns of each level, from the coarsest, ...
  for (std::uint32_t level = 1u << (axis_bits - 1); level > 1; level >>= 1) {
    const std::uint32_t below = level - 1;
    for (int axis = 0; axis < 3; ++axis) {
      if ((cell[axis] & level) != 0) {
        cell[0] ^= below;
      } else {
        const std::uint32_t exchanged = (cell[0] ^ cell[axis]) & below;
        cell[0] ^= exchanged;
        cell[axis] ^= exchanged;
      }
    }
  }
  // ... then the Gray code ...
  for (int axis = 1; axis < 3; ++axis) cell[axis] ^= cell[axis - 1];
  std::uint32_t flips = 0;
  for (std::uint32_t level = 1u << (axis_bits - 1); level > 1; level >>= 1) {
    if ((cell[2] & level) != 0) flips ^= level - 1;
  }
  for (int axis = 0; axis < 3; ++axis) cell[axis] ^= flips;
  // ... and interleave the bits.
  std::uint64_t index = 0;
  for (int bit = axis_bits - 1; bit >= 0; --bit) {
    for (int axis = 0; axis < 3; ++axis) index = index << 1 | (cell[axis] >> bit & 1u);
  }
  return index;
}

}  // namespace

std::vector<std::uint32_t> spatial_order(const MeshView& mesh) {
  const PointArrays centroids = facet_centroids(mesh, facet_frame(facet_bounds(mesh)));
  std::vector<std::pair<std::uint64_t, std::uint32_t>> places(mesh.facet_count());
  parallel_ranges(places.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t facet = begin; facet < end; ++facet) {
      // The frame holds the mesh in [-2, 2].
      const glm::vec3 centroid(centroids.x[facet], centroids.y[facet], centroids.z[facet]);
      const glm::dvec3 cell = (glm::dvec3(centroid) + 2.0) * double{1 << (axis_bits - 2)};
      places[facet] = {hilbert_index(glm::uvec3(glm::min(cell, glm::dvec3((1 << axis_bits) - 1)))),
                       static_cast<std::uint32_t>(facet)};
    }
  });
  tbb::parallel_sort(places.begin(), places.end());
  std::vector<std::uint32_t> order(places.size());
  std::transform(places.begin(), places.end(), order.begin(), [](const auto& place) { return place.second; });
  return order;
}

}  // namespace facetsort
