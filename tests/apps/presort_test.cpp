// facetsort presort writes files that order, blend and check take in place of a mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/run_program.h"
#include "facetsort/order/presorted_mesh.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

const std::vector<std::string> view{"--eye", "1,2,5"};

std::vector<std::string> with_view(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), view.begin(), view.end());
  return arguments;
}

TEST(PresortVerb, WritesAFileWhoseOrdersAreRight) {
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "mesh.ply", shapes::slab_cycle(4));
  const std::string presorted = (folder.path() / "mesh.fsort").string();
  const std::string order = (folder.path() / "order.ply").string();
  const Finished made = run_program({"presort", mesh, "-o", presorted, "--json"});
  ASSERT_EQ(made.status, 0) << made.error;
  const Json document = Json::parse(made.output);
  ASSERT_EQ(document.size(), 1u);
  const Result<PresortedMesh> file = PresortedMesh::open(presorted);
  ASSERT_TRUE(file.ok()) << file.status().message;
  EXPECT_EQ(document[0]["triangles_out"], file.value().view().triangles.size());
  EXPECT_EQ(document[0]["file_bytes"], std::filesystem::file_size(presorted));
  EXPECT_GT(document[0]["peak_memory_bytes"], 0);

  const Finished ordered = run_program(with_view({"order", presorted, "--method", "presorted", "-o", order, "--json"}));
  ASSERT_EQ(ordered.status, 0) << ordered.error;
  EXPECT_EQ(Json::parse(ordered.output)["exact"]["triangles"], document[0]["triangles_out"]);
  for (const std::string& drawn : {mesh, presorted}) {
    const Finished checked = run_program(with_view({"check", drawn, "--order", order, "--size", "128"}));
    EXPECT_EQ(checked.status, 0) << checked.output << checked.error;
  }
}

TEST(PresortVerb, BlendsTheSamePictureFromTheFileAsFromTheMesh) {
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "mesh.ply", shapes::triangle_cycle(5));
  const std::string presorted = (folder.path() / "mesh.fsort").string();
  ASSERT_EQ(run_program({"presort", mesh, "-o", presorted}).status, 0);
  std::vector<std::string> pictures;
  for (const std::string& drawn : {mesh, presorted}) {
    const std::string picture = (folder.path() / ("picture" + std::to_string(pictures.size()) + ".png")).string();
    const Finished finished =
        run_program(with_view({"blend", drawn, "--strategy", "facet_sort:presorted", "--size", "64", "-o", picture}));
    ASSERT_EQ(finished.status, 0) << finished.error;
    pictures.push_back(file_bytes(picture));
  }
  EXPECT_TRUE(pictures[0] == pictures[1]);
}

TEST(PresortVerb, FillsAFolderWithTheSameBytesForAnyThreadCount) {
  const TemporaryFolder folder;
  const std::string one = write_mesh(folder, "one.ply", shapes::torus_knot(5000)),
                    two = write_mesh(folder, "two.ply", shapes::box());
  std::vector<std::string> files;
  for (const std::string threads : {"1", "2", "8"}) {
    const std::filesystem::path output = folder.path() / "out" / threads;
    const Finished finished = run_program({"presort", one, two, "-o", output.string(), "--threads", threads});
    ASSERT_EQ(finished.status, 0) << finished.error;
    EXPECT_TRUE(std::filesystem::exists(output / "two.fsort"));
    files.push_back(file_bytes(output / "one.fsort"));
  }
  EXPECT_TRUE(files[0] == files[1] && files[0] == files[2]);
}

