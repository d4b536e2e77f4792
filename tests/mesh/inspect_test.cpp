#include "facetsort/mesh/inspect.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "facetsort/mesh/mesh.h"
#include "support/mesh_files.h"
#include "support/special_floats.h"

namespace facetsort {
namespace {

// Side 2 around the origin, wound outwards.
Mesh cube() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// Every facet gets three vertices of its own.
Mesh unwelded(const Mesh& mesh) {
  Mesh result;
  for (const glm::uvec3& triangle : mesh.triangles) {
    const auto first = static_cast<glm::uint>(result.positions.size());
    for (int i = 0; i < 3; ++i) result.positions.push_back(mesh.positions[triangle[i]]);
    result.triangles.emplace_back(first, first + 1, first + 2);
  }
  return result;
}

void expect_same_facts(const MeshFacts& a, const MeshFacts& b) {
  EXPECT_EQ(a.facets, b.facets);
  EXPECT_EQ(a.distinct_positions, b.distinct_positions);
  EXPECT_EQ(a.components, b.components);
  EXPECT_EQ(a.edges, b.edges);
  EXPECT_EQ(a.boundary_edges, b.boundary_edges);
  EXPECT_EQ(a.non_manifold_edges, b.non_manifold_edges);
  EXPECT_EQ(a.misoriented_edges, b.misoriented_edges);
  EXPECT_EQ(a.collapsed_facets, b.collapsed_facets);
  EXPECT_EQ(a.duplicate_facets, b.duplicate_facets);
  EXPECT_EQ(a.closed, b.closed);
  EXPECT_EQ(a.oriented, b.oriented);
  EXPECT_EQ(a.lowest, b.lowest);
  EXPECT_EQ(a.highest, b.highest);
  EXPECT_EQ(a.bounding_radius, b.bounding_radius);
}

TEST(Inspect, CubeIsClosedAndOriented) {
  const MeshFacts facts = inspect(cube().view());
  EXPECT_EQ(facts.facets, 12u);
  EXPECT_EQ(facts.vertices, 8u);
  EXPECT_EQ(facts.distinct_positions, 8u);
  EXPECT_EQ(facts.components, 1u);
  EXPECT_EQ(facts.edges, 18u);
  EXPECT_EQ(facts.boundary_edges, 0u);
  EXPECT_EQ(facts.non_manifold_edges, 0u);
  EXPECT_EQ(facts.misoriented_edges, 0u);
  EXPECT_EQ(facts.collapsed_facets, 0u);
  EXPECT_EQ(facts.duplicate_facets, 0u);
  EXPECT_TRUE(facts.closed);
  EXPECT_TRUE(facts.oriented);
  EXPECT_EQ(facts.lowest, glm::vec3(-1));
  EXPECT_EQ(facts.highest, glm::vec3(1));
  EXPECT_DOUBLE_EQ(facts.bounding_radius, std::sqrt(3.0));
}

TEST(Inspect, AMissingFacetOpensTheCube) {
  Mesh mesh = cube();
  mesh.triangles.pop_back();
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.boundary_edges, 3u);
  EXPECT_EQ(facts.edges, 18u);
  EXPECT_FALSE(facts.closed);
  EXPECT_TRUE(facts.oriented);
}

TEST(Inspect, AFlippedFacetIsMisorientedOnItsThreeEdges) {
  Mesh mesh = cube();
  std::swap(mesh.triangles[5].x, mesh.triangles[5].y);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.misoriented_edges, 3u);
  EXPECT_TRUE(facts.closed);
  EXPECT_FALSE(facts.oriented);
}

TEST(Inspect, ThreeFacetsOnAnEdgeAreNonManifoldAndNotClosed) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.non_manifold_edges, 1u);
  EXPECT_EQ(facts.misoriented_edges, 0u);
  EXPECT_EQ(facts.boundary_edges, 6u);
  EXPECT_EQ(facts.edges, 7u);
  EXPECT_EQ(facts.components, 1u);
  EXPECT_FALSE(facts.closed);
  EXPECT_FALSE(facts.oriented);
}

