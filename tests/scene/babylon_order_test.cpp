#include "facetsort/scene/babylon_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "scene/fixture.h"

namespace facetsort {
namespace {

using Mode = BabylonTransparencyMode;
using Rule = BabylonTransparencyRule;

struct CategoryCase {
  BabylonSubMesh sub_mesh;
  BabylonCategory mode_first, visibility_first;
  bool tested_by_mode_first = mode_first == BabylonCategory::alpha_test;
  bool tested_by_visibility_first = visibility_first == BabylonCategory::alpha_test;
};

TEST(BabylonOrder, FindsTheCategory) {
  constexpr auto opaque = BabylonCategory::opaque, alpha_test = BabylonCategory::alpha_test,
                 transparent = BabylonCategory::transparent;
  const CategoryCase cases[] = {
      {{}, opaque, opaque},
      {{.material = {.alpha = 0.9}}, transparent, transparent},
      {{.visibility = 0.9}, transparent, transparent},
      {{.has_vertex_alpha = true}, transparent, transparent},
      {{.material = {.has_opacity_texture = true}}, transparent, transparent},
      {{.material = {.diffuse_texture_has_alpha = true}}, alpha_test, alpha_test},
      {{.material = {.use_alpha_from_diffuse_texture = true}}, opaque, opaque},
      {{.material = {.diffuse_texture_has_alpha = true, .use_alpha_from_diffuse_texture = true}},
       transparent,
       transparent},
      // Visibility below 1 turns alpha test off.
      {{.material = {.diffuse_texture_has_alpha = true}, .visibility = 0.5}, transparent, transparent},
      // A mode, against what else there is.
      {{.material = {.alpha = 0.5, .transparency_mode = Mode::opaque}}, opaque, opaque},
      {{.material = {.transparency_mode = Mode::opaque}, .visibility = 0.5}, opaque, transparent},
      {{.material = {.transparency_mode = Mode::alpha_test}, .visibility = 0.5}, alpha_test, transparent},
      {{.material = {.transparency_mode = Mode::alpha_test}}, alpha_test, opaque},
      {{.material = {.transparency_mode = Mode::alpha_test, .diffuse_texture_has_alpha = true}},
       alpha_test,
       alpha_test},
      {{.material = {.transparency_mode = Mode::alpha_blend}}, transparent, opaque},
      {{.material = {.alpha = 0.5, .transparency_mode = Mode::alpha_blend}}, transparent, transparent},
      {{.material = {.transparency_mode = Mode::alpha_test_and_blend}}, transparent, alpha_test, true, true},
      {{.material = {.alpha = 0.5, .transparency_mode = Mode::alpha_test_and_blend}},
       transparent,
       transparent,
       true,
       true},
  };
  for (const CategoryCase& c : cases) {
    SCOPED_TRACE(&c - cases);
    EXPECT_EQ(babylon_category(c.sub_mesh, Rule::mode_first), c.mode_first);
    EXPECT_EQ(babylon_category(c.sub_mesh, Rule::visibility_first), c.visibility_first);
    EXPECT_EQ(babylon_needs_alpha_testing(c.sub_mesh, Rule::mode_first), c.tested_by_mode_first);
    EXPECT_EQ(babylon_needs_alpha_testing(c.sub_mesh, Rule::visibility_first), c.tested_by_visibility_first);
  }
}

TEST(BabylonOrder, MeasuresStraightToTheCentre) {
  EXPECT_EQ(babylon_distance_to_camera({.bounding_sphere_centre_world = {1, 5, -2}}, {1, 2, 2}), 5);
  // Squares that differ in their last bit have the same root, and tie.
  const BabylonSubMesh a{.bounding_sphere_centre_world = {1 + 0x1p-52, 0, 0}},
      b{.bounding_sphere_centre_world = {1, 0x1p-27, 0}};
  EXPECT_GT(babylon_distance_to_camera(a, {}), 1);
  EXPECT_EQ(babylon_distance_to_camera(b, {}), 1);
}

TEST(BabylonOrder, ComparesMaterialsThenMeshesOfThoseWithout) {
  const BabylonSubMesh first{.mesh_unique_id = 9, .mesh_material_unique_id = 1};
  const BabylonSubMesh second{.mesh_unique_id = 8, .mesh_material_unique_id = 2};
  const BabylonSubMesh bare{.mesh_unique_id = 7};
  const BabylonSortItem a{0, &first}, b{1, &second}, c{2, &bare};
  EXPECT_LT(babylon_painter_sort_compare(a, b), 0);
  EXPECT_GT(babylon_painter_sort_compare(b, a), 0);
  EXPECT_EQ(babylon_painter_sort_compare(a, a), 0);
  EXPECT_LT(babylon_painter_sort_compare(c, a), 0);
  EXPECT_LT(babylon_painter_sort_compare(c, b), 0);
}

TEST(BabylonOrder, ComparesAlphaIndexBeforeDistance) {
  const BabylonSortItem near{0, nullptr, 1, 2}, far{0, nullptr, 1, 3}, near_but_first{0, nullptr, 0, 1};
  EXPECT_LT(babylon_default_transparent_sort_compare(far, near), 0);
  EXPECT_GT(babylon_default_transparent_sort_compare(near, far), 0);
  EXPECT_EQ(babylon_default_transparent_sort_compare(near, near), 0);
  EXPECT_LT(babylon_default_transparent_sort_compare(near_but_first, far), 0);
  EXPECT_GT(babylon_default_transparent_sort_compare(far, near_but_first), 0);
  EXPECT_GT(babylon_back_to_front_sort_compare(near_but_first, far), 0);
  EXPECT_LT(babylon_back_to_front_sort_compare(far, near_but_first), 0);
  EXPECT_LT(babylon_front_to_back_sort_compare(near_but_first, far), 0);
  EXPECT_EQ(babylon_front_to_back_sort_compare(far, far), 0);
}

BabylonSubMesh at(double z, const BabylonMaterial& material, std::uint32_t material_id = 0) {
  return {.material = material, .mesh_material_unique_id = material_id, .bounding_sphere_centre_world = {0, 0, z}};
}

const BabylonMaterial glass{.alpha = 0.5}, leaves{.transparency_mode = Mode::alpha_test}, stone;

TEST(BabylonOrder, DrawsACategoryAfterTheOther) {
  const std::vector<BabylonSubMesh> sub_meshes{at(1, glass),    at(2, leaves, 3), at(3, glass),
                                               at(1, stone, 2), at(2, stone, 1),  at(9, leaves, 2)};
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, {})), "4f 3f 5fk 1fk 2fw 0fw");
}

