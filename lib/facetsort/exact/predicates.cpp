// Filters: stage A of Shewchuk 1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
// Predicates". Fallback: integers.h.
#include "facetsort/exact/predicates.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>

#include "facetsort/exact/integers.h"
#include "facetsort/exact/plane_normal.h"

namespace facetsort {
namespace {

using namespace exact_internal;

constexpr double half_epsilon = std::numeric_limits<double>::epsilon() / 2;

// Shewchuk's bounds on the error of a determinant of rounded differences, relative to the sum of the magnitudes of its
// products. They hold for float32 input unconditionally: the smallest product of three non-zero differences is 2^-447
// and the largest 2^390, so nothing underflows or overflows in double.
constexpr double bound_of_3x3 = (7 + 56 * half_epsilon) * half_epsilon;
constexpr double bound_of_2x2 = (3 + 16 * half_epsilon) * half_epsilon;

// det[u, v, w] and the sum of the magnitudes of its products.
struct Determinant {
  double value, magnitude;
};

inline Determinant determinant_of(const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& w) {
  const double uy_vz = u.y * v.z, uz_vy = u.z * v.y;
  const double uz_vx = u.z * v.x, ux_vz = u.x * v.z;
  const double ux_vy = u.x * v.y, uy_vx = u.y * v.x;
  return {w.x * (uy_vz - uz_vy) + w.y * (uz_vx - ux_vz) + w.z * (ux_vy - uy_vx),
          std::abs(w.x) * (std::abs(uy_vz) + std::abs(uz_vy)) + std::abs(w.y) * (std::abs(uz_vx) + std::abs(ux_vz)) +
              std::abs(w.z) * (std::abs(ux_vy) + std::abs(uy_vx))};
}

// Coordinates that are integers of this many bits: their differences have one more, and a determinant of three
// differences fits 128.
constexpr int small_bits = 39;
using SmallInteger = boost::multiprecision::int128_t;

double largest_magnitude(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

int small_determinant_sign(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d,
                           bool d_is_point, int exponent) {
  const auto scaled = [&](double value) { return static_cast<std::int64_t>(std::ldexp(value, -exponent)); };
  std::int64_t u[3], v[3], w[3];
  for (int i = 0; i < 3; ++i) {
    const std::int64_t origin = scaled(a[i]);
    u[i] = scaled(b[i]) - origin;
    v[i] = scaled(c[i]) - origin;
    w[i] = scaled(d[i]) - (d_is_point ? origin : 0);
  }
  SmallInteger determinant = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    determinant += (SmallInteger(u[j]) * v[k] - SmallInteger(u[k]) * v[j]) * w[i];
  }
  return determinant.sign();
}

int exact_determinant_sign(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& d) {
  ++fallback_count;
  const glm::dvec3 target(d);
  const int exponent = common_exponent({glm::dvec3(a), glm::dvec3(b), glm::dvec3(c), target});
  const double limit = std::ldexp(1.0, exponent + small_bits);
  if (std::max({largest_magnitude(a), largest_magnitude(b), largest_magnitude(c), largest_magnitude(target)}) < limit) {
    return small_determinant_sign(a, b, c, target, d.w != 0, exponent);
  }
  const IntegerVector origin = scaled_integers(a, exponent);
  const IntegerVector u = scaled_integers(b, exponent) - origin;
  const IntegerVector v = scaled_integers(c, exponent) - origin;
  IntegerVector w = scaled_integers(target, exponent);
  if (d.w != 0) w = w - origin;
  return sign(dot(cross(u, v), w));
}

int exact_normal_sign(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
  ++fallback_count;
  const int exponent = common_exponent({a.x, a.y, b.x, b.y, c.x, c.y});
  const Integer ax = scaled_integer(a.x, exponent), ay = scaled_integer(a.y, exponent);
  const Integer ux = scaled_integer(b.x, exponent) - ax, uy = scaled_integer(b.y, exponent) - ay;
  const Integer vx = scaled_integer(c.x, exponent) - ax, vy = scaled_integer(c.y, exponent) - ay;
  return sign(Integer(ux * vy - uy * vx));
}

// The sign of a line's function at a pixel, and of its direction. 1 is among the values, so that the pixel's
// coordinates and the factor of line.z share their power of two.
EdgeSigns signs_of_line(const IntegerVector& line, double pixel_x, double pixel_y) {
  const int exponent = common_exponent({pixel_x, pixel_y, 1.0});
  const Integer at_pixel = line.x * scaled_integer(pixel_x, exponent) + line.y * scaled_integer(pixel_y, exponent) +
                           line.z * scaled_integer(1.0, exponent);
  return {sign(at_pixel), sign(line.x), sign(line.y)};
}

// The projection of points to homogeneous pixels in integers: every h(p) is scaled by the same power of two.
class ExactProjection {
 public:
  ExactProjection(std::initializer_list<glm::vec3> points, const glm::vec3& eye, const glm::dmat3& rows,
                  const glm::dvec3& offset) {
    point_exponent_ = common_exponent({glm::dvec3(eye)});
    for (const glm::vec3& point : points) {
      point_exponent_ = std::min(point_exponent_, common_exponent({glm::dvec3(point)}));
    }
    const int row_exponent = common_exponent({rows[0], rows[1], rows[2]});
    const int product_exponent = point_exponent_ + row_exponent;
    const int exponent = std::min(product_exponent, common_exponent({offset}));
    eye_ = scaled_integers(eye, point_exponent_);
    // The rows carry the shift that aligns their products with the offset.
    const int shifted_row_exponent = row_exponent - (product_exponent - exponent);
    for (int i = 0; i < 3; ++i) rows_[i] = scaled_integers(rows[i], shifted_row_exponent);
    offset_ = scaled_integers(offset, exponent);
  }

