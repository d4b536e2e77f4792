// Transparency without an order, on cases worked out by hand and on real meshes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "blend/pictures.h"
#include "blend/sheets.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

constexpr glm::vec4 opaque_white(1);

Image draw_passes(std::span<const Sheet> layers, const DrawPass& pass, const glm::vec4& clear_colour,
                  PixelFormat format = PixelFormat::rgba32f) {
  const Mesh mesh = mesh_of(layers);
  Image image;
  Rasteriser().draw(mesh.view(), sheets_view(), index_order(layers.size()), colours_of(layers), std::span(&pass, 1),
                    clear_colour, format, image);
  return image;
}

TEST(Additive, AddsPremultipliedColoursAndKeepsTheAlpha) {
  const Sheet layers[] = {{10, red, 0.5f}, {5, {0.5f, 1, 0}, 0.4f}, {7, blue, 0.9f}};
  // 0.1 + 0.5 + 0.4 x 0.5, 0.1 + 0.4, 0.1 + 0.9; the clear colour's alpha.
  expect_colour(draw_passes(layers, {.blend = BlendMode::additive}, {0.1f, 0.1f, 0.1f, 0.25f}), {0.8f, 0.5f, 1, 0.25f});
}

TEST(Additive, GoesBeyondOneInFloatAndNotInEightBits) {
  const Sheet layers[] = {{10, red, 0.8f}, {5, {1, 0.1f, 0}, 0.8f}};
  const DrawPass add{.blend = BlendMode::additive};
  expect_colour(draw_passes(layers, add, {0, 0, 0, 1}), {1.6f, 0.08f, 0, 1});
  // 0.08 x 255 = 20.4.
  expect_colour(draw_passes(layers, add, {0, 0, 0, 1}, PixelFormat::rgba8), {1, 20 / 255.0f, 0, 1}, 1e-6f);
}

// What an additive mesh looks like with vertex colours, which other code draws.
TEST(Additive, AddsVertexColoursToo) {
  const Sheet layers[] = {{10, red, 0.5f}, {5, green, 0.25f}};
  Mesh mesh = mesh_of(layers);
  for (const Sheet& sheet : layers) {
    mesh.vertex_colours.insert(mesh.vertex_colours.end(), 3, glm::vec4(sheet.straight, sheet.alpha));
  }
  const DrawPass add{.blend = BlendMode::additive};
  Image image;
  Rasteriser().draw(mesh.view(), sheets_view(1, 1), index_order(2), {}, std::span(&add, 1), {0, 0, 0, 1},
                    PixelFormat::rgba32f, image);
  // Lit by a headlight, from the facet's centroid: the light is shading_test's business.
  const float light[] = {headlight(mesh.view(), 0, {0, 0, 10, 1}), headlight(mesh.view(), 1, {0, 0, 10, 1})};
  expect_colour(image, {0.5f * light[0], 0.25f * light[1], 0, 1});
}

TEST(WeightedBlended, IsTheWeightedAverageByHand) {
  // The farthest counts as at 100, the nearer one as at 50. Equation (7) without alpha:
  //   10 / (1e-5 + 10^2 + 0.25^6) = 0.0999997     10 / (1e-5 + 20^2 + 0.5^6) = 0.0249990
  // Alphas are equal: red has 0.0999997 / 0.1249987 = 0.8000061 of the average, green 0.1999939; opacity 1 - 0.5^2.
  const Sheet layers[] = {{10, green, 0.5f}, {5, red, 0.5f}};
  const Image image = draw_sheets(layers, sheets_view(), OrderIndependent::weighted, 0, opaque_white);
  expect_colour(image, {0.75f * 0.8000061f + 0.25f, 0.75f * 0.1999939f + 0.25f, 0.25f, 1});
}

double equation_7(double z) {
  return std::clamp(10 / (1e-5 + std::pow(z / 5, 2) + std::pow(z / 200, 6)), 1e-2, 3e3);
}

