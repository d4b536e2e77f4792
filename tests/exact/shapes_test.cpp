#include "shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "facetsort/exact/facts.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/mesh/inspect.h"

namespace facetsort::shapes {
namespace {

// Volume inside a closed mesh: positive when it is wound outwards.
double signed_volume(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles) {
  double sum = 0;
  for (const glm::uvec3& t : triangles) {
    const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
    sum += glm::dot(glm::cross(a, b), c);
  }
  return sum / 6;
}

double signed_volume(const Mesh& mesh) {
  return signed_volume(mesh.positions, mesh.triangles);
}

void expect_closed_and_clean(const Mesh& mesh, std::size_t components) {
  ASSERT_TRUE(validate(mesh.view()).ok());
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_TRUE(facts.closed);
  EXPECT_TRUE(facts.oriented);
  EXPECT_EQ(facts.components, components);
  EXPECT_EQ(facts.distinct_positions, mesh.positions.size());
  const GeometryFacts geometry = inspect_geometry(mesh.view());
  EXPECT_EQ(geometry.intersecting_pairs, 0u);
  EXPECT_EQ(geometry.degenerate_facets, 0u);
}

using KnotCase = std::tuple<std::size_t, std::pair<int, int>>;

class TorusKnot : public testing::TestWithParam<KnotCase> {};

TEST_P(TorusKnot, IsClosedConcaveAndClearOfItself) {
  const auto [facets, windings] = GetParam();
  const Mesh mesh = torus_knot(facets, windings.first, windings.second);
  expect_closed_and_clean(mesh, 1);
  EXPECT_NEAR(static_cast<double>(mesh.triangles.size()), static_cast<double>(facets),
              0.05 * static_cast<double>(facets));
  EXPECT_EQ(2 * mesh.positions.size(), mesh.triangles.size());  // a torus: V - E + F = 0
  EXPECT_GT(signed_volume(mesh), 0);
  EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_components, 0u);
  for (const glm::vec3& p : mesh.positions) EXPECT_LT(glm::length(p), 1.3f);
}

INSTANTIATE_TEST_SUITE_P(Sizes, TorusKnot,
                         testing::Combine(testing::Values(fewest_knot_facets, 1000, 10'000, 100'000),
                                          testing::Values(std::pair{2, 3})));
INSTANTIATE_TEST_SUITE_P(Windings, TorusKnot,
                         testing::Combine(testing::Values(fewest_knot_facets, 5000),
                                          testing::Values(std::pair{1, 1}, std::pair{3, 2}, std::pair{2, 7},
                                                          std::pair{5, 3}, std::pair{8, 1}, std::pair{8, 7})));

TEST(NestedShells, LieInsideEachOtherTheGapApart) {
  for (const auto& [layers, gap, subdivisions] :
       {std::tuple{4, 0.2f, 1}, {10, 0.01f, 2}, {3, 1e-5f, 3}, {1, 0.5f, 0}}) {
    SCOPED_TRACE(gap);
    const Mesh mesh = nested_shells(layers, gap, subdivisions);
    expect_closed_and_clean(mesh, static_cast<std::size_t>(layers));
    const std::size_t vertices = mesh.positions.size() / layers, facets = mesh.triangles.size() / layers;
    EXPECT_EQ(facets, std::size_t{20} << (2 * subdivisions));
    EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_components, static_cast<std::size_t>(layers));
    for (int shell = 0; shell < layers; ++shell) {
      const auto own_vertices = std::span(mesh.positions).subspan(shell * vertices, vertices);
      const auto own_facets = std::span(mesh.triangles).subspan(shell * facets, facets);
      for (const glm::vec3& p : own_vertices) {
        ASSERT_NEAR(glm::length(glm::dvec3(p)), 1 - shell * double{gap}, 2e-7);
      }
      EXPECT_GT(signed_volume(mesh.positions, own_facets), 0);
      if (shell + 1 == layers) continue;
      // Strictly behind every plane of a convex shell is strictly inside it.
      const auto inner_vertices = std::span(mesh.positions).subspan((shell + 1) * vertices, vertices);
      for (const glm::uvec3& t : own_facets) {
        for (const glm::vec3& p : inner_vertices) {
          ASSERT_EQ(orientation(mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z], p), -1);
        }
      }
    }
  }
}

