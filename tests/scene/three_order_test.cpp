#include "facetsort/scene/three_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "scene/fixture.h"

namespace facetsort {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(ThreeOrder, ListsTransmissiveBeforeTransparent) {
  EXPECT_EQ(three_list({}), ThreeList::opaque);
  EXPECT_EQ(three_list({.transparent = true}), ThreeList::transparent);
  EXPECT_EQ(three_list({.transmission = 0.01}), ThreeList::transmissive);
  EXPECT_EQ(three_list({.transmission = 1, .transparent = true}), ThreeList::transmissive);
}

// Each key decides where those before it tie, and is overruled where they don't.
TEST(ThreeOrder, PainterSortComparesGroupThenRenderOrderThenMaterialThenNearToFarThenId) {
  const ThreeRenderItem item{.id = 5, .group_order = 1, .render_order = 1, .material_id = 5, .z = 1};
  EXPECT_EQ(three_painter_sort_stable(item, item), 0);
  std::vector<ThreeRenderItem> firsts(5, item);
  firsts[4].id = 4;
  firsts[3].z = 0.5, firsts[3].id = 9;
  firsts[2].material_id = 4, firsts[2].z = 9;
  firsts[1].render_order = 0.5, firsts[1].material_id = 9;
  firsts[0].group_order = 0.5, firsts[0].render_order = 9;
  for (const ThreeRenderItem& first : firsts) {
    EXPECT_LT(three_painter_sort_stable(first, item), 0);
    EXPECT_GT(three_painter_sort_stable(item, first), 0);
  }
}

TEST(ThreeOrder, ReversePainterSortComparesGroupThenRenderOrderThenFarToNearThenId) {
  const ThreeRenderItem item{.id = 5, .group_order = 1, .render_order = 1, .material_id = 5, .z = 1};
  std::vector<ThreeRenderItem> firsts(4, item);
  firsts[3].id = 4;
  firsts[2].z = 1.5, firsts[2].id = 9;
  firsts[1].render_order = 0.5, firsts[1].z = 0;
  firsts[0].group_order = 0.5, firsts[0].render_order = 9;
  for (const ThreeRenderItem& first : firsts) {
    EXPECT_LT(three_reverse_painter_sort_stable(first, item), 0);
    EXPECT_GT(three_reverse_painter_sort_stable(item, first), 0);
  }
  ThreeRenderItem other_material = item;
  other_material.material_id = 1;
  EXPECT_EQ(three_reverse_painter_sort_stable(item, other_material), 0);
}

TEST(ThreeOrder, TakesClipSpaceDepthBeforeTheDivide) {
  // A perspective camera at z = 8 with near 1 and far 3: clip z is (-4/2) z - 6/2 in camera space.
  ThreeCamera camera;
  camera.projection_matrix = glm::dmat4(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -2, -1, 0, 0, -3, 0);
  camera.matrix_world_inverse[3] = {0, 0, -8, 1};
  ThreeItem item;
  item.matrix_world[3] = {5, 6, 4, 1};
  item.bounding_sphere_centre = {7, 7, 1};
  EXPECT_EQ(three_clip_z(item, camera), -2 * (4 + 1 - 8) - 3);
  item.matrix_world[2].z = 3;
  EXPECT_EQ(three_clip_z(item, camera), -2 * (4 + 3 - 8) - 3);
}

ThreeItem item_at(double z, const ThreeMaterial& material) {
  static std::uint32_t id = 0;
  return {.id = ++id, .bounding_sphere_centre = {0, 0, z}, .material = material};
}

TEST(ThreeOrder, DrawsOpaqueNearToFarThenTheRestFarToNear) {
  const ThreeMaterial opaque, transparent{.transparent = true};
  const std::vector<ThreeItem> items{item_at(0.1, transparent), item_at(0.9, opaque), item_at(0.5, transparent),
                                     item_at(0.2, opaque)};
  EXPECT_EQ(text_of(three_draw_order(items, {})), "3f 1f 2f 0f");
  EXPECT_EQ(text_of(three_draw_order(items, {}, {.sort_objects = false})), "1f 3f 0f 2f");
}

TEST(ThreeOrder, DrawsDoubleSidedTransparentItemsTwice) {
  ThreeMaterial material{.transparent = true, .side = ThreeSide::double_side, .depth_test = false};
  EXPECT_EQ(text_of(three_draw_order(std::vector{item_at(0, material)}, {})), "0bt 0ft");
  material.force_single_pass = true;
  EXPECT_EQ(text_of(three_draw_order(std::vector{item_at(0, material)}, {})), "0at");
  material = {.side = ThreeSide::double_side, .depth_write = false, .alpha_test = 0.5};
  EXPECT_EQ(text_of(three_draw_order(std::vector{item_at(0, material)}, {})), "0awk");
}

TEST(ThreeOrder, DrawsWhatShowsThroughTransmissiveItemsFirst) {
  const ThreeMaterial glass{.transmission = 1, .side = ThreeSide::double_side}, pane{.transmission = 1};
  const std::vector<ThreeItem> items{item_at(0.5, glass), item_at(0, {}), item_at(0.6, pane),
                                     item_at(0, {.transparent = true})};
  EXPECT_EQ(text_of(three_draw_order(items, {})), "1fT 0bT 1f 2f 0a 3f");
}

TEST(ThreeOrder, TakesAnyComparator) {
  const std::vector<ThreeItem> items{item_at(0.1, {}), item_at(0.9, {}), item_at(0.5, {})};
  ThreeSettings settings;
  settings.opaque_sort = [](const ThreeRenderItem&, const ThreeRenderItem&) { return nan; };
  EXPECT_EQ(text_of(three_draw_order(items, {}, settings)), "0f 1f 2f");
  settings.opaque_sort = [](const ThreeRenderItem&, const ThreeRenderItem&) { return -1.0; };
  EXPECT_EQ(three_draw_order(items, {}, settings).size(), 3u);
}

// As record_three.js has them.
const std::map<std::string, ThreeComparator>& comparators() {
  using Item = ThreeRenderItem;
  static const std::map<std::string, ThreeComparator> named{
      {"near_to_far", [](const Item& a, const Item& b) { return a.z - b.z; }},
      {"far_to_near", [](const Item& a, const Item& b) { return b.z - a.z; }},
      {"last_first", [](const Item& a, const Item& b) { return double(b.id) - double(a.id); }},
      {"render_order_only", [](const Item& a, const Item& b) { return a.render_order - b.render_order; }},
      {"all_equal", [](const Item&, const Item&) { return 0.0; }}};
  return named;
}

glm::dmat4 matrix_of(const nlohmann::json& numbers) {
  glm::dmat4 matrix(1);
  if (numbers.size() == 3) {
    matrix[3] = glm::dvec4(vector_of(numbers), 1);
  } else {
    for (int i = 0; i < 16; ++i) matrix[i / 4][i % 4] = numbers.at(i);
  }
  return matrix;
}

ThreeItem item_of(const nlohmann::json& scene, const nlohmann::json& item) {
  const nlohmann::json& material = scene["materials"].at(item.at(1).get<std::size_t>());
  return {.id = item.at(0),
          .group_order = item.at(2),
          .render_order = item.at(3),
          .matrix_world = matrix_of(scene["matrices"].at(item.at(4).get<std::size_t>())),
          .bounding_sphere_centre = vector_of(item.at(5)),
          .material = {.id = material.at(0),
                       .transmission = material.at(1),
                       .transparent = material.at(2),
                       // FrontSide 0, BackSide 1, DoubleSide 2
                       .side = std::vector{ThreeSide::front, ThreeSide::back, ThreeSide::double_side}.at(
                           material.at(3).get<std::size_t>()),
                       .force_single_pass = material.at(4),
                       .depth_test = material.at(6),
                       .depth_write = material.at(5)}};
}

// How often something happened in the scenes, so that agreement is not for want of it.
using Counts = std::map<std::string, int>;

void count_pairs(const std::vector<ThreeItem>& items, const ThreeCamera& camera, Counts& counts) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const ThreeItem &a = items[i], &b = items[j];
      if (three_list(a.material) != three_list(b.material)) continue;
      ++counts[a.group_order == b.group_order ? "group order ties" : "group order decides"];
      if (a.group_order != b.group_order) continue;
      ++counts[a.render_order == b.render_order ? "render order ties" : "render order decides"];
      if (a.render_order != b.render_order) continue;
      const double difference = std::abs(three_clip_z(a, camera) - three_clip_z(b, camera));
      ++counts[difference == 0 ? "z ties" : difference < 1e-12 ? "z nearly ties" : "z decides"];
      if (difference != 0) continue;
      ++counts[a.id == b.id ? "id ties" : "id decides"];
    }
  }
}

