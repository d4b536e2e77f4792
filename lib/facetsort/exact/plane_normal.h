// Internal to exact: normals of planes in integers.
#pragma once

#include <algorithm>

#include "facetsort/exact/integers.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {

// The largest e such that all coordinates that define the plane are integers times 2^e; 0 when all are zero.
inline int plane_exponent(const PlanePoints& plane) {
  const auto& [a, b, c] = plane.points;
  const auto& [p, q, r] = plane.facet;  // all zero, as the edge's end is, unless the plane is a join
  return common_exponent({glm::dvec3(a), glm::dvec3(b), glm::dvec3(c), glm::dvec3(plane.edge_end), glm::dvec3(p),
                          glm::dvec3(q), glm::dvec3(r)});
}

// The plane's normal by the right-hand rule, up to a positive factor. Precondition: `exponent` is at most
// plane_exponent(plane).
inline IntegerVector plane_normal(const PlanePoints& plane, int exponent) {
  const auto integers = [&](const glm::vec3& point) { return scaled_integers(point, exponent); };
  const IntegerVector origin = integers(plane.points[0]), third = integers(plane.points[2]);
  const IntegerVector second = integers(plane.points[1]) - origin;
  const IntegerVector near = cross(second, third - origin);
  if (!plane.is_join) return near;
  // The third point is the mean of the edge's ends, each weighted by how far off the facet's plane the other is.
  const IntegerVector edge_end = integers(plane.edge_end), far = cross(second, edge_end - origin);
  const IntegerVector corner = integers(plane.facet[0]);
  const IntegerVector normal = cross(integers(plane.facet[1]) - corner, integers(plane.facet[2]) - corner);
  const Integer near_weight = abs(dot(normal, edge_end - corner)), far_weight = abs(dot(normal, third - corner));
  return {near_weight * near.x + far_weight * far.x, near_weight * near.y + far_weight * far.y,
          near_weight * near.z + far_weight * far.z};
}

}  // namespace facetsort::exact_internal
