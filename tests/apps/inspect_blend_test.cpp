// facetsort inspect, facetsort blend.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/run_program.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

TEST(Inspect, TellsTheFactsOfEachMesh) {
  const TemporaryFolder folder;
  const std::string shells = write_mesh(folder, "shells.ply", shapes::nested_shells(3, 0.2f, 2));
  const std::string pair = write_mesh(folder, "pair.ply", shapes::interpenetrating(2));
  const Finished finished = run_program({"inspect", shells, pair, "--json", "--size", "64"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json meshes = Json::parse(finished.output).at("meshes");
  ASSERT_EQ(meshes.size(), 2u);

  EXPECT_EQ(meshes[0].at("mesh"), shells);
  EXPECT_EQ(meshes[0].at("facets"), 3 * 320);
  EXPECT_EQ(meshes[0].at("components"), 3);
  EXPECT_EQ(meshes[0].at("closed"), true);
  EXPECT_EQ(meshes[0].at("oriented"), true);
  EXPECT_EQ(meshes[0].at("convex_closed_components"), 3);
  EXPECT_EQ(meshes[0].at("intersecting_pairs"), 0);
  EXPECT_TRUE(meshes[0].at("first_intersecting").is_null());
  // Rays that meet all three shells pass six facets; those near the silhouette, fewer.
  EXPECT_EQ(meshes[0].at("layers").at("most"), 6);
  EXPECT_EQ(meshes[0].at("layers").at("percentile_99_5"), 6);
  EXPECT_GT(meshes[0].at("layers").at("mean"), 2.0);
  EXPECT_LT(meshes[0].at("layers").at("mean"), 6.0);

  EXPECT_GT(meshes[1].at("intersecting_pairs"), 0);
  EXPECT_EQ(meshes[1].at("first_intersecting").size(), 2u);
}

TEST(Inspect, TheTableSaysTheSame) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const Finished finished = run_program({"inspect", box, "--size", "32"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  for (const char* line : {"facets               12\n", "closed               yes\n", "intersecting pairs   0\n",
                           "convex closed parts  1, of 12 facets\n", "2 at most\n"}) {
    EXPECT_NE(finished.output.find(line), std::string::npos) << line << finished.output;
  }
}

TEST(Blend, DrawsTheSamePictureOnAnyNumberOfThreads) {
  const TemporaryFolder folder;
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(2000));
  // Files are too long to be shown where they differ, so they are compared as true or false.
  const auto picture = [&](const std::string& strategy, const std::string& threads) {
    const std::string path = (folder.path() / ("picture" + threads + ".png")).string();
    const Finished finished = run_program(
        {"blend", knot, "--strategy", strategy, "--eye", "1,2,3", "--size", "96x64", "-o", path, "--threads", threads});
    EXPECT_EQ(finished.status, 0) << finished.error;
    return file_bytes(path);
  };
  const std::string reference = picture("reference", "1");
  EXPECT_TRUE(reference == picture("reference", "3"));
  const std::string unsorted = picture("unsorted", "1");
  EXPECT_TRUE(unsorted == picture("unsorted", "3"));
  EXPECT_TRUE(unsorted != reference);
}

TEST(Blend, ANumberOutOfRangeIsOneLineThatTellsTheRange) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::string path = (folder.path() / "picture.png").string();
  for (const char* name : {"moment_based:5", "multi_layer:0", "stochastic:x", "depth_peeling:-1"}) {
    const Finished finished = run_program({"blend", box, "--strategy", name, "--eye", "1,2,3", "-o", path});
    EXPECT_EQ(finished.status, 2);
    EXPECT_NE(finished.error.find("no strategy is named '" + std::string(name) + "'"), std::string::npos);
    EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
    for (const char* range : {"moment_based:4|6", "multi_layer:1..64", "stochastic:1..64", "depth_peeling:1..1000"}) {
      EXPECT_NE(finished.error.find(range), std::string::npos) << finished.error;
    }
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(Blend, TellsPassesAndMemoryOfAStrategy) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::string path = (folder.path() / "picture.png").string();
  const Finished finished = run_program(
      {"blend", box, "--strategy", "moment_based:6", "--eye", "1,2,3", "--size", "32", "-o", path, "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json json = Json::parse(finished.output);
  EXPECT_EQ(json.at("strategy"), "moment_based:6");
  EXPECT_EQ(json.at("passes"), 2);
  EXPECT_EQ(json.at("bytes_per_pixel"), 44);
}

TEST(Blend, OptionsOfTheViewChangeThePicture) {
  const TemporaryFolder folder;
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(1000));
  const auto picture = [&](const std::vector<std::string>& options) {
    const std::string path = (folder.path() / "picture.png").string();
    std::vector<std::string> arguments{"blend", knot, "--strategy", "reference", "--size", "48", "-o", path};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const Finished finished = run_program(arguments);
    EXPECT_EQ(finished.status, 0) << finished.error;
    return file_bytes(path);
  };
  const std::string plain = picture({"--eye", "1,2,3"});
  EXPECT_TRUE(plain == picture({"--eye", "1,2,3", "--up", "0,1,0", "--fov", "45"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3.1"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--at", "0.1,0,0"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--up", "1,0,0"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--fov", "40"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--ortho"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--near", "3.5"}));
  EXPECT_TRUE(plain != picture({"--eye", "1,2,3", "--format", "rgba8"}));
}

TEST(Blend, UnwritablePictureLeavesNothing) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::filesystem::path missing = folder.path() / "missing", taken = folder.path() / "taken.png";
  std::filesystem::create_directory(taken);
  for (const std::filesystem::path& path : {missing / "picture.png", taken}) {
    const Finished finished =
        run_program({"blend", box, "--strategy", "unsorted", "--eye", "1,2,5", "--size", "16", "-o", path.string()});
    EXPECT_EQ(finished.status, 2);
    EXPECT_NE(finished.error.find(path.string()), std::string::npos) << finished.error;
  }
  EXPECT_FALSE(std::filesystem::exists(missing));
  EXPECT_TRUE(std::filesystem::is_empty(taken));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);  // the mesh and `taken`
}

}  // namespace
}  // namespace facetsort
