// Scenes where verbs take meshes.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "apps/run_program.h"
#include "facetsort/mesh/read.h"
#include "facetsort/scene/read_scene.h"
#include "facetsort/scene/scene_sorter.h"
#include "facetsort/scene/write_scene.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

// A transparent sphere around an opaque box, and another sphere behind, single-sided.
Scene spheres_and_box() {
  Scene scene;
  scene.materials = {{.material = {.base_colour = {0, 0, 1, 1}, .alpha_mode = AlphaMode::opaque}},
                     {.material = {.base_colour = {1, 0, 0, 0.5f}, .double_sided = false}}};
  const auto add_mesh = [&](const Mesh& mesh, std::uint32_t material) {
    SceneMesh added;
    added.positions = mesh.positions;
    added.triangles = mesh.triangles;
    added.material = material;
    scene.meshes.push_back(std::move(added));
  };
  add_mesh(shapes::box(), 0);
  add_mesh(shapes::nested_shells(1, 0.1f, 2), 1);
  glm::dmat4 large(2), behind(1);
  large[3][3] = 1;
  behind[3] = {0, 0, -4, 1};
  scene.objects = {{.mesh = 0}, {.mesh = 1, .world = large}, {.mesh = 1, .world = behind}};
  return scene;
}

std::string write_scene_file(const TemporaryFolder& folder, const std::string& name, const Scene& scene) {
  const std::string path = (folder.path() / name).string();
  const Status status = write_scene(path, scene);
  if (!status.ok()) throw std::runtime_error(status.message);
  return path;
}

