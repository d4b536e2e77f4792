#include "facetsort/scene/write_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <numeric>
#include <vector>

#include "facetsort/scene/read_scene.h"
#include "facetsort/scene/scene_sorter.h"
#include "mesh/temporary_folder.h"
#include "scene/random_scene.h"

namespace facetsort {
namespace {

float linear_of_byte(int byte) {
  const double encoded = byte / 255.0;
  return static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
}

Scene rich_scene() {
  Scene scene = random_scene(7, 2, 21);
  scene.materials.push_back({.name = "leaf",
                             .material = {.base_colour = {0.5f, 0.25f, 0.125f, 1},
                                          .alpha_mode = AlphaMode::mask,
                                          .alpha_cutoff = 0.375f,
                                          .double_sided = false,
                                          .texture = 0},
                             .transmissive = true});
  scene.materials.push_back({.name = "stone", .material = {.alpha_mode = AlphaMode::opaque}});
  Texture& texture = scene.textures.emplace_back();
  texture.width = 16;
  texture.height = 16;
  texture.wrap_u = Wrap::clamp_to_edge;
  texture.wrap_v = Wrap::mirrored_repeat;
  for (int i = 0; i < 256; ++i) {  // every value that a byte has
    const float value = linear_of_byte(i);
    texture.texels.emplace_back(value, 1 - value > 0.5f ? value : 0, value, static_cast<float>(i) / 255.0f);
  }
  SceneMesh& mesh = scene.meshes[0];
  mesh.material = 1;
  mesh.texture_coordinates.assign(mesh.positions.size(), glm::vec2(0.25f, 0.75f));
  mesh.vertex_colours.assign(mesh.positions.size(), glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  scene.meshes[2].material = 2;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) scene.objects[i].mesh = i % 4;  // all are shown
  scene.objects[2].world = glm::dmat4(1);
  scene.objects[0].settings.galacean.priority = -1.5;
  scene.objects[1].settings.babylon = {.rendering_group_id = 5,
                                       .alpha_index = 2,
                                       .need_depth_pre_pass = true,
                                       .separate_culling_pass = true,
                                       .force_depth_write = true,
                                       .disable_depth_write = true};
  scene.objects[2].settings.three = {
      .group_order = 1, .render_order = -2, .depth_test = false, .depth_write = false, .force_single_pass = true};
  scene.objects[3].settings.panda3d = {.bin = "late", .draw_order = -7, .depth_test = false, .depth_write = false};
  scene.panda3d_bins = {{"late", 60, Panda3DBinType::state_sorted}, {"early", -5, Panda3DBinType::fixed}};
  scene.cameras.push_back({.name = "eye", .eye = {1, 2, 3}, .at = {1, 2, 2}, .near_distance = 0.25});
  return scene;
}

void expect_same(const Scene& found, const Scene& expected) {
  ASSERT_EQ(found.meshes.size(), expected.meshes.size());
  for (std::size_t i = 0; i < found.meshes.size(); ++i) {
    const SceneMesh &a = found.meshes[i], &b = expected.meshes[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.positions, b.positions);
    EXPECT_EQ(a.triangles, b.triangles);
    EXPECT_EQ(a.vertex_colours, b.vertex_colours);
    EXPECT_EQ(a.texture_coordinates, b.texture_coordinates);
    EXPECT_EQ(a.material, b.material);
  }
  ASSERT_EQ(found.materials.size(), expected.materials.size());
  for (std::size_t i = 0; i < found.materials.size(); ++i) {
    const SceneMaterial &a = found.materials[i], &b = expected.materials[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.transmissive, b.transmissive);
    EXPECT_EQ(a.material.base_colour, b.material.base_colour);
    EXPECT_EQ(a.material.alpha_mode, b.material.alpha_mode);
    EXPECT_EQ(a.material.alpha_cutoff, b.material.alpha_cutoff);
    EXPECT_EQ(a.material.double_sided, b.material.double_sided);
    EXPECT_EQ(a.material.texture, b.material.texture);
  }
  ASSERT_EQ(found.textures.size(), expected.textures.size());
  for (std::size_t i = 0; i < found.textures.size(); ++i) {
    EXPECT_EQ(found.textures[i].width, expected.textures[i].width);
    EXPECT_EQ(found.textures[i].wrap_u, expected.textures[i].wrap_u);
    EXPECT_EQ(found.textures[i].wrap_v, expected.textures[i].wrap_v);
    EXPECT_EQ(found.textures[i].texels, expected.textures[i].texels);
  }
  ASSERT_EQ(found.objects.size(), expected.objects.size());
  for (std::size_t i = 0; i < found.objects.size(); ++i) {
    EXPECT_EQ(found.objects[i].name, expected.objects[i].name);
    EXPECT_EQ(found.objects[i].mesh, expected.objects[i].mesh);
    EXPECT_EQ(found.objects[i].world, expected.objects[i].world);
    EXPECT_EQ(found.objects[i].settings, expected.objects[i].settings);
  }
  EXPECT_EQ(found.panda3d_bins, expected.panda3d_bins);
  ASSERT_EQ(found.cameras.size(), expected.cameras.size());
  for (std::size_t i = 0; i < found.cameras.size(); ++i) {
    EXPECT_EQ(found.cameras[i].name, expected.cameras[i].name);
    EXPECT_EQ(found.cameras[i].eye, expected.cameras[i].eye);
    EXPECT_EQ(found.cameras[i].at, expected.cameras[i].at);
    EXPECT_EQ(found.cameras[i].near_distance, expected.cameras[i].near_distance);
    EXPECT_NEAR(found.cameras[i].vertical_fov_degrees, expected.cameras[i].vertical_fov_degrees, 1e-9);
  }
}

Scene written_and_read(const TemporaryFolder& folder, const char* name, const Scene& scene,
                       std::span<const ObjectOrder> orders = {}) {
  const std::filesystem::path path = folder.path() / name;
  const Status status = write_scene(path, scene, orders);
  EXPECT_TRUE(status.ok()) << status.message;
  Result<Scene> read = read_scene(path);
  EXPECT_TRUE(read.ok()) << read.status().message;
  return std::move(read).value();
}

TEST(WriteScene, ReadsBackTheSame) {
  const TemporaryFolder folder;
  const Scene scene = rich_scene();
  ASSERT_TRUE(validate(scene).ok());
  for (const char* name : {"scene.glb", "scene.gltf"}) {
    SCOPED_TRACE(name);
    expect_same(written_and_read(folder, name, scene), scene);
  }
}

TEST(WriteScene, OrthographicCameras) {
  const TemporaryFolder folder;
  Scene scene = rich_scene();
  scene.cameras = {{.name = "map", .eye = {0, 0, 9}, .at = {0, 0, 8}, .perspective = false, .height_in_units = 5}};
  const Scene read = written_and_read(folder, "scene.glb", scene);
  ASSERT_EQ(read.cameras.size(), 1u);
  EXPECT_FALSE(read.cameras[0].perspective);
  EXPECT_EQ(read.cameras[0].height_in_units, 5);
}

TEST(WriteScene, FacetColoursBecomeTheVertices) {
  const TemporaryFolder folder;
  Scene scene = rich_scene();
  for (std::size_t f = 0; f < scene.meshes[1].triangles.size(); ++f) {
    scene.meshes[1].facet_colours.emplace_back(0.125f * static_cast<float>(f % 8), 0, 0, 1);
  }
  const Scene read = written_and_read(folder, "scene.glb", scene);
  const SceneMesh &from = scene.meshes[1], &mesh = read.meshes[1];
  ASSERT_EQ(mesh.triangles.size(), from.triangles.size());
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(mesh.positions[mesh.triangles[f][i]], from.positions[from.triangles[f][i]]);
      EXPECT_EQ(mesh.vertex_colours[mesh.triangles[f][i]], from.facet_colours[f]);
    }
  }
}