TEST(PresortVerb, MakesIndexBuffersAsFsortAndAsGltf) {
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "mesh.ply", shapes::icosphere(1));
  const std::string file = (folder.path() / "mesh.fsort").string(), gltf = (folder.path() / "mesh.glb").string();
  for (const std::string& output : {file, gltf}) {
    const Finished made = run_program({"presort", mesh, "--buffers", "2", "-o", output, "--json"});
    ASSERT_EQ(made.status, 0) << made.error;
    const Json document = Json::parse(made.output)[0];
    EXPECT_EQ(document["triangles_out"], document["facets"]);
    EXPECT_GE(document["worst_inverted_rate"], document["mean_inverted_rate"]);
  }
  const Result<PresortedMesh> presorted = PresortedMesh::open(file);
  ASSERT_TRUE(presorted.ok()) << presorted.status().message;
  ASSERT_NE(presorted.value().index_buffers(), nullptr);
  EXPECT_EQ(presorted.value().index_buffers()->buffer_count, 2u);
  EXPECT_EQ(file_bytes(gltf).substr(0, 4), "glTF");
  const std::string picture = (folder.path() / "picture.png").string();
  const Finished drawn = run_program(
      with_view({"blend", file, "--strategy", "presorted_buffers:2", "--size", "32", "-o", picture}));
  EXPECT_EQ(drawn.status, 0) << drawn.error;
}

TEST(PresortVerb, TellsWhereTheErrorIsOutOfReach) {
  const TemporaryFolder folder;
  const std::string knot = write_mesh(folder, "knot.ply", shapes::torus_knot(500));
  const std::string output = (folder.path() / "knot.fsort").string();
  const Finished missed =
      run_program({"presort", knot, "--buffers", "2", "--max-error", "0", "-o", output, "--json"});
  EXPECT_EQ(missed.status, 1) << missed.error;
  const Json told = Json::parse(missed.output);
  EXPECT_EQ(told.at(0).at("buffers"), 2);
  EXPECT_EQ(told.at(0).at("misses_max_error"), true);
  EXPECT_TRUE(std::filesystem::exists(output));
  EXPECT_EQ(run_program({"presort", knot, "--buffers", "2", "--max-error", "1", "-o", output}).status, 0);
}

TEST(PresortVerb, GoesOnAfterABadMesh) {
  const TemporaryFolder folder;
  const std::string absent = (folder.path() / "absent.ply").string();
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const Finished finished = run_program({"presort", absent, box, "-o", (folder.path() / "out").string()});
  EXPECT_EQ(finished.status, 2);
  EXPECT_TRUE(finished.error.starts_with("facetsort: " + absent + ": ")) << finished.error;
  EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / "box.fsort"));
}

TEST(PresortVerb, RefusesWhatItCannotDoInOneLineAndWritesNothing) {
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "mesh.ply", shapes::slab_cycle(4));
  const std::string again = write_mesh(folder, "mesh.obj", shapes::slab_cycle(4));
  const std::string presorted = (folder.path() / "mesh.fsort").string();
  const auto expect_refused = [&](const std::vector<std::string>& arguments, const std::string& told) {
    const Finished finished = run_program(arguments);
    EXPECT_EQ(finished.status, 2);
    EXPECT_NE(finished.error.find(told), std::string::npos) << finished.error;
    EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
    EXPECT_FALSE(std::filesystem::exists(presorted));
  };
  expect_refused({"presort", mesh, "-o", presorted, "--max-growth", "1"}, "--max-growth");
  expect_refused({"presort", mesh, "-o", (folder.path() / "mesh.u32").string()}, ".fsort");
  expect_refused({"presort", mesh + ".missing", "-o", presorted}, "missing");
  expect_refused({"presort", mesh, again, "-o", (folder.path() / "out").string()}, "mesh.fsort");
  expect_refused({"presort", mesh, "-o", presorted, "--effort", "0"}, "--effort");
  expect_refused({"presort", mesh, "-o", presorted, "--cut"}, "--cut");
  expect_refused({"presort", mesh, "-o", presorted, "--max-error", "2"}, "--max-error");
  folder.write("damaged.fsort", "facetsort");
  expect_refused({"inspect", (folder.path() / "damaged.fsort").string()}, "damaged.fsort");
}

}  // namespace
}  // namespace facetsort
