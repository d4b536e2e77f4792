#include "facetsort/check/embree_referee.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>
#include <vector>

#include "facetsort/facets/facets.h"
#include "shapes.h"

namespace facetsort {
namespace {

RayHits cast(const Mesh& mesh, const View& view) {
  Result<EmbreeReferee> referee = EmbreeReferee::create(mesh.view());
  if (!referee.ok()) throw std::runtime_error(referee.status().message);
  Result<RayHits> hits = referee.value().cast(view);
  if (!hits.ok()) throw std::runtime_error(hits.status().message);
  return std::move(hits).value();
}

// From +z, the picture's height being that of the box of side 2.
View view_down_z(Projection projection, int size) {
  View view;
  view.eye = {0, 0, 5};
  view.projection = projection;
  view.width = view.height = size;
  return view;
}

View sized(View view, int width, int height) {
  view.width = width;
  view.height = height;
  return view;
}

// A triangle in the plane z = height that covers the square from (-1, -1) to (1, 1).
void add_sheet(Mesh& mesh, float height) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec2 corner : {glm::vec2(-9, -5), glm::vec2(9, -5), glm::vec2(0, 13)})
    mesh.positions.emplace_back(corner, height);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

Mesh sheets(int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) add_sheet(mesh, static_cast<float>(i) * 0.25f);
  return mesh;
}

Mesh moved(Mesh mesh, float scale, const glm::vec3& offset) {
  for (glm::vec3& position : mesh.positions) position = position * scale + offset;
  return mesh;
}

// Möller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", in double and without a bound.
std::optional<double> hit_depth(const Mesh& mesh, std::uint32_t facet, const Ray& ray) {
  const glm::dvec3 a(mesh.view().corner(facet, 0));
  const glm::dvec3 ab = glm::dvec3(mesh.view().corner(facet, 1)) - a;
  const glm::dvec3 ac = glm::dvec3(mesh.view().corner(facet, 2)) - a;
  const glm::dvec3 across = glm::cross(ray.direction, ac);
  const double determinant = glm::dot(ab, across);
  const glm::dvec3 to_origin = ray.origin - a;
  const double b = glm::dot(to_origin, across) / determinant;
  const glm::dvec3 q = glm::cross(to_origin, ab);
  const double c = glm::dot(ray.direction, q) / determinant;
  if (!(b >= 0 && c >= 0 && b + c <= 1)) return std::nullopt;
  return glm::dot(ac, q) / determinant;
}

void expect_every_facet_tried(const Mesh& mesh, const View& view) {
  const RayHits hits = cast(mesh, view);
  const Camera camera(view);
  EXPECT_GT(hits.rays, 0u);
  EXPECT_LT(hits.unjudged_rays * 1000, hits.rays);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const auto pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(view.width) + static_cast<std::size_t>(x);
      if (!hits.judged[pixel]) continue;
      const Ray ray = camera.pixel_ray(x, y);
      std::size_t found = 0;
      for (std::uint32_t facet = 0; facet < mesh.triangles.size(); ++facet) {
        const std::optional<double> depth = hit_depth(mesh, facet, ray);
        if (!depth || (camera.perspective && *depth * glm::dot(ray.direction, camera.forward) < camera.near_distance))
          continue;
        ++found;
        const auto list = hits.lists.pixel(pixel);
        const auto fragment =
            std::find_if(list.begin(), list.end(), [&](const Fragment& f) { return f.facet == facet; });
        ASSERT_NE(fragment, list.end()) << "facet " << facet << " at " << x << ", " << y;
        EXPECT_NEAR(fragment->depth, *depth, 1e-9 * *depth);
      }
      ASSERT_EQ(hits.lists.pixel(pixel).size(), found) << "at " << x << ", " << y;
    }
  }
}

void expect_same(const RayHits& a, const RayHits& b) {
  EXPECT_EQ(a.judged, b.judged);
  EXPECT_EQ(a.rays, b.rays);
  EXPECT_EQ(a.unjudged_rays, b.unjudged_rays);
  EXPECT_EQ(a.lists.offsets, b.lists.offsets);
  ASSERT_EQ(a.lists.fragments.size(), b.lists.fragments.size());
  for (std::size_t i = 0; i < a.lists.fragments.size(); ++i) {
    ASSERT_EQ(a.lists.fragments[i].facet, b.lists.fragments[i].facet);
    ASSERT_EQ(a.lists.fragments[i].depth, b.lists.fragments[i].depth);
    ASSERT_EQ(a.lists.fragments[i].depth_error, b.lists.fragments[i].depth_error);
  }
}