TEST(BabylonOrder, DrawsDepthFirstAndAgain) {
  BabylonMaterial dense_glass = glass, wet_stone = stone, dense_leaves = leaves;
  dense_glass.need_depth_pre_pass = wet_stone.need_depth_pre_pass = dense_leaves.need_depth_pre_pass = true;
  const std::vector<BabylonSubMesh> sub_meshes{at(1, dense_glass, 1), at(2, glass, 1), at(0, wet_stone, 2),
                                               at(0, dense_leaves, 1), at(0, stone, 1)};
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, {})), "3fpk 2fp 4f 2f 3fk 1fw 0fp 0fw");
  BabylonScene scene;
  scene.disable_depth_pre_pass = true;
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, scene)), "4f 2f 3fk 1fw 0fw");
}

TEST(BabylonOrder, CullsAsTheMaterialSays) {
  BabylonMaterial material;
  const auto drawn = [&] { return text_of(babylon_draw_order(std::vector{at(1, material)}, {})); };
  EXPECT_EQ(drawn(), "0f");
  material.cull_back_faces = false;
  EXPECT_EQ(drawn(), "0b");
  material.back_face_culling = false;
  EXPECT_EQ(drawn(), "0a");
  material.separate_culling_pass = true;
  EXPECT_EQ(drawn(), "0f 0b");
  material.cull_back_faces = true;
  EXPECT_EQ(drawn(), "0b 0f");
  material.alpha = 0.5, material.need_depth_pre_pass = true;
  EXPECT_EQ(drawn(), "0bp 0fp 0bw 0fw");
}

TEST(BabylonOrder, WritesDepthAsTheMaterialSays) {
  BabylonMaterial material = glass;
  const auto drawn = [&] { return text_of(babylon_draw_order(std::vector{at(1, material)}, {})); };
  EXPECT_EQ(drawn(), "0fw");
  material.force_depth_write = true;
  EXPECT_EQ(drawn(), "0f");
  material.disable_depth_write = true;
  EXPECT_EQ(drawn(), "0fw");
  material = glass, material.alpha_mode = babylon_alpha_disable;
  EXPECT_EQ(drawn(), "0f");
  material = stone, material.disable_depth_write = true;
  EXPECT_EQ(drawn(), "0fw");
}

TEST(BabylonOrder, DrawsGroupsInTurnAndClearsDepthBetweenThem) {
  std::vector<BabylonSubMesh> sub_meshes{at(1, glass), at(1, stone), at(1, glass), at(1, stone), at(1, stone)};
  sub_meshes[0].rendering_group_id = 1;
  sub_meshes[1].rendering_group_id = 3;
  sub_meshes[3].rendering_group_id = 1;
  sub_meshes[4].rendering_group_id = 4;
  BabylonScene scene;
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, scene)), "2fw 3fc 0fw 1fc");
  scene.rendering_groups.resize(6);
  scene.rendering_groups[1].auto_clear_depth = false;
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, scene)), "2fw 3f 0fw 1fc 4fc");
}

