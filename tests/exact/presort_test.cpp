// What every presorted mesh holds, whatever the mesh. That its orders are right is tested with all exact orders.
#include "facetsort/exact/presort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/order/presorted_mesh.h"
#include "shapes.h"
#include "support/effort.h"
#include "support/instruction_sets.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

std::string file_of(const PresortedData& data) {
  std::ostringstream stream;
  const Status status = write_presorted(stream, data.view());
  EXPECT_TRUE(status.ok()) << status.message;
  return stream.str();
}

glm::dvec3 area_vector(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  return glm::cross(b - a, c - a) / 2.0;
}

// The triangles of all pieces of a facet make its area, and none is turned over.
void expect_areas_kept(const Mesh& mesh, const PresortedData& data) {
  const double radius = facet_bounds(mesh.view()).radius(), rounding = 1e-5 * radius * radius;
  const auto position = [&](std::uint32_t vertex) {
    return glm::dvec3(vertex < mesh.positions.size() ? mesh.positions[vertex]
                                                     : data.made_positions[vertex - mesh.positions.size()]);
  };
  std::vector<glm::dvec3> area(mesh.triangles.size(), glm::dvec3(0));
  std::size_t next = 0;
  for (const PresortedPiece& piece : data.pieces) {
    const glm::uvec3& facet = mesh.triangles[piece.facet];
    const glm::dvec3 whole = area_vector(position(facet.x), position(facet.y), position(facet.z));
    for (std::uint32_t i = 0; i < piece.triangle_count; ++i, ++next) {
      const glm::uvec3& triangle = data.triangles[next];
      const glm::dvec3 part = area_vector(position(triangle.x), position(triangle.y), position(triangle.z));
      EXPECT_GE(glm::dot(part, whole), -rounding * glm::length(whole));
      area[piece.facet] += part;
    }
  }
  EXPECT_EQ(next, data.triangles.size());
  for (std::size_t f = 0; f < area.size(); ++f) {
    const glm::uvec3& facet = mesh.triangles[f];
    const glm::dvec3 whole = area_vector(position(facet.x), position(facet.y), position(facet.z));
    EXPECT_LE(glm::length(area[f] - whole), rounding) << "facet " << f;
  }
}

void expect_vertices_in_their_facets(const Mesh& mesh, const PresortedData& data) {
  const double rounding = 1e-6 * facet_bounds(mesh.view()).radius();
  for (std::size_t i = 0; i < data.made_vertices.size(); ++i) {
    const PresortedVertex& vertex = data.made_vertices[i];
    glm::dvec3 place(0);
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(vertex.barycentric[k], 0);
      place += static_cast<double>(vertex.barycentric[k]) * glm::dvec3(mesh.view().corner(vertex.facet, k));
    }
    EXPECT_LE(glm::distance(place, glm::dvec3(data.made_positions[i])), rounding) << "made vertex " << i;
  }
}

TEST(Presort, IsSoundAndKeepsAreas) {
  for (const Mesh& mesh :
       {shapes::torus_knot(800), shapes::interpenetrating(2), shapes::slab_cycle(5), shapes::triangle_cycle(4),
        shapes::soup(20, 3), shapes::woven_mat(4), shapes::coplanar(40, 5), shapes::duplicated_grid(3, 3),
        shapes::box(), shapes::nested_shells(3, 0.01f, 1)}) {
    const std::optional<Presorted> presorted = presort(mesh.view());
    ASSERT_TRUE(presorted);
    const PresortedData& data = presorted->data;
    const Status status = validate_presorted(data.view());
    EXPECT_TRUE(status.ok()) << status.message;
    expect_areas_kept(mesh, data);
    expect_vertices_in_their_facets(mesh, data);
    EXPECT_EQ(presorted->statistics.nodes, data.nodes.size());
    EXPECT_EQ(presorted->statistics.pieces, data.pieces.size());
    EXPECT_EQ(presorted->statistics.triangles, data.triangles.size());
  }
}