// Where segments pq and rs cross strictly as seen along z: +1 when pq is above, -1 when below; 0 where they don't
// cross.
int above_at_crossing(const glm::vec3& p, const glm::vec3& q, const glm::vec3& r, const glm::vec3& s) {
  const int z = 2;
  const int turn = normal_sign(p, q, s, z);
  if (turn == 0 || normal_sign(p, q, r, z) != -turn) return 0;
  if (normal_sign(r, s, p, z) * normal_sign(r, s, q, z) != -1) return 0;
  // rs crosses from one side of pq to the other; s lies on the side of the plane pqr that tells which passes over.
  return orientation(p, q, r, s) * turn;
}

// Compares the members of a ring (runs of facets_each facets): the counts of edges of one that pass above and below
// edges of the other.
std::pair<int, int> crossings(const Mesh& mesh, std::size_t facets_each, std::size_t one, std::size_t other) {
  std::pair<int, int> counts{0, 0};
  for (std::size_t f = one * facets_each; f < (one + 1) * facets_each; ++f) {
    for (std::size_t g = other * facets_each; g < (other + 1) * facets_each; ++g) {
      for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
          const int above = above_at_crossing(mesh.view().corner(f, i), mesh.view().corner(f, (i + 1) % 3),
                                              mesh.view().corner(g, j), mesh.view().corner(g, (j + 1) % 3));
          counts.first += above > 0;
          counts.second += above < 0;
        }
      }
    }
  }
  return counts;
}

TEST(AboveAtCrossing, KnowsAboveFromBelow) {
  const glm::vec3 p(-1, 0, 1), q(1, 0, 1), r(0, -1, 0), s(0, 1, 0);
  EXPECT_EQ(above_at_crossing(p, q, r, s), 1);
  EXPECT_EQ(above_at_crossing(q, p, r, s), 1);
  EXPECT_EQ(above_at_crossing(r, s, p, q), -1);
  EXPECT_EQ(above_at_crossing(p, q, r + glm::vec3(3, 0, 0), s + glm::vec3(3, 0, 0)), 0);
}

void expect_cycle(const Mesh& mesh, int n, std::size_t facets_each) {
  ASSERT_EQ(mesh.triangles.size(), n * facets_each);
  EXPECT_EQ(inspect(mesh.view()).components, static_cast<std::size_t>(n));
  EXPECT_EQ(inspect_geometry(mesh.view()).intersecting_pairs, 0u);
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n;
    const auto [above, below] = crossings(mesh, facets_each, k, next);
    EXPECT_GT(above, 0) << k;
    EXPECT_EQ(below, 0) << k;
    for (int other = 0; other < n; ++other) {
      if (other == k || other == next || (other + 1) % n == k) continue;
      EXPECT_EQ(crossings(mesh, facets_each, k, other), (std::pair{0, 0})) << k << ' ' << other;
    }
  }
}

class Cycle : public testing::TestWithParam<int> {};

TEST_P(Cycle, OfSlabsHidesItsOwnStart) {
  const int n = GetParam();
  const Mesh mesh = slab_cycle(n);
  expect_cycle(mesh, n, 12);
  expect_closed_and_clean(mesh, static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k)
    EXPECT_GT(signed_volume(mesh.positions, std::span(mesh.triangles).subspan(12 * k, 12)), 0);
}

TEST_P(Cycle, OfTrianglesHidesItsOwnStart) {
  const int n = GetParam();
  const Mesh mesh = triangle_cycle(n);
  expect_cycle(mesh, n, 1);
  for (int k = 0; k < n; ++k) {
    EXPECT_EQ(normal_sign(mesh.view().corner(k, 0), mesh.view().corner(k, 1), mesh.view().corner(k, 2), 2), 1);
  }
}

INSTANTIATE_TEST_SUITE_P(Members, Cycle, testing::Values(3, 4, 5, 6, 7, 12, 25));

