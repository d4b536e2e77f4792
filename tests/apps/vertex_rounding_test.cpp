// What the rounding of new vertices explains of a drawing, and what it does not.
#include "facetsort/vertex_rounding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {
namespace {

// A triangle, and its two halves with a new vertex on the side between the first two corners.
struct Halves {
  Mesh mesh, drawn;
  std::vector<std::uint32_t> sources{0, 0};

  Halves() {
    mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
    mesh.triangles = {{0, 1, 2}};
    drawn.positions = mesh.positions;
    drawn.positions.emplace_back(0, -1, 0);
    drawn.triangles = {{0, 3, 2}, {3, 1, 2}};
  }

  PartedMesh parted() const { return PartedMesh(mesh.view(), drawn.view(), sources); }
};

View view_of(const Mesh& mesh) {
  View view = default_view(facet_bounds(mesh.view()), {0.1f, 0.2f, 4});
  view.width = view.height = 256;
  return view;
}

PartCoverage coverage_of(const Halves& halves) {
  const View view = view_of(halves.mesh);
  return halves.parted().compare_coverage(view, collect_fragments(halves.mesh.view(), view),
                                          collect_fragments(halves.drawn.view(), view));
}

TEST(VertexRounding, BoundsTheRoundingOfEachFacet) {
  const Halves halves;
  EXPECT_GE(vertex_rounding(halves.mesh.view(), 0), std::sqrt(3.0) * 0x1p-24);
  EXPECT_LE(vertex_rounding(halves.mesh.view(), 0), 0x1p-22);
  Mesh tiny;
  tiny.positions.assign(3, glm::vec3(0));
  tiny.triangles = {{0, 1, 2}};
  EXPECT_GT(vertex_rounding(tiny.view(), 0), 0x1p-149);
}

TEST(VertexRounding, DistanceToASegmentWithAndWithoutLength) {
  EXPECT_DOUBLE_EQ(distance_to_segment({1, 2, 0}, {0, 0, 0}, {3, 0, 0}), 2);
  EXPECT_DOUBLE_EQ(distance_to_segment({-3, 4, 0}, {0, 0, 0}, {3, 0, 0}), 5);
  EXPECT_DOUBLE_EQ(distance_to_segment({0, 0, 7}, {0, 0, 5}, {0, 0, 5}), 2);
}

TEST(PartCoverage, HalvesCoverTheWhole) {
  const PartCoverage coverage = coverage_of(Halves());
  EXPECT_EQ(coverage.miscovered_pixels, 0u);
  EXPECT_EQ(coverage.excused_pixels, 0u);
}

TEST(PartCoverage, GapsAndDoubleCoverCount) {
  Halves moved;
  moved.drawn.positions[3].y += 0.1f;
  EXPECT_GT(coverage_of(moved).miscovered_pixels, 100u);

  Halves missing;
  missing.drawn.triangles.pop_back();
  missing.sources.pop_back();
  const std::size_t gap = coverage_of(missing).miscovered_pixels;
  EXPECT_GT(gap, 1000u);

  Halves repeated;
  repeated.drawn.triangles.push_back(repeated.drawn.triangles.back());
  repeated.sources.push_back(0);
  EXPECT_NEAR(static_cast<double>(coverage_of(repeated).miscovered_pixels), static_cast<double>(gap), 300);
}

TEST(PartCoverage, WhatRoundingCouldHaveMovedIsExcused) {
  // Moves the side by two pixels; far from the origin that is within the rounding of float32.
  for (const bool far : {false, true}) {
    Halves halves;
    for (glm::vec3& position : halves.mesh.positions) position.x += far ? 262144.0f : 0.0f;
    for (glm::vec3& position : halves.drawn.positions) position.x += far ? 262144.0f : 0.0f;
    halves.drawn.positions[3].y += 0.03f;
    View view = default_view(facet_bounds(halves.mesh.view()), {far ? 262144.0f : 0.0f, 0, 4});
    view.width = view.height = 256;
    const PartCoverage coverage = halves.parted().compare_coverage(
        view, collect_fragments(halves.mesh.view(), view), collect_fragments(halves.drawn.view(), view));
    EXPECT_GT(far ? coverage.excused_pixels : coverage.miscovered_pixels, 10u) << far;
    EXPECT_EQ(far ? coverage.miscovered_pixels : coverage.excused_pixels, 0u) << far;
  }
}

TEST(WidenDepthErrors, ByTheRoundingAlongTheRayOfWhatHasNewCorners) {
  Halves halves;
  halves.mesh.positions.insert(halves.mesh.positions.end(), {{-1, -1, -1}, {1, -1, -1}, {0, 1, -1}});
  halves.mesh.triangles.emplace_back(3, 4, 5);
  halves.drawn.positions = halves.mesh.positions;
  halves.drawn.positions.emplace_back(0, -1, 0);
  halves.drawn.triangles = {{3, 4, 5}, {0, 6, 2}, {6, 1, 2}};
  halves.sources = {1, 0, 0};
  const View view = view_of(halves.mesh);
  const FragmentLists before = collect_fragments(halves.drawn.view(), view);
  FragmentLists after = before;
  halves.parted().widen_depth_errors(view, after);
  ASSERT_GT(before.fragments.size(), 1000u);
  for (std::size_t i = 0; i < before.fragments.size(); ++i) {
    const float widened = after.fragments[i].depth_error - before.fragments[i].depth_error;
    EXPECT_EQ(after.fragments[i].depth, before.fragments[i].depth);
    if (before.fragments[i].facet == 0) {
      EXPECT_EQ(widened, 0.0f);  // whole
    } else {
      EXPECT_GE(widened, static_cast<float>(vertex_rounding(halves.mesh.view(), 0)));
      EXPECT_LE(widened, 2 * static_cast<float>(vertex_rounding(halves.mesh.view(), 0)));
    }
  }
}

}  // namespace
}  // namespace facetsort
