#include "facetsort/exact/predicates.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <thread>

#include "exact/rational.h"
#include "support/effort.h"

namespace facetsort {
namespace {

using rational::Number;
using rational::Point;

int sign(const Number& value) {
  return value.sign();
}

Point exactly(const glm::vec3& p) {
  return Point(glm::dvec3(p));
}

int reference_side(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye) {
  const Point origin = exactly(a);
  const Point w = exactly(glm::vec3(eye));
  return sign(dot(cross(exactly(b) - origin, exactly(c) - origin), eye.w == 0 ? w : w - origin));
}

// Points that make predicates hard. Each kind gives all three signs, which the tests check.
class HardPoints {
 public:
  enum Kind { on_a_grid, near_a_plane, of_mixed_magnitude, denormal, kinds };

  explicit HardPoints(Kind kind) : kind_(kind) {}

  glm::vec3 operator()() {
    switch (kind_) {
      case on_a_grid:
        return glm::vec3(small_(random_), small_(random_), small_(random_));
      case near_a_plane: {
        const float x = uniform_(random_), y = uniform_(random_);
        return {x, y, 0.3f * x + 0.7f * y};
      }
      case of_mixed_magnitude:
        return {magnitude(), magnitude(), magnitude()};
      case denormal:
      case kinds:
        break;
    }
    return glm::vec3(small_(random_), small_(random_), small_(random_)) * std::numeric_limits<float>::denorm_min();
  }

 private:
  // A few mantissas, so that exact zeros come up, times powers of two from the smallest to the largest.
  float magnitude() { return std::ldexp(static_cast<float>(small_(random_)), exponents_[exponent_(random_)]); }

