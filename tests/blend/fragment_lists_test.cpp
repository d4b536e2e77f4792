#include "facetsort/blend/fragment_lists.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "blend/pictures.h"
#include "facetsort/exact/predicates.h"
#include "shapes.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

View view_from(const Mesh& mesh, const glm::vec3& direction, float radii, Projection projection, int width = 96,
               int height = 80) {
  const Box box = facet_bounds(mesh.view());
  return sized(default_view(box, box.centre() + radii * box.radius() * direction, projection), width, height);
}

// Whether the exact ray through the pixel's centre meets the facet, by exact arithmetic alone.
bool covers(const Mesh& mesh, std::uint32_t facet, const View& view, const Camera& camera, int x, int y) {
  const glm::dmat3 rows(camera.row_x, camera.row_y, camera.row_w);
  const glm::vec3 corner[3] = {mesh.view().corner(facet, 0), mesh.view().corner(facet, 1), mesh.view().corner(facet, 2)};
  const int facing = exact_facing(corner[0], corner[1], corner[2], view.eye, rows, camera.offset);
  if (facing == 0) return false;
  for (int i = 0; i < 3; ++i) {
    const EdgeSigns signs = exact_edge_signs(corner[(i + 1) % 3], corner[(i + 2) % 3], view.eye, rows, camera.offset,
                                             x + 0.5, y + 0.5);
    const int side = signs.at_pixel != 0 ? signs.at_pixel : signs.x != 0 ? signs.x : signs.y;
    if (side != facing) return false;
  }
  return true;
}

void expect_exact_coverage(const Mesh& mesh, const View& view) {
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const Camera camera(view);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      std::vector<std::uint32_t> expected, found;
      for (std::uint32_t facet = 0; facet < mesh.triangles.size(); ++facet) {
        if (covers(mesh, facet, view, camera, x, y)) expected.push_back(facet);
      }
      for (const Fragment& fragment : lists.pixel(static_cast<std::size_t>(y * view.width + x))) {
        found.push_back(fragment.facet);
      }
      std::sort(found.begin(), found.end());
      ASSERT_EQ(found, expected) << "pixel " << x << ", " << y;
    }
  }
}

TEST(FragmentLists, CoverageIsExactOnRandomFacets) {
  const Mesh mesh = shapes::soup(60, 11);
  expect_exact_coverage(mesh, view_from(mesh, {0.3f, 0.5f, 0.8f}, 2.5f, Projection::perspective, 48, 40));
  expect_exact_coverage(mesh, view_from(mesh, {0, 0, 1}, 2.5f, Projection::orthographic, 48, 40));
}

TEST(FragmentLists, CoverageIsExactAroundAnEyeInside) {
  const Mesh mesh = shapes::soup(60, 12);
  View view = view_from(mesh, {0.01f, 0.02f, 0.005f}, 1.0f, Projection::perspective, 40, 40);
  view.vertical_fov_degrees = 120;
  view.near_distance = 1e-20f;
  expect_exact_coverage(mesh, view);
}

TEST(FragmentLists, CoverageIsExactOnSliversAndTinyFacets) {
  Mesh fan = shapes::sliver_fan(40, 1e6f);
  expect_exact_coverage(fan, view_from(fan, {0.2f, 0.1f, 0.97f}, 2.5f, Projection::perspective, 40, 32));
  Mesh far = shapes::icosphere(1);
  expect_exact_coverage(far, view_from(far, {0.2f, 0.1f, 0.97f}, 60.0f, Projection::perspective, 40, 32));
}

// From less than a pixel to most of the picture: facets of each size are rasterised in a way of their own, and facets
// across tiles and the picture's sides in parts.
TEST(FragmentLists, CoverageIsExactOnFacetsOfAnySize) {
  std::uint32_t seed = 20;
  for (const float size : {0.01f, 0.04f, 0.1f, 0.25f, 0.8f}) {
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      SCOPED_TRACE(size);
      const Mesh mesh = shapes::scattered(25, size, ++seed);
      View view = view_from(mesh, {0.3f, 0.5f, 0.8f}, 2.5f, projection, 70, 66);
      view.vertical_fov_degrees = 30;
      view.height_in_units *= 0.7f;
      expect_exact_coverage(mesh, view);
    }
  }
}

// Corners up to a hundred and up to a million pictures away.
TEST(FragmentLists, CoverageIsExactOnFacetsFarLargerThanThePicture) {
  for (const float degrees : {0.5f, 5e-5f}) {
    SCOPED_TRACE(degrees);
    const Mesh mesh = shapes::soup(60, 13);
    View view = view_from(mesh, {0.3f, 0.5f, 0.8f}, 2.5f, Projection::perspective, 40, 36);
    view.vertical_fov_degrees = degrees;
    expect_exact_coverage(mesh, view);
  }
}

