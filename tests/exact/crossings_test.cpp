// Pairs of facets that cross, where many facets share a corner, and the cost that a limit puts on cutting them.
#include "facetsort/exact/crossings.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <set>
#include <utility>

#include "exact/point_space.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/mesh/mesh.h"
#include "shapes.h"
#include "support/threads.h"

namespace facetsort::exact_internal {
namespace {

PartedFacets part(const MeshView& mesh, std::size_t most_triangles) {
  const PointSpace space = space_of(mesh);
  Points points(space);
  return part_crossing_facets(points, find_degenerate_facets(mesh), most_triangles);
}

constexpr std::size_t no_limit = 1'000'000;

// Facets with a corner in common, in random directions: some cross.
Mesh around_one_corner(int facets, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto coordinate = [&] { return static_cast<float>(random() % 2001) / 1000.0f - 1.0f; };
  Mesh mesh;
  mesh.positions.push_back({0.25f, 0.5f, 0.125f});
  for (int f = 0; f < facets; ++f) {
    const glm::vec3 corner(coordinate(), coordinate(), coordinate());
    const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(corner);
    mesh.positions.push_back(corner + 0.3f * glm::vec3(coordinate(), coordinate(), coordinate()));
    const glm::uvec3 triangle(0, first, first + 1);
    // The common corner first, second or third.
    mesh.triangles.push_back({triangle[f % 3], triangle[(f + 1) % 3], triangle[(f + 2) % 3]});
  }
  return mesh;
}

// Each pair on its own has no corner that many facets share.
std::size_t count_crossing_pairs_one_by_one(const Mesh& mesh) {
  std::size_t crossing = 0;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (std::size_t g = 0; g < f; ++g) {
      const glm::uvec3 two[] = {mesh.triangles[f], mesh.triangles[g]};
      crossing += part({mesh.positions, two, {}, {}}, no_limit).crossing_pairs;
    }
  }
  return crossing;
}

TEST(Crossings, AreAllFoundAroundACornerOfMany) {
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    const Mesh mesh = around_one_corner(150, seed);
    const std::size_t expected = count_crossing_pairs_one_by_one(mesh);
    EXPECT_GT(expected, 20u);
    EXPECT_EQ(part(mesh.view(), no_limit).crossing_pairs, expected);
  }
}

TEST(Crossings, AreAllFoundBetweenTwoCornersOfMany) {
  Mesh mesh = around_one_corner(80, 4);
  const Mesh other = around_one_corner(80, 5);
  const std::uint32_t offset = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec3& position : other.positions) mesh.positions.push_back(position + glm::vec3(0.2f, 0.1f, 0.0f));
  for (const glm::uvec3& triangle : other.triangles) mesh.triangles.push_back(triangle + offset);
  // And a few facets that have both corners.
  for (std::uint32_t i = 1; i < 20; ++i) mesh.triangles.push_back({0, offset, i});
  EXPECT_EQ(part(mesh.view(), no_limit).crossing_pairs, count_crossing_pairs_one_by_one(mesh));
}

// Some 10^10 pairs of boxes overlap; a search through all of them would take minutes.
TEST(Crossings, AroundACornerOfVeryManyAreNotSoughtPairByPair) {
  EXPECT_EQ(part(shapes::sliver_fan(100'000, 20'000).view(), no_limit).crossing_pairs, 0u);
}

// A band of narrow facets in z = 0, along x, and curtains along x that zigzag through it, side by side: in most facets
// each curtain has a kink, and hides the corners beyond it from the kinks of the others.
Mesh band_and_curtains(int curtains, std::uint32_t seed) {
  std::mt19937 random(seed);
  const auto shift = [&] { return static_cast<float>(random() % 1001) / 1000.0f; };
  Mesh mesh;
  const auto add_strip = [&](int columns, const auto& first_row, const auto& second_row) {
    const auto offset = static_cast<std::uint32_t>(mesh.positions.size());
    for (int i = 0; i < columns; ++i) {
      mesh.positions.push_back(first_row(i));
      mesh.positions.push_back(second_row(i));
    }
    for (std::uint32_t i = offset; i + 3 < mesh.positions.size(); i += 2) {
      mesh.triangles.push_back({i, i + 1, i + 2});
      mesh.triangles.push_back({i + 2, i + 1, i + 3});
    }
  };
  const auto height = static_cast<float>(2 * curtains);
  const auto x = [](int i) { return static_cast<float>(i); };
  add_strip(
      21, [&](int i) { return glm::vec3(x(i), 0, 0); }, [&](int i) { return glm::vec3(x(i), height, 0); });
  for (int c = 0; c < curtains; ++c) {
    const auto y = static_cast<float>(2 * c) + 0.5f;
    add_strip(
        18, [&](int i) { return glm::vec3(1.37f * x(i) - 1.5f + 0.2f * shift(), y + shift(), 1 + shift()); },
        [&](int i) { return glm::vec3(1.37f * x(i) - 1.5f + 0.2f * shift(), y + shift(), -1 - shift()); });
  }
  return mesh;
}