TEST(Scenes, AreComparedByEnginesOrdersToo) {
  const TemporaryFolder folder;
  const std::string path = write_scene_file(folder, "things.glb", spheres_and_box());
  const std::string report = (folder.path() / "report").string();
  const Finished finished =
      run_program({"compare", path, "--views", "2", "--size", "96", "--repeats", "1", "--out", report, "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  std::map<std::string, std::size_t> wrong;
  const Json results = Json::parse(finished.output);
  for (const Json& row : results.at("rows")) {
    EXPECT_EQ(row.at("mesh"), "things");
    EXPECT_EQ(row.at("facets"), 12 + 2 * 320);
    wrong[row.at("strategy")] += row.at("wrong_pixels").get<std::size_t>();
    EXPECT_TRUE(row.at("strategy") != "facet_sort:exact" || row.at("inverted_pixels").is_null());
  }
  // Convex objects of one side each: a sort of objects is enough, index order is not.
  for (const char* right : {"facet_sort:exact", "facet_sort:presorted", "depth_peeling", "draw_order:three",
                            "draw_order:babylon", "draw_order:galacean", "draw_order:panda3d", "reference"}) {
    ASSERT_EQ(wrong.count(right), 1u) << right;
    EXPECT_EQ(wrong[right], 0u) << right;
  }
  EXPECT_GT(wrong["unsorted"], 100u);
}

TEST(Scenes, AreWrittenInDrawOrder) {
  const TemporaryFolder folder;
  const Scene scene = spheres_and_box();
  const std::string path = write_scene_file(folder, "things.glb", scene);
  for (const char* name : {"ordered.glb", "ordered.gltf"}) {
    const std::string output = (folder.path() / name).string();
    const Finished finished =
        run_program({"order", path, "--eye", "1,2,8", "--method", "exact", "-o", output, "--json"});
    ASSERT_EQ(finished.status, 0) << finished.error;
    const Json told = Json::parse(finished.output);
    EXPECT_EQ(told.at("blended_objects"), 2);
    EXPECT_EQ(told.at("facets"), 2 * 320);
    EXPECT_EQ(told.at("cut_facets"), 0);
    EXPECT_EQ(told.at("draws"), 2);  // one behind the other
    ASSERT_EQ(told.at("choices").size(), 3u);
    EXPECT_EQ(told.at("choices")[0].at("choice"), "whole_objects");

    const Result<Scene> read = read_scene(output);
    ASSERT_TRUE(read.ok()) << read.status().message;
    ASSERT_EQ(read.value().objects.size(), scene.objects.size());
    EXPECT_EQ(read.value().mesh_of(0).triangles, scene.meshes[0].triangles);  // opaque
    auto sorter = SceneSorter::create(scene, blended_objects(scene));
    ASSERT_TRUE(sorter.ok());
    const SceneOrder order = sorter.value().sort({.eye = {1, 2, 8, 1}});
    const std::vector<ObjectOrder> orders = object_orders(scene, sorter.value().merged(), order.facets);
    for (std::uint32_t object = 1; object < 3; ++object) {
      SCOPED_TRACE(object);
      const std::vector<glm::uvec3>& found = read.value().mesh_of(object).triangles;
      ASSERT_EQ(found.size(), 320u);
      for (std::size_t i = 0; i < found.size(); ++i) {
        ASSERT_EQ(found[i], scene.mesh_of(object).triangles[orders[object][i]]) << i;
      }
      EXPECT_NE(found, scene.mesh_of(object).triangles);
    }
  }
  // A mesh is a scene of one object.
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(600));
  const std::string output = (folder.path() / "knot.glb").string();
  ASSERT_EQ(run_program({"order", knot, "--eye", "1,2,8", "-o", output}).status, 0);
  EXPECT_EQ(read_scene(output).value().meshes[0].triangles.size(), read_mesh(knot).value().triangles.size());
}

TEST(Scenes, FoldersOfMeshesAreScenes) {
  const TemporaryFolder folder, scene;
  write_mesh(scene, "a.ply", shapes::box());
  write_mesh(scene, "b.ply", shapes::torus_knot(600));
  const std::string picture = (folder.path() / "a.png").string();
  const Finished finished = run_program({"blend", scene.path().string(), "--strategy", "draw_order:three", "--eye",
                                         "1,2,6", "--size", "32", "-o", picture, "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(Json::parse(finished.output).at("passes"), 4);  // back and front faces of two objects
  EXPECT_GT(std::filesystem::file_size(picture), 100u);
}

TEST(Scenes, BadOnesGetOneLine) {
  const TemporaryFolder folder;
  const std::string picture = (folder.path() / "a.png").string();
  const auto blend = [&](const std::string& input, const std::string& strategy) {
    const Finished finished = run_program({"blend", input, "--strategy", strategy, "--eye", "1,2,6", "-o", picture});
    EXPECT_EQ(finished.status, 2);
    EXPECT_FALSE(std::filesystem::exists(picture));
    return finished.error;
  };
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  EXPECT_EQ(blend(box, "draw_order:three"),
            "facetsort: " + box + ": draw_order:three orders the objects of a scene, and this is a mesh\n");
  const std::string damaged = folder.write("damaged.glb", "glTF").string();
  const std::string line = blend(damaged, "unsorted");
  EXPECT_TRUE(line.starts_with("facetsort: " + damaged + ": ")) << line;
  EXPECT_EQ(line.find('\n'), line.size() - 1) << line;
  // Verbs whose files have no room for materials take meshes alone.
  const std::string scene = write_scene_file(folder, "things.glb", spheres_and_box());
  const Finished presort = run_program({"presort", scene, "-o", (folder.path() / "a.fsort").string()});
  EXPECT_EQ(presort.status, 2);
  EXPECT_TRUE(presort.error.starts_with("facetsort: " + scene + ": ")) << presort.error;
  const Finished order =
      run_program({"order", scene, "--eye", "1,2,8", "-o", (folder.path() / "a.u32").string()});
  EXPECT_EQ(order.status, 2);
  EXPECT_EQ(order.error, "facetsort: " + scene + ": a scene, whose order needs a .glb or .gltf as output\n");
  const std::string sorted = (folder.path() / "sorted.glb").string();
  Scene opaque = spheres_and_box();
  opaque.materials[1].material.alpha_mode = AlphaMode::opaque;
  const std::string stones = write_scene_file(folder, "stones.glb", opaque);
  EXPECT_EQ(run_program({"order", stones, "--eye", "1,2,8", "-o", sorted}).error,
            "facetsort: " + stones + ": no object is blended: there is nothing to sort\n");
  EXPECT_FALSE(std::filesystem::exists(sorted));
}

}  // namespace
}  // namespace facetsort