  static constexpr int exponents_[] = {-149, -100, -1, 0, 1, 24, 125};
  Kind kind_;
  std::mt19937 random_{7};
  std::uniform_int_distribution<int> small_{-2, 2};
  std::uniform_int_distribution<int> exponent_{0, 6};
  std::uniform_real_distribution<float> uniform_{-1, 1};
};

class HardPredicates : public testing::TestWithParam<HardPoints::Kind> {};

TEST_P(HardPredicates, PlaneSidesAreThoseOfRationalArithmetic) {
  HardPoints point(GetParam());
  std::map<int, int> seen;
  for (int i = 0; i < cases(3000); ++i) {
    const glm::vec3 a = point(), b = point(), c = point(), d = point();
    const int expected = reference_side(a, b, c, glm::vec4(d, 1));
    ++seen[expected];
    ASSERT_EQ(orientation(a, b, c, d), expected) << i;
    ASSERT_EQ(side_of_plane(a, b, c, glm::vec4(d, 1)), expected) << i;
    ASSERT_EQ(orientation(b, a, c, d), -expected) << i;
    ASSERT_EQ(side_of_plane(a, b, c, glm::vec4(d, 0)), reference_side(a, b, c, glm::vec4(d, 0))) << i;
  }
  EXPECT_GT(seen[-1], 0);
  EXPECT_GT(seen[0], 0);
  EXPECT_GT(seen[1], 0);
}

TEST_P(HardPredicates, TurnsAreThoseOfRationalArithmetic) {
  HardPoints point(GetParam());
  std::map<int, int> seen;
  int lines = 0;
  for (int i = 0; i < cases(3000); ++i) {
    const glm::vec3 a = point(), b = point(), c = i % 5 == 0 ? a : point();
    const Point normal = cross(exactly(b) - exactly(a), exactly(c) - exactly(a));
    ASSERT_EQ(normal_sign(a, b, c, 0), sign(normal.x)) << i;
    ASSERT_EQ(normal_sign(a, b, c, 1), sign(normal.y)) << i;
    ASSERT_EQ(normal_sign(a, b, c, 2), sign(normal.z)) << i;
    ASSERT_EQ(collinear(a, b, c), is_zero(normal)) << i;
    ++seen[sign(normal.z)];
    lines += is_zero(normal);
  }
  EXPECT_GT(seen[-1], 0);
  EXPECT_GT(seen[1], 0);
  EXPECT_GT(lines, 0);
}

TEST_P(HardPredicates, SignedVolumesAreWithinTheirBounds) {
  HardPoints point(GetParam());
  int certain = 0;
  for (int i = 0; i < cases(3000); ++i) {
    const glm::vec3 a = point(), b = point(), c = point();
    const glm::vec3 d = i % 7 == 0 ? a : i % 7 == 1 ? b : i % 7 == 2 ? c : point();
    const SignedVolume volume = signed_volume(a, b, c, d);
    const Point origin = exactly(a);
    const Number exact = dot(cross(exactly(b) - origin, exactly(c) - origin), exactly(d) - origin);
    ASSERT_LE(abs(Number(volume.value) - exact), Number(volume.error)) << i;
    if (d == a || d == b || d == c) {
      ASSERT_EQ(volume.error, 0) << i;
    } else {
      certain += std::abs(volume.value) > volume.error;
    }
  }
  EXPECT_GT(certain, cases(300));
}

std::string kind_name(const testing::TestParamInfo<HardPoints::Kind>& test) {
  constexpr const char* names[HardPoints::kinds] = {"OnAGrid", "NearAPlane", "OfMixedMagnitude", "Denormal"};
  return names[test.param];
}

INSTANTIATE_TEST_SUITE_P(Points, HardPredicates,
                         testing::Values(HardPoints::on_a_grid, HardPoints::near_a_plane,
                                         HardPoints::of_mixed_magnitude, HardPoints::denormal),
                         kind_name);

TEST(Predicates, SeeTheNeighbouringFloat) {
  // Three corners on the plane x + y + z = 1 and a point next to it, one unit in the last place away.
  const glm::vec3 a(1, 0, 0), b(0, 1, 0), c(0, 0, 1);
  const glm::vec3 inside(0.25f, 0.25f, 0.5f);
  EXPECT_EQ(orientation(a, b, c, inside), 0);
  for (int axis = 0; axis < 3; ++axis) {
    glm::vec3 above = inside, below = inside;
    above[axis] = std::nextafter(inside[axis], 1.0f);
    below[axis] = std::nextafter(inside[axis], 0.0f);
    EXPECT_EQ(orientation(a, b, c, above), 1) << axis;
    EXPECT_EQ(orientation(a, b, c, below), -1) << axis;
  }
}

TEST(Predicates, HoldAtBothEndsOfTheRange) {
  for (const float size : {std::numeric_limits<float>::denorm_min(), 1e-30f, 1.0f, std::numeric_limits<float>::max()}) {
    const glm::vec3 origin(0), x(size, 0, 0), y(0, size, 0), z(0, 0, size);
    EXPECT_EQ(orientation(origin, x, y, z), 1) << size;
    EXPECT_EQ(orientation(origin, x, y, -z), -1) << size;
    EXPECT_EQ(orientation(x, y, z, glm::vec3(size)), 1) << size;
    EXPECT_EQ(orientation(x, y, -x, -y), 0) << size;
    EXPECT_FALSE(collinear(origin, x, y)) << size;
    EXPECT_TRUE(collinear(x, -x, origin)) << size;
  }
}

TEST(Predicates, CountTheirFallbacksByThread) {
  const glm::vec3 a(0.1f, 0.7f, 0.3f), b(0.9f, 0.2f, 0.3f), c(0.4f, 0.4f, 0.8f);
  const unsigned long long before = exact_fallbacks();
  EXPECT_NE(orientation(a, b, c, glm::vec3(5, 6, 7)), 0);
  EXPECT_EQ(exact_fallbacks(), before);
  EXPECT_EQ(orientation(a, b, c, b), 0);
  EXPECT_EQ(exact_fallbacks(), before + 1);
  std::thread([] { EXPECT_EQ(exact_fallbacks(), 0u); }).join();
}

struct Projection {
  glm::vec3 eye;
  glm::dmat3 rows;
  glm::dvec3 offset;