TEST(WriteScene, PutsFacetsInDrawOrder) {
  const TemporaryFolder folder;
  const Scene scene = random_scene(6, 1, 5);
  std::vector<std::uint32_t> all(scene.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  Result<SceneSorter> sorter = SceneSorter::create(scene, all, {.method = Method::centroid_distance});
  ASSERT_TRUE(sorter.ok());
  const SceneOrder order = sorter.value().sort({.eye = {5, 4, 3, 1}});
  const std::vector<ObjectOrder> orders = object_orders(scene, sorter.value().merged(), order.facets);
  const Scene read = written_and_read(folder, "sorted.glb", scene, orders);
  ASSERT_EQ(read.objects.size(), scene.objects.size());
  std::size_t moved = 0;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    const SceneMesh &from = scene.mesh_of(i), &mesh = read.mesh_of(i);
    EXPECT_EQ(read.objects[i].world, scene.objects[i].world);
    EXPECT_EQ(mesh.positions, from.positions);
    ASSERT_EQ(orders[i].size(), from.triangles.size());
    ASSERT_EQ(mesh.triangles.size(), from.triangles.size());
    for (std::size_t k = 0; k < orders[i].size(); ++k) EXPECT_EQ(mesh.triangles[k], from.triangles[orders[i][k]]);
    moved += mesh.triangles != from.triangles;
  }
  EXPECT_EQ(moved, scene.objects.size());
}

// A facet in pieces comes where its last piece is.
TEST(WriteScene, OrdersOfObjectsFromAnOrderOfPieces) {
  const Scene scene = random_scene(2, 5, 3);
  const std::vector<std::uint32_t> second{1};
  const Result<MergedMesh> merged = merge(scene, second);
  ASSERT_TRUE(merged.ok());
  const std::vector<std::uint32_t> facets{2, 0, 2, 1, 0};
  const std::vector<ObjectOrder> orders = object_orders(scene, merged.value(), facets);
  ASSERT_EQ(orders.size(), 2u);
  EXPECT_TRUE(orders[0].empty());
  EXPECT_EQ(orders[1], (ObjectOrder{2, 1, 0}));
}

TEST(WriteScene, RefusesAndLeavesWhatStoodThere) {
  const TemporaryFolder folder;
  const Scene scene = rich_scene();
  const std::filesystem::path path = folder.write("kept.glb", "old");
  std::vector<ObjectOrder> orders(scene.objects.size());
  orders[3] = {0, 1, 99999};
  const Status wrong = write_scene(path, scene, orders);
  EXPECT_EQ(wrong.fault, Fault::bad_argument);
  EXPECT_EQ(wrong.message, path.string() + ": the order of object 3 names facet 99999 of " +
                               std::to_string(scene.mesh_of(3).triangles.size()));
  EXPECT_EQ(write_scene(path, scene, std::span(orders).first(2)).fault, Fault::bad_argument);
  EXPECT_EQ(write_scene(path, Scene{}).fault, Fault::empty_mesh);
  std::ifstream file(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "old");
  EXPECT_EQ(write_scene(folder.path() / "gone" / "x.glb", scene).fault, Fault::cannot_write);
}

}  // namespace
}  // namespace facetsort
