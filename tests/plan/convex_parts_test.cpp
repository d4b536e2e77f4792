#include "facetsort/plan/convex_parts.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"

namespace facetsort {
namespace {

TEST(AreApart, ComparesTheConesThatSpheresFill) {
  // From a distance of 10 a radius of 1 fills asin(0.1) to each side: centres 2 asin(0.1) apart just touch.
  const double touching = 2 * std::asin(0.1);
  const auto at = [](double angle) { return Sphere{{10 * std::sin(angle), 0, -10 * std::cos(angle)}, 1}; };
  const glm::vec4 eye(0, 0, 0, 1);
  EXPECT_TRUE(are_apart(at(0), at(touching + 1e-6), eye));
  EXPECT_FALSE(are_apart(at(0), at(touching), eye));
  EXPECT_FALSE(are_apart(at(0), at(touching - 1e-6), eye));
  EXPECT_FALSE(are_apart({{0, 0, -10}, 1}, {{0, 0, -20}, 0.1}, eye));
  EXPECT_TRUE(are_apart({{0, 0, -10}, 1}, {{0, 0, 20}, 1}, eye)) << "before and behind the eye";
}

TEST(AreApart, AnEyeInASphereSeesItAllAround) {
  EXPECT_FALSE(are_apart({{0, 0, 0.5}, 1}, {{0, 0, -20}, 0.1}, {0, 0, 0, 1}));
  EXPECT_FALSE(are_apart({{0, 0, 1}, 1}, {{0, 0, -20}, 0.1}, {0, 0, 0, 1}));
}

TEST(AreApart, OrthographicEyesCompareAcrossTheDirection) {
  const glm::vec4 eye(0, 0, 5, 0);
  EXPECT_TRUE(are_apart({{0, 0, 0}, 1}, {{2.001, 0, 90}, 1}, eye));
  EXPECT_FALSE(are_apart({{0, 0, 0}, 1}, {{2, 0, 90}, 1}, eye));
}

TEST(ConvexParts, AreFoundWhereAllOfTheMeshIsOfThem) {
  const Mesh shells = shapes::nested_shells(3, 0.2f, 1);
  EXPECT_EQ(ConvexParts::find(shells.view(), inspect_geometry(shells.view())).count(), 3u);
  Mesh open = shells;
  open.triangles.pop_back();
  EXPECT_EQ(ConvexParts::find(open.view(), inspect_geometry(open.view())).count(), 0u);
}

TEST(ConvexParts, OnePartIsApartFromEveryEyeAndNestedOnesFromNone) {
  const Mesh box = shapes::box();
  const ConvexParts one = ConvexParts::find(box.view(), inspect_geometry(box.view()));
  EXPECT_TRUE(one.are_apart_from({0, 0, 0, 1}));
  const Mesh shells = shapes::nested_shells(2, 0.2f, 1);
  const ConvexParts nested = ConvexParts::find(shells.view(), inspect_geometry(shells.view()));
  EXPECT_FALSE(nested.are_apart_from({0, 0, 9, 1}));
}

}  // namespace
}  // namespace facetsort