TEST(Presort, LeavesABoxWhole) {
  const Mesh mesh = shapes::box();
  const std::optional<Presorted> presorted = presort(mesh.view());
  ASSERT_TRUE(presorted);
  EXPECT_EQ(presorted->statistics.tree_cuts, 0u);
  EXPECT_EQ(presorted->data.triangles.size(), mesh.triangles.size());
  EXPECT_TRUE(presorted->data.made_vertices.empty());
}

TEST(Presort, PutsFacetsInOnePlaneIntoOneNode) {
  const Mesh mesh = shapes::coplanar(50, 9);
  const std::optional<Presorted> presorted = presort(mesh.view());
  ASSERT_TRUE(presorted);
  ASSERT_EQ(presorted->data.nodes.size(), 1u);
  EXPECT_EQ(presorted->data.nodes.front().piece_count, 50u);
}

TEST(Presort, TakesNothingOneFacetAndFacetsWithoutArea) {
  const std::optional<Presorted> nothing = presort({});
  ASSERT_TRUE(nothing);
  EXPECT_TRUE(nothing->data.nodes.empty());
  EXPECT_TRUE(nothing->data.pieces.empty());

  Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}}, {{0, 1, 2}}, {}, {}};
  const std::optional<Presorted> one = presort(mesh.view());
  ASSERT_TRUE(one);
  EXPECT_EQ(one->data.nodes.size(), 1u);
  EXPECT_EQ(one->data.triangles, mesh.triangles);

  mesh.triangles.push_back({0, 1, 3});  // on a line
  mesh.triangles.push_back({2, 2, 2});
  const std::optional<Presorted> three = presort(mesh.view());
  ASSERT_TRUE(three);
  ASSERT_EQ(three->data.pieces.size(), 3u);
  EXPECT_EQ(three->data.pieces[0].facet, 1u);
  EXPECT_EQ(three->data.pieces[1].facet, 2u);
  EXPECT_EQ(three->data.nodes.size(), 1u);
  EXPECT_TRUE(validate_presorted(three->data.view()).ok());
}

TEST(Presort, KeepsColours) {
  Mesh mesh = shapes::slab_cycle(3);
  mesh.facet_colours.assign(mesh.triangles.size(), glm::vec4(0.25f, 0.5f, 1, 0.5f));
  const std::optional<Presorted> presorted = presort(mesh.view());
  ASSERT_TRUE(presorted);
  EXPECT_EQ(presorted->data.facet_colours, mesh.facet_colours);
  EXPECT_GT(presorted->statistics.tree_cuts + presorted->statistics.crossing_cuts, 0u);
}

TEST(Presort, IsTheSameForAnyThreadCountAndInstructionSet) {
  for (const Mesh& mesh : {shapes::torus_knot(is_sanitized ? 800 : 3000), load("teapot_1k")}) {
    const std::string expected = file_of(presort(mesh.view())->data);
    for (const int threads : {1, 2, 3, 8}) {
      with_threads(threads, [&] { EXPECT_TRUE(file_of(presort(mesh.view())->data) == expected) << threads; });
    }
    for_each_instruction_set([&] { EXPECT_TRUE(file_of(presort(mesh.view())->data) == expected); });
  }
}

TEST(Presort, GivesNothingWhereGrowthIsNotEnoughOrItIsCancelled) {
  const Mesh mesh = shapes::slab_cycle(3);
  EXPECT_FALSE(presort(mesh.view(), {.max_growth = 1}));
  PresortProgress progress;
  progress.cancelled = true;
  EXPECT_FALSE(presort(mesh.view(), {}, &progress));
}

TEST(Presort, TellsItsProgress) {
  const Mesh mesh = shapes::soup(30, 4);
  PresortProgress progress;
  const std::optional<Presorted> presorted = presort(mesh.view(), {}, &progress);
  ASSERT_TRUE(presorted);
  EXPECT_EQ(progress.done, presorted->statistics.pieces);
  EXPECT_EQ(progress.all, progress.done);
}

}  // namespace
}  // namespace facetsort
