#include "facetsort/order/eye_side.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "facetsort/exact/predicates.h"

namespace facetsort::order_internal {
namespace {

// Points that make signs hard to tell.
class HardPoints {
 public:
  glm::vec3 on_a_grid() { return glm::vec3(small(), small(), small()); }
  glm::vec3 near_a_plane() {
    const float x = uniform_(random_), y = uniform_(random_);
    return {x, y, 0.3f * x + 0.7f * y};
  }
  glm::vec3 of_mixed_magnitude() { return {magnitude(), magnitude(), magnitude()}; }
  glm::vec3 denormal() { return on_a_grid() * std::numeric_limits<float>::denorm_min(); }
  glm::vec3 far_from_the_origin() { return glm::vec3(16777216) + on_a_grid() + on_a_grid() * 2.0f; }
  // Whatever bits there are.
  glm::vec3 of_any_bits() { return {any_bits(), any_bits(), any_bits()}; }

 private:
  float small() { return static_cast<float>(small_(random_)); }
  float magnitude() { return std::ldexp(small(), exponents_[exponent_(random_)]); }
  float any_bits() { return std::ldexp(uniform_(random_), std::uniform_int_distribution<int>(-149, 127)(random_)); }

  static constexpr int exponents_[] = {-149, -100, -1, 0, 1, 24, 125};
  std::mt19937 random_{11};
  std::uniform_int_distribution<int> small_{-2, 2}, exponent_{0, 6};
  std::uniform_real_distribution<float> uniform_{-1, 1};
};

using Kind = glm::vec3 (HardPoints::*)();

void expect_sides_of_integers(Kind kind, bool meets_planes) {
  HardPoints points;
  std::map<int, int> seen;
  for (int i = 0; i < 5000; ++i) {
    const glm::vec3 a = (points.*kind)(), b = (points.*kind)(), c = (points.*kind)(), d = (points.*kind)();
    for (const float w : {1.0f, 0.0f}) {
      const glm::vec4 eye(i % 50 == 0 ? a : d, w);
      const int expected = side_of_plane(a, b, c, eye);
      ASSERT_EQ(eye_side(a, b, c, eye), expected) << i;
      ASSERT_EQ(eye_side(c, b, a, eye), -expected) << i;
      ++seen[expected];
    }
  }
  EXPECT_GT(seen[-1], 100);
  EXPECT_GT(seen[1], 100);
  if (meets_planes) {
    EXPECT_GT(seen[0], 100);
  }
}

TEST(EyeSide, IsThatOfIntegersOnAGrid) {
  expect_sides_of_integers(&HardPoints::on_a_grid, true);
}
TEST(EyeSide, IsThatOfIntegersNearAPlane) {
  expect_sides_of_integers(&HardPoints::near_a_plane, true);
}
TEST(EyeSide, IsThatOfIntegersOfMixedMagnitude) {
  expect_sides_of_integers(&HardPoints::of_mixed_magnitude, true);
}
TEST(EyeSide, IsThatOfIntegersOfDenormalSize) {
  expect_sides_of_integers(&HardPoints::denormal, true);
}
TEST(EyeSide, IsThatOfIntegersFarFromTheOrigin) {
  expect_sides_of_integers(&HardPoints::far_from_the_origin, true);
}
TEST(EyeSide, IsThatOfIntegersOfAnyBits) {
  expect_sides_of_integers(&HardPoints::of_any_bits, false);
}

TEST(EyeSide, HoldsAtBothEndsOfTheRange) {
  for (const float size : {std::numeric_limits<float>::denorm_min(), 1e-30f, 1.0f, std::numeric_limits<float>::max()}) {
    const glm::vec3 o(0), x(size, 0, 0), y(0, size, 0);
    EXPECT_EQ(eye_side(o, x, y, glm::vec4(0, 0, size, 1)), 1) << size;
    EXPECT_EQ(eye_side(o, x, y, glm::vec4(0, 0, -size, 1)), -1) << size;
    EXPECT_EQ(eye_side(o, x, y, glm::vec4(size, size, 0, 1)), 0) << size;
    EXPECT_EQ(eye_side(-x, x, y, glm::vec4(0, 0, size, 0)), 1) << size;
    EXPECT_EQ(eye_side(x, y, glm::vec3(-size), glm::vec4(size, size, size, 1)),
              side_of_plane(x, y, glm::vec3(-size), glm::vec4(size, size, size, 1)))
        << size;
  }
}

}  // namespace
}  // namespace facetsort::order_internal
