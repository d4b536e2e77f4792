// What does not depend on the view: representative points, planes and bounds of facets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Borrowed positions, `stride` bytes apart: an interleaved vertex buffer needs no copy. Each is three float32 with any
// alignment.
class StridedPositions {
 public:
  StridedPositions(std::span<const glm::vec3> positions)  // NOLINT: a plain array of positions is one of these
      : StridedPositions(positions.data(), positions.size(), sizeof(glm::vec3)) {}
  // Precondition: from `first` on, `count` positions can be read.
  StridedPositions(const void* first, std::size_t count, std::size_t stride)
      : first_(static_cast<const std::byte*>(first)), count_(count), stride_(stride) {}

  std::size_t size() const { return count_; }
  glm::vec3 operator[](std::size_t vertex) const {
    glm::vec3 position;
    std::memcpy(&position, first_ + vertex * stride_, sizeof position);
    return position;
  }

 private:
  const std::byte* first_;
  std::size_t count_, stride_;
};

// Box of the positions that facets use.
struct Box {
  glm::vec3 lowest{0}, highest{0};

  glm::vec3 centre() const;
  // Half the diagonal: the bounding radius R.
  float radius() const;
};
// Parallel in the caller's task arena, as are the others that give something for each facet.
Box facet_bounds(std::span<const glm::uvec3> triangles, const StridedPositions& positions);
Box facet_bounds(const MeshView& mesh);

// A frame in which a mesh is about 1 in size and sits around 0: points become (p - origin) * scale. Float32 points in
// it keep their digits however far from the origin the mesh lies, and their products neither overflow nor underflow.
struct FacetFrame {
  glm::dvec3 origin{0};  // centre of the box
  double scale = 1;      // a power of two that brings the largest half extent of the box into [1, 2)
};
FacetFrame facet_frame(const Box& box);

// One point a facet, as three arrays: what a depth key reads in one stream.
struct PointArrays {
  std::vector<float> x, y, z;

  std::size_t size() const { return x.size(); }
};

// Which point of a facet.
enum class FacetPoint {
  centroid,       // (a + b + c) / 3, in double and rounded once
  bounds_centre,  // centre of the facet's axis-aligned box
  corner_0,
  corner_1,
  corner_2,
};
// One point a facet into `points`, whose memory is used again.
void compute_facet_points(std::span<const glm::uvec3> triangles, const StridedPositions& positions, FacetPoint point,
                          const FacetFrame& frame, PointArrays& points);
// Those of the facets [begin, end) alone. Precondition: `points` has room for all.
void compute_facet_points(std::span<const glm::uvec3> triangles, const StridedPositions& positions, FacetPoint point,
                          const FacetFrame& frame, std::size_t begin, std::size_t end, PointArrays& points);
PointArrays facet_centroids(const MeshView& mesh, const FacetFrame& frame);
PointArrays facet_bounds_centres(const MeshView& mesh, const FacetFrame& frame);
// Corner i (0, 1 or 2) of each facet.
PointArrays facet_corners(const MeshView& mesh, int i, const FacetFrame& frame);

// Plane through a facet, in double: normal = (b - a) x (c - a), not normalised, and offset = dot(normal, a).
struct Plane {
  glm::dvec3 normal;
  double offset;
};
Plane facet_plane(const MeshView& mesh, std::uint32_t facet);

}  // namespace facetsort
