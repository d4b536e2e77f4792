// Signs that are never wrong: floating-point filters with an exact fallback.
//
// Every input is taken as the real number that its bits stand for. A filter evaluates in double with a bound on its
// own rounding (Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates");
// where the value is within the bound, the sign comes from multiple-precision integers. All functions are pure and
// thread-safe, take finite input of any magnitude (denormal numbers too), and expect rounding to nearest; the fallback
// may allocate.
#pragma once

#include <array>
#include <glm/glm.hpp>

namespace facetsort {

// Sign of det[b - a, c - a, d - a]: +1 when d lies on the side of the plane of abc that the normal (b - a) x (c - a)
// points to, -1 on the other side, 0 in the plane (or when a, b, c are collinear).
int orientation(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

// The same with a homogeneous eye (w = 1 a point, w = 0 a direction) for d: the side of the plane of abc that the eye
// is on, +1 for the side of the normal (front, for a counter-clockwise facet), 0 when the eye is in the plane.
int side_of_plane(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye);

// det[b - a, c - a, d - a], whose sign orientation() tells, as a filter computes it: in double, and a bound on the
// rounding. Where d is one of a, b and c, value and bound are 0. Nothing underflows or overflows.
struct SignedVolume {
  double value, error;
};
SignedVolume signed_volume(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

// Three points that are not on one line, and the plane through them. Where it is a join, the third is not points[2] but
// where the edge from there to `edge_end` pierces the plane of `facet`, which parts the edge's ends strictly.
struct PlanePoints {
  std::array<glm::vec3, 3> points;
  bool is_join = false;
  glm::vec3 edge_end{};
  std::array<glm::vec3, 3> facet{};
};

// The same for such a plane, up to a positive factor that depends on the plane alone.
SignedVolume signed_volume(const PlanePoints& plane, const glm::vec3& d);

// Sign of component `axis` (0, 1 or 2) of the normal (b - a) x (c - a): the turn that abc makes when the points are
// projected along that axis, +1 for counter-clockwise as seen from its positive end.
int normal_sign(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, int axis);

// Whether three points lie on one line (two equal points do).
bool collinear(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c);

// The exact side of an edge's line on which a pixel's point lies, and the line's direction for tie rules.
struct EdgeSigns {
  int at_pixel;  // of A * pixel_x + B * pixel_y + C
  int x;         // of A
  int y;         // of B
};

// Signs of the homogeneous edge function (A, B, C) = h(a) x h(b) at a pixel's point, where
// h(p) = (dot(rows[0], p - eye), dot(rows[1], p - eye), dot(rows[2], p - eye)) + offset, in real arithmetic: nothing is
// rounded. rows[i] is the i-th row of the projection. Always exact, without a filter: for callers whose own filter was
// undecided. Two to three microseconds.
EdgeSigns exact_edge_signs(const glm::vec3& a, const glm::vec3& b, const glm::vec3& eye, const glm::dmat3& rows,
                           const glm::dvec3& offset, double pixel_x, double pixel_y);

// Sign of det[h(a), h(b), h(c)] with the same h. Always exact, without a filter.
int exact_facing(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& eye,
                 const glm::dmat3& rows, const glm::dvec3& offset);

// The same for the line in which a plane cuts a facet: the sum, over the corners i of `facet`, of the
// signed volume of `plane` and corner i times the edge function h(corner i + 1) x h(corner i + 2). Times the sign of
// det[h(facet)], it is positive where the point of the facet that is seen lies on the side of `plane` that its normal
// points to. All signs are 0 when the facet lies in the plane. Always exact, without a filter; four microseconds.
EdgeSigns exact_cut_signs(const std::array<glm::vec3, 3>& facet, const PlanePoints& plane,
                          const glm::vec3& eye, const glm::dmat3& rows, const glm::dvec3& offset, double pixel_x,
                          double pixel_y);

// How often the calling thread has computed with multiple-precision integers; for statistics.
unsigned long long exact_fallbacks();

}  // namespace facetsort
