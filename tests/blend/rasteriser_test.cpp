#include "facetsort/blend/rasteriser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "blend/pictures.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/report/allocations.h"
#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

// A right triangle that covers the whole of a small picture, at height z, looked at from +z.
Mesh covering_triangles(std::initializer_list<float> heights) {
  Mesh mesh;
  for (const float z : heights) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(-5000, -5000), glm::vec2(15000, -5000), glm::vec2(-5000, 15000)}) {
      mesh.positions.emplace_back(corner, z);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

View small_view(int width = 5, int height = 3) {
  View view;
  view.eye = {0, 0, 10};
  view.width = width;
  view.height = height;
  return view;
}

constexpr DrawPass plain[] = {{}};
const glm::vec4 half_red(0.5f, 0, 0, 0.5f), half_green(0, 0.5f, 0, 0.5f);

Image draw(const Mesh& mesh, const View& view, std::vector<std::uint32_t> order, std::vector<glm::vec4> colours,
           std::span<const DrawPass> passes = plain, PixelFormat format = PixelFormat::rgba32f) {
  Image image;
  Rasteriser().draw(mesh.view(), view, order, colours, passes, background, format, image);
  return image;
}

TEST(Rasteriser, BlendsInTheOrderGiven) {
  const Mesh mesh = covering_triangles({0, 1});
  const std::vector<glm::vec4> colours{half_red, half_green};
  for (const glm::vec4& pixel : draw(mesh, small_view(), {0, 1}, colours).pixels) {
    EXPECT_EQ(pixel, glm::vec4(0.25f, 0.5f, 0, 1));
  }
  for (const glm::vec4& pixel : draw(mesh, small_view(), {1, 0}, colours).pixels) {
    EXPECT_EQ(pixel, glm::vec4(0.5f, 0.25f, 0, 1));
  }
}

TEST(Rasteriser, DrawsSubsetsRepeatsAndNothing) {
  const Mesh mesh = covering_triangles({0, 1});
  const std::vector<glm::vec4> colours{half_red, half_green};
  EXPECT_EQ(draw(mesh, small_view(), {1}, colours).pixels[7], glm::vec4(0, 0.5f, 0, 1));
  EXPECT_EQ(draw(mesh, small_view(), {1, 1}, colours).pixels[7], glm::vec4(0, 0.75f, 0, 1));
  EXPECT_EQ(draw(mesh, small_view(), {}, colours).pixels[7], background);
}

TEST(Rasteriser, EightBitsRoundAfterEveryBlend) {
  const Mesh mesh = covering_triangles({0, 1, 2});
  const std::vector<glm::vec4> colours(3, glm::vec4(0.3f, 0.2f, 0.1f, 0.3f));
  float red = 0;  // in steps
  for (int layer = 0; layer < 3; ++layer) red = std::nearbyint(0.3f * 255.0f + red * (1.0f - 0.3f));
  const Image image = draw(mesh, small_view(), {0, 1, 2}, colours, plain, PixelFormat::rgba8);
  for (const glm::vec4& pixel : image.pixels) {
    EXPECT_FLOAT_EQ(pixel.r * 255.0f, red);
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(pixel[k] * 255.0f, std::nearbyint(pixel[k] * 255.0f), 1e-4);
  }
}

TEST(Rasteriser, CullsByWhatTheEyeSees) {
  Mesh mesh = covering_triangles({0});
  const std::vector<glm::vec4> colours{half_red};
  const DrawPass no_backs[] = {{.cull = Cull::back_faces}}, no_fronts[] = {{.cull = Cull::front_faces}};
  const glm::vec4 drawn(0.5f, 0, 0, 1);
  EXPECT_EQ(draw(mesh, small_view(), {0}, colours, no_backs).pixels[0], drawn);
  EXPECT_EQ(draw(mesh, small_view(), {0}, colours, no_fronts).pixels[0], background);
  std::swap(mesh.triangles[0].x, mesh.triangles[0].y);
  EXPECT_EQ(draw(mesh, small_view(), {0}, colours, no_backs).pixels[0], background);
  EXPECT_EQ(draw(mesh, small_view(), {0}, colours, no_fronts).pixels[0], drawn);
}

TEST(Rasteriser, DepthTestAndWriteKeepTheNearest) {
  const Mesh mesh = covering_triangles({0, 1});
  const std::vector<glm::vec4> colours{half_red, half_green};
  const DrawPass depth[] = {{.depth_test = DepthTest::less, .depth_write = true}};
  EXPECT_EQ(draw(mesh, small_view(), {0, 1}, colours, depth).pixels[0], glm::vec4(0.25f, 0.5f, 0, 1));
  EXPECT_EQ(draw(mesh, small_view(), {1, 0}, colours, depth).pixels[0], glm::vec4(0, 0.5f, 0, 1));
  // Tested but not written: the clear depth lets all pass.
  const DrawPass tested[] = {{.depth_test = DepthTest::less}};
  EXPECT_EQ(draw(mesh, small_view(), {1, 0}, colours, tested).pixels[0], glm::vec4(0.5f, 0.25f, 0, 1));
}

TEST(Rasteriser, PassesWithoutColourLeaveThePictureAlone) {
  const Mesh mesh = covering_triangles({0, 1});
  const std::vector<glm::vec4> colours{half_red, half_green};
  const DrawPass no_colour[] = {{.colour_write = false}};
  EXPECT_EQ(draw(mesh, small_view(), {0, 1}, colours, no_colour).pixels[0], background);
  const DrawPass depth_alone[] = {{.depth_write = true, .colour_write = false},
                                  {.depth_test = DepthTest::less_or_equal}};
  EXPECT_EQ(draw(mesh, small_view(), {0, 1}, colours, depth_alone).pixels[0], glm::vec4(0, 0.5f, 0, 1));
}

TEST(Rasteriser, CountsTheFacetsItDraws) {
  Mesh mesh = covering_triangles({0, 1});
  std::swap(mesh.triangles[1].x, mesh.triangles[1].y);  // a back face
  for (const glm::vec2& corner : {glm::vec2(500, 500), glm::vec2(501, 500), glm::vec2(500, 501)}) {
    mesh.positions.emplace_back(corner, 0);
  }
  mesh.triangles.emplace_back(6, 7, 8);  // outside the picture
  const std::vector<std::uint32_t> order{0, 1, 2};
  const std::vector<glm::vec4> colours(3, half_red);
  Image image;
  const DrawPass passes[] = {{.cull = Cull::front_faces}, {.cull = Cull::back_faces}, {}};
  const auto count = [&](std::span<const DrawPass> some) {
    return Rasteriser().draw(mesh.view(), small_view(), order, colours, some, background, PixelFormat::rgba32f, image);
  };
  EXPECT_EQ(count(plain).facets_drawn, 2u);
  EXPECT_EQ(count(passes).facets_drawn, 4u);
}

TEST(Rasteriser, PicturesOfAnySize) {
  const Mesh mesh = covering_triangles({0});
  for (const auto& [width, height] : {std::pair{1, 1}, {31, 33}, {32, 32}, {65, 1}, {1, 70}}) {
    const Image image = draw(mesh, small_view(width, height), {0}, {half_red});
    ASSERT_EQ(image.pixels.size(), static_cast<std::size_t>(width * height));
    for (const glm::vec4& pixel : image.pixels) ASSERT_EQ(pixel, glm::vec4(0.5f, 0, 0, 1));
  }
}

// The order drawn, blended by hand from the per-pixel lists, must be the very picture.
TEST(Rasteriser, DrawsWhatTheListsSayInAnyOrder) {
  const Mesh mesh = load("spiralstair_15k");
  const Box box = facet_bounds(mesh.view());
  View view = default_view(box, box.centre() + box.radius() * glm::vec3(1.2f, 0.5f, 0.9f));
  view.width = 150;
  view.height = 130;
  std::vector<std::uint32_t> order(mesh.triangles.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = (i * 7919u) % static_cast<std::uint32_t>(order.size());
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const Image image = draw(mesh, view, order, colours);

  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t k = 0; k < order.size(); ++k) rank[order[k]] = k;
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    std::vector<std::uint32_t> ranks;
    for (const Fragment& fragment : lists.pixel(pixel)) ranks.push_back(rank[fragment.facet]);
    std::sort(ranks.begin(), ranks.end());
    glm::vec4 blended = background;
    for (const std::uint32_t k : ranks) {
      const glm::vec4& source = colours[order[k]];
      blended = source + blended * (1.0f - source.a);
    }
    ASSERT_EQ(image.pixels[pixel], blended) << "pixel " << pixel;
  }
}