TEST(Interpenetrating, IsTwoConvexBodiesThatCross) {
  const Mesh mesh = interpenetrating(3);
  EXPECT_EQ(mesh.triangles.size(), 20u * 64 + 12);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_TRUE(facts.closed && facts.oriented);
  const GeometryFacts geometry = inspect_geometry(mesh.view());
  EXPECT_EQ(geometry.convex_closed_components, 2u);
  EXPECT_GT(geometry.intersecting_pairs, 100u);
  // Through each other: each has corners in and out of the other.
  const auto sphere = std::span(mesh.positions).first(mesh.positions.size() - 8);
  const auto corners = std::span(mesh.positions).last(8);
  const auto in_sphere =
      std::count_if(corners.begin(), corners.end(), [](const glm::vec3& p) { return glm::length(p) < 1; });
  EXPECT_TRUE(in_sphere > 0 && in_sphere < 8) << in_sphere;
  const auto in_box = std::count_if(sphere.begin(), sphere.end(), [&](const glm::vec3& p) {
    return glm::all(glm::lessThan(p, corners[7])) && glm::all(glm::greaterThan(p, corners[0]));
  });
  EXPECT_GT(in_box, 0);
  EXPECT_LT(in_box, static_cast<long>(sphere.size()));
}

TEST(SliverFan, HasSliversOfItsAspect) {
  for (const auto& [n, aspect] : {std::pair{60, 10.0f}, {1000, 1000.0f}, {500, 1e5f}, {1, 1.0f}}) {
    SCOPED_TRACE(aspect);
    const Mesh mesh = sliver_fan(n, aspect);
    ASSERT_EQ(mesh.triangles.size(), static_cast<std::size_t>(n));
    EXPECT_EQ(inspect_geometry(mesh.view()).intersecting_pairs, 0u);
    EXPECT_EQ(inspect_geometry(mesh.view()).degenerate_facets, 0u);
    const MeshFacts facts = inspect(mesh.view());
    EXPECT_TRUE(facts.oriented);
    EXPECT_EQ(facts.components, 1u);
    EXPECT_EQ(facts.boundary_edges, static_cast<std::size_t>(n) + 2);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      const glm::dvec3 a(mesh.view().corner(f, 0)), b(mesh.view().corner(f, 1)), c(mesh.view().corner(f, 2));
      EXPECT_NEAR(glm::length(b - a) / glm::length(c - b), double{aspect}, 0.02 * double{aspect});
      EXPECT_GT(glm::cross(b - a, c - a).z, 0);
    }
  }
}

TEST(ManyScales, ReachesFromMicroToMega) {
  const Mesh mesh = many_scales();
  ASSERT_EQ(mesh.triangles.size(), 104u);
  expect_closed_and_clean(mesh, 26);
  EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_components, 26u);
  const auto edge = [&](std::size_t facet) {
    return glm::distance(glm::dvec3(mesh.view().corner(facet, 0)), glm::dvec3(mesh.view().corner(facet, 1)));
  };
  const double edge_of_unit = std::sqrt(8.0 / 3);
  EXPECT_NEAR(edge(0), 1e-6 * edge_of_unit, 1e-12);
  EXPECT_NEAR(edge(103), 1e6 * edge_of_unit, 1);
  for (std::size_t k = 0; k < 24; ++k) {
    // Inside the first tetrahedron of the next size: behind its four planes.
    const std::size_t outer = 4 * (k / 2 * 2 + 2);
    for (std::size_t f = outer; f < outer + 4; ++f) {
      for (std::size_t v = 4 * k; v < 4 * k + 4; ++v) {
        EXPECT_EQ(orientation(mesh.view().corner(f, 0), mesh.view().corner(f, 1), mesh.view().corner(f, 2),
                              mesh.positions[v]),
                  -1);
      }
    }
  }
}

