// What does not depend on the view: representative points, planes and bounds of facets.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// One point a facet, as three arrays: what a depth key reads in one stream.
struct PointArrays {
  std::vector<float> x, y, z;

  std::size_t size() const { return x.size(); }
};

// (a + b + c) / 3, summed in double and rounded once.
PointArrays facet_centroids(const MeshView& mesh);
// Centre of the facet's axis-aligned box.
PointArrays facet_bounds_centres(const MeshView& mesh);
// Corner i (0, 1 or 2) of each facet.
PointArrays facet_corners(const MeshView& mesh, int i);

// Plane through a facet, in double: normal = (b - a) x (c - a), not normalised, and offset = dot(normal, a).
struct Plane {
  glm::dvec3 normal;
  double offset;
};
Plane facet_plane(const MeshView& mesh, std::uint32_t facet);

// Box of the positions that facets use.
struct Box {
  glm::vec3 lowest{0}, highest{0};

  glm::vec3 centre() const;
  // Half the diagonal: the bounding radius R.
  float radius() const;
};
Box facet_bounds(const MeshView& mesh);

}  // namespace facetsort