TEST(EmbreeReferee, MeasuresDepthAlongTheRay) {
  const Mesh mesh = sheets(5);
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    const View view = sized(view_down_z(projection, 0), 20, 10);
    const RayHits hits = cast(mesh, view);
    EXPECT_EQ(hits.unjudged_rays, 0u);
    EXPECT_EQ(hits.rays, 200u);
    const Camera camera(view);
    for (std::size_t p = 0; p < 200; ++p) {
      const auto list = hits.lists.pixel(p);
      ASSERT_EQ(list.size(), 5u);
      const Ray ray = camera.pixel_ray(static_cast<int>(p % 20), static_cast<int>(p / 20));
      for (std::uint32_t i = 0; i < 5; ++i) {
        EXPECT_EQ(list[i].facet, i);
        const double depth = (5 - 0.25 * i) / -ray.direction.z;
        EXPECT_NEAR(list[i].depth, depth, static_cast<double>(list[i].depth_error));
        EXPECT_LT(static_cast<double>(list[i].depth_error), 1e-12);
      }
    }
  }
}

TEST(EmbreeReferee, FindsBothSidesOfEveryShell) {
  constexpr int layers = 12;
  constexpr float gap = 0.01f;
  const Mesh mesh = shapes::nested_shells(layers, gap);
  // The ray of the middle pixel of an odd picture goes through the common centre, where shells are copies at a scale.
  const View view = sized(views_around(facet_bounds(mesh.view()), 9, 3, Projection::orthographic)[4], 65, 65);
  const RayHits hits = cast(mesh, view);
  const std::size_t middle = 32 * 65 + 32;
  ASSERT_TRUE(hits.judged[middle]);
  const auto list = hits.lists.pixel(middle);
  ASSERT_EQ(list.size(), 2u * layers);
  const double centre = glm::dot(glm::dvec3(view.at) - glm::dvec3(view.eye), Camera(view).forward);
  const double near_radius = centre - list.back().depth, far_radius = list.front().depth - centre;
  EXPECT_GT(near_radius, 0.98);
  EXPECT_GT(far_radius, 0.98);
  for (std::size_t k = 0; k < layers; ++k) {
    const double scale = 1 - static_cast<double>(gap) * static_cast<double>(k);
    EXPECT_NEAR(list[k].depth, centre + scale * far_radius, 1e-6);
    EXPECT_NEAR(list[2 * layers - 1 - k].depth, centre - scale * near_radius, 1e-6);
  }
}

TEST(EmbreeReferee, EqualsTryingEveryFacet) {
  const Mesh soup = shapes::soup(300, 5);
  for (const Projection projection : {Projection::orthographic, Projection::perspective})
    for (const View& view : views_around(facet_bounds(soup.view()), 3, 2.5f, projection))
      expect_every_facet_tried(soup, sized(view, 96, 64));
}

TEST(EmbreeReferee, EqualsTryingEveryFacetFromInside) {
  const Mesh soup = shapes::soup(300, 6);
  for (const View& view : cube_views(facet_bounds(soup.view()), {0.4f, 0.5f, 0.6f}))
    expect_every_facet_tried(soup, sized(view, 48, 48));
}

TEST(EmbreeReferee, EqualsTryingEveryFacetFarFromTheOrigin) {
  const Mesh soup = moved(shapes::soup(300, 7), 1, {3000, -20000, 500});
  expect_every_facet_tried(soup,
                           sized(views_around(facet_bounds(soup.view()), 5, 2.5f, Projection::perspective)[2], 96, 64));
}

TEST(EmbreeReferee, EqualsTryingEveryFacetFromAFarEye) {
  const Mesh soup = shapes::soup(300, 8);
  View view = sized(views_around(facet_bounds(soup.view()), 5, 1e5f, Projection::perspective)[3], 96, 64);
  view.vertical_fov_degrees = 1.2e-3f;
  expect_every_facet_tried(soup, view);
}

TEST(EmbreeReferee, MeetsEachWallOfABoxOnceFromInside) {
  const Mesh box = shapes::box();
  std::size_t rays = 0;
  for (const View& view : cube_views(facet_bounds(box.view()), {0.125f, -0.25f, 0.0625f})) {
    const RayHits hits = cast(box, sized(view, 31, 31));
    EXPECT_EQ(hits.rays, 31u * 31u);
    EXPECT_EQ(hits.lists.fragments.size() + hits.unjudged_rays, hits.rays);
    rays += hits.lists.fragments.size();
  }
  EXPECT_GT(rays, 6u * 31u * 31u - 40u);
}

