// Internal to order: on which side of a plane an eye is, with no error and no library of big numbers.
#pragma once

#include <glm/glm.hpp>

namespace facetsort::order_internal {

// The side of the plane of a, b, c that the eye (w = 1 a point, w = 0 a direction) is on: +1 for that of the normal
// (b - a) x (c - a), 0 where the eye is in the plane, or the three points are on one line. Every input is taken as the
// real number that its bits stand for. Pure and thread-safe; allocates nothing; expects rounding to nearest.
// Precondition: all are finite.
int eye_side(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye);

}  // namespace facetsort::order_internal
