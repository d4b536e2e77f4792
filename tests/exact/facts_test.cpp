#include "facetsort/exact/facts.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "exact/rational.h"
#include "facetsort/mesh/inspect.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

using rational::Number;
using rational::Point;

std::array<Point, 3> corners_of(const Mesh& mesh, std::size_t facet) {
  const auto corner = [&](int i) { return Point(glm::dvec3(mesh.view().corner(facet, i))); };
  return {corner(0), corner(1), corner(2)};
}

// The part of a convex polygon (any point list: a segment or a point too) in dot(normal, p - through) >= 0.
std::vector<Point> clip(const std::vector<Point>& polygon, const Point& normal, const Point& through) {
  std::vector<Point> inside;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const Number p_side = dot(normal, p - through), q_side = dot(normal, q - through);
    if (p_side >= 0) inside.push_back(p);
    if (p_side * q_side < 0) inside.push_back(p + (p_side / (p_side - q_side)) * (q - p));
  }
  return inside;
}

// The definition in facts.h, taken literally: cut one triangle down to the other, see whether what is left is more than
// what they share.
bool reference_intersect(const std::array<Point, 3>& s, const std::array<Point, 3>& t) {
  const Point s_normal = cross(s[1] - s[0], s[2] - s[0]), t_normal = cross(t[1] - t[0], t[2] - t[0]);
  if (is_zero(s_normal) || is_zero(t_normal)) return false;
  std::vector<Point> shared;
  for (const Point& p : s) {
    if (std::find(t.begin(), t.end(), p) != t.end()) shared.push_back(p);
  }
  if (shared.size() == 3) return false;
  std::vector<Point> common(s.begin(), s.end());
  common = clip(common, t_normal, t[0]);
  common = clip(common, Number(-1) * t_normal, t[0]);
  for (int i = 0; i < 3; ++i) common = clip(common, cross(t_normal, t[(i + 1) % 3] - t[i]), t[i]);
  for (const Point& p : common) {
    const bool in_shared = shared.size() == 1   ? p == shared[0]
                           : shared.size() == 2 ? is_zero(cross(p - shared[0], shared[1] - shared[0]))
                                                : false;
    if (!in_shared) return true;
  }
  return false;
}

struct ReferencePairs {
  std::size_t count = 0;
  std::size_t first[2] = {0, 0};
};

ReferencePairs reference_pairs(const Mesh& mesh) {
  std::vector<std::array<Point, 3>> corners;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) corners.push_back(corners_of(mesh, f));
  ReferencePairs pairs;
  for (std::size_t f = 0; f < corners.size(); ++f) {
    for (std::size_t g = f + 1; g < corners.size(); ++g) {
      if (!reference_intersect(corners[f], corners[g])) continue;
      if (pairs.count++ == 0) pairs.first[0] = f, pairs.first[1] = g;
    }
  }
  return pairs;
}

