// Signs that are never wrong: floating-point filters with an exact fallback.
//
// Every input is taken as the real number that its bits stand for. A filter evaluates in double with a bound on its
// own rounding (Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates");
// where the value is within the bound, the sign comes from multiple-precision integers. All functions are pure and
// thread-safe; the fallback allocates.
#pragma once

#include <glm/glm.hpp>

namespace facetsort {

// Sign of det[b - a, c - a, d - a]: +1 when d lies on the side of the plane of abc that the normal (b - a) x (c - a)
// points to, -1 on the other side, 0 in the plane (or when a, b, c are collinear).
int orientation(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

// The same with a homogeneous eye (w = 1 a point, w = 0 a direction) for d: the side of the plane of abc that the eye
// is on, +1 for the side of the normal (front, for a counter-clockwise facet), 0 when the eye is in the plane.
int side_of_plane(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye);

// Whether three points lie on one line (two equal points do).
bool collinear(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

// How often the calling thread has taken the exact fallback; for statistics.
unsigned long long exact_fallbacks();

}  // namespace facetsort
