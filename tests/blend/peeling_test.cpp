// Depth peeling on the blend target: exact where float32 depths differ, and what becomes of layers where they do not.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "facetsort/blend/fragment_lists.h"
#include "blend/pictures.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

constexpr Strategy both[] = {{.kind = StrategyKind::depth_peeling}, {.kind = StrategyKind::dual_depth_peeling}};

std::size_t most_layers(const FragmentLists& lists) {
  std::size_t most = 0;
  for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
    most = std::max(most, lists.pixel(pixel).size());
  }
  return most;
}

// A pixel whose layers are all farther apart than float32 depth can mistake.
bool can_be_told_apart(std::span<const Fragment> fragments, double gap) {
  for (std::size_t i = 1; i < fragments.size(); ++i) {
    if (fragments[i - 1].depth - fragments[i].depth <= gap) return false;
  }
  return true;
}

void expect_reference_picture(const Mesh& mesh, const View& view, PixelFormat format, float tolerance) {
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  Image reference;
  blend_lists(mesh.view(), view, lists, format, reference);
  // -1 / W in float32 at 3.5 radii; the depth of a facet seen nearly edge-on is its line's, which strays further.
  const double gap = 4e-6 * static_cast<double>(facet_bounds(mesh.view()).radius());
  for (const Strategy& strategy : both) {
    SCOPED_TRACE(strategy.name());
    StrategyRenderer renderer(mesh.view(), strategy);
    renderer.order(view);
    Image image, coverage;
    const DrawStatistics statistics = renderer.draw(view, format, image);
    renderer.draw_coverage(view, coverage);
    std::size_t compared = 0, told_apart = 0, covered = 0;
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      const auto fragments = lists.pixel(pixel);
      covered += !fragments.empty();
      if (!can_be_told_apart(fragments, gap)) continue;
      told_apart += !fragments.empty();
      ++compared;
      ASSERT_EQ(coverage.pixels[pixel].r, static_cast<float>(fragments.size())) << pixel;
      for (int k = 0; k < 4; ++k) {
        ASSERT_NEAR(image.pixels[pixel][k], reference.pixels[pixel][k], tolerance) << pixel;
      }
    }
    EXPECT_GT(compared, image.pixels.size() / 2);
    EXPECT_GT(told_apart, covered * 9 / 10);
    EXPECT_EQ(statistics.passes, renderer.passes());
    const auto layers = static_cast<int>(most_layers(lists));
    const int passes = strategy.kind == StrategyKind::depth_peeling ? layers + 1 : (layers + 1) / 2 + 1;
    EXPECT_LE(renderer.passes(), passes);
    EXPECT_GE(renderer.passes(), passes - 2);  // the deepest pixel may have layers at one depth
  }
}

