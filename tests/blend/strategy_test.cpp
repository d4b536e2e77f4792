#include "facetsort/blend/strategy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <utility>

#include "blend/pictures.h"
#include "facetsort/blend/shading.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

Image picture(const Mesh& mesh, const View& view, const Strategy& strategy) {
  StrategyRenderer renderer(mesh.view(), strategy);
  renderer.order(view);
  Image image;
  renderer.draw(view, PixelFormat::rgba32f, image);
  return image;
}

std::size_t wrong_pixels(const Mesh& mesh, const View& view, StrategyKind kind) {
  const Image reference = picture(mesh, view, {.kind = StrategyKind::reference});
  const std::vector<unsigned char> all(reference.pixels.size(), 1);
  return compare_images(picture(mesh, view, {.kind = kind}), reference, all).wrong_pixels;
}

TEST(Strategy, NamesAreDistinctAndKnown) {
  std::set<std::string> names;
  for (const Strategy& strategy : all_strategies()) {
    EXPECT_TRUE(names.insert(strategy.name()).second);
    EXPECT_EQ(strategy_from_name(strategy.name()), strategy);
  }
  EXPECT_EQ(names.size(), 18u);
  EXPECT_EQ(strategy_from_name("facet_sort:parametric_centre"), strategy_from_name("facet_sort:centroid_depth"));
  EXPECT_EQ(strategy_from_name("facet_sort"), strategy_from_name("facet_sort:centroid_distance"));
  EXPECT_EQ(strategy_from_name("presorted_buffers:12"),
            (Strategy{.kind = StrategyKind::presorted_buffers, .number = 12}));
  for (const char* name : {"additive", "premultiplied_over", "presorted_buffers:12", "depth_peeling:1",
                           "depth_peeling:1000", "dual_depth_peeling:5", "moment_based:4", "moment_based:6",
                           "multi_layer:1", "multi_layer:64", "stochastic:1", "stochastic:64"}) {
    const std::optional<Strategy> strategy = strategy_from_name(name);
    ASSERT_TRUE(strategy) << name;
    EXPECT_EQ(strategy->name(), name);
    EXPECT_TRUE(names.insert(name).second);
  }
  EXPECT_EQ(numbered_strategy_names(),
            (std::vector<std::string>{"additive", "premultiplied_over", "facet_sort:METHOD:quantised",
                                      "draw_order:galacean|babylon|three|panda3d", "presorted_buffers:1..1000",
                                      "depth_peeling:1..1000", "dual_depth_peeling:1..1000", "moment_based:4|6",
                                      "multi_layer:1..64", "stochastic:1..64", "auto", "auto:0..1"}));
  for (const char* unknown : {"presorted_buffers",
                              "presorted_buffers:",
                              "presorted_buffers:0",
                              "presorted_buffers:1x",
                              "presorted_buffers:-1",
                              "presorted_buffers:1001",
                              "depth_peeling:",
                              "depth_peeling:0",
                              "depth_peeling:-1",
                              "depth_peeling:1001",
                              "dual_depth_peeling:+5",
                              "weighted_blended:1",
                              "moment_based",
                              "moment_based:5",
                              "moment_based:8",
                              "moment_based:44",
                              "multi_layer",
                              "multi_layer:0",
                              "multi_layer:65",
                              "stochastic",
                              "stochastic:x",
                              "stochastic:0",
                              "stochastic:65",
                              "stochastic: 8",
                              "additive:2",
                              "premultiplied_over:1",
                              "reference:1",
                              "",
                              "sorted",
                              "facet_sort:",
                              "facet_sort:nothing",
                              "unsorted:centroid_depth",
                              "unsorted:"}) {
    EXPECT_FALSE(strategy_from_name(unknown).has_value()) << unknown;
  }
}

TEST(Strategy, PresortedBuffersDrawTheOneForTheDirectionOfTheEye) {
  const Mesh mesh = shapes::box();
  IndexBuffers buffers;
  buffers.buffer_count = 2;
  buffers.directions = {{0, 0, 1}, {0, 0, -1}};
  buffers.buffer_of_direction = {1, 0};
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  buffers.facets = order;
  buffers.facets.insert(buffers.facets.end(), order.rbegin(), order.rend());
  StrategyRenderer renderer(mesh.view(), {.kind = StrategyKind::presorted_buffers, .number = 2}, {.buffers = &buffers});
  for (const bool front : {true, false}) {
    View view = view_of(mesh);
    const glm::vec3 centre = facet_bounds(mesh.view()).centre();
    view.at = centre;
    view.eye = centre + glm::vec3(0.1f, 0.2f, front ? 5.0f : -5.0f);
    renderer.order(view);
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    std::vector<std::uint32_t> expected = order;
    if (front) std::reverse(expected.begin(), expected.end());
    EXPECT_EQ(renderer.ranks(view, lists), fragment_ranks(mesh.view(), view, lists, expected));
  }
}

TEST(Strategy, CullingPassesAreExactOnAConvexMeshAndDoubleSidedIsTheReverse) {
  const Mesh sphere = shapes::icosphere(3);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const View view = view_of(sphere, projection);
    EXPECT_EQ(wrong_pixels(sphere, view, StrategyKind::separate_culling_pass), 0u);
    EXPECT_EQ(wrong_pixels(sphere, view, StrategyKind::facet_sort), 0u);
    EXPECT_GT(wrong_pixels(sphere, view, StrategyKind::double_sided), 3000u);
  }
}