// A wavy sheet over [-1, 1]^2: seen from above, one layer.
Mesh sheet(std::uint32_t side) {
  Mesh mesh;
  for (std::uint32_t y = 0; y <= side; ++y) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      const glm::vec2 p = 2.0f * glm::vec2(x, y) / static_cast<float>(side) - 1.0f;
      mesh.positions.emplace_back(p, 0.1f * std::sin(4 * p.x) * std::cos(3 * p.y));
    }
  }
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x;
      mesh.triangles.emplace_back(a, a + 1, a + side + 2);
      mesh.triangles.emplace_back(a, a + side + 2, a + side + 1);
    }
  }
  return mesh;
}

TEST(Rasteriser, VertexColoursAreInterpolatedInPerspective) {
  const Mesh mesh = with_vertex_colours(sheet(12));
  const Box box = facet_bounds(mesh.view());
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    View view = default_view(box, box.centre() + box.radius() * glm::vec3(0.2f, 0.5f, 1.1f), projection);
    view.width = view.height = 120;
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    const Camera camera(view);
    StrategyRenderer renderer(mesh.view(), {.kind = StrategyKind::unsorted});
    Image image;
    renderer.draw(view, PixelFormat::rgba32f, image);
    std::size_t compared = 0;
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      if (lists.pixel(pixel).size() != 1) continue;
      ++compared;
      const Ray ray = camera.pixel_ray(static_cast<int>(pixel) % 120, static_cast<int>(pixel) / 120);
      const glm::vec4 source =
          fragment_colour(mesh.view(), lists.pixel(pixel)[0].facet, ray, view.homogeneous_eye());
      for (int k = 0; k < 4; ++k) {
        ASSERT_NEAR(image.pixels[pixel][k], source[k] + background[k] * (1 - source.a), 1e-6);
      }
    }
    EXPECT_GT(compared, 3000u);
  }
}