// A sheet of squares whose corners lie exactly on pixel centres, seen straight on: centres are on edges and corners.
void expect_sheet_covered_once(int squares, int pixels_per_square) {
  const int side = squares * pixels_per_square;
  Mesh sheet;
  for (int y = 0; y <= squares; ++y) {
    for (int x = 0; x <= squares; ++x) sheet.positions.emplace_back(x * pixels_per_square, y * pixels_per_square, 0);
  }
  const auto squares_across = static_cast<std::uint32_t>(squares);
  for (std::uint32_t y = 0; y < squares_across; ++y) {
    for (std::uint32_t x = 0; x < squares_across; ++x) {
      const std::uint32_t a = y * (squares_across + 1) + x, b = a + 1, c = a + squares_across + 1, d = c + 1;
      // Diagonals both ways, windings both ways: the rule must not care.
      if ((x + y) % 2 == 0) {
        sheet.triangles.emplace_back(a, b, d);
        sheet.triangles.emplace_back(a, c, d);
      } else {
        sheet.triangles.emplace_back(b, a, c);
        sheet.triangles.emplace_back(b, d, c);
      }
    }
  }
  View view;
  view.projection = Projection::orthographic;
  const int size = side + 8;
  view.width = view.height = size;
  view.height_in_units = static_cast<float>(size);  // one unit a pixel
  const float middle = 0.5f * static_cast<float>(side) + 0.5f;  // pixel centres fall on whole coordinates
  view.eye = {middle, middle, 5};
  view.at = {middle, middle, 0};
  const FragmentLists lists = collect_fragments(sheet.view(), view);
  for (int y = 0; y < size; ++y) {
    for (int x = 0; x < size; ++x) {
      // The centre of pixel (x, y) is at (x - 3, side + 4 - y) on the sheet; left and top sides are in, the others out.
      const int sheet_x = x - 3, sheet_y = side + 4 - y;
      const bool inside = sheet_x >= 0 && sheet_x < side && sheet_y > 0 && sheet_y <= side;
      EXPECT_EQ(lists.pixel(static_cast<std::size_t>(y * size + x)).size(), inside ? 1u : 0u) << x << ", " << y;
    }
  }
}

TEST(FragmentLists, TopLeftRuleCoversASheetOnPixelCentresOnce) {
  expect_sheet_covered_once(8, 1);
  expect_sheet_covered_once(10, 4);   // small facets, some across tiles
  expect_sheet_covered_once(4, 20);   // larger ones
}

TEST(FragmentLists, ClosedMeshesAreEnteredAsOftenAsLeft) {
  for (const Mesh& mesh : {shapes::torus_knot(3000), shapes::interpenetrating(2), load("hand_2k"),
                           load("cocktailglass_8k")}) {
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      for (const View& view : views_around(facet_bounds(mesh.view()), 4, 2.5f, projection)) {
        const FragmentLists lists = collect_fragments(mesh.view(), sized(view, 128, 128));
        const glm::vec4 eye = view.homogeneous_eye();
        for (std::size_t pixel = 0; pixel < 128 * 128; ++pixel) {
          int depth = 0;
          for (const Fragment& fragment : lists.pixel(pixel)) {
            depth += side_of_plane(mesh.view().corner(fragment.facet, 0), mesh.view().corner(fragment.facet, 1),
                                   mesh.view().corner(fragment.facet, 2), eye);
          }
          ASSERT_EQ(depth, 0) << "fronts and backs differ at pixel " << pixel;
        }
      }
    }
  }
}

TEST(FragmentLists, AnEyeInsideAClosedMeshLeavesItOnceMore) {
  const Mesh mesh = shapes::icosphere(3);
  for (View view : cube_views(facet_bounds(mesh.view()), {0.3f, -0.2f, 0.4f})) {
    view.width = view.height = 64;
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    for (std::size_t pixel = 0; pixel < 64 * 64; ++pixel) ASSERT_EQ(lists.pixel(pixel).size(), 1u);
  }
}

TEST(FragmentLists, DepthIsTheDistanceAlongTheRay) {
  // A plane far larger than the picture, tilted: the ray meets it where the plane's equation says.
  Mesh mesh;
  mesh.positions = {{-100, -100, -10}, {100, -100, 10}, {100, 100, 10}, {-100, 100, -10}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    View view;
    view.eye = {1, 2, 40};
    view.at = {1, 2, 0};
    view.projection = projection;
    view.height_in_units = 10;
    view.width = view.height = 33;
    const Camera camera(view);
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    for (int y = 0; y < 33; ++y) {
      for (int x = 0; x < 33; ++x) {
        const auto fragments = lists.pixel(static_cast<std::size_t>(y * 33 + x));
        ASSERT_EQ(fragments.size(), 1u);
        const Ray ray = camera.pixel_ray(x, y);
        const glm::dvec3 normal(-0.1, 0, 1);  // z = x / 10
        const double expected = -glm::dot(normal, ray.origin) / glm::dot(normal, ray.direction);
        // The bound is of the facet's float32 corners alone: they are exact here.
        EXPECT_NEAR(fragments[0].depth, expected, static_cast<double>(fragments[0].depth_error) + 1e-13);
        EXPECT_LT(fragments[0].depth_error, 1e-10f);
      }
    }
  }
}

