// Two independent ways to a picture's fragments, Embree's rays and the rasteriser's edge functions, on real meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "facetsort/blend/strategy.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/facets/facets.h"
#include "facetsort/mesh/read.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

// The same facets, each at the same depth within the two error bounds.
bool agree(std::span<const Fragment> a, std::span<const Fragment> b) {
  if (a.size() != b.size()) return false;
  const auto by_facet = [](std::span<const Fragment> list) {
    std::vector<Fragment> sorted(list.begin(), list.end());
    std::sort(sorted.begin(), sorted.end(), [](const Fragment& x, const Fragment& y) { return x.facet < y.facet; });
    return sorted;
  };
  const std::vector<Fragment> sorted_a = by_facet(a), sorted_b = by_facet(b);
  return std::equal(sorted_a.begin(), sorted_a.end(), sorted_b.begin(), [](const Fragment& x, const Fragment& y) {
    const double errors = static_cast<double>(x.depth_error) + static_cast<double>(y.depth_error);
    return x.facet == y.facet && std::abs(x.depth - y.depth) <= errors;
  });
}

// Whether some depths are too close to say which is nearer: coincident facets have no right order.
bool has_tie(std::span<const Fragment> list) {
  for (std::size_t i = 1; i < list.size(); ++i) {
    const double errors = static_cast<double>(list[i - 1].depth_error) + static_cast<double>(list[i].depth_error);
    if (list[i - 1].depth - list[i].depth <= 2 * errors) return true;
  }
  return false;
}

void expect_agreement(const Mesh& mesh, const EmbreeReferee& referee, const View& view) {
  const Result<RayHits> cast = referee.cast(view);
  ASSERT_TRUE(cast.ok()) << cast.status().message;
  const RayHits& hits = cast.value();
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  EXPECT_GT(hits.rays, 1000u);
  EXPECT_LE(hits.unjudged_rays * 1000, hits.rays);  // 0.1 %

  std::vector<unsigned char> comparable(hits.judged.size());
  std::size_t different_rays = 0, comparable_pixels = 0;
  for (std::size_t p = 0; p < hits.judged.size(); ++p) {
    if (!hits.judged[p]) continue;
    different_rays += !agree(hits.lists.pixel(p), lists.pixel(p));
    comparable[p] = !lists.pixel(p).empty() && !has_tie(lists.pixel(p));
    comparable_pixels += comparable[p];
  }
  EXPECT_EQ(different_rays, 0u);
  EXPECT_GT(comparable_pixels * 2, hits.rays);

  Image by_rays, by_rasteriser;
  blend_lists(mesh.view(), view, hits.lists, PixelFormat::rgba32f, by_rays);
  blend_lists(mesh.view(), view, lists, PixelFormat::rgba32f, by_rasteriser);
  const ImageError error = compare_images(by_rays, by_rasteriser, comparable);
  EXPECT_EQ(error.wrong_pixels, 0u);
  EXPECT_EQ(error.max_error, 0);
}

TEST(Agreement, OfEmbreeAndTheRasteriserOnEveryMesh) {
  const std::vector<std::filesystem::path> files = mesh_files();
  ASSERT_FALSE(files.empty());
  for (const std::filesystem::path& file : files) {
    SCOPED_TRACE(file.string());
    const Result<Mesh> mesh = read_mesh(file);
    ASSERT_TRUE(mesh.ok()) << mesh.status().message;
    const Result<EmbreeReferee> referee = EmbreeReferee::create(mesh.value().view());
    ASSERT_TRUE(referee.ok()) << referee.status().message;
    const Box bounds = facet_bounds(mesh.value().view());
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      View view = views_around(bounds, 5, 2.5f, projection)[3];
      view.width = view.height = 256;
      expect_agreement(mesh.value(), referee.value(), view);
    }
  }
}

}  // namespace
}  // namespace facetsort