TEST(Inspect, TwoCubesOnOneEdgeAreClosedThoughNonManifold) {
  Mesh mesh = cube();
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(mesh.positions[i] + glm::vec3(2, 2, 0));
  for (int f = 0; f < 12; ++f) mesh.triangles.push_back(mesh.triangles[f] + 8u);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.vertices, 16u);
  EXPECT_EQ(facts.distinct_positions, 14u);
  EXPECT_EQ(facts.non_manifold_edges, 1u);
  EXPECT_EQ(facts.edges, 35u);
  EXPECT_EQ(facts.components, 1u);
  EXPECT_TRUE(facts.closed);
  EXPECT_FALSE(facts.oriented);
}

TEST(Inspect, DuplicatesCountInAnyWinding) {
  Mesh mesh = cube();
  mesh.triangles.push_back(mesh.triangles[0]);
  mesh.triangles.emplace_back(mesh.triangles[0].z, mesh.triangles[0].y, mesh.triangles[0].x);
  mesh.triangles.emplace_back(mesh.triangles[7].y, mesh.triangles[7].z, mesh.triangles[7].x);
  EXPECT_EQ(inspect(mesh.view()).duplicate_facets, 3u);
}

TEST(Inspect, CollapsedFacetsHaveNoEdges) {
  Mesh mesh = cube();
  mesh.positions.push_back(mesh.positions[3]);
  mesh.triangles.emplace_back(0, 0, 1);
  mesh.triangles.emplace_back(3, 5, 8);  // two vertices at one place
  mesh.triangles.emplace_back(6, 6, 6);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.collapsed_facets, 3u);
  EXPECT_EQ(facts.edges, 18u);
  EXPECT_EQ(facts.components, 1u);
  EXPECT_TRUE(facts.closed);
  EXPECT_TRUE(facts.oriented);
}

TEST(Inspect, NothingButCollapsedFacetsIsNotClosed) {
  Mesh mesh;
  mesh.positions = {{1, 2, 3}};
  mesh.triangles = {{0, 0, 0}};
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.collapsed_facets, 1u);
  EXPECT_EQ(facts.components, 0u);
  EXPECT_EQ(facts.edges, 0u);
  EXPECT_FALSE(facts.closed);
  EXPECT_EQ(facts.bounding_radius, 0);
}

TEST(Inspect, SharedCornersDoNotJoinComponents) {
  Mesh mesh = cube();
  for (int i = 0; i < 8; ++i) mesh.positions.push_back(mesh.positions[i] + glm::vec3(2, 2, 2));
  for (int f = 0; f < 12; ++f) mesh.triangles.push_back(mesh.triangles[f] + 8u);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.components, 2u);
  EXPECT_EQ(facts.distinct_positions, 15u);
  EXPECT_TRUE(facts.closed);
  EXPECT_TRUE(facts.oriented);
}

TEST(Inspect, UnweldedMeshesAreJudgedByTheirShape) {
  const Mesh welded = cube();
  expect_same_facts(inspect(unwelded(welded).view()), inspect(welded.view()));
}