TEST(Soup, FollowsItsSeed) {
  const Mesh mesh = soup(1000, 5);
  ASSERT_TRUE(validate(mesh.view()).ok());
  EXPECT_EQ(mesh.triangles.size(), 1000u);
  EXPECT_EQ(mesh.positions, soup(1000, 5).positions);
  EXPECT_NE(mesh.positions, soup(1000, 6).positions);
  glm::dvec3 mean(0);
  for (const glm::vec3& p : mesh.positions) {
    EXPECT_TRUE(glm::all(glm::greaterThanEqual(p, glm::vec3(0))) && glm::all(glm::lessThan(p, glm::vec3(1))));
    mean += glm::dvec3(p) / 3000.0;
  }
  // Six standard deviations of the mean of 3000 uniform numbers.
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(mean[axis], 0.5, 6 * std::sqrt(1.0 / 12 / 3000));
}

TEST(Scattered, HasTrianglesOfItsSizeAndFollowsItsSeed) {
  const Mesh mesh = scattered(2000, 0.05f, 5);
  ASSERT_TRUE(validate(mesh.view()).ok());
  ASSERT_EQ(mesh.triangles.size(), 2000u);
  EXPECT_EQ(mesh.positions, scattered(2000, 0.05f, 5).positions);
  EXPECT_NE(mesh.positions, scattered(2000, 0.05f, 6).positions);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const glm::vec3 edge = glm::abs(mesh.view().corner(f, i) - mesh.view().corner(f, (i + 1) % 3));
      EXPECT_TRUE(glm::all(glm::lessThan(edge, glm::vec3(0.0501f))));
    }
  }
  EXPECT_LT(inspect_geometry(mesh.view()).intersecting_pairs,
            inspect_geometry(scattered(2000, 0.2f, 5).view()).intersecting_pairs);
}

TEST(WovenMat, PassesOverAndUnderInTurn) {
  for (const int n : {2, 3, 8}) {
    const Mesh mesh = woven_mat(n);
    const std::size_t quads = static_cast<std::size_t>(n - 1), ribbons = static_cast<std::size_t>(2 * n);
    ASSERT_EQ(mesh.triangles.size(), 2 * quads * ribbons);
    EXPECT_EQ(inspect(mesh.view()).components, ribbons);
    EXPECT_TRUE(inspect(mesh.view()).oriented);
    EXPECT_EQ(inspect_geometry(mesh.view()).intersecting_pairs, 0u);
    for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
      EXPECT_EQ(normal_sign(mesh.view().corner(f, 0), mesh.view().corner(f, 1), mesh.view().corner(f, 2), 2), 1);
    }
    // The quads around an opening, each over the one before it.
    const auto quad_along_x = [&](std::size_t ribbon, std::size_t at) { return ribbon * quads + at; };
    const auto quad_along_y = [&](std::size_t ribbon, std::size_t at) {
      return ribbons / 2 * quads + ribbon * quads + at;
    };
    for (std::size_t x = 0; x < quads; ++x) {
      for (std::size_t y = 0; y < quads; ++y) {
        std::size_t around[] = {quad_along_x(y, x), quad_along_y(x, y), quad_along_x(y + 1, x), quad_along_y(x + 1, y)};
        if ((x + y) % 2 == 1) std::swap(around[1], around[3]);
        for (int k = 0; k < 4; ++k) {
          const auto [above, below] = crossings(mesh, 2, around[k], around[(k + 1) % 4]);
          EXPECT_GT(above, 0) << x << ' ' << y << ' ' << k;
          EXPECT_EQ(below, 0) << x << ' ' << y << ' ' << k;
        }
      }
    }
  }
}

TEST(Comb, TiesEachToothToBothBars) {
  for (const std::size_t n : {1, 4, 40}) {
    const Mesh mesh = comb(static_cast<int>(n));
    ASSERT_EQ(mesh.triangles.size(), n + 2);
    EXPECT_EQ(inspect_geometry(mesh.view()).intersecting_pairs, 0u);
    const std::size_t upper = n, lower = n + 1;  // bars
    const auto expect_over = [&](std::size_t one, std::size_t other) {
      const auto [above, below] = crossings(mesh, 1, one, other);
      EXPECT_GT(above, 0) << one << ' ' << other;
      EXPECT_EQ(below, 0) << one << ' ' << other;
    };
    expect_over(upper, lower);
    for (std::size_t tooth = 0; tooth < n; ++tooth) {
      expect_over(tooth, upper);
      expect_over(lower, tooth);
      if (tooth == 0) continue;
      EXPECT_EQ(crossings(mesh, 1, tooth - 1, tooth), (std::pair{0, 0}));
    }
  }
}