Mesh unwelded(std::initializer_list<glm::vec3> corners) {
  Mesh mesh;
  mesh.positions = corners;
  for (std::uint32_t i = 0; i < mesh.positions.size(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

// n triangles with corners on a grid of the given number of steps: full of shared corners and edges, touching corners,
// coplanar overlaps, duplicates and degenerate facets.
Mesh grid_soup(std::size_t n, int steps, std::uint32_t seed) {
  Mesh mesh = shapes::soup(n, seed);
  for (glm::vec3& p : mesh.positions) p = glm::floor(p * static_cast<float>(steps)) * 0.1f;
  return mesh;
}

void expect_reference_pairs(const Mesh& mesh) {
  const ReferencePairs expected = reference_pairs(mesh);
  const GeometryFacts facts = inspect_geometry(mesh.view());
  ASSERT_EQ(facts.intersecting_pairs, expected.count);
  if (expected.count == 0) return;
  EXPECT_EQ(facts.first_intersecting[0], expected.first[0]);
  EXPECT_EQ(facts.first_intersecting[1], expected.first[1]);
}

TEST(IntersectingPairs, OfTwoTrianglesAreThoseOfRationalClipping) {
  std::size_t intersecting = 0;
  constexpr std::uint32_t cases = 1500;
  for (std::uint32_t seed = 0; seed < cases; ++seed) {
    SCOPED_TRACE(seed);
    // Two steps give almost nothing but special positions; flat ones (every third) give coplanar overlaps.
    Mesh mesh = grid_soup(2, 2 + static_cast<int>(seed % 4), seed);
    if (seed % 3 == 0) {
      for (glm::vec3& p : mesh.positions) p.z = p.x + p.y;
    }
    ASSERT_NO_FATAL_FAILURE(expect_reference_pairs(mesh));
    intersecting += inspect_geometry(mesh.view()).intersecting_pairs;
  }
  EXPECT_GT(intersecting, cases / 10);
  EXPECT_LT(intersecting, cases - cases / 10);
}

TEST(IntersectingPairs, OfSoupsAreThoseOfRationalClipping) {
  for (std::uint32_t seed = 0; seed < 3; ++seed) {
    SCOPED_TRACE(seed);
    ASSERT_NO_FATAL_FAILURE(expect_reference_pairs(grid_soup(40, 5, seed)));
    Mesh small = shapes::soup(70, seed);
    for (std::size_t i = 0; i < small.positions.size(); ++i) {
      if (i % 3 != 0) small.positions[i] = glm::mix(small.positions[i - i % 3], small.positions[i], 0.4f);
    }
    ASSERT_NO_FATAL_FAILURE(expect_reference_pairs(small));
  }
}

TEST(IntersectingPairs, CountWhatFactsSays) {
  const auto pairs = [](const Mesh& mesh) { return inspect_geometry(mesh.view()).intersecting_pairs; };
  const glm::vec3 a(0, 0, 0), b(1, 0, 0), c(0, 1, 0);
  // Through each other, touching with a corner, touching with an edge.
  EXPECT_EQ(pairs(unwelded({a, b, c, {0.2f, 0.2f, -1}, {0.2f, 0.2f, 1}, {2, 2, 0}})), 1u);
  EXPECT_EQ(pairs(unwelded({a, b, c, {0.25f, 0.25f, 0}, {0, 0, 1}, {1, 0, 1}})), 1u);
  EXPECT_EQ(pairs(unwelded({a, b, c, {0.5f, 0, 0}, {2, 0, 0}, {1, 0, 1}})), 1u);
  // Neighbours along an edge: bent, flat, folded.
  EXPECT_EQ(pairs(unwelded({a, b, c, b, a, {0, 0, 1}})), 0u);
  EXPECT_EQ(pairs(unwelded({a, b, c, b, a, {0, -1, 0}})), 0u);
  EXPECT_EQ(pairs(unwelded({a, b, c, b, a, {1, 1, 0}})), 1u);
  // Neighbours at a corner, one plane: beside each other, overlapping, one in the other.
  EXPECT_EQ(pairs(unwelded({a, b, c, a, {-1, 0, 0}, {0, -1, 0}})), 0u);
  EXPECT_EQ(pairs(unwelded({a, b, c, a, {2, 1, 0}, {1, 2, 0}})), 1u);
  EXPECT_EQ(pairs(unwelded({a, b, c, a, {0.4f, 0.3f, 0}, {0.3f, 0.4f, 0}})), 1u);
  // Neighbours at a corner, through each other.
  EXPECT_EQ(pairs(unwelded({a, b, c, a, {1, 1, 1}, {1, 1, -1}})), 1u);
  // Duplicates share everything, in any winding; -0 is 0; degenerate facets have no area to meet.
  EXPECT_EQ(pairs(unwelded({a, b, c, c, b, {-0.0f, -0.0f, -0.0f}})), 0u);
  EXPECT_EQ(pairs(unwelded({a, b, c, {0.2f, 0.2f, -1}, {0.2f, 0.2f, 0}, {0.2f, 0.2f, 1}})), 0u);
}

TEST(IntersectingPairs, HoldAtEveryScale) {
  const Mesh mesh = grid_soup(30, 4, 11);
  const std::size_t expected = inspect_geometry(mesh.view()).intersecting_pairs;
  ASSERT_GT(expected, 0u);
  // 0.1f has 24 bits: down to 2^-120 it scales without rounding.
  for (const int power : {-120, -60, 60, 125}) {
    Mesh scaled = mesh;
    for (glm::vec3& p : scaled.positions) p *= std::ldexp(1.0f, power);
    EXPECT_EQ(inspect_geometry(scaled.view()).intersecting_pairs, expected) << power;
  }
}

TEST(IntersectingPairs, DoNotDependOnTheOrderOfFacetsNorOnMirrors) {
  const Mesh mesh = grid_soup(200, 9, 4);
  const std::size_t expected = inspect_geometry(mesh.view()).intersecting_pairs;
  ASSERT_GT(expected, 0u);
  Mesh changed = mesh;
  std::shuffle(changed.triangles.begin(), changed.triangles.end(), std::mt19937(1));
  for (glm::vec3& p : changed.positions) p = {-p.z, p.y, p.x};
  for (glm::uvec3& t : changed.triangles) t = {t.y, t.x, t.z};
  EXPECT_EQ(inspect_geometry(changed.view()).intersecting_pairs, expected);
}

TEST(GeometryFacts, AreTheSameForAnyThreadCount) {
  const Mesh mesh = shapes::soup(1000, 2);
  std::vector<GeometryFacts> results;
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 5);
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute([&] { results.push_back(inspect_geometry(mesh.view())); });
  }
  ASSERT_GT(results[0].intersecting_pairs, 0u);
  for (const GeometryFacts& facts : results) {
    EXPECT_EQ(facts.intersecting_pairs, results[0].intersecting_pairs);
    EXPECT_EQ(facts.first_intersecting[0], results[0].first_intersecting[0]);
    EXPECT_EQ(facts.first_intersecting[1], results[0].first_intersecting[1]);
  }
}

TEST(GeometryFacts, IgnoreVerticesThatNoFacetUses) {
  Mesh mesh = shapes::box();
  mesh.positions.insert(mesh.positions.begin(), glm::vec3(std::nanf("")));
  for (glm::uvec3& t : mesh.triangles) t += 1u;
  EXPECT_EQ(inspect_geometry(mesh.view()).convex_closed_facets, 12u);
}

GeometryFacts facts_of(const Mesh& mesh) {
  return inspect_geometry(mesh.view());
}

TEST(ConvexComponents, AreClosedConvexAndWoundOutwards) {
  const Mesh box = shapes::box();
  EXPECT_EQ(facts_of(box).convex_closed_components, 1u);
  EXPECT_EQ(facts_of(box).convex_closed_facets, 12u);

  Mesh inside_out = box;
  for (glm::uvec3& t : inside_out.triangles) t = {t.y, t.x, t.z};
  EXPECT_EQ(facts_of(inside_out).convex_closed_components, 0u);

  Mesh one_flipped = box;
  one_flipped.triangles[3] = {box.triangles[3].y, box.triangles[3].x, box.triangles[3].z};
  EXPECT_EQ(facts_of(one_flipped).convex_closed_components, 0u);

  Mesh open = box;
  open.triangles.pop_back();
  EXPECT_EQ(facts_of(open).convex_closed_components, 0u);

  Mesh doubled = box;
  doubled.triangles.push_back(box.triangles[0]);
  EXPECT_EQ(facts_of(doubled).convex_closed_components, 0u);

  Mesh dented = box;
  dented.positions.push_back({0, 0, 0.5f});  // over the face z = 1, which is the last two facets
  const std::uint32_t apex = 8;
  dented.triangles.resize(10);
  for (const auto& [from, to] : {std::pair{4u, 5u}, {5u, 7u}, {7u, 6u}, {6u, 4u}}) {
    dented.triangles.push_back({from, to, apex});
  }
  ASSERT_TRUE(inspect(dented.view()).closed);
  EXPECT_EQ(facts_of(dented).convex_closed_components, 0u);
  dented.positions[apex].z = 1.5f;
  EXPECT_EQ(facts_of(dented).convex_closed_components, 1u);
  dented.positions[apex].z = 1;  // flat edges are not reflex
  EXPECT_EQ(facts_of(dented).convex_closed_components, 1u);
}

TEST(ConvexComponents, AreJudgedByPositions) {
  const Mesh box = shapes::box();
  Mesh split;
  for (const glm::uvec3& t : box.triangles) {
    for (int i = 0; i < 3; ++i) split.positions.push_back(box.positions[t[i]]);
  }
  for (std::uint32_t i = 0; i < split.positions.size(); i += 3) split.triangles.push_back({i, i + 1, i + 2});
  EXPECT_EQ(facts_of(split).convex_closed_facets, 12u);
}

TEST(ConvexComponents, LeaveCollapsedFacetsOutAndRefuseDegenerateOnes) {
  Mesh mesh = shapes::box();
  mesh.triangles.push_back({0, 0, 1});
  EXPECT_EQ(facts_of(mesh).convex_closed_facets, 12u);
  EXPECT_EQ(facts_of(mesh).degenerate_facets, 1u);

  // Facet (0, 4, 6) of the box split at the middle of its edge 0 4, the gap to the neighbour filled by a line.
  Mesh filled = shapes::box();
  const auto edge = [&](std::uint32_t a, std::uint32_t b) {
    return std::find_if(filled.triangles.begin(), filled.triangles.end(), [&](const glm::uvec3& t) {
      return (t.x == a && t.y == b) || (t.y == a && t.z == b) || (t.z == a && t.x == b);
    });
  };
  const auto facet = edge(0, 4);
  const std::uint32_t opposite = facet->x + facet->y + facet->z - 4;
  filled.positions.push_back((filled.positions[0] + filled.positions[4]) * 0.5f);
  *facet = {0, 8, opposite};
  filled.triangles.push_back({8, 4, opposite});
  filled.triangles.push_back({0, 4, 8});
  ASSERT_TRUE(inspect(filled.view()).closed);
  ASSERT_TRUE(inspect(filled.view()).oriented);
  EXPECT_EQ(facts_of(filled).degenerate_facets, 1u);
  EXPECT_EQ(facts_of(filled).convex_closed_components, 0u);
}

TEST(ConvexComponents, AreNotFooledByEdgesThatAreConvexOneByOne) {
  // The great icosahedron: its 20 facets pass through each other, yet no edge is reflex.
  Mesh star = shapes::icosphere(0);
  const auto far_but_not_opposite = [&](std::uint32_t a, std::uint32_t b) {
    const float distance = glm::distance(star.positions[a], star.positions[b]);
    return distance > 1.5f && distance < 1.9f;
  };
  star.triangles.clear();
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!far_but_not_opposite(a, b) || !far_but_not_opposite(b, c) || !far_but_not_opposite(c, a)) continue;
        const glm::vec3 p = star.positions[a], q = star.positions[b], r = star.positions[c];
        const bool outwards = glm::dot(glm::cross(q - p, r - p), p) > 0;
        star.triangles.push_back(outwards ? glm::uvec3(a, b, c) : glm::uvec3(a, c, b));
      }
    }
  }
  const MeshFacts facts = inspect(star.view());
  ASSERT_EQ(facts.facets, 20u);
  ASSERT_TRUE(facts.closed && facts.oriented);
  EXPECT_GT(facts_of(star).intersecting_pairs, 0u);
  EXPECT_EQ(facts_of(star).convex_closed_components, 0u);

  // A flat facet and its back: closed and wound consistently, but no body.
  EXPECT_EQ(
      facts_of(unwelded({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}, {0, 1, 0}})).convex_closed_components,
      0u);
}