TEST(WeightedBlended, OpaqueIshAndThinLayersOverAnyBackground) {
  const Sheet layers[] = {{9, green, 0.95f}, {0.2f, {1, 0.5f, 0.25f}, 0.02f}, {8, blue, 0.3f}, {3, red, 0.6f}};
  const glm::vec4 clear_colour(0.1f, 0.2f, 0.3f, 0.5f);
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    glm::dvec3 sum(0);
    double weights = 0, transparency = 1;
    for (const Sheet& sheet : layers) {
      const double z = projection == Projection::perspective
                           ? 100 * static_cast<double>(sheet.distance) / 9
                           : 50 + 50 * (static_cast<double>(sheet.distance) - 0.2) / (9 - 0.2);
      const double alpha = static_cast<double>(sheet.alpha), weight = alpha * alpha * equation_7(z);
      sum += weight * glm::dvec3(sheet.straight);
      weights += weight;
      transparency *= 1 - alpha;
    }
    const glm::dvec4 expected =
        glm::dvec4((1 - transparency) * sum / weights, 1 - transparency) + transparency * glm::dvec4(clear_colour);
    expect_colour(draw_sheets(layers, sheets_view(5, 3, projection), OrderIndependent::weighted, 0, clear_colour),
                  glm::vec4(expected));
  }
}

TEST(WeightedBlended, DoesNotDependOnTheUnitOfLength) {
  const Sheet layers[] = {{10, green, 0.5f}, {5, red, 0.25f}, {7, blue, 0.75f}};
  const Mesh mesh = mesh_of(layers);
  for (const float unit : {0x1p-40f, 0x1p50f}) {
    Mesh scaled = mesh;
    for (glm::vec3& position : scaled.positions) position *= unit;
    View view = sheets_view();
    view.eye *= unit;
    view.near_distance *= unit;
    Image image, expected = draw_sheets(layers, sheets_view(), OrderIndependent::weighted, 0);
    Rasteriser().draw_order_independent(scaled.view(), view, index_order(3), colours_of(layers),
                                        OrderIndependent::weighted, 0, {0, 0, 0, 1}, PixelFormat::rgba32f, image);
    expect_colour(image, expected.pixels[0]);
  }
}

TEST(MultiLayer, IsExactForAsManyLayersAsItKeeps) {
  const Sheet layers[] = {{8, green, 0.5f}, {4, red, 0.9f}, {6, blue, 0.1f}, {9, {1, 1, 1}, 0.25f}};
  // Red first, what is left is 0.1; blue takes 0.01 of that, 0.09 is left; green 0.045; white 0.045 / 4 and the rest,
  // 0.03375, is the clear colour's.
  const glm::vec4 expected(0.9f + 0.01125f, 0.045f + 0.01125f, 0.01f + 0.01125f, 1);
  for (const int kept : {4, 5, 64}) {
    expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::layers, kept), expected, 1e-6f);
  }
}

TEST(MultiLayer, MergesTheFarthestTwoOfMore) {
  // Two are kept. 8 and 4 are; 6 comes between them, and what is farthest then, 6 and 8, become one at 6: exact. At 9,
  // it is behind that: exact. Then 7 comes, behind the merged one's 6, though before 8 and 9: drawn behind them.
  const Sheet layers[] = {
      {8, green, 0.5f}, {4, red, 0.5f}, {6, blue, 0.5f}, {9, {1, 1, 1}, 0.5f}, {7, {1, 1, 0}, 0.5f}};
  const float white_part = 0.0625f, yellow_part = 0.03125f;
  expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::layers, 2),
                {0.5f + white_part + yellow_part, 0.125f + white_part + yellow_part, 0.25f + white_part, 1}, 1e-6f);
  // One is kept: nearest at 4 from then on, all else is drawn behind what came before.
  expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::layers, 1),
                {0.5f + white_part + yellow_part, 0.25f + white_part + yellow_part, 0.125f + white_part, 1}, 1e-6f);
}

TEST(MultiLayer, DrawsTheLaterOfTwoAtOneDepthInFront) {
  const Sheet layers[] = {{5, red, 0.5f}, {5, green, 0.5f}};
  for (const int kept : {1, 2}) {
    expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::layers, kept), {0.25f, 0.5f, 0, 1}, 1e-6f);
  }
}

TEST(OrderIndependent, OneLayerIsExact) {
  const Sheet layer[] = {{6, {0.25f, 0.5f, 1}, 0.3f}};
  const glm::vec4 clear_colour(0.5f, 0.25f, 0, 0.75f);
  const glm::vec4 expected = layer[0].premultiplied() + clear_colour * 0.7f;
  for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
    const View view = sheets_view(5, 3, projection);
    for (const auto& [method, count] : {std::pair(OrderIndependent::weighted, 0),
                                        {OrderIndependent::moments, 4},
                                        {OrderIndependent::moments, 6},
                                        {OrderIndependent::layers, 1},
                                        {OrderIndependent::stochastic, 1},
                                        {OrderIndependent::stochastic, 64}}) {
      SCOPED_TRACE(count);
      expect_colour(draw_sheets(layer, view, method, count, clear_colour), expected);
      // 255 times the above, rounded once.
      expect_colour(draw_sheets(layer, view, method, count, {0, 0, 0, 1}, PixelFormat::rgba8),
                    {19 / 255.0f, 38 / 255.0f, 76 / 255.0f, 1}, 1e-6f);
    }
  }
}