TEST(DepthPeeling, IsTheReferencePictureOfRealMeshes) {
  for (const char* name : {"teapot_1k", "hand_2k", "cocktailglass_8k", "spiralstair_15k"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = load(name);
    expect_reference_picture(mesh, view_of(mesh, Projection::perspective), PixelFormat::rgba32f, 1e-5f);
    expect_reference_picture(mesh, view_of(mesh, Projection::orthographic), PixelFormat::rgba32f, 1e-5f);
  }
}

TEST(DepthPeeling, IsTheReferencePictureOfCyclesAndInterpenetration) {
  for (const Mesh& mesh : {shapes::triangle_cycle(5), shapes::interpenetrating(2), shapes::soup(200, 3)}) {
    expect_reference_picture(mesh, view_of(mesh, Projection::perspective), PixelFormat::rgba32f, 1e-5f);
  }
}

TEST(DepthPeeling, InterpolatesVertexColours) {
  Mesh mesh = shapes::torus_knot(2000);
  for (const glm::vec3& position : mesh.positions) {
    mesh.vertex_colours.emplace_back(0.5f + 0.5f * glm::sin(position * 5.0f), 0.4f);
  }
  expect_reference_picture(mesh, view_of(mesh, Projection::perspective), PixelFormat::rgba32f, 1e-5f);
}

TEST(DepthPeeling, AroundAnEyeInside) {
  const Mesh mesh = shapes::soup(120, 8);
  const Box box = facet_bounds(mesh.view());
  View view = default_view(box, box.centre());
  view.vertical_fov_degrees = 110;
  view.width = view.height = 120;
  expect_reference_picture(mesh, view, PixelFormat::rgba32f, 1e-5f);
}

// Round layers and blends to 8 bits in another sequence: a few steps' difference, not more than a half a blend.
TEST(DepthPeeling, EightBitsRoundLayersAndBlends) {
  const Mesh mesh = shapes::torus_knot(3000);
  const View view = view_of(mesh, Projection::perspective);
  for (const Strategy& strategy : both) {
    StrategyRenderer renderer(mesh.view(), strategy);
    Image image;
    renderer.draw(view, PixelFormat::rgba8, image);
    for (const glm::vec4& pixel : image.pixels) {
      for (int k = 0; k < 4; ++k) ASSERT_NEAR(pixel[k] * 255.0f, std::nearbyint(pixel[k] * 255.0f), 1e-4);
    }
  }
  expect_reference_picture(mesh, view, PixelFormat::rgba8, 5.0f / 255.0f);
}

// Triangles that cover the whole of a small picture, seen from +z.
Mesh sheets(std::initializer_list<float> heights) {
  Mesh mesh;
  for (const float z : heights) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(-500, -500), glm::vec2(1500, -500), glm::vec2(-500, 1500)}) {
      mesh.positions.emplace_back(corner, z);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

struct Peeled {
  Image image;
  DrawStatistics statistics;
};

Peeled peel(const Mesh& mesh, Peeling peeling, const std::vector<glm::vec4>& colours,
            const std::vector<std::uint32_t>& order) {
  View view;
  view.eye = {0, 0, 10};
  view.width = 5;
  view.height = 3;
  Peeled peeled;
  peeled.statistics = Rasteriser().peel(mesh.view(), view, order, colours, peeling, background, PixelFormat::rgba32f,
                                        peeled.image);
  return peeled;
}

std::vector<std::uint32_t> index_order(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

TEST(DepthPeeling, CountsItsPasses) {
  const std::vector<glm::vec4> colours(6, glm::vec4(0.25f, 0.25f, 0.25f, 0.5f));
  const struct {
    Mesh mesh;
    int front_to_back, from_both_ends;
  } cases[] = {{sheets({}), 1, 1},
               {sheets({0}), 2, 2},
               {sheets({0, 1}), 3, 2},
               {sheets({0, 1, 2}), 4, 3},
               {sheets({0, 1, 2, 3}), 5, 3},
               {sheets({5, 4, 3, 2, 1, 0}), 7, 4}};
  for (const auto& expected : cases) {
    const std::size_t facets = expected.mesh.triangles.size();
    SCOPED_TRACE(facets);
    const std::vector<glm::vec4> some(colours.begin(), colours.begin() + static_cast<std::ptrdiff_t>(facets));
    for (const Peeling peeling : {Peeling::front_to_back, Peeling::from_both_ends}) {
      Mesh mesh = expected.mesh;
      if (mesh.triangles.empty()) mesh.vertex_colours = {glm::vec4(1)};  // colours must be there
      const DrawStatistics statistics = peel(mesh, peeling, some, index_order(mesh)).statistics;
      const int passes = peeling == Peeling::front_to_back ? expected.front_to_back : expected.from_both_ends;
      EXPECT_EQ(statistics.passes, passes);
      EXPECT_EQ(statistics.facets_drawn, facets * static_cast<std::size_t>(passes));
    }
  }
}

// Three sheets, two of them at one depth: the classic strict comparison keeps one of these.
TEST(DepthPeeling, KeepsOneOfTheLayersAtOneDepth) {
  const Mesh mesh = sheets({1, 0, 1});
  const std::vector<glm::vec4> colours{{0.5f, 0, 0, 0.5f}, {0, 0.5f, 0, 0.5f}, {0, 0, 0.5f, 0.25f}};
  const glm::vec4 green_over_black(0, 0.5f, 0, 1);
  const auto over_green = [&](const glm::vec4& layer) { return layer + green_over_black * (1.0f - layer.a); };
  for (const glm::vec4& pixel : peel(mesh, Peeling::front_to_back, colours, {0, 1, 2}).image.pixels) {
    EXPECT_EQ(pixel, over_green(colours[0]));
  }
  for (const glm::vec4& pixel : peel(mesh, Peeling::front_to_back, colours, {2, 1, 0}).image.pixels) {
    EXPECT_EQ(pixel, over_green(colours[2]));
  }
  // MAX blending keeps the larger value of each channel, whatever the order.
  const glm::vec4 larger(0.5f, 0, 0.5f, 0.5f);
  for (const auto& order : {std::vector<std::uint32_t>{0, 1, 2}, {2, 1, 0}}) {
    const Peeled peeled = peel(mesh, Peeling::from_both_ends, colours, order);
    EXPECT_EQ(peeled.statistics.passes, 2);
    for (const glm::vec4& pixel : peeled.image.pixels) EXPECT_EQ(pixel, over_green(larger));
  }
  // The same at the far end.
  const Mesh far_pair = sheets({0, 1, 0});
  for (const glm::vec4& pixel : peel(far_pair, Peeling::from_both_ends, colours, {0, 1, 2}).image.pixels) {
    EXPECT_EQ(pixel, colours[1] + (larger + background * (1.0f - larger.a)) * (1.0f - colours[1].a));
  }
}

TEST(DepthPeeling, TellsLayersOneFloatStepApart) {
  // At a distance of 1: depths next to each other in float32.
  const Mesh mesh = sheets({9, std::nextafter(9.0f, 10.0f)});
  const std::vector<glm::vec4> colours{{0.5f, 0, 0, 0.5f}, {0, 0.5f, 0, 0.5f}};
  for (const Peeling peeling : {Peeling::front_to_back, Peeling::from_both_ends}) {
    for (const glm::vec4& pixel : peel(mesh, peeling, colours, {0, 1}).image.pixels) {
      EXPECT_EQ(pixel, glm::vec4(0.25f, 0.5f, 0, 1));
    }
  }
}

// Four sheets of alpha 1/2, nearest red, then green, blue and white, and at most so many passes.
TEST(DepthPeeling, LosesWhatIsLeftAfterTheLastPass) {
  const Mesh mesh = sheets({3, 2, 1, 0});
  const std::vector<glm::vec4> colours{{0.5f, 0, 0, 0.5f}, {0, 0.5f, 0, 0.5f}, {0, 0, 0.5f, 0.5f}, glm::vec4(0.5f)};
  const float white = 0.0625f;  // of the fourth of all layers
  const glm::vec4 all(0.5f + white, 0.25f + white, 0.125f + white, 1);
  const struct {
    Peeling peeling;
    int most_passes, passes;  // that peel; that are drawn
    glm::vec4 expected;
  } cases[] = {{Peeling::front_to_back, 1, 1, {0.5f, 0, 0, 1}},
               {Peeling::front_to_back, 2, 2, {0.5f, 0.25f, 0, 1}},
               {Peeling::front_to_back, 3, 3, {0.5f, 0.25f, 0.125f, 1}},
               {Peeling::front_to_back, 4, 4, all},
               {Peeling::front_to_back, 9, 5, all},
               // The nearest over the farthest: the two between are lost.
               {Peeling::from_both_ends, 1, 2, {0.75f, 0.25f, 0.25f, 1}},
               {Peeling::from_both_ends, 2, 3, all},
               {Peeling::from_both_ends, 9, 3, all}};
  for (const auto& [peeling, most_passes, passes, expected] : cases) {
    SCOPED_TRACE(testing::Message() << most_passes << " passes, " << (peeling == Peeling::front_to_back));
    View view;
    view.eye = {0, 0, 10};
    view.width = 5;
    view.height = 3;
    Image image;
    const DrawStatistics statistics =
        Rasteriser().peel(mesh.view(), view, index_order(mesh), colours, peeling, background, PixelFormat::rgba32f,
                          image, {}, most_passes);
    EXPECT_EQ(statistics.passes, passes);
    EXPECT_EQ(statistics.facets_drawn, 4 * static_cast<std::size_t>(passes));
    for (const glm::vec4& pixel : image.pixels) EXPECT_EQ(pixel, expected);
  }
}

// Babylon.js draws ten layers in five passes.
TEST(DepthPeeling, ALimitBeyondTheLayersChangesNothing) {
  const Mesh mesh = load("cocktailglass_8k");
  const View view = view_of(mesh, Projection::perspective);
  ASSERT_LE(most_layers(collect_fragments(mesh.view(), view)), 10u);
  const auto picture = [&](const char* name) {
    StrategyRenderer renderer(mesh.view(), strategy_from_name(name).value());
    Image image;
    renderer.draw(view, PixelFormat::rgba32f, image);
    return image.pixels;
  };
  EXPECT_EQ(picture("depth_peeling:10"), picture("depth_peeling"));
  EXPECT_EQ(picture("dual_depth_peeling:5"), picture("dual_depth_peeling"));
  EXPECT_NE(picture("depth_peeling:2"), picture("depth_peeling"));
  EXPECT_NE(picture("dual_depth_peeling:1"), picture("dual_depth_peeling"));
}

}  // namespace
}  // namespace facetsort
