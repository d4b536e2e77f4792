// facetsort order writes permutations; facetsort check tells right ones from wrong ones and from damaged ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "apps/run_program.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "facetsort/mesh/read.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;
using Json = nlohmann::json;

constexpr glm::vec3 eye{1, 2, 5};
const std::string eye_text = "1,2,5";

Ids ids_of(const std::string& bytes) {
  Ids ids(bytes.size() / 4);
  for (std::size_t i = 0; i < 4 * ids.size(); ++i)
    ids[i / 4] |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << 8 * (i % 4);
  return ids;
}

std::string bytes_of(const Ids& ids) {
  std::string bytes;
  for (const std::uint32_t id : ids) {
    for (const unsigned shift : {0u, 8u, 16u, 24u}) bytes += static_cast<char>(id >> shift & 0xff);
  }
  return bytes;
}

// A mesh on disk, its order, and checks of variants of it.
class OrderOf {
 public:
  explicit OrderOf(Mesh mesh, std::vector<std::string> view = {}) : mesh_(std::move(mesh)), view_(std::move(view)) {
    path_ = write_mesh(folder_, "mesh.ply", mesh_);
  }

  std::string order(const std::string& name, const std::vector<std::string>& more = {}) const {
    const std::string output = (folder_.path() / name).string();
    const Finished finished = run({"order", path_, "-o", output}, more);
    EXPECT_EQ(finished.status, 0) << finished.error;
    return output;
  }
  Ids ids(const std::vector<std::string>& more = {}) const { return ids_of(file_bytes(order("order.u32", more))); }
  Finished check_file(const std::string& order) const {
    return run({"check", path_, "--order", order, "--size", "128", "--json"}, {});
  }
  Finished check_bytes(const std::string& bytes) const {
    return check_file(folder_.write("given.u32", bytes).string());
  }
  Finished check(const Ids& ids) const { return check_bytes(bytes_of(ids)); }
  const Mesh& mesh() const { return mesh_; }
  const TemporaryFolder& folder() const { return folder_; }

 private:
  Finished run(std::vector<std::string> arguments, const std::vector<std::string>& more) const {
    arguments.insert(arguments.end(), {"--eye", eye_text});
    arguments.insert(arguments.end(), view_.begin(), view_.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program(arguments);
  }

  TemporaryFolder folder_;
  Mesh mesh_;
  std::vector<std::string> view_;
  std::string path_;
};

// The farthest and the nearest facet of the pixel in which they are farthest apart.
std::pair<std::uint32_t, std::uint32_t> overlapping_facets(const Mesh& mesh, Projection projection) {
  View view = default_view(facet_bounds(mesh.view()), eye, projection);
  view.width = view.height = 128;
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  std::pair<std::uint32_t, std::uint32_t> facets;
  double largest = 0;
  for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
    const auto fragments = lists.pixel(pixel);
    if (fragments.empty() || fragments.front().depth - fragments.back().depth <= largest) continue;
    largest = fragments.front().depth - fragments.back().depth;
    facets = {fragments.front().facet, fragments.back().facet};
  }
  EXPECT_GT(largest, 0);
  return facets;
}

Ids swapped(Ids ids, std::uint32_t a, std::uint32_t b) {
  std::iter_swap(std::find(ids.begin(), ids.end(), a), std::find(ids.begin(), ids.end(), b));
  return ids;
}

struct ExpectedFault {
  const char* name;
  std::size_t count;
  std::uint32_t first;
};

void expect_not_a_permutation(const Finished& finished, const std::vector<ExpectedFault>& faults) {
  EXPECT_EQ(finished.status, 1) << finished.error;
  const Json document = Json::parse(finished.output);
  EXPECT_EQ(document.at("right"), false);
  EXPECT_EQ(document.at("permutation"), false);
  for (const ExpectedFault& fault : faults) {
    EXPECT_EQ(document.at("faults").at(fault.name).at("count"), fault.count) << fault.name;
    EXPECT_EQ(document.at("faults").at(fault.name).at("first"), fault.first) << fault.name;
  }
  EXPECT_TRUE(document.at("pixel_lists").is_null());
}

TEST(Order, IsAPermutationForEveryMethodAndProjection) {
  const OrderOf knot(shapes::torus_knot(1500));
  Ids identity(knot.mesh().triangles.size());
  std::iota(identity.begin(), identity.end(), 0u);
  for (const char* method : {"centroid_distance", "centroid_depth", "parametric_centre", "bounds_centre",
                             "first_vertex", "nearest_vertex", "farthest_vertex"}) {
    Ids ids = knot.ids({"--method", method});
    EXPECT_FALSE(std::is_sorted(ids.begin(), ids.end())) << method;
    std::sort(ids.begin(), ids.end());
    EXPECT_EQ(ids, identity) << method;
  }
  const Ids perspective = knot.ids();
  Ids orthographic = knot.ids({"--ortho"});
  EXPECT_NE(perspective, orthographic);
  std::sort(orthographic.begin(), orthographic.end());
  EXPECT_EQ(orthographic, identity);
}