TEST(OrderIndependent, NothingAndInvisibleLayersLeaveTheClearColour) {
  const Sheet invisible[] = {{6, red, 0}, {7, green, 0}};
  const glm::vec4 clear_colour(0.5f, 0.25f, 0, 0.75f);
  for (const auto& [method, count] : {std::pair(OrderIndependent::weighted, 0),
                                      {OrderIndependent::moments, 4},
                                      {OrderIndependent::moments, 6},
                                      {OrderIndependent::layers, 1},
                                      {OrderIndependent::stochastic, 8}}) {
    expect_colour(draw_sheets(invisible, sheets_view(), method, count, clear_colour), clear_colour, 1e-6f);
    expect_colour(draw_sheets({}, sheets_view(), method, count, clear_colour), clear_colour, 0);
  }
}

TEST(OrderIndependent, AnOpaqueLayerHidesAllBehindIt) {
  const Sheet layers[] = {{8, green, 1}, {4, red, 1}, {9, blue, 0.5f}};
  expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::layers, 3), {1, 0, 0, 1}, 1e-6f);
  expect_colour(draw_sheets(layers, sheets_view(), OrderIndependent::stochastic, 4), {1, 0, 0, 1}, 1e-6f);
}

Image picture(const Mesh& mesh, const View& view, const char* name) {
  const std::optional<Strategy> strategy = strategy_from_name(name);
  if (!strategy) throw std::invalid_argument(name);
  StrategyRenderer renderer(mesh.view(), *strategy);
  renderer.order(view);
  Image image;
  renderer.draw(view, PixelFormat::rgba32f, image);
  return image;
}

// Pixels with two layers so near that float32 depth may take them for one are not compared.
double largest_difference(const Mesh& mesh, const View& view, const Image& a, const Image& b) {
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const double gap = 4e-6 * static_cast<double>(facet_bounds(mesh.view()).radius());
  double largest = 0;
  std::size_t left_out = 0;
  for (std::size_t pixel = 0; pixel < a.pixels.size(); ++pixel) {
    const auto fragments = lists.pixel(pixel);
    bool close = false;
    for (std::size_t i = 1; i < fragments.size(); ++i) close |= fragments[i - 1].depth - fragments[i].depth <= gap;
    left_out += close;
    if (close) continue;
    for (int k = 0; k < 4; ++k) {
      largest = std::max(largest, static_cast<double>(std::abs(a.pixels[pixel][k] - b.pixels[pixel][k])));
    }
  }
  EXPECT_LT(left_out, a.pixels.size() / 20);
  return largest;
}

TEST(MultiLayer, IsTheReferencePictureWithEnoughLayers) {
  for (const char* name : {"teapot_1k", "cocktailglass_8k", "spiralstair_15k"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = load(name);
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      const View view = view_of(mesh, projection);
      const Image reference = picture(mesh, view, "reference");
      EXPECT_LT(largest_difference(mesh, view, picture(mesh, view, "multi_layer:64"), reference), 1e-6);
      EXPECT_GT(largest_difference(mesh, view, picture(mesh, view, "multi_layer:1"), reference), 0.01);
    }
  }
}

double rmse(const Image& a, const Image& b) {
  return compare_images(a, b, std::vector<unsigned char>(a.pixels.size(), 1)).rmse;
}

TEST(OrderIndependent, ErrorsAreOrderedAsTheMethodsAreMeant) {
  for (const char* name : {"teapot_1k", "cocktailglass_8k"}) {
    SCOPED_TRACE(name);
    const Mesh mesh = load(name);
    const View view = view_of(mesh);
    const Image reference = picture(mesh, view, "reference");
    const auto error = [&](const char* strategy) { return rmse(picture(mesh, view, strategy), reference); };
    // More samples, more layers, more moments: nearer. The bounds are loose.
    EXPECT_LT(error("stochastic:64"), 0.6 * error("stochastic:8"));
    EXPECT_LT(error("stochastic:8"), 0.6 * error("stochastic:1"));
    EXPECT_LT(error("multi_layer:2"), error("multi_layer:1"));
    EXPECT_LT(error("moment_based:6"), error("moment_based:4"));
    EXPECT_LT(error("moment_based:4"), 0.5 * error("weighted_blended"));
    EXPECT_LT(error("weighted_blended"), error("unsorted"));
  }
}

