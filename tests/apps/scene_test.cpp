// Scenes where verbs take meshes.
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

#include "apps/run_program.h"
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
}

}  // namespace
}  // namespace facetsort
