#include "facetsort/scene/merge.h"

#include <gtest/gtest.h>

#include <limits>
#include <numeric>
#include <vector>

#include "facetsort/mesh/inspect.h"
#include "scene/random_scene.h"

namespace facetsort {
namespace {

Scene two_triangles() {
  Scene scene;
  scene.materials = {{.name = "a"}, {.name = "b"}};
  SceneMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}};
  scene.meshes = {mesh, mesh};
  scene.meshes[1].material = 1;
  scene.objects = {{.name = "first", .mesh = 0}, {.name = "second", .mesh = 1}};
  scene.objects[1].world[3] = glm::dvec4(10, 0, 0, 1);
  return scene;
}

MergedMesh merged_all(const Scene& scene) {
  std::vector<std::uint32_t> all(scene.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  Result<MergedMesh> merged = merge(scene, all);
  EXPECT_TRUE(merged.ok());
  return std::move(merged).value();
}

TEST(Merge, PutsObjectsInTheOrderAskedForIntoTheWorld) {
  const Scene scene = two_triangles();
  const std::vector<std::uint32_t> objects{1, 0};
  const Result<MergedMesh> result = merge(scene, objects);
  ASSERT_TRUE(result.ok());
  const MergedMesh& merged = result.value();
  EXPECT_TRUE(validate(merged.mesh.view()).ok());
  ASSERT_EQ(merged.mesh.triangles.size(), 2u);
  EXPECT_EQ(merged.mesh.view().corner(0, 1), glm::vec3(11, 0, 0));
  EXPECT_EQ(merged.mesh.view().corner(1, 1), glm::vec3(1, 0, 0));
  EXPECT_EQ(merged.facet_objects, (std::vector<std::uint32_t>{0, 1}));
  EXPECT_EQ(merged.objects[0].object, 1u);
  EXPECT_EQ(merged.objects[1].first_facet, 1u);
  EXPECT_EQ(merged.objects[1].first_vertex, 4u);
  EXPECT_EQ(merged.facet_in_object(1), 0u);
  EXPECT_EQ(merged.mesh.facet_materials, (std::vector<std::uint32_t>{1, 0}));
  EXPECT_EQ(merged.mesh.materials.size(), 2u);
}

// In double and rounded once: 2^24 + 1 is no float, and would be lost before the second shift takes it back.
TEST(Merge, RoundsOnce) {
  Scene scene = two_triangles();
  scene.objects[0].world[3] = glm::dvec4(0x1p24 + 1, 0, 0, 1);
  scene.meshes[0].positions[0].x = -0x1p24f;
  EXPECT_EQ(merged_all(scene).mesh.positions[0].x, 1.0f);
}

TEST(Merge, KeepsTheWindingOfMirroredObjects) {
  Scene scene = two_triangles();
  scene.objects[1].world[0] = glm::dvec4(-1, 0, 0, 0);
  const MergedMesh merged = merged_all(scene);
  EXPECT_FALSE(merged.objects[0].is_mirrored);
  EXPECT_TRUE(merged.objects[1].is_mirrored);
  for (std::size_t f = 0; f < 2; ++f) {
    const glm::vec3 a = merged.mesh.view().corner(f, 0), b = merged.mesh.view().corner(f, 1);
    EXPECT_GT(glm::cross(b - a, merged.mesh.view().corner(f, 2) - a).z, 0) << f;  // towards +z still
  }
}

TEST(Merge, FillsUpWithWhite) {
  Scene scene = two_triangles();
  scene.meshes[1].vertex_colours.assign(4, glm::vec4(0.5f));
  const MergedMesh merged = merged_all(scene);
  EXPECT_TRUE(merged.mesh.facet_colours.empty());
  ASSERT_EQ(merged.mesh.vertex_colours.size(), 8u);
  EXPECT_EQ(merged.mesh.vertex_colours[0], glm::vec4(1));
  EXPECT_EQ(merged.mesh.vertex_colours[4], glm::vec4(0.5f));
}

TEST(Merge, KeepsFacetColoursWhereNoneBelongsToVertices) {
  Scene scene = two_triangles();
  scene.meshes[1].facet_colours = {glm::vec4(0.25f)};
  const MergedMesh merged = merged_all(scene);
  EXPECT_EQ(merged.mesh.facet_colours, (std::vector<glm::vec4>{glm::vec4(1), glm::vec4(0.25f)}));
  EXPECT_TRUE(merged.mesh.vertex_colours.empty());
}

TEST(Merge, SplitsCornersToCarryFacetColoursBesideThoseOfVertices) {
  Scene scene = two_triangles();
  scene.meshes[0].vertex_colours.assign(4, glm::vec4(0.5f));
  scene.meshes[1].facet_colours = {glm::vec4(0.25f)};
  MergedMesh merged = merged_all(scene);
  EXPECT_TRUE(validate(merged.mesh.view()).ok());
  EXPECT_TRUE(merged.objects[1].has_split_corners);
  EXPECT_EQ(merged.objects[1].vertex_count, 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(merged.mesh.vertex_colours[merged.mesh.triangles[1][i]], glm::vec4(0.25f));
  scene.objects[1].world[3].y = 7;
  ASSERT_TRUE(update(merged, scene, 1).ok());
  EXPECT_EQ(merged.mesh.view().corner(1, 2), glm::vec3(10, 8, 0));
}

TEST(Merge, GivesCoordinatesWhereSomeMaterialHasATexture) {
  Scene scene = two_triangles();
  EXPECT_TRUE(merged_all(scene).mesh.texture_coordinates.empty());
  scene.textures.push_back({.width = 1, .height = 1, .texels = {glm::vec4(1)}});
  scene.materials[1].material.texture = 0;
  scene.meshes[1].texture_coordinates.assign(4, glm::vec2(0.5f, 0.25f));
  const MergedMesh merged = merged_all(scene);
  ASSERT_EQ(merged.mesh.texture_coordinates.size(), 8u);
  EXPECT_EQ(merged.mesh.texture_coordinates[0], glm::vec2(0));
  EXPECT_EQ(merged.mesh.texture_coordinates[5], glm::vec2(0.5f, 0.25f));
  EXPECT_EQ(merged.mesh.textures.size(), 1u);
  EXPECT_TRUE(validate(merged.mesh.view()).ok());
}

TEST(Merge, UpdateIsAsIfMergedAnew) {
  Scene scene = random_scene(12, 2, 1);
  MergedMesh merged = merged_all(scene);
  scene.objects[3].world[3] += glm::dvec4(0.25, -1, 2, 0);
  scene.objects[5].world[1] *= -1.0;  // mirrors it, or unmirrors it
  ASSERT_TRUE(update(merged, scene, 3).ok());
  ASSERT_TRUE(update(merged, scene, 5).ok());
  const MergedMesh anew = merged_all(scene);
  EXPECT_EQ(merged.mesh.positions, anew.mesh.positions);
  EXPECT_EQ(merged.mesh.triangles, anew.mesh.triangles);
  EXPECT_EQ(merged.objects[5].is_mirrored, anew.objects[5].is_mirrored);
}

TEST(Merge, UpdateTakesPositionsThatTheSceneDoesNotHave) {
  const Scene scene = two_triangles();
  MergedMesh merged = merged_all(scene);
  const std::vector<glm::vec3> bent{{0, 0, 1}, {1, 0, 2}, {0, 1, 3}, {0, 0, 0}};
  ASSERT_TRUE(update(merged, scene, 1, bent).ok());
  EXPECT_EQ(merged.mesh.view().corner(1, 1), glm::vec3(11, 0, 2));
  EXPECT_EQ(merged.mesh.view().corner(0, 1), glm::vec3(1, 0, 0));
}

TEST(Merge, RefusesPlacesBeyondFloat) {
  Scene scene = two_triangles();
  MergedMesh merged = merged_all(scene);
  const std::vector<glm::vec3> before = merged.mesh.positions;
  scene.objects[1].world[3].x = 1e39;
  EXPECT_EQ(update(merged, scene, 1).fault, Fault::non_finite_position);
  EXPECT_EQ(merged.mesh.positions, before);
  const std::vector<std::uint32_t> objects{0, 1};
  const Result<MergedMesh> refused = merge(scene, objects);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.status().fault, Fault::non_finite_position);
  EXPECT_NE(refused.status().message.find("object 1"), std::string::npos);
}

// What no facet uses is not looked at.
TEST(Merge, LetsUnusedVerticesBe) {
  Scene scene = two_triangles();
  scene.meshes[0].positions[3].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(validate(merged_all(scene).mesh.view()).ok());
}

}  // namespace
}  // namespace facetsort