TEST(Order, DoesNotDependOnTheNumberOfThreads) {
  const OrderOf knot(shapes::torus_knot(3000));
  EXPECT_EQ(knot.ids({"--threads", "1"}), knot.ids({"--threads", "5"}));
}

TEST(Order, PlyHasTheTrianglesInDrawOrderWithTheirColours) {
  Mesh mesh = shapes::torus_knot(1000);
  for (std::size_t facet = 0; facet < mesh.triangles.size(); ++facet) {
    mesh.facet_colours.emplace_back(static_cast<float>(facet % 256) / 255, static_cast<float>(facet / 256) / 255, 0, 1);
  }
  const OrderOf knot(mesh);
  const Ids ids = knot.ids();
  const std::string ply = knot.order("order.ply");
  const Result<std::vector<std::uint32_t>> source = read_ply_source(ply);
  ASSERT_TRUE(source.ok()) << source.status().message;
  EXPECT_EQ(source.value(), ids);
  const Result<Mesh> drawn = read_mesh(ply);
  ASSERT_TRUE(drawn.ok()) << drawn.status().message;
  ASSERT_EQ(drawn.value().triangles.size(), ids.size());
  for (std::size_t place = 0; place < ids.size(); ++place) {
    EXPECT_EQ(drawn.value().triangles[place], mesh.triangles[ids[place]]);
    EXPECT_EQ(drawn.value().facet_colours[place], mesh.facet_colours[ids[place]]);
  }
}

TEST(Order, UnwritableOutputLeavesNothing) {
  const TemporaryFolder folder;
  const std::string box = write_mesh(folder, "box.ply", shapes::box());
  const std::filesystem::path taken = folder.path() / "taken.u32", missing = folder.path() / "missing";
  std::filesystem::create_directory(taken);
  for (const std::filesystem::path& path : {missing / "order.u32", missing / "order.ply", taken}) {
    const Finished finished = run_program({"order", box, "--eye", eye_text, "-o", path.string()});
    EXPECT_EQ(finished.status, 2);
    EXPECT_NE(finished.error.find(path.string()), std::string::npos) << finished.error;
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);  // the mesh and `taken`
  EXPECT_TRUE(std::filesystem::is_empty(taken));
}

TEST(Check, RightOrdersPassAndOneSwapOfOverlappingFacetsFails) {
  const std::pair<Mesh, bool> cases[] = {{shapes::icosphere(3), false}, {shapes::nested_shells(3, 0.3f, 3), true}};
  for (const auto& [mesh, orthographic] : cases) {
    SCOPED_TRACE(orthographic ? "shells, orthographic" : "sphere, perspective");
    const OrderOf order_of(mesh, orthographic ? std::vector<std::string>{"--ortho"} : std::vector<std::string>{});
    const Ids ids = order_of.ids();
    const Finished right = order_of.check(ids);
    ASSERT_EQ(right.status, 0) << right.error << right.output;
    const Json verdict = Json::parse(right.output);
    EXPECT_EQ(verdict.at("right"), true);
    EXPECT_EQ(verdict.at("pixel_lists").at("inverted_pixels"), 0);
    EXPECT_GT(verdict.at("pixel_lists").at("covered_pixels"), 1000);
    EXPECT_TRUE(verdict.at("pixel_lists").at("worst").is_null());
    EXPECT_EQ(verdict.at("embree").at("verdict").at("inverted_pixels"), 0);

    const auto [far, near] =
        overlapping_facets(mesh, orthographic ? Projection::orthographic : Projection::perspective);
    const Finished wrong = order_of.check(swapped(ids, far, near));
    EXPECT_EQ(wrong.status, 1) << wrong.error;
    const Json spoiled = Json::parse(wrong.output);
    EXPECT_EQ(spoiled.at("right"), false);
    EXPECT_EQ(spoiled.at("permutation"), true);
    for (const Json& referee : {spoiled.at("pixel_lists"), spoiled.at("embree").at("verdict")}) {
      EXPECT_GT(referee.at("inverted_pixels"), 0);
      EXPECT_GT(referee.at("worst_backtrack"), 0.0);
      EXPECT_EQ(referee.at("worst").at("far_facet"), far);
      EXPECT_EQ(referee.at("worst").at("near_facet"), near);
    }
  }
}