TEST(Inspect, BothZerosAreOnePosition) {
  Mesh mesh;
  mesh.positions = {{0.f, 0, 1}, {-0.f, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.distinct_positions, 3u);
  EXPECT_EQ(facts.collapsed_facets, 1u);
}

TEST(Inspect, UnusedVerticesDoNotCount) {
  Mesh mesh = cube();
  mesh.positions.emplace_back(100, nan, infinity);
  const MeshFacts facts = inspect(mesh.view());
  EXPECT_EQ(facts.vertices, 9u);
  EXPECT_EQ(facts.distinct_positions, 8u);
  EXPECT_EQ(facts.highest, glm::vec3(1));
}

TEST(Inspect, TheLargestBoxHasAFiniteRadius) {
  constexpr float largest = std::numeric_limits<float>::max();
  Mesh mesh;
  mesh.positions = {{-largest, -largest, -largest}, {largest, largest, largest}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_NEAR(inspect(mesh.view()).bounding_radius / largest, std::sqrt(3.0), 1e-15);
}

TEST(Inspect, FacetOrderAndRotationOfCornersDoNotMatter) {
  for (const std::string name : {"teapot_1k", "spiralstair_15k", "tablefan_36k"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = load(name);
    Mesh shuffled = mesh;
    std::mt19937 random(7);
    for (glm::uvec3& triangle : shuffled.triangles) {
      if (random() & 1) triangle = {triangle.y, triangle.z, triangle.x};
    }
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
    expect_same_facts(inspect(shuffled.view()), inspect(mesh.view()));
  }
}

TEST(Inspect, SameFactsForAnyThreadCount) {
  const Mesh mesh = load("tablefan_36k");
  const MeshFacts one = tbb::task_arena(1).execute([&] { return inspect(mesh.view()); });
  for (const int threads : {2, 5}) {
    expect_same_facts(tbb::task_arena(threads).execute([&] { return inspect(mesh.view()); }), one);
  }
}

struct KnownFacts {
  const char* mesh;
  bool shipped;
  std::size_t facets, boundary_edges, non_manifold_edges, duplicate_facets, components;
  bool closed;
};

// Of the shipped meshes, and of others that FACETSORT_MESH_PATH may have.
constexpr std::array known{KnownFacts{"teapot_1k", true, 992, 64, 0, 0, 4, false},
                           KnownFacts{"hand_2k", true, 2314, 0, 0, 0, 1, true},
                           KnownFacts{"cocktailglass_8k", true, 7808, 0, 0, 0, 1, true},
                           KnownFacts{"beerglass_10k", true, 9836, 60, 0, 0, 2, false},
                           KnownFacts{"spiralstair_15k", true, 14578, 94, 6, 6, 28, false},
                           KnownFacts{"tablefan_36k", true, 35956, 40, 80, 0, 182, false},
                           KnownFacts{"plant_63k", true, 63428, 7488, 0, 0, 2229, false},
                           KnownFacts{"truck_116k", true, 116495, 1993, 5472, 2991, 488, false},
                           KnownFacts{"furball_114k", false, 113880, 121472, 0, 0, 3796, false},
                           KnownFacts{"bunny_4k", false, 3674, 0, 0, 0, 1, true},
                           KnownFacts{"dragon_res4_11k", false, 11102, 0, 803, 502, 5, true},
                           KnownFacts{"cheese_18k", false, 17786, 0, 0, 0, 1, true},
                           KnownFacts{"tr12j_27k", false, 26966, 0, 0, 0, 1, true},
                           KnownFacts{"snowden_38k", false, 37629, 39, 88, 0, 4, false},
                           KnownFacts{"bunny_70k", false, 69666, 0, 0, 0, 1, true},
                           KnownFacts{"dragon_871k", false, 871306, 0, 0, 0, 1, true}};

TEST(Inspect, KnownMeshes) {
  for (const KnownFacts& expected : known) {
    if (!expected.shipped && !has_mesh(expected.mesh)) continue;
    SCOPED_TRACE(expected.mesh);
    const Mesh mesh = load(expected.mesh);
    ASSERT_TRUE(validate(mesh.view()).ok());
    const MeshFacts facts = inspect(mesh.view());
    EXPECT_EQ(facts.facets, expected.facets);
    EXPECT_EQ(facts.boundary_edges, expected.boundary_edges);
    EXPECT_EQ(facts.non_manifold_edges, expected.non_manifold_edges);
    EXPECT_EQ(facts.duplicate_facets, expected.duplicate_facets);
    EXPECT_EQ(facts.components, expected.components);
    EXPECT_EQ(facts.closed, expected.closed);
  }
}

TEST(Validate, AcceptsAMesh) {
  Mesh mesh = cube();
  mesh.facet_colours.resize(12);
  mesh.vertex_colours.resize(8);
  EXPECT_TRUE(validate(mesh.view()).ok());
  EXPECT_EQ(validate(mesh.view()).message, "");
}

TEST(Validate, NamesTheFirstFacetAtFault) {
  const auto expect = [](const Mesh& mesh, Fault fault, const std::string& message) {
    const Status status = validate(mesh.view());
    EXPECT_EQ(status.fault, fault);
    EXPECT_EQ(status.message, message);
  };
  expect(Mesh{}, Fault::empty_mesh, "no facet");

  Mesh mesh = cube();
  mesh.triangles[9].z = 8;
  mesh.triangles[4].y = 900;
  expect(mesh, Fault::index_out_of_range, "facet 4 names vertex 900 of 8");

  for (const float bad : {nan, infinity, -infinity}) {
    for (int axis = 0; axis < 3; ++axis) {
      mesh = cube();
      mesh.positions[5][axis] = bad;
      expect(mesh, Fault::non_finite_position, "facet 2 uses vertex 5, whose position is not finite");
    }
  }
  mesh = cube();
  mesh.positions.emplace_back(nan);
  expect(mesh, Fault::none, "");

  mesh.facet_colours.resize(13);
  expect(mesh, Fault::size_mismatch, "13 facet colours for 12 facets");
  mesh.facet_colours.clear();
  mesh.vertex_colours.resize(8);
  expect(mesh, Fault::size_mismatch, "8 vertex colours for 9 vertices");
}

TEST(Validate, ColoursCanBeDrawn) {
  for (const glm::vec4& bad : {glm::vec4(0, 0, 0, 2), glm::vec4(0, 0, 0, -1), glm::vec4(-0.1f, 0, 0, 1),
                               glm::vec4(0, nan, 0, 1), glm::vec4(0, 0, infinity, 1), glm::vec4(0, 0, 0, nan)}) {
    EXPECT_FALSE(is_colour(bad));
    Mesh mesh = cube();
    mesh.facet_colours.assign(mesh.triangles.size(), glm::vec4(3, 0, 0, 1));  // brighter than white is one
    EXPECT_TRUE(validate(mesh.view()).ok());
    mesh.facet_colours[4] = bad;
    EXPECT_EQ(validate(mesh.view()).fault, Fault::bad_argument);
    EXPECT_EQ(validate(mesh.view()).message, "facet 4 has a colour below 0, not finite or of an alpha above 1");
    mesh.facet_colours.clear();
    mesh.vertex_colours.assign(mesh.positions.size(), glm::vec4(1));
    mesh.vertex_colours[7] = bad;
    EXPECT_EQ(validate(mesh.view()).message, "vertex 7 has a colour below 0, not finite or of an alpha above 1");
    mesh.vertex_colours.clear();
    mesh.facet_materials.assign(mesh.triangles.size(), 0);
    mesh.materials = {{.base_colour = bad}};
    EXPECT_EQ(validate(mesh.view()).message, "material 0 has a colour below 0, not finite or of an alpha above 1");
  }
}

TEST(Validate, IdsMustFitIn32Bits) {
  // Only the counts are looked at.
  const glm::uvec3 triangle(0);
  const glm::vec3 position(0);
  constexpr std::size_t too_many = std::numeric_limits<std::uint32_t>::max();
  EXPECT_EQ(validate({{&position, 1}, {&triangle, too_many}, {}, {}}).fault, Fault::too_many_facets);
  EXPECT_EQ(validate({{&position, too_many}, {&triangle, 1}, {}, {}}).fault, Fault::too_many_facets);
  EXPECT_EQ(validate({{&position, too_many - 1}, {&triangle, 1}, {}, {}}).fault, Fault::none);
}

}  // namespace
}  // namespace facetsort
