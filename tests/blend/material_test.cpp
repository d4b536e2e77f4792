// What materials and textures make of a picture.
#include "facetsort/mesh/material.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <vector>

#include "blend/pictures.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/blend/texture.h"
#include "facetsort/mesh/inspect.h"
#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/threads.h"

namespace facetsort {
namespace {

void expect_near(const glm::vec4& a, const glm::vec4& b, float tolerance = 1e-6f) {
  for (int channel = 0; channel < 4; ++channel) EXPECT_NEAR(a[channel], b[channel], tolerance) << channel;
}

const glm::vec4 opaque_red(1, 0, 0, 1), half_blue(0, 0, 1, 0.5f);

Texture red_and_blue(Wrap wrap) {
  return {.width = 2, .height = 1, .texels = {opaque_red, half_blue}, .wrap_u = wrap, .wrap_v = wrap};
}

// Centres of the two texels are at 1/4 and 3/4.
TEST(TextureSample, WeighsTheTexelsAround) {
  const Texture texture = red_and_blue(Wrap::clamp_to_edge);
  expect_near(sample(texture, {0.25, 0.5}), opaque_red);
  expect_near(sample(texture, {0.75, 0.5}), half_blue);
  expect_near(sample(texture, {0.5, 0.5}), (opaque_red + half_blue) / 2.0f);
  expect_near(sample(texture, {0.375, 0.1}), opaque_red * 0.75f + half_blue * 0.25f);
}

TEST(TextureSample, WrapsAsTheModeSays) {
  const glm::vec4 middle = (opaque_red + half_blue) / 2.0f;
  const auto at = [](Wrap wrap, double u) { return sample(red_and_blue(wrap), {u, 0.5}); };
  expect_near(at(Wrap::clamp_to_edge, 0), opaque_red);
  expect_near(at(Wrap::clamp_to_edge, -7.3), opaque_red);
  expect_near(at(Wrap::clamp_to_edge, 7.3), half_blue);
  expect_near(at(Wrap::repeat, 0), middle);
  expect_near(at(Wrap::repeat, 1), middle);
  expect_near(at(Wrap::repeat, 5.25), opaque_red);
  expect_near(at(Wrap::repeat, -0.25), half_blue);
  expect_near(at(Wrap::mirrored_repeat, 0), opaque_red);
  expect_near(at(Wrap::mirrored_repeat, 1), half_blue);
  expect_near(at(Wrap::mirrored_repeat, 1.25), half_blue);
  expect_near(at(Wrap::mirrored_repeat, 1.75), opaque_red);
  expect_near(at(Wrap::mirrored_repeat, -0.75), half_blue);
  for (const Wrap wrap : {Wrap::repeat, Wrap::mirrored_repeat}) {  // somewhere in the texture
    EXPECT_NEAR(at(wrap, 1e30).r + at(wrap, 1e30).b, 1, 1e-6);
  }
}

TEST(TextureSample, RowsGoDown) {
  const Texture texture{.width = 1, .height = 2, .texels = {opaque_red, half_blue}};
  expect_near(sample(texture, {0.5, 0.25}), opaque_red);
  expect_near(sample(texture, {0.5, 0.75}), half_blue);
}

// Two triangles that make the square from (-1, -1) to (1, 1) at height z, texture coordinates 0 to 1 from its upper
// left corner on; seen from +z they face the eye.
void add_square(Mesh& mesh, float z, std::uint32_t material) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec2& corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
    mesh.positions.emplace_back(corner, z);
    mesh.texture_coordinates.emplace_back((corner.x + 1) / 2, (1 - corner.y) / 2);
  }
  mesh.triangles.emplace_back(first, first + 1, first + 2);
  mesh.triangles.emplace_back(first, first + 2, first + 3);
  mesh.facet_materials.insert(mesh.facet_materials.end(), 2, material);
}

// Orthographic, so that a square fills it and its facets have the full headlight.
View square_view(int size) {
  View view;
  view.eye = {0, 0, 5};
  view.projection = Projection::orthographic;
  view.width = view.height = size;
  return view;
}

