#include "facetsort/facets/facets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shapes.h"

namespace facetsort {
namespace {

TEST(Facets, BoundsAreThoseOfPositionsThatFacetsUse) {
  Mesh mesh = shapes::box();
  mesh.positions.push_back({100, 100, 100});
  const Box box = facet_bounds(mesh.view());
  EXPECT_EQ(box.lowest, glm::vec3(-1));
  EXPECT_EQ(box.highest, glm::vec3(1));
  EXPECT_EQ(box.centre(), glm::vec3(0));
  EXPECT_FLOAT_EQ(box.radius(), std::sqrt(3.0f));
}

TEST(Facets, BoundsAtTheEndsOfTheFloatRangeStayFinite) {
  Mesh mesh;
  mesh.positions = {{-3e38f, 0, 0}, {3e38f, 0, 0}, {0, 1e-38f, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Box box = facet_bounds(mesh.view());
  EXPECT_EQ(box.centre().x, 0);
  EXPECT_FLOAT_EQ(box.radius(), 3e38f);
}

TEST(Facets, FrameBringsTheMeshToSizeOneAroundItsCentre) {
  for (const float scale : {1e-30f, 1e-3f, 1.0f, 12345.0f, 1e30f}) {
    const Box box{glm::vec3(3 * scale), glm::vec3(7 * scale)};
    const FacetFrame frame = facet_frame(box);
    EXPECT_EQ(std::exp2(std::round(std::log2(frame.scale))), frame.scale) << "not a power of two";
    const double half = 0.5 * (static_cast<double>(box.highest.x) - static_cast<double>(box.lowest.x)) * frame.scale;
    EXPECT_GE(half, 1.0);
    EXPECT_LT(half, 2.0);
    EXPECT_NEAR((static_cast<double>(box.lowest.x) - frame.origin.x) * frame.scale, -half, 1e-12);
  }
  EXPECT_EQ(facet_frame({glm::vec3(5), glm::vec3(5)}).scale, 1.0);
}

TEST(Facets, PointsAreWhatTheirNamesSay) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {3, 0, 0}, {0, 6, 9}};
  mesh.triangles = {{0, 1, 2}};
  const FacetFrame identity;
  const PointArrays centroids = facet_centroids(mesh.view(), identity);
  EXPECT_EQ(glm::vec3(centroids.x[0], centroids.y[0], centroids.z[0]), glm::vec3(1, 2, 3));
  const PointArrays centres = facet_bounds_centres(mesh.view(), identity);
  EXPECT_EQ(glm::vec3(centres.x[0], centres.y[0], centres.z[0]), glm::vec3(1.5, 3, 4.5));
  const PointArrays corners = facet_corners(mesh.view(), 2, identity);
  EXPECT_EQ(glm::vec3(corners.x[0], corners.y[0], corners.z[0]), glm::vec3(0, 6, 9));
  ASSERT_EQ(corners.size(), 1u);
}

TEST(Facets, PlaneHoldsTheCornersAndFacesCounterClockwise) {
  const Mesh mesh = shapes::box();
  for (std::uint32_t facet = 0; facet < mesh.triangles.size(); ++facet) {
    const Plane plane = facet_plane(mesh.view(), facet);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(glm::dot(plane.normal, glm::dvec3(mesh.view().corner(facet, i))), plane.offset);
    }
    EXPECT_GT(plane.offset, 0) << "the box is wound outwards, its centre lies behind every facet";
  }
}

}  // namespace
}  // namespace facetsort