TEST(Scroll, WindsAroundTheAxis) {
  for (const auto& [turns, facets_per_turn] : {std::pair{1, 6}, {5, 30}}) {
    const Mesh mesh = scroll(turns, facets_per_turn);
    ASSERT_EQ(mesh.triangles.size(), static_cast<std::size_t>(turns * facets_per_turn));
    EXPECT_EQ(inspect(mesh.view()).components, 1u);
    EXPECT_TRUE(inspect(mesh.view()).oriented);
    EXPECT_EQ(inspect_geometry(mesh.view()).intersecting_pairs, 0u);
    double angle = 0;
    for (std::size_t f = 0; f < mesh.triangles.size(); f += 2) {
      const glm::dvec3 a(mesh.view().corner(f, 0)), b(mesh.view().corner(f, 1)), c(mesh.view().corner(f, 2));
      EXPECT_GT(glm::dot(glm::dvec2(glm::cross(b - a, c - a)), glm::dvec2(a)), 0);  // outwards
      angle += std::acos(glm::dot(glm::normalize(glm::dvec2(a)), glm::normalize(glm::dvec2(b))));
    }
    EXPECT_NEAR(angle, turns * 2 * std::acos(-1.0), 1e-5);
    for (const glm::vec3& p : mesh.positions) EXPECT_LT(glm::length(glm::vec2(p)), 1.0001f);
  }
}

TEST(Coplanar, LiesInOnePlaneExactly) {
  const Mesh mesh = coplanar(300, 2);
  ASSERT_EQ(mesh.triangles.size(), 300u);
  EXPECT_EQ(inspect_geometry(mesh.view()).degenerate_facets, 0u);
  EXPECT_GT(inspect_geometry(mesh.view()).intersecting_pairs, 1000u);
  int front = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const glm::vec3 a = mesh.view().corner(f, 0), b = mesh.view().corner(f, 1), c = mesh.view().corner(f, 2);
    front += normal_sign(a, b, c, 2) > 0;
    for (const glm::vec3& p : mesh.positions) ASSERT_EQ(orientation(a, b, c, p), 0);
  }
  EXPECT_TRUE(front > 100 && front < 200) << front;
}

TEST(DuplicatedGrid, RepeatsEveryFacetInEitherWinding) {
  const Mesh mesh = duplicated_grid(4, 5);
  const std::size_t facets = 2 * 4 * 4;
  ASSERT_EQ(mesh.triangles.size(), 5 * facets);
  EXPECT_EQ(inspect(mesh.view()).duplicate_facets, 4 * facets);
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    const glm::uvec3 t = mesh.triangles[f], original = mesh.triangles[f % facets];
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(t[i] == original.x || t[i] == original.y || t[i] == original.z);
    const int sign = normal_sign(mesh.view().corner(f, 0), mesh.view().corner(f, 1), mesh.view().corner(f, 2), 2);
    EXPECT_EQ(sign, f / facets % 2 == 0 ? 1 : -1);
  }
}

TEST(Box, IsTheCubeOfSideTwo) {
  const Mesh mesh = box();
  expect_closed_and_clean(mesh, 1);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_components, 1u);
  EXPECT_DOUBLE_EQ(signed_volume(mesh), 8);
}

TEST(Icosphere, IsConvexAtEveryLevel) {
  for (int subdivisions = 0; subdivisions <= 6; ++subdivisions) {
    SCOPED_TRACE(subdivisions);
    const Mesh mesh = icosphere(subdivisions);
    expect_closed_and_clean(mesh, 1);
    EXPECT_EQ(mesh.triangles.size(), std::size_t{20} << (2 * subdivisions));
    EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_components, 1u);
    for (const glm::vec3& p : mesh.positions) ASSERT_NEAR(glm::length(glm::dvec3(p)), 1, 2e-7);
  }
}

}  // namespace
}  // namespace facetsort::shapes
