// What does not depend on the view: representative points, planes and bounds of facets.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Box of the positions that facets use.
struct Box {
  glm::vec3 lowest{0}, highest{0};

  glm::vec3 centre() const;
  // Half the diagonal: the bounding radius R.
  float radius() const;
};
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

// (a + b + c) / 3, in double and rounded once. This and the next two are parallel in the caller's task arena.
PointArrays facet_centroids(const MeshView& mesh, const FacetFrame& frame);
// Centre of the facet's axis-aligned box.
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