TEST(BabylonOrder, SortsEachQueueByItsOwnComparator) {
  const std::vector<BabylonSubMesh> sub_meshes{at(1, stone),  at(2, stone), at(1, leaves),
                                               at(2, leaves), at(1, glass), at(2, glass)};
  const BabylonComparator last_first = [](const auto& a, const auto& b) { return double(b.item) - a.item; };
  const auto drawn = [&](BabylonComparator BabylonRenderingGroup::*queue) {
    BabylonScene scene;
    scene.rendering_groups[0].*queue = last_first;
    return text_of(babylon_draw_order(sub_meshes, scene));
  };
  EXPECT_EQ(drawn(&BabylonRenderingGroup::opaque_sort_compare), "1f 0f 2fk 3fk 5fw 4fw");
  EXPECT_EQ(drawn(&BabylonRenderingGroup::alpha_test_sort_compare), "0f 1f 3fk 2fk 5fw 4fw");
  BabylonScene scene;
  scene.rendering_groups[0].transparent_sort_compare = babylon_front_to_back_sort_compare;
  EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, scene)), "0f 1f 2fk 3fk 4fw 5fw");
}

// Babylon.js's own, and two as record_babylon.js has them.
const std::map<std::string, BabylonComparator>& comparators() {
  using Item = BabylonSortItem;
  static const std::map<std::string, BabylonComparator> named{
      {"front_to_back", babylon_front_to_back_sort_compare},
      {"back_to_front", babylon_back_to_front_sort_compare},
      {"last_first",
       [](const Item& a, const Item& b) {
         return double(b.sub_mesh->mesh_unique_id) - double(a.sub_mesh->mesh_unique_id);
       }},
      {"all_equal", [](const Item&, const Item&) { return 0.0; }}};
  return named;
}

BabylonComparator comparator_of(const nlohmann::json& name) {
  return name.is_string() ? comparators().at(name) : BabylonComparator();
}

BabylonScene scene_of(const nlohmann::json& recorded, Rule rule) {
  BabylonScene scene{.camera_global_position = vector_of(recorded["camera"]),
                     .rendering_groups = {},
                     .disable_depth_pre_pass = recorded["disableDepthPrePass"],
                     .transparency_rule = rule};
  for (const nlohmann::json& group : recorded["groups"]) {
    scene.rendering_groups.push_back(
        {group.at(0), comparator_of(group.at(1)), comparator_of(group.at(2)), comparator_of(group.at(3))});
  }
  return scene;
}

BabylonMaterial material_of(const nlohmann::json& recorded) {
  BabylonMaterial material{.alpha = recorded.at(0),
                           .diffuse_texture_has_alpha = recorded.at(2),
                           .use_alpha_from_diffuse_texture = recorded.at(3),
                           .has_opacity_texture = recorded.at(4),
                           .alpha_mode = recorded.at(11),
                           .need_depth_pre_pass = recorded.at(5),
                           .back_face_culling = recorded.at(6),
                           .separate_culling_pass = recorded.at(7),
                           .cull_back_faces = recorded.at(8),
                           .force_depth_write = recorded.at(9),
                           .disable_depth_write = recorded.at(10)};
  // As Material counts them: OPAQUE 0, ALPHATEST 1, ALPHABLEND 2, ALPHATESTANDBLEND 3.
  if (recorded.at(1).is_number()) material.transparency_mode = static_cast<Mode>(recorded.at(1).get<int>());
  return material;
}

std::vector<BabylonSubMesh> sub_meshes_of(const nlohmann::json& recorded) {
  std::vector<BabylonSubMesh> sub_meshes;
  for (const nlohmann::json& item : recorded["items"]) {
    BabylonSubMesh sub_mesh{.material = material_of(recorded["materials"].at(item.at(0).get<std::size_t>())),
                            .mesh_unique_id = item.at(2),
                            .rendering_group_id = item.at(3),
                            .visibility = item.at(5),
                            .has_vertex_alpha = item.at(6),
                            .bounding_sphere_centre_world = {item.at(7), item.at(8), item.at(9)}};
    if (item.at(1).is_number()) sub_mesh.mesh_material_unique_id = item.at(1);
    if (item.at(4).is_number()) sub_mesh.alpha_index = item.at(4);
    sub_meshes.push_back(sub_mesh);
  }
  return sub_meshes;
}

