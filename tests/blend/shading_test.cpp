#include "facetsort/blend/shading.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/threads.h"

namespace facetsort {
namespace {

// In the plane z = 0, centroid at the origin.
Mesh one_triangle() {
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

Ray ray_down_at(double x, double y) {
  return {{x, y, 5}, {0, 0, -1}};
}

void expect_near(const glm::vec4& a, const glm::vec4& b, float tolerance = 1e-6f) {
  for (int channel = 0; channel < 4; ++channel) EXPECT_NEAR(a[channel], b[channel], tolerance) << channel;
}

TEST(DefaultColours, ArePureHuesThatTellFacetsApart) {
  int alike = 0;
  for (std::uint32_t facet = 0; facet < 10000; ++facet) {
    const glm::vec4 colour = default_facet_colour(facet);
    EXPECT_EQ(colour.a, default_alpha);
    EXPECT_EQ(std::max({colour.r, colour.g, colour.b}), 1);
    EXPECT_EQ(std::min({colour.r, colour.g, colour.b}), 0);
    // Two facets swapped change the picture by a quarter of the difference of their colours.
    const glm::vec4 difference = glm::abs(colour - default_facet_colour(facet + 1)) / 4.0f;
    alike += std::max({difference.r, difference.g, difference.b}) <= 1.0f / 255;
  }
  EXPECT_LT(alike, 100);
}

TEST(Headlight, FallsWithTheAngleOnBothSides) {
  const Mesh mesh = one_triangle();
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {0, 0, 7, 1}), 1);
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {0, 0, -7, 1}), 1);
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {9, 0, 0, 1}), 0.25f);
  const float sixty_degrees = 0.25f + 0.75f * 0.5f;
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {std::sqrt(3.0f), 0, 1, 1}), sixty_degrees);
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {std::sqrt(3.0f), 0, -1, 0}), sixty_degrees);
  EXPECT_FLOAT_EQ(headlight(mesh.view(), 0, {0, 2 * std::sqrt(3.0f), 2, 0}), sixty_degrees);
}

TEST(Headlight, IsFullOnFacetsWithoutArea) {
  Mesh mesh = one_triangle();
  mesh.triangles[0] = {0, 1, 1};
  EXPECT_EQ(headlight(mesh.view(), 0, {0, 0, 7, 1}), 1);
  EXPECT_EQ(headlight(one_triangle().view(), 0, {0, 0, 0, 1}), 1);  // the eye on the centroid
}

TEST(Headlight, IsTheSameToTheBitAtAnyPowerOfTwo) {
  const Mesh mesh = shapes::soup(100, 2);
  for (const float w : {0.0f, 1.0f}) {
    const glm::vec4 eye(3, -1, 2, w);
    for (const int exponent : {-100, -60, 60, 100}) {
      const float scale = std::ldexp(1.0f, exponent);
      Mesh scaled = mesh;
      for (glm::vec3& position : scaled.positions) position *= scale;
      for (std::uint32_t facet = 0; facet < 100; ++facet)
        EXPECT_EQ(headlight(scaled.view(), facet, glm::vec4(glm::vec3(eye) * scale, w)),
                  headlight(mesh.view(), facet, eye));
    }
  }
}

TEST(FacetColours, AreTheMeshsOwnLitAndPremultiplied) {
  Mesh mesh = one_triangle();
  const glm::vec4 eye(std::sqrt(3.0f), 0, 1, 0);  // lit by 0.625
  expect_near(facet_colour(mesh.view(), 0, eye),
              default_facet_colour(0) * glm::vec4(glm::vec3(0.625f * default_alpha), 1));
  mesh.facet_colours = {{0.8f, 0.4f, 0.2f, 0.25f}};
  expect_near(facet_colour(mesh.view(), 0, eye), {0.125f, 0.0625f, 0.03125f, 0.25f});
  // Facet colours count where there are both.
  mesh.vertex_colours.assign(3, glm::vec4(1));
  expect_near(fragment_colour(mesh.view(), 0, ray_down_at(0, 0), eye), {0.125f, 0.0625f, 0.03125f, 0.25f});
}