TEST(EmbreeReferee, ScalesByPowersOfTwoToTheBit) {
  const Mesh mesh = shapes::torus_knot(2000);
  for (const Projection projection : {Projection::orthographic, Projection::perspective}) {
    View view = sized(views_around(facet_bounds(mesh.view()), 7, 2.5f, projection)[2], 80, 60);
    const RayHits expected = cast(mesh, view);
    EXPECT_GT(expected.lists.fragments.size(), 1000u);
    for (const int exponent : {-90, -20, 20, 90, 120}) {
      const float scale = std::ldexp(1.0f, exponent);
      View scaled = view;
      scaled.eye *= scale;
      scaled.at *= scale;
      scaled.near_distance *= scale;
      scaled.height_in_units *= scale;
      const RayHits hits = cast(moved(mesh, scale, {}), scaled);
      EXPECT_EQ(hits.judged, expected.judged);
      ASSERT_EQ(hits.lists.offsets, expected.lists.offsets);
      for (std::size_t i = 0; i < hits.lists.fragments.size(); ++i) {
        ASSERT_EQ(hits.lists.fragments[i].facet, expected.lists.fragments[i].facet);
        ASSERT_EQ(hits.lists.fragments[i].depth, std::ldexp(expected.lists.fragments[i].depth, exponent));
      }
    }
  }
}

TEST(EmbreeReferee, IsTheSameForAnyThreadCount) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  const Mesh mesh = shapes::torus_knot(5000);
  const View view = sized(views_around(facet_bounds(mesh.view()), 7, 2.5f, Projection::perspective)[5], 120, 90);
  const RayHits expected = cast(mesh, view);
  for (const int threads : {1, 2, 8})
    expect_same(tbb::task_arena(threads).execute([&] { return cast(mesh, view); }), expected);
}

TEST(EmbreeReferee, LeavesOutWhatTheNearPlaneCutsOff) {
  const Mesh mesh = sheets(5);  // at depths 5, 4.75, 4.5, 4.25 and 4 along the axis
  View view = view_down_z(Projection::perspective, 16);
  view.near_distance = 4.6f;
  const RayHits hits = cast(mesh, view);
  EXPECT_EQ(hits.unjudged_rays, 0u);
  for (std::size_t p = 0; p < 256; ++p) {
    ASSERT_EQ(hits.lists.pixel(p).size(), 2u);
    EXPECT_EQ(hits.lists.pixel(p)[0].facet, 0u);
    EXPECT_EQ(hits.lists.pixel(p)[1].facet, 1u);
  }

  view.near_distance = 4.5f;
  const RayHits on_the_plane = cast(mesh, view);
  EXPECT_EQ(on_the_plane.unjudged_near_plane, 256u);
  EXPECT_EQ(on_the_plane.unjudged_rays, 256u);
  EXPECT_EQ(on_the_plane.rays, 256u);
  EXPECT_TRUE(on_the_plane.lists.fragments.empty());
}

TEST(EmbreeReferee, CutsNothingOffInOrthographicViews) {
  View view = view_down_z(Projection::orthographic, 16);
  view.eye.z = 0.6f;
  view.at.z = -1;
  view.near_distance = 0.3f;
  const RayHits hits = cast(sheets(5), view);
  EXPECT_EQ(hits.lists.fragments.size(), 5u * 256u);
  EXPECT_LT(hits.lists.pixel(0).back().depth, 0);
}

TEST(EmbreeReferee, LeavesRaysThroughAnEdgeUnjudged) {
  const Mesh box = shapes::box();
  // The diagonals of both faces across the view go through pixel centres.
  const RayHits hits = cast(box, view_down_z(Projection::orthographic, 8));
  EXPECT_GE(hits.unjudged_edge, 8u);
  EXPECT_LE(hits.unjudged_edge, 16u);
  EXPECT_EQ(hits.unjudged_edge, hits.unjudged_rays);
  EXPECT_EQ(hits.rays, 64u);
  for (std::size_t p = 0; p < 64; ++p) {
    const std::size_t x = p % 8, y = p / 8;
    const bool is_on_a_diagonal = x == y || x + y == 7;
    EXPECT_TRUE(hits.judged[p] || is_on_a_diagonal);
    EXPECT_EQ(hits.lists.pixel(p).size(), hits.judged[p] ? 2u : 0u);
  }
}