  IntegerVector operator()(const glm::vec3& point) const {
    const IntegerVector p = scaled_integers(point, point_exponent_) - eye_;
    return {dot(rows_[0], p) + offset_.x, dot(rows_[1], p) + offset_.y, dot(rows_[2], p) + offset_.z};
  }

 private:
  int point_exponent_;
  IntegerVector eye_, rows_[3], offset_;
};

}  // namespace

int side_of_plane(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye) {
  assert(eye.w == 0 || eye.w == 1);
  const glm::dvec3 origin(a);
  const glm::dvec3 u = glm::dvec3(b) - origin, v = glm::dvec3(c) - origin;
  const glm::dvec3 w = eye.w == 0 ? glm::dvec3(eye) : glm::dvec3(eye) - origin;
  const auto [determinant, magnitude] = determinant_of(u, v, w);
  // The second case: every product is zero, which is certain because none underflows.
  if (std::abs(determinant) > bound_of_3x3 * magnitude || magnitude == 0) return sign(determinant);
  return exact_determinant_sign(a, b, c, eye);
}

int orientation(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  return side_of_plane(a, b, c, glm::vec4(d, 1));
}

SignedVolume signed_volume(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  if (d == a || d == b || d == c) return {0, 0};
  const glm::dvec3 origin(a);
  const auto [determinant, magnitude] =
      determinant_of(glm::dvec3(b) - origin, glm::dvec3(c) - origin, glm::dvec3(d) - origin);
  return {determinant, bound_of_3x3 * magnitude};
}

SignedVolume signed_volume(const PlanePoints& plane, const glm::vec3& d) {
  const auto& [a, b, c] = plane.points;
  const SignedVolume near = signed_volume(a, b, c, d);
  if (!plane.is_join) return near;
  // The third point is the mean of the edge's ends, each weighted by how far off the other is.
  const auto& [p, q, r] = plane.facet;
  const SignedVolume far = signed_volume(a, b, plane.edge_end, d);
  const SignedVolume near_weight = signed_volume(p, q, r, plane.edge_end), far_weight = signed_volume(p, q, r, c);
  const auto product_error = [](const SignedVolume& weight, const SignedVolume& volume) {
    return std::abs(weight.value) * volume.error + weight.error * (std::abs(volume.value) + volume.error);
  };
  const double near_part = std::abs(near_weight.value) * near.value, far_part = std::abs(far_weight.value) * far.value;
  constexpr double roundings = 0x1p-50;  // of the products, their sum, and the error itself
  return {near_part + far_part, (1 + roundings) * (product_error(near_weight, near) + product_error(far_weight, far)) +
                                    roundings * (std::abs(near_part) + std::abs(far_part))};
}

int normal_sign(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, int axis) {
  assert(axis >= 0 && axis < 3);
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  const glm::dvec2 origin(a[i], a[j]), second(b[i], b[j]), third(c[i], c[j]);
  const glm::dvec2 u = second - origin, v = third - origin;
  const double left = u.x * v.y, right = u.y * v.x;
  const double magnitude = std::abs(left) + std::abs(right);
  if (std::abs(left - right) > bound_of_2x2 * magnitude || magnitude == 0) return sign(left - right);
  return exact_normal_sign(origin, second, third);
}

bool collinear(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  return normal_sign(a, b, c, 0) == 0 && normal_sign(a, b, c, 1) == 0 && normal_sign(a, b, c, 2) == 0;
}

EdgeSigns exact_edge_signs(const glm::vec3& a, const glm::vec3& b, const glm::vec3& eye, const glm::dmat3& rows,
                           const glm::dvec3& offset, double pixel_x, double pixel_y) {
  ++fallback_count;
  const ExactProjection project({a, b}, eye, rows, offset);
  return signs_of_line(cross(project(a), project(b)), pixel_x, pixel_y);
}

int exact_facing(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& eye,
                 const glm::dmat3& rows, const glm::dvec3& offset) {
  ++fallback_count;
  const ExactProjection project({a, b, c}, eye, rows, offset);
  return sign(dot(cross(project(a), project(b)), project(c)));
}

EdgeSigns exact_cut_signs(const std::array<glm::vec3, 3>& facet, const PlanePoints& plane,
                          const glm::vec3& eye, const glm::dmat3& rows, const glm::dvec3& offset, double pixel_x,
                          double pixel_y) {
  ++fallback_count;
  const int exponent =
      std::min(plane_exponent(plane),
               common_exponent({glm::dvec3(facet[0]), glm::dvec3(facet[1]), glm::dvec3(facet[2])}));
  const IntegerVector origin = scaled_integers(plane.points[0], exponent);
  const IntegerVector normal = plane_normal(plane, exponent);
  const ExactProjection project({facet[0], facet[1], facet[2]}, eye, rows, offset);
  const IntegerVector corner[3] = {project(facet[0]), project(facet[1]), project(facet[2])};
  IntegerVector line;
  for (int i = 0; i < 3; ++i) {
    const Integer volume = dot(normal, scaled_integers(facet[i], exponent) - origin);
    const IntegerVector edge = cross(corner[(i + 1) % 3], corner[(i + 2) % 3]);
    line = {line.x + volume * edge.x, line.y + volume * edge.y, line.z + volume * edge.z};
  }
  return signs_of_line(line, pixel_x, pixel_y);
}

unsigned long long exact_fallbacks() {
  return fallback_count;
}

}  // namespace facetsort