void expect_colours_of_each_facet(const Mesh& mesh, const glm::vec4& eye) {
  std::vector<glm::vec4> colours(5);  // of an earlier mesh
  facet_colours(mesh.view(), eye, colours);
  ASSERT_EQ(colours.size(), mesh.triangles.size());
  for (std::uint32_t facet = 0; facet < colours.size(); ++facet) {
    ASSERT_EQ(colours[facet], facet_colour(mesh.view(), facet, eye)) << facet;
  }
}

TEST(FacetColours, AreThoseOfEachFacetForAnyThreadCount) {
  const Mesh mesh = shapes::soup(20000, 4);
  for (const int threads : {1, 2, 8}) {
    with_threads(threads, [&] { expect_colours_of_each_facet(mesh, {3, -1, 2, 1}); });
  }
}

// Whole vectors and what is left of them; facets without area among the others.
TEST(FacetColours, AreThoseOfEachFacetForAnyInstructionSetAndCount) {
  for_each_instruction_set([] {
    for (const std::size_t facets : {1u, 7u, 63u, 64u, 65u, 200u}) {
      SCOPED_TRACE(facets);
      Mesh mesh = shapes::soup(facets, 5);
      for (std::size_t facet = 0; facet < facets; facet += 5) mesh.triangles[facet].y = mesh.triangles[facet].x;
      for (const glm::vec4& eye : {glm::vec4(3, -1, 2, 1), glm::vec4(0.1f, 0.2f, -0.9f, 0)}) {
        expect_colours_of_each_facet(mesh, eye);
        Mesh coloured = mesh;
        for (std::uint32_t facet = 0; facet < facets; ++facet) {
          const float shade = static_cast<float>(facet) / static_cast<float>(facets);
          coloured.facet_colours.emplace_back(shade, 1 - shade, 0.5f, 0.3f + 0.5f * shade);
        }
        expect_colours_of_each_facet(coloured, eye);
      }
    }
  });
}

TEST(FragmentColours, MixTheCornersBeforeTheyArePremultiplied) {
  Mesh mesh = one_triangle();
  mesh.vertex_colours = {{1, 0, 0, 1}, {0, 1, 0, 0.5f}, {0, 0, 1, 0}};
  ASSERT_FALSE(has_one_colour_per_facet(mesh.view()));
  const glm::vec4 eye(0, 0, 1, 0);
  const auto colour_at = [&](double x, double y) { return fragment_colour(mesh.view(), 0, ray_down_at(x, y), eye); };
  expect_near(colour_at(-1, -1), {1, 0, 0, 1});
  expect_near(colour_at(2, -1), {0, 0.5f, 0, 0.5f});
  expect_near(colour_at(-1, 2), {0, 0, 0, 0});
  expect_near(colour_at(0, 0), {1 / 6.0f, 1 / 6.0f, 1 / 6.0f, 0.5f});
  expect_near(colour_at(0.5, -1), {0.375f, 0.375f, 0, 0.75f});
  // Beside the facet by rounding: the edge's colour, not one beyond the corners'.
  expect_near(colour_at(0.5, -1.000001), {0.375f, 0.375f, 0, 0.75f});
}

TEST(FragmentColours, AreCorrectInPerspective) {
  Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {3, 0, -3}, {0, 9, -1}};
  mesh.triangles = {{0, 1, 2}};
  mesh.vertex_colours = {{1, 0, 0, 1}, {0, 0, 1, 1}, {0, 1, 0, 1}};
  // From the origin through the middle of the edge in space, which is not the middle of the edge on the screen.
  const Ray ray{{0, 0, 0}, glm::normalize(glm::dvec3(1, 0, -2))};
  const glm::vec4 colour = fragment_colour(mesh.view(), 0, ray, {0, 0, 0, 1});
  const float light = headlight(mesh.view(), 0, {0, 0, 0, 1});
  EXPECT_LT(light, 1);
  expect_near(colour, {0.5f * light, 0, 0.5f * light, 1});
}

}  // namespace
}  // namespace facetsort
