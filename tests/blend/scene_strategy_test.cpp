// Strategies on scenes: opaque objects among transparent ones, and whole objects in the order of an engine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <glm/gtc/matrix_transform.hpp>
#include <string>
#include <vector>

#include "blend/pictures.h"
#include "blend/sheets.h"
#include "facetsort/blend/strategy.h"
#include "shapes.h"

namespace facetsort {
namespace {

SceneMesh scene_mesh(const Mesh& mesh, std::uint32_t material) {
  SceneMesh result;
  result.positions = mesh.positions;
  result.triangles = mesh.triangles;
  result.material = material;
  return result;
}

glm::dmat4 at(double x, double y, double z) {
  return glm::translate(glm::dmat4(1), {x, y, z});
}

// A scene and its objects as one mesh, blended ones first.
struct MergedScene {
  Scene scene;
  MergedMesh merged;

  explicit MergedScene(Scene made) : scene(std::move(made)) {
    std::vector<std::uint32_t> objects;
    for (const bool blended : {true, false}) {
      for (std::uint32_t object = 0; object < scene.objects.size(); ++object) {
        const AlphaMode mode = scene.material_of(object).material.alpha_mode;
        if ((mode == AlphaMode::blend) == blended) objects.push_back(object);
      }
    }
    merged = merge(scene, objects).value();
  }

  View view(const glm::vec3& direction) const {
    const Box box = facet_bounds(merged.mesh.view());
    View view = default_view(box, box.centre() + box.radius() * direction);
    view.width = view.height = 160;
    return view;
  }