// Rows of the table of facts in meshes/SOURCES.md: the cells after the file's name, without thousands separators.
struct DocumentedMesh {
  std::string name;
  std::vector<std::string> cells;
};

std::vector<DocumentedMesh> documented_meshes() {
  std::ifstream file(FACETSORT_SOURCE_DIR "/meshes/SOURCES.md");
  std::vector<DocumentedMesh> meshes;
  bool in_table = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| file | facets |")) in_table = true;
    if (!in_table || !line.starts_with("| `")) continue;
    line.erase(std::remove_if(line.begin(), line.end(), [](char c) { return c == ',' || c == '`' || c == ' '; }),
               line.end());
    std::istringstream cells(line.substr(1));
    DocumentedMesh mesh;
    std::getline(cells, mesh.name, '|');
    for (std::string cell; std::getline(cells, cell, '|');) mesh.cells.push_back(cell);
    meshes.push_back(mesh);
  }
  return meshes;
}

TEST(ShippedMeshes, AreWhatTheirTableSays) {
  const std::filesystem::path folder(FACETSORT_SOURCE_DIR "/meshes");
  const std::vector<DocumentedMesh> documented = documented_meshes();
  std::size_t shipped = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) shipped += entry.path().extension() == ".ply";
  EXPECT_EQ(documented.size(), shipped);
  EXPECT_GE(documented.size(), 8u);
  for (const DocumentedMesh& row : documented) {
    SCOPED_TRACE(row.name);
    const Mesh mesh = load(row.name);
    const MeshFacts facts = inspect(mesh.view());
    const GeometryFacts geometry = inspect_geometry(mesh.view());
    const std::vector<std::string> expected = {std::to_string(facts.facets),
                                               std::to_string(facts.components),
                                               facts.closed ? "yes" : "no",
                                               std::to_string(facts.boundary_edges),
                                               std::to_string(facts.non_manifold_edges),
                                               std::to_string(facts.duplicate_facets),
                                               std::to_string(geometry.degenerate_facets),
                                               std::to_string(geometry.intersecting_pairs),
                                               std::to_string(geometry.convex_closed_components)};
    EXPECT_EQ(row.cells, expected);
  }
}

// Counted by other programs before; the first two are shipped, the others are looked for in FACETSORT_MESH_PATH.
TEST(GeometryFacts, MeshesHaveTheirKnownIntersections) {
  const std::pair<const char*, std::size_t> known[] = {
      {"teapot_1k", 56}, {"plant_63k", 111491}, {"bunny_4k", 0},  {"dragon_res4_11k", 34}, {"cheese_18k", 0},
      {"tr12j_27k", 0},  {"snowden_38k", 2890}, {"bunny_70k", 2}, {"dragon_871k", 206}};
  std::size_t found = 0;
  for (const auto& [name, pairs] : known) {
    if (!has_mesh(name)) continue;
    ++found;
    EXPECT_EQ(facts_of(load(name)).intersecting_pairs, pairs) << name;
  }
  EXPECT_GE(found, 2u);
}

}  // namespace
}  // namespace facetsort