std::vector<std::uint32_t> all_facets(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

TEST(MaterialColour, IsTheProductOfAll) {
  Mesh mesh;
  add_square(mesh, 0, 0);
  mesh.materials = {{.base_colour = {0.5f, 0.25f, 1, 0.5f}}};
  const glm::vec4 eye(0, 0, 1, 0);
  EXPECT_TRUE(has_one_colour_per_facet(mesh.view()));
  expect_near(facet_colour(mesh.view(), 0, eye), {0.25f, 0.125f, 0.5f, 0.5f});  // of white
  mesh.facet_colours = {{1, 1, 0, 0.5f}, {0, 0, 1, 1}};
  expect_near(facet_colour(mesh.view(), 0, eye), {0.125f, 0.0625f, 0, 0.25f});
  expect_near(facet_colour(mesh.view(), 1, eye), {0, 0, 0.5f, 0.5f});
  mesh.textures = {red_and_blue(Wrap::clamp_to_edge)};
  mesh.materials[0].texture = 0;
  EXPECT_FALSE(has_one_colour_per_facet(mesh.view()));
  const Ray ray{{-0.5, 0.5, 5}, {0, 0, -1}};  // facet 1, texture coordinate 1/4: red, alpha 1
  expect_near(fragment_colour(mesh.view(), 1, ray, eye), {0, 0, 0, 0.5f});
  mesh.facet_colours.clear();
  expect_near(fragment_colour(mesh.view(), 1, ray, eye), {0.25f, 0, 0, 0.5f});
}

TEST(MaterialColour, AlphaModesSettleAlpha) {
  Mesh mesh;
  add_square(mesh, 0, 0);
  const glm::vec4 eye(0, 0, 1, 0);
  mesh.materials = {{.base_colour = {1, 0.5f, 0, 0.4f}, .alpha_mode = AlphaMode::opaque}};
  expect_near(facet_colour(mesh.view(), 0, eye), {1, 0.5f, 0, 1});
  mesh.materials[0].alpha_mode = AlphaMode::mask;
  expect_near(facet_colour(mesh.view(), 0, eye), {0, 0, 0, 0});  // 0.4 is below the cutoff of 0.5
  mesh.materials[0].alpha_cutoff = 0.4f;
  expect_near(facet_colour(mesh.view(), 0, eye), {1, 0.5f, 0, 1});  // at the cutoff is not below it
  mesh.vertex_colours = {{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 0}, {1, 1, 1, 1}};
  mesh.materials[0].alpha_mode = AlphaMode::opaque;
  expect_near(fragment_colour(mesh.view(), 0, {{0.9, 0.8, 5}, {0, 0, -1}}, eye), {1, 0.5f, 0, 1});
}

// Every texel is drawn where it belongs, by every way of drawing.
TEST(Textures, FillASquare) {
  Mesh mesh;
  add_square(mesh, 0, 0);
  Texture texture{.width = 4, .height = 4, .wrap_u = Wrap::clamp_to_edge, .wrap_v = Wrap::clamp_to_edge};
  for (int i = 0; i < 16; ++i) {
    const auto x = static_cast<float>(i % 4), y = static_cast<float>(i / 4);
    texture.texels.emplace_back(x / 3, y / 3, 1, 0.25f + x / 8);
  }
  mesh.textures = {texture};
  mesh.materials = {{.texture = 0}};
  std::vector<Strategy> strategies = all_strategies();
  for (const char* exact_for_one_layer : {"weighted_blended", "moment_based:4", "moment_based:6", "multi_layer:1",
                                          "stochastic:8", "depth_peeling:1"}) {
    strategies.push_back(strategy_from_name(exact_for_one_layer).value());
  }
  for (const Strategy& strategy : strategies) {
    SCOPED_TRACE(strategy.name());
    StrategyRenderer renderer(mesh.view(), strategy);
    const View view = square_view(4);  // a pixel a texel
    Image image;
    renderer.order(view);
    renderer.draw(view, PixelFormat::rgba32f, image);
    for (std::size_t i = 0; i < 16; ++i) {
      const glm::vec4 texel = texture.texels[i];
      const glm::vec4 source(glm::vec3(texel) * texel.a, texel.a);
      expect_near(image.pixels[i], source + background * (1 - source.a), 1e-5f);
    }
  }
}

// Nested spheres of all kinds of materials, with and without colours of vertices.
Mesh mixed_spheres(bool with_vertex_colours) {
  Mesh mesh = shapes::nested_shells(4, 0.2f, 2);
  const std::size_t shell = mesh.triangles.size() / 4;
  for (std::size_t facet = 0; facet < mesh.triangles.size(); ++facet) {
    mesh.facet_materials.push_back(static_cast<std::uint32_t>(facet / shell));
  }
  for (const glm::vec3& position : mesh.positions) {
    mesh.texture_coordinates.emplace_back(position.x * 3, position.y * 2);
    const glm::vec3 unit = glm::normalize(position);
    if (with_vertex_colours) mesh.vertex_colours.emplace_back(unit * unit, 0.2f + 0.7f * unit.x * unit.x);
  }
  mesh.textures = {red_and_blue(Wrap::repeat), red_and_blue(Wrap::mirrored_repeat)};
  mesh.textures[1].texels[1].a = 0.1f;
  mesh.materials = {{.base_colour = {1, 1, 0.5f, 0.5f}, .texture = 0},
                    {.alpha_mode = AlphaMode::mask, .alpha_cutoff = 0.45f, .texture = 1},
                    {.base_colour = {0, 1, 0, 0.5f}, .double_sided = false},
                    {.base_colour = {0.5f, 0.5f, 1, 0.2f}, .alpha_mode = AlphaMode::opaque}};
  return mesh;
}

View shell_view(const Mesh& mesh, int size) {
  const Box box = facet_bounds(mesh.view());
  View view = default_view(box, box.centre() + box.radius() * glm::vec3(0.9f, 0.4f, 2.0f));
  view.width = view.height = size;
  return view;
}


TEST(Materials, StrategiesThatAreExactDrawTheReference) {
  for (const bool with_vertex_colours : {false, true}) {
    const Mesh mesh = mixed_spheres(with_vertex_colours);
    ASSERT_TRUE(validate(mesh.view()).ok()) << validate(mesh.view()).message;
    const View view = shell_view(mesh, 150);
    Image reference;
    StrategyRenderer(mesh.view(), {.kind = StrategyKind::reference}).draw(view, PixelFormat::rgba32f, reference);
    for (const char* name : {"facet_sort:exact", "facet_sort:presorted", "depth_peeling", "dual_depth_peeling"}) {
      SCOPED_TRACE(name);
      StrategyRenderer renderer(mesh.view(), *strategy_from_name(name));
      Image image;
      renderer.order(view);
      renderer.draw(view, PixelFormat::rgba32f, image);
      EXPECT_EQ(pixels_off(image, reference, 1e-4f), 0u);
    }
    // And what hides what matters here.
    StrategyRenderer unsorted(mesh.view(), {.kind = StrategyKind::unsorted});
    Image image;
    unsorted.draw(view, PixelFormat::rgba32f, image);
    EXPECT_GT(pixels_off(image, reference, 0.01f), 3000u);
  }
}

TEST(Materials, SamePictureForAnyThreadCountAndInstructionSet) {
  const Mesh mesh = mixed_spheres(true);
  const View view = shell_view(mesh, 90);
  const auto draw = [&] {
    Image image;
    StrategyRenderer renderer(mesh.view(), {.kind = StrategyKind::depth_prepass});
    renderer.draw(view, PixelFormat::rgba32f, image);
    return image.pixels;
  };
  const std::vector<glm::vec4> expected = draw();
  for (const int threads : {1, 3}) with_threads(threads, [&] { EXPECT_EQ(draw(), expected); });
  EXPECT_GE(for_each_instruction_set([&] { EXPECT_EQ(draw(), expected); }), 1);
}

TEST(Materials, SingleSidedFacetsAreSeenFromTheFrontAlone) {
  Mesh mesh = shapes::nested_shells(1, 0.2f, 2);
  mesh.facet_materials.assign(mesh.triangles.size(), 0);
  mesh.materials = {{}};
  const View view = shell_view(mesh, 100);
  const FragmentLists both = collect_fragments(mesh.view(), view);
  mesh.materials[0].double_sided = false;
  const FragmentLists fronts = collect_fragments(mesh.view(), view);
  ASSERT_GT(fronts.fragments.size(), 1000u);
  ASSERT_EQ(both.fragments.size(), 2 * fronts.fragments.size());  // a convex shape
  for (std::size_t pixel = 0; pixel + 1 < fronts.offsets.size(); ++pixel) {
    if (fronts.pixel(pixel).empty()) continue;
    EXPECT_EQ(fronts.pixel(pixel)[0].facet, both.pixel(pixel)[1].facet);  // the nearer of the two
  }
}

// --- batches

constexpr DrawPass with_depth{.depth_test = DepthTest::less, .depth_write = true};
constexpr DrawPass behind_nothing{.depth_test = DepthTest::less_or_equal};

TEST(DrawBatches, OfOneStateAreOneDraw) {
  const Mesh mesh = mixed_spheres(true);
  const View view = shell_view(mesh, 90);
  const std::vector<std::uint32_t> order = all_facets(mesh);
  for (const DrawPass& pass : {DrawPass{}, with_depth}) {
    Image whole, parts;
    Rasteriser rasteriser;
    const DrawStatistics statistics =
        rasteriser.draw(mesh.view(), view, order, {}, std::span(&pass, 1), background, PixelFormat::rgba8, whole);
    const std::span<const std::uint32_t> all(order);
    const DrawBatch batches[] = {{all.first(100), pass}, {all.subspan(100, 0), pass}, {all.subspan(100), pass}};
    const DrawStatistics of_parts =
        rasteriser.draw(mesh.view(), view, batches, {}, background, PixelFormat::rgba8, parts);
    EXPECT_EQ(parts.pixels, whole.pixels);
    EXPECT_EQ(of_parts.facets_drawn, statistics.facets_drawn);
    EXPECT_EQ(of_parts.passes, 3);
  }
}

// An opaque box that sticks out of a transparent sphere: the box with depth, then the sphere's backs and fronts, tested
// against it.
TEST(DrawBatches, OpaqueAmongTransparentIsTheReference) {
  Mesh mesh = shapes::interpenetrating(3);
  const std::size_t sphere = 20 * 64;
  ASSERT_EQ(mesh.triangles.size(), sphere + 12);
  mesh.facet_materials.assign(sphere, 0);
  mesh.facet_materials.resize(mesh.triangles.size(), 1);
  mesh.materials = {{.base_colour = {1, 0, 0, 0.5f}},
                    {.base_colour = {0, 1, 1, 0.5f}, .alpha_mode = AlphaMode::opaque}};
  const View view = shell_view(mesh, 160);
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  const std::vector<std::uint32_t> order = all_facets(mesh);
  const auto spheres = std::span(order).first(sphere), boxes = std::span(order).subspan(sphere);
  DrawPass backs = behind_nothing, fronts = behind_nothing;
  backs.cull = Cull::front_faces;
  fronts.cull = Cull::back_faces;
  const DrawBatch batches[] = {{boxes, with_depth}, {spheres, backs}, {spheres, fronts}};
  Image image, reference;
  Rasteriser().draw(mesh.view(), view, batches, colours, background, PixelFormat::rgba32f, image);
  StrategyRenderer(mesh.view(), {.kind = StrategyKind::reference}).draw(view, PixelFormat::rgba32f, reference);
  EXPECT_EQ(pixels_off(image, reference, 1e-5f), 0u);

  const DrawBatch without_depth[] = {{boxes, {}}, {spheres, {.cull = Cull::front_faces}}, {spheres, {}}};
  Rasteriser().draw(mesh.view(), view, without_depth, colours, background, PixelFormat::rgba32f, image);
  EXPECT_GT(pixels_off(image, reference, 0.1f), 1000u);
}

TEST(DrawBatches, NoDepthIsWrittenWhereAMaterialLeavesAFragmentOut) {
  Mesh mesh;
  add_square(mesh, 1, 0);  // nearer; the left half is left out
  add_square(mesh, 0, 1);
  mesh.textures = {{.width = 2, .height = 1, .texels = {{1, 1, 1, 0}, {1, 1, 1, 1}}, .wrap_u = Wrap::clamp_to_edge}};
  mesh.materials = {{.base_colour = {1, 0, 0, 1}, .alpha_mode = AlphaMode::mask, .texture = 0},
                    {.base_colour = {0, 1, 0, 1}, .alpha_mode = AlphaMode::opaque}};
  const std::vector<std::uint32_t> order = all_facets(mesh);
  const DrawBatch batches[] = {{std::span(order).first(2), with_depth}, {std::span(order).subspan(2), with_depth}};
  Image image;
  Rasteriser().draw(mesh.view(), square_view(8), batches, {}, background, PixelFormat::rgba32f, image);
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    expect_near(image.pixels[pixel], pixel % 8 < 4 ? glm::vec4(0, 1, 0, 1) : glm::vec4(1, 0, 0, 1), 1e-5f);
  }
}