TEST(Check, ReadsThePlyThatOrderWrites) {
  const OrderOf sphere(shapes::icosphere(2));
  const std::string ply = sphere.order("order.ply");
  EXPECT_EQ(sphere.check_file(ply).status, 0);

  // The same triangles under other facets' ids: no order of this mesh, whatever the ids say.
  const Result<Mesh> drawn = read_mesh(ply);
  ASSERT_TRUE(drawn.ok());
  Ids ids = sphere.ids();
  std::swap(ids[7], ids[100]);
  ASSERT_TRUE(write_ply(ply, drawn.value().view(), ids).ok());
  const Finished finished = sphere.check_file(ply);
  EXPECT_EQ(finished.status, 1);
  const Json faults = Json::parse(finished.output).at("faults");
  EXPECT_EQ(faults.at("wrong_corners").at("count"), 2);
  EXPECT_EQ(faults.at("wrong_corners").at("first"), 7);
}

TEST(Check, TellsWhatKeepsAnOrderFromBeingAPermutation) {
  const OrderOf sphere(shapes::icosphere(1));  // 80 facets
  const Ids ids = sphere.ids();

  Ids missing = ids;
  missing.pop_back();
  expect_not_a_permutation(sphere.check(missing), {{"missing", 1, ids.back()}});
  expect_not_a_permutation(sphere.check({}), {{"missing", 80, 0}});

  Ids repeated = ids;
  repeated[3] = repeated[50];
  expect_not_a_permutation(sphere.check(repeated), {{"repeated", 1, ids[50]}, {"missing", 1, ids[3]}});

  Ids longer = ids;
  longer.push_back(ids[0]);
  expect_not_a_permutation(sphere.check(longer), {{"repeated", 1, ids[0]}});

  Ids out_of_range = ids;
  out_of_range[10] = 80;
  out_of_range[20] = 0xffffffffu;
  expect_not_a_permutation(sphere.check(out_of_range),
                           {{"out_of_range", 2, 80}, {"missing", 2, std::min(ids[10], ids[20])}});
}

TEST(Check, DamagedOrderFilesAreBadInput) {
  const OrderOf sphere(shapes::icosphere(1));
  const std::string bytes = bytes_of(sphere.ids());
  const std::string plain_ply = write_mesh(sphere.folder(), "plain.ply", sphere.mesh());
  const std::pair<Finished, const char*> cases[] = {
      {sphere.check_bytes(bytes.substr(0, bytes.size() - 1)), "319 bytes"},
      {sphere.check_file((sphere.folder().path() / "missing.u32").string()), "missing.u32"},
      {sphere.check_file(sphere.folder().write("order.txt", bytes).string()), ".u32 or .ply"},
      {sphere.check_file(sphere.folder().write("cut.ply", file_bytes(plain_ply).substr(0, 400)).string()), "cut.ply"},
      {sphere.check_file(plain_ply), "`source`"},
  };
  for (const auto& [finished, said] : cases) {
    EXPECT_EQ(finished.status, 2) << said;
    EXPECT_EQ(finished.output, "") << said;
    EXPECT_NE(finished.error.find(said), std::string::npos) << finished.error;
  }
}

TEST(Check, SaysWhereEmbreeCannotJudge) {
  // The only ray, through the middle, meets the edge that both facets share.
  Mesh square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "square.ply", square);
  const std::string order = folder.write("order.u32", bytes_of({0, 1})).string();
  const std::vector<std::string> arguments{"check", mesh, "--order", order, "--eye", "0,0,5", "--size", "1"};
  const Finished finished = run_program(arguments);
  EXPECT_EQ(finished.status, 0) << finished.error;
  EXPECT_NE(finished.output.find("not judged; 1 of 1 rays in doubt: 1 at an edge"), std::string::npos)
      << finished.output;
}

TEST(Check, SaysWhereThereIsNothingToJudge) {
  const TemporaryFolder folder;
  const std::string mesh = write_mesh(folder, "box.ply", shapes::box());
  Ids ids(12);
  std::iota(ids.begin(), ids.end(), 0u);
  const std::string order = folder.write("order.u32", bytes_of(ids)).string();
  const Finished finished =
      run_program({"check", mesh, "--order", order, "--eye", "0,0,5", "--at", "0,0,9", "--size", "8"});
  EXPECT_EQ(finished.status, 0) << finished.error;
  EXPECT_NE(finished.output.find("nothing to judge"), std::string::npos) << finished.output;
}

}  // namespace
}  // namespace facetsort
