// Internal to exact: on which side of a plane an eye is, by a filter in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

#include "facetsort/exact/points.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {

// A plane through three vertices with a bound for its filter: with d = eye - corner (or the direction of an
// orthographic eye), dot(normal, d) has the sign of the eye's side where it exceeds `error` times the sum of d's
// magnitudes.
struct FilteredPlane {
  glm::dvec3 normal;
  double error;
  glm::vec3 corner;
};

inline FilteredPlane filtered_plane(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::dvec3 u = glm::dvec3(b) - glm::dvec3(a), v = glm::dvec3(c) - glm::dvec3(a);
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    largest = std::max(largest, std::abs(u[j] * v[k]) + std::abs(u[k] * v[j]));
  }
  return {glm::cross(u, v), 0x1p-49 * largest, a};
}

// The side of the plane that the eye is on, +1 for that of the normal; 0 where the filter can't tell.
inline int filtered_side(const FilteredPlane& plane, const Eye& eye) {
  const glm::dvec3 d = eye.w == 0 ? glm::dvec3(eye) : glm::dvec3(eye) - glm::dvec3(plane.corner);
  const double value = glm::dot(plane.normal, d);
  return std::abs(value) > plane.error * sum_of_magnitudes(d) ? (value > 0 ? 1 : -1) : 0;
}

// The same, exactly: 0 where the eye is in the plane of a, b, c, which `plane` was made of.
inline int eye_side(const FilteredPlane& plane, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c,
                    const Eye& eye) {
  const int side = filtered_side(plane, eye);
  return side != 0 ? side : side_of_plane(a, b, c, eye);
}

}  // namespace facetsort::exact_internal