TEST(OrderIndependent, NoOrderChangesThePicture) {
  const Mesh mesh = load("cocktailglass_8k");
  const View view = view_of(mesh);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const std::vector<std::uint32_t> in_order = index_order(mesh.triangles.size());
  std::vector<std::uint32_t> shuffled = in_order;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(3));
  Rasteriser rasteriser;
  for (const auto& [method, count] : {std::pair(OrderIndependent::weighted, 0),
                                      {OrderIndependent::moments, 4},
                                      {OrderIndependent::moments, 6},
                                      {OrderIndependent::layers, 64},
                                      {OrderIndependent::stochastic, 8}}) {
    Image first, second;
    rasteriser.draw_order_independent(mesh.view(), view, in_order, colours, method, count, background,
                                      PixelFormat::rgba32f, first);
    rasteriser.draw_order_independent(mesh.view(), view, shuffled, colours, method, count, background,
                                      PixelFormat::rgba32f, second);
    // Moments of layers close together come of sums that nearly cancel.
    const double tolerance = method == OrderIndependent::moments ? 1e-3 : 2e-6;
    EXPECT_LT(largest_difference(mesh, view, first, second), tolerance) << count;
  }
  Image first, second;
  const DrawPass add[] = {{.blend = BlendMode::additive}}, over[] = {{}};
  const auto draw = [&](const auto& order, const auto& pass, Image& image) {
    rasteriser.draw(mesh.view(), view, order, colours, pass, background, PixelFormat::rgba32f, image);
  };
  draw(in_order, add, first);
  draw(shuffled, add, second);
  EXPECT_LT(largest_difference(mesh, view, first, second), 2e-6);
  draw(in_order, over, first);
  draw(shuffled, over, second);
  EXPECT_GT(largest_difference(mesh, view, first, second), 0.1);
}

TEST(OrderIndependent, PremultipliedOverIsThePictureOfUnsorted) {
  const Mesh mesh = load("teapot_1k");
  const View view = view_of(mesh);
  EXPECT_EQ(picture(mesh, view, "premultiplied_over").pixels, picture(mesh, view, "unsorted").pixels);
}

TEST(OrderIndependent, InterpolatesVertexColours) {
  Mesh mesh = shapes::torus_knot(2000);
  for (const glm::vec3& position : mesh.positions) {
    mesh.vertex_colours.emplace_back(0.5f + 0.5f * glm::sin(position * 5.0f), 0.3f + 0.2f * std::sin(position.x));
  }
  const View view = view_of(mesh);
  const Image reference = picture(mesh, view, "reference");
  EXPECT_LT(largest_difference(mesh, view, picture(mesh, view, "multi_layer:32"), reference), 1e-5);
  for (const char* name : {"moment_based:4", "moment_based:6", "stochastic:64"}) {
    EXPECT_LT(rmse(picture(mesh, view, name), reference), 0.02) << name;
  }
  EXPECT_LT(rmse(picture(mesh, view, "weighted_blended"), reference), 0.06);
}

TEST(OrderIndependent, TellsItsPassesAndMemory) {
  const struct {
    const char* name;
    int passes;
    std::size_t bytes;
  } expected[] = {{"unsorted", 1, 0},           {"depth_write", 1, 4},           {"additive", 1, 0},
                  {"premultiplied_over", 1, 0}, {"weighted_blended", 1, 20},     {"moment_based:4", 2, 36},
                  {"moment_based:6", 2, 44},    {"multi_layer:8", 1, 160},       {"stochastic:8", 2, 52},
                  {"depth_peeling:2", 2, 40},   {"dual_depth_peeling:1", 2, 80}, {"reference", 1, 6 * 16}};
  const Mesh mesh = shapes::nested_shells(3, 0.3f, 2);
  const View view = view_of(mesh);
  for (const auto& [name, passes, bytes] : expected) {
    SCOPED_TRACE(name);
    StrategyRenderer renderer(mesh.view(), *strategy_from_name(name));
    renderer.order(view);
    Image image;
    EXPECT_EQ(renderer.draw(view, PixelFormat::rgba32f, image).passes, passes);
    EXPECT_EQ(renderer.passes(), passes);
    EXPECT_EQ(renderer.bytes_per_pixel(), bytes);
  }
}

}  // namespace
}  // namespace facetsort