TEST(FragmentLists, ListsAreSortedFarthestFirst) {
  const Mesh mesh = shapes::soup(400, 5);
  const FragmentLists lists = collect_fragments(mesh.view(), view_from(mesh, {0, 0.6f, 0.8f}, 2, Projection::perspective));
  std::size_t layered = 0;
  for (std::size_t pixel = 0; pixel < 96 * 80; ++pixel) {
    const auto fragments = lists.pixel(pixel);
    layered += fragments.size() > 1;
    for (std::size_t k = 1; k < fragments.size(); ++k) {
      ASSERT_TRUE(fragments[k - 1].depth > fragments[k].depth ||
                  (fragments[k - 1].depth == fragments[k].depth && fragments[k - 1].facet < fragments[k].facet));
    }
  }
  EXPECT_GT(layered, 1000u);
}

TEST(FragmentLists, NothingNearerThanTheNearPlane) {
  const Mesh mesh = shapes::icosphere(3);
  View view = view_from(mesh, {0, 0, 1}, 2.5f, Projection::perspective);
  const glm::dvec3 axis(view.forward());
  const double middle = glm::length(glm::dvec3(view.eye));  // of the sphere, along the axis
  view.near_distance = static_cast<float>(middle);
  const FragmentLists cut = collect_fragments(mesh.view(), view);
  view.near_distance = 1e-3f;
  const FragmentLists whole = collect_fragments(mesh.view(), view);
  const Camera camera(view);
  std::size_t cut_away = 0;
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * view.width + x);
      const double along_axis = glm::dot(camera.pixel_ray(x, y).direction, axis);
      std::size_t beyond = 0;
      for (const Fragment& fragment : whole.pixel(pixel)) beyond += fragment.depth * along_axis >= middle;
      ASSERT_EQ(cut.pixel(pixel).size(), beyond);
      cut_away += whole.pixel(pixel).size() - beyond;
    }
  }
  EXPECT_GT(cut_away, 500u);
}

TEST(FragmentLists, EdgeOnAndDegenerateFacetsCoverNothing) {
  Mesh mesh;
  mesh.positions = {{-1, 0, -1}, {1, 0, -1}, {0, 0, 1}, {-1, -1, 0}, {0, 0, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {0, 0, 1}};  // in the eye's plane; on a line; two corners alike
  View view;
  view.eye = {0, 0, 4};
  view.width = view.height = 65;  // a row and a column of pixel centres pass through the middle
  const FragmentLists perspective = collect_fragments(mesh.view(), view);
  EXPECT_TRUE(perspective.fragments.empty());
  view.projection = Projection::orthographic;
  const FragmentLists orthographic = collect_fragments(mesh.view(), view);
  EXPECT_TRUE(orthographic.fragments.empty());
}

TEST(FragmentLists, MirroringAndPowersOfTwoChangeNoFragment) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_from(mesh, {0.6f, 0.3f, 0.74f}, 2.5f, Projection::perspective);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  for (const int exponent : {-90, -7, 7, 90}) {
    const float scale = std::ldexp(1.0f, exponent);
    Mesh scaled = mesh;
    for (glm::vec3& position : scaled.positions) position *= scale;
    View scaled_view = view;
    scaled_view.eye *= scale;
    scaled_view.at *= scale;
    scaled_view.near_distance *= scale;
    const FragmentLists other = collect_fragments(scaled.view(), scaled_view);
    ASSERT_EQ(other.offsets, lists.offsets);
    for (std::size_t i = 0; i < lists.fragments.size(); ++i) {
      ASSERT_EQ(other.fragments[i].facet, lists.fragments[i].facet);
      ASSERT_EQ(other.fragments[i].depth, lists.fragments[i].depth * static_cast<double>(scale));
    }
  }
}

TEST(FragmentLists, SameForAnyThreadCount) {
  const Mesh mesh = load("spiralstair_15k");
  const View view = view_from(mesh, {0.6f, 0.3f, 0.74f}, 2.5f, Projection::perspective, 300, 200);
  const FragmentLists expected = collect_fragments(mesh.view(), view);
  for (const int threads : {1, 2, 3, 8}) {
    const FragmentLists lists = with_threads(threads, [&] { return collect_fragments(mesh.view(), view); });
    ASSERT_EQ(lists.offsets, expected.offsets);
    for (std::size_t i = 0; i < lists.fragments.size(); ++i) {
      ASSERT_EQ(lists.fragments[i].facet, expected.fragments[i].facet);
      ASSERT_EQ(lists.fragments[i].depth, expected.fragments[i].depth);
    }
  }
}

}  // namespace
}  // namespace facetsort