  Image draw(const std::string& strategy, const View& view) const {
    StrategyRenderer renderer(merged.mesh.view(), *strategy_from_name(strategy), {}, {&scene, merged.objects});
    Image image;
    renderer.order(view);
    renderer.draw(view, PixelFormat::rgba32f, image);
    return image;
  }
};

// Two spheres one behind the other, an opaque box that sticks out of one of them, and a knot through the other.
Scene mixed_scene(bool double_sided) {
  Scene scene;
  scene.materials = {{.material = {.base_colour = {1, 0, 0, 0.5f}, .double_sided = double_sided}},
                     {.material = {.base_colour = {0, 1, 0, 0.5f}, .double_sided = double_sided}},
                     {.material = {.base_colour = {0, 0, 1, 0.3f}, .alpha_mode = AlphaMode::opaque}}};
  const Mesh sphere = shapes::nested_shells(1, 0.1f, 2);
  scene.meshes = {scene_mesh(sphere, 0), scene_mesh(sphere, 1), scene_mesh(shapes::interpenetrating(0), 2),
                  scene_mesh(shapes::torus_knot(2000), 0)};
  scene.objects = {{.mesh = 0, .world = at(0, 0, 0)},
                   {.mesh = 2, .world = at(0.9, 0.3, 0)},
                   {.mesh = 1, .world = at(0.5, 0.2, -2.5)},
                   {.mesh = 3, .world = at(0.2, 0, -2.6)}};
  return scene;
}

TEST(SceneStrategy, ExactOrdersAmongOpaqueObjectsDrawTheReference) {
  const MergedScene scene(mixed_scene(true));
  for (const glm::vec3& direction : {glm::vec3(0.3f, 0.4f, 2.5f), glm::vec3(2, 1, -1.5f)}) {
    const View view = scene.view(direction);
    const Image reference = scene.draw("reference", view);
    for (const char* exact : {"facet_sort:exact", "facet_sort:exact_tree", "facet_sort:presorted", "depth_peeling",
                              "dual_depth_peeling", "multi_layer:24"}) {
      EXPECT_EQ(pixels_off(scene.draw(exact, view), reference), 0u) << exact;
    }
    // The box hides by depth, whatever the order of the rest.
    EXPECT_GT(pixels_off(scene.draw("unsorted", view), reference), 200u);
  }
}

TEST(SceneStrategy, OpaqueFacetsAreNeitherSortedNorCounted) {
  const MergedScene scene(mixed_scene(true));
  const MeshView mesh = scene.merged.mesh.view(), blended = blended_facets(mesh);
  EXPECT_EQ(blended.facet_count(), 2 * 20 * 16 + scene.scene.meshes[3].triangles.size());
  EXPECT_LT(blended.facet_count(), mesh.facet_count());
  StrategyRenderer renderer(mesh, *strategy_from_name("facet_sort:centroid_distance"));
  EXPECT_FALSE(renderer.draws_in_order());
  EXPECT_TRUE(renderer.discards_fragments());
  EXPECT_EQ(renderer.bytes_per_pixel(), sizeof(float));
  StrategyRenderer all(blended, *strategy_from_name("facet_sort:centroid_distance"));
  EXPECT_TRUE(all.draws_in_order());
  EXPECT_FALSE(all.discards_fragments());
}

// A layer before what is opaque and one behind it: what remains is one layer, which each is exact for.
TEST(SceneStrategy, OrderIndependentOnesDrawOverWhatIsOpaque) {
  const Sheet layers[] = {{8, red, 0.9f}, {4, green, 0.25f}, {6, blue, 1}, {9, red, 1}};
  Mesh mesh = mesh_of(layers);
  mesh.facet_materials = {0, 1, 2, 3};
  for (const Sheet& layer : layers) {
    mesh.materials.push_back({.base_colour = glm::vec4(layer.straight, layer.alpha),
                              .alpha_mode = layer.alpha < 1 ? AlphaMode::blend : AlphaMode::opaque});
  }
  for (const bool with_colours_of_vertices : {false, true}) {
    if (with_colours_of_vertices) mesh.vertex_colours.assign(mesh.positions.size(), glm::vec4(1));
    for (const char* name : {"weighted_blended", "moment_based:4", "moment_based:6", "multi_layer:1", "stochastic:8",
                             "depth_peeling:1", "dual_depth_peeling:1", "dual_depth_peeling"}) {
      SCOPED_TRACE(name);
      StrategyRenderer renderer(mesh.view(), strategy_from_name(name).value());
      Image image;
      View view = sheets_view();
      view.projection = Projection::orthographic;  // full headlight
      renderer.order(view);
      const DrawStatistics statistics = renderer.draw(view, PixelFormat::rgba32f, image);
      expect_colour(image, {0, 0.25f, 0.75f, 1});
      EXPECT_EQ(statistics.passes, renderer.passes());
      EXPECT_GE(statistics.passes, 2);
      EXPECT_TRUE(renderer.discards_fragments());
      renderer.draw(view, PixelFormat::rgba8, image);
      expect_colour(image, {0, 64.0f / 255, 191.0f / 255, 1}, 1.01f / 255);
    }
  }
}

TEST(SceneStrategy, NothingButOpaqueNeedsNoOrder) {
  Scene scene = mixed_scene(true);
  for (SceneMaterial& material : scene.materials) material.material.alpha_mode = AlphaMode::opaque;
  const MergedScene opaque(std::move(scene));
  const View view = opaque.view({0.3f, 0.4f, 2.5f});
  const Image reference = opaque.draw("reference", view);
  for (const char* any : {"unsorted", "facet_sort:exact", "separate_culling_pass", "draw_order:three",
                          "depth_peeling:1", "weighted_blended", "moment_based:4", "multi_layer:1", "stochastic:4"}) {
    EXPECT_EQ(pixels_off(opaque.draw(any, view), reference), 0u) << any;
  }
}

// Two triangles one above the other, the nearer one first, and a camera straight above.
Scene stacked_triangles() {
  Scene scene;
  scene.materials = {{.material = {.base_colour = {1, 0, 0, 0.5f}}}, {.material = {.base_colour = {0, 0, 1, 0.5f}}}};
  const Mesh triangle{{{-4, 0, -4}, {0, 0, 8}, {4, 0, -4}}, {{0, 1, 2}}, {}, {}};
  scene.meshes = {scene_mesh(triangle, 0), scene_mesh(triangle, 1)};
  scene.objects = {{.mesh = 0, .world = at(0, 1, 0)}, {.mesh = 1}};
  return scene;
}

// Along the camera's own up, where a matrix made of it would be no matrix.
View straight_above() {
  View view;
  view.eye = {0, 8, 0};
  view.at = {0, 0, 0};
  view.width = view.height = 32;
  return view;
}

TEST(SceneStrategy, EnginesOrderObjectsSeenFromStraightAbove) {
  const MergedScene merged(stacked_triangles());
  const View view = straight_above();
  for (const DrawOrderRule rule : all_draw_order_rules()) {
    const std::string name = "draw_order:" + std::string(draw_order_rule_name(rule));
    EXPECT_EQ(pixels_off(merged.draw(name, view), merged.draw("reference", view)), 0u) << name;
  }
}

TEST(SceneStrategy, EnginesHeedTheirSettings) {
  const auto expect_picture_of = [](const char* strategy, DrawOrderRule rule, const char* what,
                                    void (*set)(EngineSettings & nearer, EngineSettings & farther)) {
    Scene scene = stacked_triangles();
    set(scene.objects[0].settings, scene.objects[1].settings);
    scene.panda3d_bins = {{"last", 60, Panda3DBinType::fixed}};
    ASSERT_TRUE(validate(scene).ok());
    const MergedScene merged(std::move(scene));
    const View view = straight_above();
    const Image expected = merged.draw(strategy, view);
    EXPECT_GT(pixels_off(expected, merged.draw("reference", view)), 100u);
    EXPECT_EQ(pixels_off(merged.draw("draw_order:" + std::string(draw_order_rule_name(rule)), view), expected), 0u)
        << what;
  };
  using Settings = EngineSettings;
  // The nearer one first, and without depth: the picture of `unsorted`.
  expect_picture_of("unsorted", DrawOrderRule::galacean, "priority",
                    [](Settings&, Settings& farther) { farther.galacean.priority = 1; });
  expect_picture_of("unsorted", DrawOrderRule::babylon, "alphaIndex",
                    [](Settings& nearer, Settings&) { nearer.babylon.alpha_index = 0; });
  expect_picture_of("unsorted", DrawOrderRule::babylon, "renderingGroupId", [](Settings& nearer, Settings& farther) {
    nearer.babylon.force_depth_write = true;  // and depth is cleared before the next group
    farther.babylon.rendering_group_id = 5;
  });
  expect_picture_of("unsorted", DrawOrderRule::three, "renderOrder", [](Settings& nearer, Settings& farther) {
    nearer.three.depth_write = false;
    farther.three.render_order = 1;
  });
  expect_picture_of("unsorted", DrawOrderRule::three, "depthTest", [](Settings&, Settings& farther) {
    farther.three.group_order = 1;
    farther.three.depth_test = false;
  });
  expect_picture_of("unsorted", DrawOrderRule::panda3d, "bin", [](Settings& nearer, Settings& farther) {
    nearer.panda3d.depth_write = false;
    farther.panda3d.bin = "last";
  });
  expect_picture_of("unsorted", DrawOrderRule::panda3d, "drawOrder", [](Settings& nearer, Settings& farther) {
    nearer.panda3d = {.bin = "fixed", .draw_order = -2};
    farther.panda3d = {.bin = "fixed", .draw_order = -1, .depth_test = false};
  });
  // The nearer one first, with depth: the farther one is lost.
  expect_picture_of("depth_write", DrawOrderRule::babylon, "forceDepthWrite", [](Settings& nearer, Settings&) {
    nearer.babylon = {.alpha_index = 0, .force_depth_write = true};
  });
  expect_picture_of("depth_write", DrawOrderRule::babylon, "needDepthPrePass", [](Settings& nearer, Settings&) {
    nearer.babylon = {.alpha_index = 0, .need_depth_pre_pass = true};
  });
  expect_picture_of("unsorted", DrawOrderRule::babylon, "disableDepthWrite", [](Settings& nearer, Settings&) {
    nearer.babylon = {.alpha_index = 0, .force_depth_write = true, .disable_depth_write = true};
  });
  expect_picture_of("depth_write", DrawOrderRule::three, "renderOrder, depth written",
                    [](Settings&, Settings& farther) { farther.three.render_order = 1; });
  expect_picture_of("depth_write", DrawOrderRule::panda3d, "bin, depth written",
                    [](Settings& nearer, Settings&) { nearer.panda3d.bin = "background"; });
}

// Convex objects apart from each other and seen from outside need no more than each engine does.
Scene spheres_in_a_row(bool double_sided) {
  Scene scene = mixed_scene(double_sided);
  scene.objects = {{.mesh = 0, .world = at(0, 0, 0)},
                   {.mesh = 1, .world = at(0.3, 0.1, -2.5)},
                   {.mesh = 0, .world = at(-0.2, 0.2, 2.4)},
                   {.mesh = 2, .world = at(0.1, -0.4, -7)}};
  return scene;
}

TEST(SceneStrategy, EnginesAreRightOnConvexObjectsApart) {
  const MergedScene scene(spheres_in_a_row(false));
  for (const glm::vec3& direction : {glm::vec3(0.1f, 0.2f, 2.5f), glm::vec3(0.2f, 0.3f, -2.5f)}) {
    const View view = scene.view(direction);
    const Image reference = scene.draw("reference", view);
    for (const DrawOrderRule rule : all_draw_order_rules()) {
      const std::string name = "draw_order:" + std::string(draw_order_rule_name(rule));
      EXPECT_EQ(pixels_off(scene.draw(name, view), reference), 0u) << name;
    }
    EXPECT_GT(pixels_off(scene.draw("unsorted", view), reference), 100u);
  }
}

// Back faces, then front faces: that is Three.js's way with both sides of a transparent material.
TEST(SceneStrategy, OnlyThreeIsRightOnBothSidesOfConvexObjects) {
  const MergedScene scene(spheres_in_a_row(true));
  const View view = scene.view({0.1f, 0.2f, 2.5f});
  const Image reference = scene.draw("reference", view);
  EXPECT_EQ(pixels_off(scene.draw("draw_order:three", view), reference), 0u);
  for (const char* other : {"draw_order:babylon", "draw_order:galacean", "draw_order:panda3d"}) {
    EXPECT_GT(pixels_off(scene.draw(other, view), reference), 100u) << other;
  }
}

TEST(SceneStrategy, SettingsTellInHowManyPassesBothSidesAreDrawn) {
  Scene scene = spheres_in_a_row(true);
  for (SceneObject& object : scene.objects) {
    object.settings.babylon.separate_culling_pass = true;
    object.settings.three.force_single_pass = true;
  }
  const MergedScene merged(std::move(scene));
  const View view = merged.view({0.1f, 0.2f, 2.5f});
  const Image reference = merged.draw("reference", view);
  EXPECT_EQ(pixels_off(merged.draw("draw_order:babylon", view), reference), 0u);
  EXPECT_GT(pixels_off(merged.draw("draw_order:three", view), reference), 100u);
}

TEST(SceneStrategy, NamesOfRules) {
  for (const DrawOrderRule rule : all_draw_order_rules()) {
    const Strategy strategy{.kind = StrategyKind::draw_order, .rule = rule};
    EXPECT_EQ(strategy_from_name(strategy.name()), strategy);
    EXPECT_FALSE(strategy.draws_in_order());
  }
  EXPECT_EQ(strategy_from_name("draw_order"), std::nullopt);
  EXPECT_EQ(strategy_from_name("draw_order:unity"), std::nullopt);
}

}  // namespace
}  // namespace facetsort