  Point operator()(const glm::vec3& p) const {
    const Point v = exactly(p) - exactly(eye);
    return Point(dot(Point(rows[0]), v), dot(Point(rows[1]), v), dot(Point(rows[2]), v)) + Point(offset);
  }
};

// Perspective and orthographic cameras as the rasteriser has them, and some whose rows make exact zeros.
class Projections {
 public:
  Projection operator()() {
    const auto any = [&] { return uniform_(random_); };
    const auto small = [&] { return static_cast<double>(small_(random_)); };
    const glm::vec3 eye(static_cast<float>(any()), static_cast<float>(any()), 3);
    switch (kind_(random_)) {
      case 0:
        return {eye, {{300 * any(), any(), any()}, {any(), 300 * any(), any()}, {any(), any(), any()}}, glm::dvec3(0)};
      case 1:
        return {eye, {{300 * any(), any(), any()}, {any(), 300 * any(), any()}, {0, 0, 0}}, {256, 256, 1}};
      case 2:
        return {glm::vec3(0, 0, 1), {{small(), small(), small()}, {small(), 4, small()}, {0, 0, -1}}, {0, small(), 0}};
      default:
        return {eye, {{1e300 * any(), 0, any()}, {0, 1e-300 * any(), any()}, {1e-310, any(), 0}}, {any(), 0, 1e-320}};
    }
  }