// All that need no number, and the others with one.
std::vector<Strategy> strategies_of_every_kind() {
  std::vector<Strategy> strategies = all_strategies();
  for (const char* name : {"depth_peeling:2", "dual_depth_peeling:1", "moment_based:4", "moment_based:6",
                           "multi_layer:1", "multi_layer:3", "multi_layer:64", "stochastic:1", "stochastic:7",
                           "stochastic:40"}) {
    strategies.push_back(strategy_from_name(name).value());
  }
  return strategies;
}

std::vector<Image> pictures_of_every_kind(const Mesh& mesh, const Mesh& coloured) {
  const Box box = facet_bounds(mesh.view());
  View view = default_view(box, box.centre() + box.radius() * glm::vec3(0.9f, 0.4f, 0.8f));
  view.width = 140;
  view.height = 110;
  std::vector<Image> images;
  for (const Mesh* drawn : {&mesh, &coloured}) {
    for (const Strategy& strategy : strategies_of_every_kind()) {
      for (const PixelFormat format : {PixelFormat::rgba32f, PixelFormat::rgba8}) {
        StrategyRenderer renderer(drawn->view(), strategy);
        renderer.order(view);
        renderer.draw(view, format, images.emplace_back());
      }
    }
  }
  return images;
}

void expect_same(const std::vector<Image>& found, const std::vector<Image>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) ASSERT_EQ(found[i].pixels, expected[i].pixels) << "picture " << i;
}

TEST(Rasteriser, SamePictureForAnyThreadCount) {
  const Mesh mesh = load("teapot_1k"), coloured = with_vertex_colours(mesh);
  const std::vector<Image> expected = pictures_of_every_kind(mesh, coloured);
  for (const int threads : {1, 2, 3, 8}) {
    with_threads(threads, [&] { expect_same(pictures_of_every_kind(mesh, coloured), expected); });
  }
}

TEST(Rasteriser, SamePictureForAnyInstructionSet) {
  const Mesh mesh = load("teapot_1k"), coloured = with_vertex_colours(mesh);
  const std::vector<Image> expected = pictures_of_every_kind(mesh, coloured);
  for_each_instruction_set([&] { expect_same(pictures_of_every_kind(mesh, coloured), expected); });
}

TEST(Rasteriser, DrawingAgainAllocatesNothing) {
  const Mesh mesh = load("teapot_1k");
  const Box box = facet_bounds(mesh.view());
  const View view = default_view(box, box.centre() + box.radius() * glm::vec3(0.9f, 0.4f, 2.0f));
  for (const char* name : {"facet_sort", "additive", "weighted_blended", "moment_based:4", "multi_layer:4",
                           "stochastic:8", "depth_peeling:3"}) {
    SCOPED_TRACE(name);
    StrategyRenderer renderer(mesh.view(), strategy_from_name(name).value());
    Image image;
    with_threads(1, [&] {
      renderer.order(view);
      renderer.draw(view, PixelFormat::rgba32f, image);
      const AllocationScope scope;
      renderer.order(view);
      renderer.draw(view, PixelFormat::rgba32f, image);
      EXPECT_EQ(scope.count().calls, 0u);
    });
  }
}

}  // namespace
}  // namespace facetsort