// How often something happened in the scenes, so that agreement is not for want of it.
using Counts = std::map<std::string, int>;

void count_sub_mesh(const BabylonSubMesh& sub_mesh, const BabylonScene& scene, Counts& counts) {
  const std::optional<Mode>& mode = sub_mesh.material.transparency_mode;
  ++counts[mode ? "mode " + std::to_string(int(*mode)) : "no mode"];
  if (sub_mesh.rendering_group_id >= scene.rendering_groups.size()) return void(++counts["in no group"]);
  ++counts["group " + std::to_string(sub_mesh.rendering_group_id)];
  ++counts["category " + std::to_string(int(babylon_category(sub_mesh, scene.transparency_rule)))];
  if (sub_mesh.visibility < 1) ++counts["visibility below 1"];
  if (!sub_mesh.mesh_material_unique_id) ++counts["no material"];
}

void count_pairs(const std::vector<BabylonSubMesh>& sub_meshes, const BabylonScene& scene, Counts& counts) {
  for (const BabylonSubMesh& a : sub_meshes) {
    for (const BabylonSubMesh& b : sub_meshes) {
      if (&a >= &b || a.rendering_group_id != b.rendering_group_id) continue;
      const BabylonCategory category = babylon_category(a, scene.transparency_rule);
      if (category != babylon_category(b, scene.transparency_rule)) continue;
      if (category != BabylonCategory::transparent) {
        ++counts[a.mesh_material_unique_id == b.mesh_material_unique_id ? "material ties" : "material decides"];
        continue;
      }
      ++counts[a.alpha_index == b.alpha_index ? "alpha index ties" : "alpha index decides"];
      if (a.alpha_index != b.alpha_index) continue;
      const double difference = babylon_distance_to_camera(a, scene.camera_global_position) -
                                babylon_distance_to_camera(b, scene.camera_global_position);
      ++counts[difference == 0 ? "distance ties" : "distance decides"];
      if (difference != 0 && std::abs(difference) < 1e-12) ++counts["distance nearly ties"];
    }
  }
}

Counts agreement(const std::string& fixture, Rule rule) {
  Counts counts;
  for (const nlohmann::json& recorded : read_scenes(fixture)) {
    const BabylonScene scene = scene_of(recorded, rule);
    const std::vector<BabylonSubMesh> sub_meshes = sub_meshes_of(recorded);
    const std::string draws = recorded["draws"];
    EXPECT_EQ(text_of(babylon_draw_order(sub_meshes, scene)), draws) << recorded;

    ++counts["scenes"];
    ++counts[recorded["perspective"] ? "perspective" : "orthographic"];
    if (scene.disable_depth_pre_pass) ++counts["no depth pre-pass"];
    bool custom = false;
    for (const BabylonRenderingGroup& group : scene.rendering_groups) {
      if (group.opaque_sort_compare) custom = ++counts["custom opaque"];
      if (group.alpha_test_sort_compare) custom = ++counts["custom alpha test"];
      if (group.transparent_sort_compare) custom = ++counts["custom transparent"];
    }
    for (const BabylonSubMesh& sub_mesh : sub_meshes) count_sub_mesh(sub_mesh, scene, counts);
    if (!custom) count_pairs(sub_meshes, scene, counts);
    for (const char flag : draws) ++counts[std::string(1, flag)];
  }
  for (const char* happening : {"perspective",
                                "orthographic",
                                "custom opaque",
                                "custom alpha test",
                                "custom transparent",
                                "no mode",
                                "mode 0",
                                "mode 1",
                                "mode 2",
                                "mode 3",
                                "group 0",
                                "group 1",
                                "group 2",
                                "group 3",
                                "group 5",
                                "in no group",
                                "category 0",
                                "category 1",
                                "category 2",
                                "visibility below 1",
                                "no material",
                                "material ties",
                                "material decides",
                                "alpha index ties",
                                "alpha index decides",
                                "distance ties",
                                "distance decides",
                                "distance nearly ties",
                                "a",
                                "b",
                                "f",
                                "p",
                                "w",
                                "c",
                                "k"}) {
    EXPECT_GE(counts[happening], 10) << happening;
  }
  return counts;
}

TEST(BabylonOrder, AgreesWithRecordedScenes) {
  Counts counts = agreement("babylon", Rule::mode_first);
  EXPECT_GE(counts["scenes"], 500);
  EXPECT_GE(counts["no depth pre-pass"], 20);
}

TEST(BabylonOrder, AgreesWithRecordedScenesOfRelease7) {
  EXPECT_GE(agreement("babylon_7", Rule::visibility_first)["scenes"], 500);
}

}  // namespace
}  // namespace facetsort