// Pairs of an edge and a facet that it pierces.
std::size_t count_pierced(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) edges.insert(std::minmax(t[i], t[(i + 1) % 3]));
  }
  std::size_t pierced = 0;
  for (const auto& [p, q] : edges) {
    for (const glm::uvec3& t : mesh.triangles) {
      const auto side = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        return orientation(mesh.positions[a], mesh.positions[b], mesh.positions[c], mesh.positions[d]);
      };
      if (side(t.x, t.y, t.z, p) * side(t.x, t.y, t.z, q) >= 0) continue;
      const int first = side(p, q, t.x, t.y);
      pierced += first != 0 && side(p, q, t.y, t.z) == first && side(p, q, t.z, t.x) == first;
    }
  }
  return pierced;
}

TEST(Crossings, TakeNoPointsButWhereEdgesPierceFacets) {
  for (const int curtains : {1, 2, 3, 5}) {
    const Mesh mesh = band_and_curtains(curtains, static_cast<std::uint32_t>(curtains));
    const PointSpace space = space_of(mesh.view());
    Points points(space);
    const PartedFacets parted = part_crossing_facets(points, find_degenerate_facets(mesh.view()), no_limit);
    EXPECT_GT(parted.crossing_pairs, 20u);
    EXPECT_EQ(count_new_corners(points, parted.pieces, mesh.positions.size()), count_pierced(mesh));
    std::size_t joins = 0;
    for (const CutPlane& plane : points.added_planes()) joins += plane.is_join();
    EXPECT_TRUE(curtains == 1 || joins > 0);

    std::map<FacetId, double> area;
    const auto area_of = [&](PointId a, PointId b, PointId c) {
      const glm::dvec3 origin = points.position(a);
      return glm::length(glm::cross(points.position(b) - origin, points.position(c) - origin));
    };
    for (const Part& piece : parted.pieces.parts) {
      const std::span<const PartCorner> corners = parted.pieces.corners_of(piece);
      for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
        area[piece.facet] += area_of(corners[0].point, corners[i].point, corners[i + 1].point);
      }
      // Convex, and on the right side of all its cuts.
      for (const Cut& cut : parted.pieces.cuts_of(piece)) {
        for (const PartCorner& corner : corners) EXPECT_GE(points.side(cut.plane, corner.point) * cut.side, 0);
      }
    }
    EXPECT_FALSE(area.empty());
    for (const auto& [facet, sum] : area) {
      const glm::uvec3& t = mesh.triangles[facet];
      EXPECT_NEAR(sum, area_of(t.x, t.y, t.z), 1e-9);
    }
  }
}

TEST(Crossings, ThatALimitLeavesAreCounted) {
  const Mesh soup = shapes::soup(100, 7);
  const PartedFacets all = part(soup.view(), no_limit);
  EXPECT_EQ(all.uncut_pairs, 0u);
  std::size_t uncut = all.crossing_pairs;
  for (const std::size_t most : {100, 150, 300, 700, 1'500}) {
    const PartedFacets some = part(soup.view(), most);
    EXPECT_EQ(some.crossing_pairs, all.crossing_pairs);
    EXPECT_GT(some.uncut_pairs, 0u);
    EXPECT_LE(some.uncut_pairs, uncut);
    uncut = some.uncut_pairs;
    EXPECT_LE(some.cuts, 2 * most);
    if (most == soup.triangles.size()) {
      EXPECT_EQ(some.cuts, 0u);
      EXPECT_EQ(some.uncut_pairs, all.crossing_pairs);
    }
    for (const int threads : {1, 3}) {
      const PartedFacets again = with_threads(threads, [&] { return part(soup.view(), most); });
      EXPECT_EQ(again.uncut_pairs, some.uncut_pairs);
      EXPECT_EQ(again.pieces.parts.size(), some.pieces.parts.size());
    }
  }
  EXPECT_LT(uncut, all.crossing_pairs);
}

}  // namespace
}  // namespace facetsort::exact_internal
