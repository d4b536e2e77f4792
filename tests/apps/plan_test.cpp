// facetsort plan, and the strategy auto.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/run_program.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

TEST(Plan, TellsWhatEachMeshNeedsAndWhatNot) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(500));
  const Finished finished =
      run_program({"plan", box, knot, "--json", "--size", "48", "--frames", "10", "--views", "2"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json json = Json::parse(finished.output);
  EXPECT_EQ(json.at("frames"), 10);
  EXPECT_EQ(json.at("views"), 2);
  ASSERT_EQ(json.at("meshes").size(), 2u);
  const Json convex = json["meshes"][0].at("plan"), curved = json["meshes"][1].at("plan");
  EXPECT_EQ(json["meshes"][0].at("mesh"), box);
  EXPECT_EQ(convex.at("strategy"), "separate_culling_pass");
  EXPECT_EQ(convex.at("certainty"), "proved");
  EXPECT_EQ(convex.at("convex_closed_components"), 1);
  EXPECT_TRUE(convex.at("timed").empty());
  EXPECT_EQ(curved.at("layers_that_matter"), 9);
  EXPECT_FALSE(curved.at("timed").empty());
  const auto presorting = [](const Json& left) { return left.at("what") == "presorting"; };
  EXPECT_TRUE(std::any_of(curved.at("left_out").begin(), curved.at("left_out").end(), presorting));
}

TEST(Plan, TheTextSaysTheSame) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const Finished finished = run_program({"plan", box});
  ASSERT_EQ(finished.status, 0) << finished.error;
  for (const char* text : {"separate_culling_pass, proved: closed, wound outwards and convex", "left out", "sorting",
                           "planned in", "the nearest 9"}) {
    EXPECT_NE(finished.output.find(text), std::string::npos) << text << '\n' << finished.output;
  }
}

TEST(Plan, TakesScenes) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "scene");
  const Status first = write_ply(folder.path() / "scene" / "a.ply", shapes::box().view());
  const Mesh knot = shapes::torus_knot(shapes::fewest_knot_facets);
  const Status second = write_ply(folder.path() / "scene" / "b.ply", knot.view());
  ASSERT_TRUE(first.ok() && second.ok());
  const Finished finished = run_program({"plan", (folder.path() / "scene").string(), "--json", "--size", "48"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json scene = Json::parse(finished.output).at("meshes").at(0);
  EXPECT_EQ(scene.at("blended_objects"), 2);
  EXPECT_EQ(scene.at("most_overlapping_objects"), 2);
  ASSERT_EQ(scene.at("objects").size(), 2u);
  EXPECT_EQ(scene["objects"][0].at("strategy"), "separate_culling_pass");
  EXPECT_NE(scene["objects"][1].at("strategy"), "separate_culling_pass");
}

TEST(Plan, SaysHowOftenAnOrbitKeepsAnOrder) {
  const TemporaryFolder folder;
  const std::string shells = write_mesh(folder, "shells.ply", shapes::nested_shells(2, 0.5f, 1));
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  std::size_t kept_before = 1000;
  for (const char* degrees : {"0.25", "20"}) {
    const Finished finished = run_program({"plan", shells, box, "--orbit", degrees, "--json", "--size", "32"});
    ASSERT_EQ(finished.status, 0) << finished.error;
    const Json json = Json::parse(finished.output);
    EXPECT_EQ(json.at("orbit_degrees"), std::stod(degrees));
    const Json turned = json.at("meshes").at(0).at("orbit"), convex = json.at("meshes").at(1).at("orbit");
    const std::size_t frames = degrees == std::string("20") ? 18 : 1440;
    EXPECT_EQ(turned.at("frames"), frames);
    EXPECT_LT(turned.at("kept"), frames);  // the first is never kept
    EXPECT_EQ(convex.at("kept").get<std::size_t>() + convex.at("unsorted").get<std::size_t>(), frames);
    const std::size_t kept = turned.at("kept").get<std::size_t>() * 1000 / frames;
    EXPECT_LT(kept, kept_before);
    kept_before = kept;
  }
  EXPECT_NE(run_program({"plan", box, "--orbit", "90"}).output.find("4 of a turn of 360 degrees"), std::string::npos);
  const std::string scene = (folder.path() / "scene").string();
  std::filesystem::create_directory(scene);
  std::filesystem::copy(box, scene);
  const Finished finished = run_program({"plan", scene, "--orbit", "0.05", "--json", "--size", "32"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(Json::parse(finished.output).at("meshes").at(0).at("orbit").at("frames"), 3600);
}

TEST(Plan, AddedColoursAreNotSorted) {
  const TemporaryFolder folder;
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(500));
  const Finished finished = run_program({"plan", knot, "--additive"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_NE(finished.output.find("additive, proved: colours are added"), std::string::npos) << finished.output;
}

TEST(Plan, RefusesWithOneLine) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::string broken = (folder.path() / "broken.ply").string();
  std::ofstream(broken) << "no mesh\n";
  const std::vector<std::vector<std::string>> wrong{{"plan"},
                                                    {"plan", box, "--budget", "2"},
                                                    {"plan", box, "--budget", "x"},
                                                    {"plan", box, "--frames", "0"},
                                                    {"plan", box, "--orbit", "0"},
                                                    {"plan", box, "--orbit", "x"},
                                                    {"plan", "absent"},
                                                    {"plan", box, "--size", "0"},
                                                    {"plan", broken}};
  for (const std::vector<std::string>& arguments : wrong) {
    const Finished finished = run_program(arguments);
    EXPECT_EQ(finished.status, 2) << arguments.back();
    EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
    EXPECT_TRUE(finished.output.empty());
  }
}

TEST(Auto, DrawsWhatThePlanChose) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::string picture = (folder.path() / "auto.png").string(), other = (folder.path() / "culled.png").string();
  const Finished finished =
      run_program({"blend", box, "--strategy", "auto", "--eye", "3,4,5", "--size", "48", "-o", picture, "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(Json::parse(finished.output).at("passes"), 2);
  const Finished culled =
      run_program({"blend", box, "--strategy", "separate_culling_pass", "--eye", "3,4,5", "--size", "48", "-o", other});
  ASSERT_EQ(culled.status, 0) << culled.error;
  EXPECT_TRUE(file_bytes(picture) == file_bytes(other));
}

TEST(Auto, IsComparedAsAnyStrategy) {
  const TemporaryFolder folder;
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(500));
  const Finished finished =
      run_program({"compare", knot, "--strategies", "auto,auto:0.01,unsorted", "--views", "2", "--size", "48",
                   "--repeats", "1", "--out", (folder.path() / "report").string(), "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  std::size_t seen = 0;
  const Json report = Json::parse(finished.output);
  for (const Json& row : report.at("rows")) {
    if (row.at("strategy") == "auto") {
      EXPECT_EQ(row.at("wrong_pixels"), 0);
    }
    if (row.at("strategy") == "auto:0.01") {
      EXPECT_LE(row.at("wrong_rate"), 0.01);
    }
    if (row.at("strategy") == "unsorted") {
      EXPECT_GT(row.at("wrong_pixels"), 0);
    }
    seen += row.at("strategy") != "unsorted";
  }
  EXPECT_EQ(seen, 4u);
}

}  // namespace
}  // namespace facetsort