TEST(ThreeOrder, AgreesWithRecordedScenes) {
  const nlohmann::json scenes = read_scenes("three");
  ASSERT_GE(scenes.size(), 500u);
  Counts counts;
  for (const nlohmann::json& scene : scenes) {
    const ThreeCamera camera{matrix_of(scene["projection"]), matrix_of(scene["view"])};
    ThreeSettings settings{.sort_objects = scene["sortObjects"]};
    if (scene["opaqueSort"].is_string()) settings.opaque_sort = comparators().at(scene["opaqueSort"]);
    if (scene["transparentSort"].is_string()) settings.transparent_sort = comparators().at(scene["transparentSort"]);

    std::vector<ThreeItem> items;
    for (const nlohmann::json& recorded : scene["items"]) {
      items.push_back(item_of(scene, recorded));
      if (!settings.sort_objects) continue;
      ASSERT_EQ(three_clip_z(items.back(), camera), recorded.at(6).get<double>());
    }
    const std::string draws = scene["draws"];
    ASSERT_EQ(text_of(three_draw_order(items, camera, settings)), draws) << scene;

    ++counts[scene["perspective"] ? "perspective" : "orthographic"];
    if (!settings.sort_objects) ++counts["unsorted"];
    if (settings.opaque_sort) ++counts["custom opaque"];
    if (settings.transparent_sort) ++counts["custom transparent"];
    for (const ThreeItem& item : items) ++counts["list " + std::to_string(int(three_list(item.material)))];
    for (const char flag : draws) ++counts[std::string(1, flag)];
    if (settings.sort_objects && !settings.opaque_sort && !settings.transparent_sort) {
      count_pairs(items, camera, counts);
    }
  }
  for (const char* happening : {"perspective",
                                "orthographic",
                                "unsorted",
                                "custom opaque",
                                "custom transparent",
                                "list 0",
                                "list 1",
                                "list 2",
                                "group order ties",
                                "group order decides",
                                "render order ties",
                                "render order decides",
                                "z ties",
                                "z nearly ties",
                                "z decides",
                                "id ties",
                                "id decides",
                                "a",
                                "b",
                                "f",
                                "w",
                                "t",
                                "T"}) {
    EXPECT_GE(counts[happening], 20) << happening;
  }
}

}  // namespace
}  // namespace facetsort