TEST(EmbreeReferee, LeavesRaysAlongAFacetUnjudged) {
  Mesh mesh = sheets(1);
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec2 corner : {glm::vec2(-0.5f, 0.5f), glm::vec2(0.5f, 0.5f), glm::vec2(0, 0.75f)})
    mesh.positions.emplace_back(0, corner);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  // Of 9 columns the middle one looks along the upright facet, which reaches over 5 of 9 rows.
  const RayHits hits = cast(mesh, view_down_z(Projection::orthographic, 9));
  EXPECT_EQ(hits.unjudged_grazing, 5u);
  EXPECT_EQ(hits.unjudged_rays, 5u);
  EXPECT_EQ(hits.lists.fragments.size(), 76u);
}

TEST(EmbreeReferee, FindsNothingOnFacetsWithoutArea) {
  Mesh point;
  point.positions = {{1, 2, 3}};
  point.triangles = {{0, 0, 0}};
  Mesh line;
  line.positions = {{-1, 0.01f, 0}, {0, 0.01f, 0}, {1, 0.01f, 0}};
  line.triangles = {{0, 1, 2}, {0, 2, 2}};
  for (const Mesh& mesh : {point, line}) {
    const RayHits hits = cast(mesh, view_down_z(Projection::perspective, 32));
    EXPECT_EQ(hits.rays, 0u);
    EXPECT_TRUE(hits.lists.fragments.empty());
  }
}

TEST(EmbreeReferee, CatchesTwoSwappedFacets) {
  const Mesh mesh = sheets(6);
  const RayHits hits = cast(mesh, view_down_z(Projection::perspective, 16));
  JudgeOptions options;
  options.bounding_radius = static_cast<double>(facet_bounds(mesh.view()).radius());
  std::vector<std::uint32_t> rank{0, 1, 2, 3, 4, 5};
  EXPECT_EQ(judge_order(hits.lists, rank, options).inverted_pixels, 0u);
  std::swap(rank[1], rank[2]);
  const Verdict verdict = judge_order(hits.lists, rank, options);
  EXPECT_EQ(verdict.inverted_pixels, 256u);
  EXPECT_EQ(verdict.inverted_pairs, 256u);
  EXPECT_EQ(verdict.worst_far_facet, 1u);
  EXPECT_EQ(verdict.worst_near_facet, 2u);
}

TEST(EmbreeReferee, LeavesTheFloatingPointModeAlone) {
  std::atomic<int> flushed{0};
  // A new thread, whose arena has done no work before Embree's.
  std::thread([&] {
    const Mesh mesh = shapes::torus_knot(20000);
    cast(mesh, view_down_z(Projection::perspective, 8));
    tbb::parallel_for(0, 10000, [&](int) {
      const volatile float smallest_normal = std::numeric_limits<float>::min();
      const volatile float denormal = smallest_normal / 2;
      if (!(denormal > 0)) ++flushed;
    });
  }).join();
  EXPECT_EQ(flushed, 0);
}

TEST(EmbreeReferee, RefusesAViewThatIsNone) {
  const Mesh box = shapes::box();
  const Result<EmbreeReferee> referee = EmbreeReferee::create(box.view());
  ASSERT_TRUE(referee.ok());
  View view;
  view.at = view.eye;
  const Result<RayHits> hits = referee.value().cast(view);
  ASSERT_FALSE(hits.ok());
  EXPECT_EQ(hits.status().fault, Fault::bad_argument);
}

TEST(EmbreeReferee, MeetsSingleSidedFacetsFromTheFrontAlone) {
  Mesh mesh = shapes::torus_knot(2000);
  mesh.facet_materials.assign(mesh.triangles.size(), 0);
  mesh.materials = {{.double_sided = false}};
  const View view = sized(default_view(facet_bounds(mesh.view()), {2, 1, 3}), 80, 60);
  const RayHits hits = cast(mesh, view);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  EXPECT_LT(hits.unjudged_rays, 10u);
  ASSERT_GT(lists.fragments.size(), 500u);
  std::size_t several = 0;
  for (std::size_t pixel = 0; pixel < hits.judged.size(); ++pixel) {
    if (!hits.judged[pixel]) continue;
    const auto found = hits.lists.pixel(pixel), expected = lists.pixel(pixel);
    ASSERT_EQ(found.size(), expected.size()) << pixel;
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i].facet, expected[i].facet);
    several += found.size() > 1;
  }
  EXPECT_GT(several, 10u);
}

}  // namespace
}  // namespace facetsort