TEST(Strategy, RanksAreTheSequenceInWhichFragmentsAreDrawn) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_of(mesh);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  for (const Strategy& strategy : all_strategies()) {
    if (!strategy.draws_in_order()) continue;
    SCOPED_TRACE(strategy.name());
    StrategyRenderer renderer(mesh.view(), strategy);
    renderer.order(view);
    const std::vector<std::uint32_t> ranks = renderer.ranks(view, lists);
    ASSERT_EQ(ranks.size(), lists.fragments.size());
    EXPECT_EQ(std::count(ranks.begin(), ranks.end(), not_drawn), 0);

    Image image;
    renderer.draw(view, PixelFormat::rgba32f, image);
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      std::vector<std::pair<std::uint32_t, std::uint32_t>> drawn;  // rank and facet
      for (std::size_t i = lists.offsets[pixel]; i < lists.offsets[pixel + 1]; ++i) {
        drawn.emplace_back(ranks[i], lists.fragments[i].facet);
      }
      std::sort(drawn.begin(), drawn.end());
      glm::vec4 blended = background;
      for (const auto& [rank, facet] : drawn) blended = colours[facet] + blended * (1.0f - colours[facet].a);
      ASSERT_EQ(image.pixels[pixel], blended);
    }
  }
}

TEST(Strategy, DepthPrepassShowsTheNearestSurfaceAlone) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_of(mesh);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const Image image = picture(mesh, view, {.kind = StrategyKind::depth_prepass});
  const double float_step = 1e-6 * static_cast<double>(facet_bounds(mesh.view()).radius());
  std::size_t compared = 0;
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    const auto fragments = lists.pixel(pixel);
    // Two layers nearer to each other than float32 depth can tell: either may be in front.
    if (fragments.size() > 1 && fragments[fragments.size() - 2].depth - fragments.back().depth < float_step) continue;
    glm::vec4 expected = background;
    if (!fragments.empty()) {
      const glm::vec4& source = colours[fragments.back().facet];
      expected = source + background * (1.0f - source.a);
      ++compared;
    }
    ASSERT_EQ(image.pixels[pixel], expected);
  }
  EXPECT_GT(compared, 2000u);
}

TEST(Strategy, DepthWriteKeepsWhatIsNotBehindWhatWasDrawn) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_of(mesh, Projection::orthographic);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const Image image = picture(mesh, view, {.kind = StrategyKind::depth_write});
  std::size_t differing = 0;
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    std::vector<Fragment> fragments(lists.pixel(pixel).begin(), lists.pixel(pixel).end());
    std::sort(fragments.begin(), fragments.end(),
              [](const Fragment& a, const Fragment& b) { return a.facet < b.facet; });
    glm::vec4 blended = background;
    float nearest = INFINITY;
    for (const Fragment& fragment : fragments) {
      if (static_cast<float>(fragment.depth) > nearest) continue;
      nearest = static_cast<float>(fragment.depth);
      const glm::vec4& source = colours[fragment.facet];
      blended = source + blended * (1.0f - source.a);
    }
    differing += image.pixels[pixel] != blended;
  }
  EXPECT_LE(differing, 3u) << "depths that differ in the last bit of a float32";
}

TEST(Strategy, CoverageIsCountedByTheSamePasses) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_of(mesh);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  for (const Strategy& strategy : all_strategies()) {
    SCOPED_TRACE(strategy.name());
    StrategyRenderer renderer(mesh.view(), strategy);
    renderer.order(view);
    Image coverage;
    renderer.draw_coverage(view, coverage);
    std::size_t fewer = 0;
    for (std::size_t pixel = 0; pixel < coverage.pixels.size(); ++pixel) {
      const auto layers = static_cast<float>(lists.pixel(pixel).size());
      ASSERT_LE(coverage.pixels[pixel].r, layers);
      fewer += coverage.pixels[pixel].r < layers;
    }
    // Depth peeling loses layers at one float32 depth: the teapot's spout and handle pass through its wall.
    const bool peels =
        strategy.kind == StrategyKind::depth_peeling || strategy.kind == StrategyKind::dual_depth_peeling;
    if (peels) {
      EXPECT_LE(fewer, 5u);
    } else {
      EXPECT_EQ(fewer > 0, strategy.discards_fragments());
    }
  }
}

TEST(Strategy, ReferenceBlendsEveryFragmentByItsOwnDepth) {
  const Mesh mesh = shapes::interpenetrating(2);
  const View view = view_of(mesh);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const Image image = picture(mesh, view, {.kind = StrategyKind::reference});
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    glm::vec4 blended = background;
    for (const Fragment& fragment : lists.pixel(pixel)) {
      blended = colours[fragment.facet] + blended * (1.0f - colours[fragment.facet].a);
    }
    ASSERT_EQ(image.pixels[pixel], blended);
  }
  EXPECT_GT(wrong_pixels(mesh, view, StrategyKind::unsorted), 1000u);
}

TEST(Strategy, OrdersAreKeptWhereTheyHold) {
  const Mesh knot = shapes::torus_knot(500);
  StrategyRenderer presorted(knot.view(), *strategy_from_name("facet_sort:presorted"));
  const View view = view_of(knot);
  View near = view, turned = view, far = view;
  near.eye.x += 1e-5f;
  turned.at.x += 1;
  far.eye *= -1;
  EXPECT_FALSE(presorted.keeps_order(view));
  presorted.order(view);
  EXPECT_TRUE(presorted.keeps_order(near));
  EXPECT_TRUE(presorted.keeps_order(turned));
  EXPECT_FALSE(presorted.keeps_order(far));
  StrategyRenderer by_depth(knot.view(), *strategy_from_name("facet_sort:centroid_depth"));
  by_depth.order(view);
  EXPECT_TRUE(by_depth.keeps_order(view));
  EXPECT_FALSE(by_depth.keeps_order(near));
  EXPECT_FALSE(by_depth.keeps_order(turned));
}

}  // namespace
}  // namespace facetsort