 private:
  std::mt19937 random_{3};
  std::uniform_int_distribution<int> kind_{0, 3}, small_{-2, 2};
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

TEST(ProjectedPredicates, AreThoseOfRationalArithmetic) {
  HardPoints grid(HardPoints::on_a_grid), mixed(HardPoints::of_mixed_magnitude);
  Projections projections;
  std::mt19937 random(5);
  std::uniform_int_distribution<int> pixel(-4, 4);
  std::map<int, int> at_pixel_seen, facing_seen;
  for (int i = 0; i < cases(1500); ++i) {
    const Projection h = projections();
    HardPoints& point = i % 4 == 0 ? mixed : grid;
    const glm::vec3 a = point(), b = point(), c = point();
    const double pixel_x = pixel(random) / 2.0, pixel_y = pixel(random) / 2.0;

    const Point line = cross(h(a), h(b));
    const EdgeSigns signs = exact_edge_signs(a, b, h.eye, h.rows, h.offset, pixel_x, pixel_y);
    ASSERT_EQ(signs.at_pixel, sign(dot(line, Point(Number(pixel_x), Number(pixel_y), Number(1))))) << i;
    ASSERT_EQ(signs.x, sign(line.x)) << i;
    ASSERT_EQ(signs.y, sign(line.y)) << i;
    ++at_pixel_seen[signs.at_pixel];

    const int facing = exact_facing(a, b, c, h.eye, h.rows, h.offset);
    ASSERT_EQ(facing, sign(dot(line, h(c)))) << i;
    ++facing_seen[facing];
  }
  for (const int expected : {-1, 0, 1}) {
    EXPECT_GT(at_pixel_seen[expected], cases(10)) << expected;
    EXPECT_GT(facing_seen[expected], cases(10)) << expected;
  }
}

TEST(ProjectedPredicates, CutSignsAreThoseOfRationalArithmetic) {
  HardPoints grid(HardPoints::on_a_grid), near_plane(HardPoints::near_a_plane), mixed(HardPoints::of_mixed_magnitude);
  Projections projections;
  std::mt19937 random(6);
  std::uniform_int_distribution<int> pixel(-4, 4);
  std::map<int, int> seen, side_seen;
  int joins = 0;
  for (int i = 0; i < cases(1500); ++i) {
    const Projection h = projections();
    HardPoints& point = i % 8 == 0 ? mixed : i % 8 == 1 ? near_plane : grid;
    const std::array<glm::vec3, 3> facet{point(), point(), point()};
    // Facets that share a corner or an edge with the plane's, too.
    PlanePoints plane{{i % 3 == 0 ? facet[2] : point(), i % 6 == 0 ? facet[1] : point(), point()}};
    const double pixel_x = pixel(random) / 2.0, pixel_y = pixel(random) / 2.0;

    const Point origin = exactly(plane.points[0]);
    Point third = exactly(plane.points[2]);
    if (i % 2 == 0) {
      plane.edge_end = point();
      plane.facet = i % 4 == 0 ? facet : std::array<glm::vec3, 3>{point(), point(), point()};
      const Point corner = exactly(plane.facet[0]), end = exactly(plane.edge_end);
      const Point parting = cross(exactly(plane.facet[1]) - corner, exactly(plane.facet[2]) - corner);
      const Number third_at = dot(parting, third - corner), end_at = dot(parting, end - corner);
      plane.is_join = third_at * end_at < 0;
      if (plane.is_join) third = third + (third_at / (third_at - end_at)) * (end - third);
      joins += plane.is_join;
    }
    const Point normal = cross(exactly(plane.points[1]) - origin, third - origin);
    for (const glm::vec3& corner : facet) {
      const SignedVolume volume = signed_volume(plane, corner);
      const int side = sign(dot(normal, exactly(corner) - origin));
      if (std::abs(volume.value) > volume.error) {
        ASSERT_EQ(sign(volume.value), side) << i;
      }
    }
    Point line(0, 0, 0), seen_point(0, 0, 0);
    Number weights = 0;
    const Point at(Number(pixel_x), Number(pixel_y), Number(1));
    for (int k = 0; k < 3; ++k) {
      const Point edge = cross(h(facet[(k + 1) % 3]), h(facet[(k + 2) % 3]));
      line = line + dot(normal, exactly(facet[k]) - origin) * edge;
      seen_point = seen_point + dot(edge, at) * exactly(facet[k]);
      weights += dot(edge, at);
    }
    const EdgeSigns signs = exact_cut_signs(facet, plane, h.eye, h.rows, h.offset, pixel_x, pixel_y);
    ASSERT_EQ(signs.at_pixel, sign(dot(line, at))) << i;
    ASSERT_EQ(signs.x, sign(line.x)) << i;
    ASSERT_EQ(signs.y, sign(line.y)) << i;
    ++seen[signs.at_pixel];
    // It is the side of the plane on which the point seen at the pixel lies.
    if (weights == 0) continue;
    const int side = sign(dot(normal, Number(1) / weights * seen_point - origin));
    ASSERT_EQ(signs.at_pixel * weights.sign(), side) << i;
    ++side_seen[side];
  }
  for (const int expected : {-1, 0, 1}) {
    EXPECT_GT(seen[expected], cases(10)) << expected;
    EXPECT_GT(side_seen[expected], cases(10)) << expected;
  }
  EXPECT_GT(joins, cases(100));
}

TEST(ProjectedPredicates, DecideAPixelCentreExactlyOnAnEdge) {
  // One unit is one pixel, seen along -z: the edge runs through pixel centres on the diagonal.
  const glm::dmat3 rows({1, 0, 0}, {0, 1, 0}, {0, 0, 0});
  const glm::dvec3 offset(0, 0, 1);
  const glm::vec3 a(0, 0, 0), b(100, 100, 7), eye(0, 0, 50);
  EXPECT_EQ(exact_edge_signs(a, b, eye, rows, offset, 17.5, 17.5).at_pixel, 0);
  const int below = exact_edge_signs(a, b, eye, rows, offset, 17.5, std::nextafter(17.5, 0.0)).at_pixel;
  EXPECT_NE(below, 0);
  EXPECT_EQ(exact_edge_signs(a, b, eye, rows, offset, 17.5, std::nextafter(17.5, 20.0)).at_pixel, -below);
  EXPECT_EQ(exact_edge_signs(b, a, eye, rows, offset, 17.5, std::nextafter(17.5, 0.0)).at_pixel, -below);
}

}  // namespace
}  // namespace facetsort