// --- what validate() refuses

TEST(ValidateMaterials, NamesWhatIsWrong) {
  const auto message = [](const auto& spoil) {
    Mesh mesh;
    add_square(mesh, 0, 0);
    mesh.materials = {{.texture = 0}};
    mesh.textures = {red_and_blue(Wrap::repeat)};
    spoil(mesh);
    const Status status = validate(mesh.view());
    return status.ok() ? std::string() : status.message;
  };
  EXPECT_EQ(message([](Mesh&) {}), "");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.facet_materials.pop_back(); }), "1 facet materials for 2 facets");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.facet_materials[1] = 1; }), "facet 1 names material 1 of 1");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.materials[0].texture = 3; }), "material 0 names texture 3 of 1");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.textures[0].height = 2; }), "texture 0 has 2 texels for 2 x 2");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.textures[0].width = 0; }), "texture 0 has 2 texels for 0 x 1");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.texture_coordinates.pop_back(); }), "3 texture coordinates for 4 vertices");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.texture_coordinates.clear(); }),
            "facet 0 has a texture and no texture coordinates");
  EXPECT_EQ(message([](Mesh& mesh) { mesh.texture_coordinates[3].y = std::numeric_limits<float>::infinity(); }),
            "facet 1 uses vertex 3, whose texture coordinates are not finite");
}

}  // namespace
}  // namespace facetsort
