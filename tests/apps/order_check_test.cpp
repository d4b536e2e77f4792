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
#include "support/mesh_files.h"

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
                             "first_vertex", "nearest_vertex", "farthest_vertex", "exact"}) {
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

TEST(Order, ExactPlyHasTheVerticesOfCutsWithTheirColours) {
  Mesh mesh = shapes::slab_cycle(3);
  Box box = facet_bounds(mesh.view());
  for (const glm::vec3& position : mesh.positions) {
    mesh.vertex_colours.emplace_back((position - box.lowest) / (box.highest - box.lowest), 0.5f);
  }
  for (const bool by_facet : {false, true}) {
    if (by_facet) {
      for (std::size_t facet = 0; facet < mesh.triangles.size(); ++facet) {
        mesh.facet_colours.emplace_back(static_cast<float>(facet) / 255, 0, 1, 1);
      }
    }
    const OrderOf slabs(mesh);
    const std::string ply = slabs.order("order.ply", {"--method", "exact"});
    const Result<std::vector<std::uint32_t>> source = read_ply_source(ply);
    const Result<Mesh> drawn = read_mesh(ply);
    ASSERT_TRUE(drawn.ok() && source.ok());
    ASSERT_GT(drawn.value().positions.size(), mesh.positions.size());
    for (std::size_t v = 0; v < drawn.value().positions.size(); ++v) {
      // The colours are the place, whose interpolation is the place of the vertex; both were rounded to 8 bits.
      const glm::vec3 place = (drawn.value().positions[v] - box.lowest) / (box.highest - box.lowest);
      const glm::vec3 difference = glm::abs(glm::vec3(drawn.value().vertex_colours[v]) - place);
      EXPECT_LE(std::max({difference.x, difference.y, difference.z}), 1.01f / 255) << v;
      if (v < mesh.positions.size()) {
        EXPECT_EQ(drawn.value().positions[v], mesh.positions[v]);
      }
    }
    ASSERT_EQ(drawn.value().facet_colours.size(), by_facet ? source.value().size() : 0);
    for (std::size_t place = 0; place < drawn.value().facet_colours.size(); ++place) {
      EXPECT_EQ(drawn.value().facet_colours[place], mesh.facet_colours[source.value()[place]]);
    }
  }
}

TEST(Order, ExactIsWrittenAsIdsOnlyWhereNothingIsCut) {
  const OrderOf knot(shapes::torus_knot(1500));
  const std::string ply = knot.order("order.ply", {"--method", "exact"});
  EXPECT_EQ(read_ply_source(ply).value(), knot.ids({"--method", "exact"}));

  const TemporaryFolder folder;
  const std::string slabs = write_mesh(folder, "slabs.ply", shapes::slab_cycle(3));
  const std::string output = (folder.path() / "order.u32").string();
  const Finished finished = run_program({"order", slabs, "--eye", eye_text, "--method", "exact", "-o", output});
  EXPECT_EQ(finished.status, 2);
  EXPECT_EQ(finished.output, "");
  const std::string said = "cut; write a .ply\n";
  ASSERT_GT(finished.error.size(), said.size());
  EXPECT_EQ(finished.error.substr(finished.error.size() - said.size()), said) << finished.error;
  EXPECT_EQ(finished.error.rfind("facetsort: " + output + ": ", 0), 0u) << finished.error;
  EXPECT_FALSE(std::filesystem::exists(output));
}

TEST(Order, TellsWhatTheExactOrderHadToDo) {
  const TemporaryFolder folder;
  const std::string pair = write_mesh(folder, "pair.ply", shapes::interpenetrating(2));
  const std::string output = (folder.path() / "order.ply").string();
  std::vector<std::string> arguments{"order", pair, "--eye", eye_text, "--method", "exact", "-o", output};
  const Finished text = run_program(arguments);
  ASSERT_EQ(text.status, 0) << text.error;
  for (const char* said : {"crossing", "pairs", "cycles", "growth 1.", "times"}) {
    EXPECT_NE(text.output.find(said), std::string::npos) << said;
  }
  EXPECT_EQ(text.output.find("NOT EXACT"), std::string::npos);

  arguments.insert(arguments.end(), {"--max-growth", "1"});
  const Finished capped = run_program(arguments);
  ASSERT_EQ(capped.status, 0) << capped.error;
  EXPECT_NE(capped.output.find("NOT EXACT"), std::string::npos) << capped.output;
  arguments.push_back("--json");
  const Json document = Json::parse(run_program(arguments).output);
  EXPECT_EQ(document.at("growth"), 1.0);
  EXPECT_GT(document.at("exact").at("crossing_pairs_uncut"), 0);
  EXPECT_GE(document.at("exact").at("times_ms").at("pairs"), 0.0);
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

// Triangles with the facets that they are or are part of.
struct Drawn {
  Mesh mesh;
  Ids sources;
};

// The exact order of a mesh, and checks of what was done to it.
class CutOrder {
 public:
  explicit CutOrder(const Mesh& mesh, std::vector<std::string> view = {}) : order_(mesh, std::move(view)) {
    const std::string path = order_.order("order.ply", {"--method", "exact"});
    drawn_ = {read_mesh(path).value(), read_ply_source(path).value()};
  }

  const Mesh& mesh() const { return order_.mesh(); }
  const Drawn& drawn() const { return drawn_; }
  Finished check(const Drawn& drawn) const {
    const std::string path = (order_.folder().path() / "changed.ply").string();
    EXPECT_TRUE(write_ply(path, drawn.mesh.view(), drawn.sources).ok());
    return order_.check_file(path);
  }
  // A triangle with a corner that is none of its facet's, of more than a thousandth of the largest area.
  std::size_t place_of_part() const {
    double largest = 0;
    std::size_t found = drawn_.sources.size();
    for (std::size_t place = 0; place < drawn_.sources.size(); ++place) {
      const glm::uvec3 corners = drawn_.mesh.triangles[place];
      if (std::max({corners.x, corners.y, corners.z}) < mesh().positions.size()) continue;
      const MeshView view = drawn_.mesh.view();
      const glm::dvec3 a(view.corner(place, 0)), b(view.corner(place, 1)), c(view.corner(place, 2));
      const double area = glm::length(glm::cross(b - a, c - a));
      if (area > largest) {
        largest = area;
        found = place;
      }
    }
    EXPECT_LT(found, drawn_.sources.size()) << "nothing was cut";
    return found;
  }

 private:
  OrderOf order_;
  Drawn drawn_;
};

void expect_fault(const Finished& finished, const char* fault, std::size_t count, std::size_t first) {
  EXPECT_EQ(finished.status, 1) << finished.error;
  const Json document = Json::parse(finished.output);
  EXPECT_EQ(document.at("right"), false);
  EXPECT_EQ(document.at("permutation"), false);
  for (const auto& [name, found] : document.at("faults").items()) {
    EXPECT_EQ(found.at("count"), name == fault ? count : 0) << name;
    if (name == fault) {
      EXPECT_EQ(found.at("first"), first) << name;
    }
  }
}

Mesh scaled(Mesh mesh, float scale) {
  for (glm::vec3& position : mesh.positions) position *= scale;
  return mesh;
}

TEST(CheckParts, ExactOrdersPassAndOneSwapOfOverlappingTrianglesFails) {
  const std::pair<Mesh, bool> cases[] = {{shapes::interpenetrating(2), false},
                                         {shapes::interpenetrating(2), true},
                                         {shapes::slab_cycle(5), false},
                                         {scaled(load("teapot_1k"), 0.0625f), false}};
  for (const auto& [mesh, orthographic] : cases) {
    SCOPED_TRACE(std::to_string(mesh.triangles.size()) + (orthographic ? " orthographic" : " perspective"));
    const CutOrder cut(mesh, orthographic ? std::vector<std::string>{"--ortho"} : std::vector<std::string>{});
    const Finished right = cut.check(cut.drawn());
    ASSERT_EQ(right.status, 0) << right.error << right.output;
    const Json verdict = Json::parse(right.output);
    EXPECT_EQ(verdict.at("right"), true);
    EXPECT_EQ(verdict.at("permutation"), false);
    EXPECT_GT(verdict.at("facets_in_parts"), 0);
    EXPECT_GT(verdict.at("triangles"), verdict.at("facets"));
    EXPECT_GT(verdict.at("pixel_lists").at("covered_pixels"), 500);
    EXPECT_EQ(verdict.at("pixel_lists").at("inverted_pixels"), 0);
    EXPECT_EQ(verdict.at("embree").at("verdict").at("inverted_pixels"), 0);
    EXPECT_EQ(verdict.at("coverage").at("miscovered_pixels"), 0);

    const auto [far, near] = overlapping_facets(
        cut.drawn().mesh, orthographic ? Projection::orthographic : Projection::perspective);
    Drawn swapped = cut.drawn();
    std::swap(swapped.mesh.triangles[far], swapped.mesh.triangles[near]);
    std::swap(swapped.sources[far], swapped.sources[near]);
    const Finished wrong = cut.check(swapped);
    EXPECT_EQ(wrong.status, 1) << wrong.error;
    const Json spoiled = Json::parse(wrong.output);
    EXPECT_EQ(spoiled.at("right"), false);
    for (const Json& referee : {spoiled.at("pixel_lists"), spoiled.at("embree").at("verdict")}) {
      EXPECT_GT(referee.at("inverted_pixels"), 0);
      EXPECT_EQ(referee.at("worst").at("far_triangle"), near);  // each is where the other was
      EXPECT_EQ(referee.at("worst").at("near_triangle"), far);
      EXPECT_EQ(referee.at("worst").at("far_facet"), cut.drawn().sources[far]);
      EXPECT_EQ(referee.at("worst").at("near_facet"), cut.drawn().sources[near]);
    }
    EXPECT_EQ(spoiled.at("coverage").at("miscovered_pixels"), 0);
  }
}

TEST(CheckParts, FarFromTheOriginRoundingIsNoFault) {
  // Coordinates keep 13 bits of the mesh's size: new vertices are off by a ten thousandth of it. The edges of a soup are
  // free ones, so that no neighbour covers what a moved one lays bare.
  Mesh mesh = shapes::soup(60, 1);
  for (glm::vec3& position : mesh.positions) position = position * 64.0f + glm::vec3(50000, 0, 0);
  const TemporaryFolder folder;
  const std::string path = write_mesh(folder, "far.ply", mesh), order = (folder.path() / "order.ply").string();
  const std::string far_eye = "50064,80,200";
  ASSERT_EQ(run_program({"order", path, "--eye", far_eye, "--method", "exact", "-o", order}).status, 0);
  const Finished finished = run_program({"check", path, "--order", order, "--eye", far_eye, "--json"});
  EXPECT_EQ(finished.status, 0) << finished.output;
  const Json document = Json::parse(finished.output);
  EXPECT_GT(document.at("facets_in_parts"), 0);
  EXPECT_GT(document.at("coverage").at("excused_pixels"), 0) << "nothing that rounding would have to explain";
}

TEST(CheckParts, WhatDoesNotCoverEachFacetOnceFails) {
  const CutOrder cut(shapes::interpenetrating(2));
  const std::size_t place = cut.place_of_part();
  const std::uint32_t facet = cut.drawn().sources[place];

  Drawn dropped = cut.drawn();
  dropped.mesh.triangles.erase(dropped.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(place));
  dropped.sources.erase(dropped.sources.begin() + static_cast<std::ptrdiff_t>(place));
  expect_fault(cut.check(dropped), "wrong_cover", 1, facet);

  Drawn repeated = cut.drawn();
  repeated.mesh.triangles.push_back(repeated.mesh.triangles[place]);
  repeated.sources.push_back(facet);
  expect_fault(cut.check(repeated), "wrong_cover", 1, facet);

  Drawn turned_over = cut.drawn();
  std::swap(turned_over.mesh.triangles[place].x, turned_over.mesh.triangles[place].y);
  expect_fault(cut.check(turned_over), "wrong_cover", 1, facet);

  Drawn whole_too = cut.drawn();
  whole_too.mesh.triangles.push_back(cut.mesh().triangles[facet]);
  whole_too.sources.push_back(facet);
  expect_fault(cut.check(whole_too), "wrong_cover", 1, facet);

  Drawn without_facet = cut.drawn();
  for (std::size_t i = without_facet.sources.size(); i-- > 0;) {
    if (without_facet.sources[i] != facet) continue;
    without_facet.mesh.triangles.erase(without_facet.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(i));
    without_facet.sources.erase(without_facet.sources.begin() + static_cast<std::ptrdiff_t>(i));
  }
  expect_fault(cut.check(without_facet), "missing", 1, facet);

  Drawn of_another = cut.drawn();
  of_another.sources[place] = (facet + 1) % static_cast<std::uint32_t>(cut.mesh().triangles.size());
  const Json faults = Json::parse(cut.check(of_another).output).at("faults");
  EXPECT_EQ(faults.at("wrong_corners").at("count"), 1);
  EXPECT_EQ(faults.at("wrong_corners").at("first"), place);
}

TEST(CheckParts, AMovedVertexFails) {
  const CutOrder cut(shapes::interpenetrating(2));
  const std::size_t place = cut.place_of_part();
  const std::uint32_t facet = cut.drawn().sources[place];
  const glm::uvec3 corners = cut.drawn().mesh.triangles[place];
  const std::uint32_t vertex = std::max({corners.x, corners.y, corners.z});
  const glm::vec3 a = cut.mesh().view().corner(facet, 0), b = cut.mesh().view().corner(facet, 1),
                  c = cut.mesh().view().corner(facet, 2), centre = (a + b + c) / 3.0f;

  // Out of the plane, by a few times the rounding of coordinates of about 1.
  Drawn lifted = cut.drawn();
  lifted.mesh.positions[vertex] += 1e-6f * glm::normalize(glm::cross(b - a, c - a));
  const Json out_of_plane = Json::parse(cut.check(lifted).output);
  EXPECT_EQ(out_of_plane.at("right"), false);
  EXPECT_GE(out_of_plane.at("faults").at("wrong_corners").at("count"), 1);

  // Within the facet.
  Drawn moved = cut.drawn();
  moved.mesh.positions[vertex] += 0.01f * (centre - moved.mesh.positions[vertex]);
  expect_fault(cut.check(moved), "wrong_cover", 1, facet);
}

TEST(CheckParts, TellsFaultsAndCoverageInText) {
  const TemporaryFolder folder;
  const Mesh pair = shapes::interpenetrating(1);
  const std::string mesh = write_mesh(folder, "pair.ply", pair), order = (folder.path() / "order.ply").string();
  ASSERT_EQ(run_program({"order", mesh, "--eye", eye_text, "--method", "exact", "-o", order}).status, 0);
  const std::vector<std::string> arguments{"check", mesh, "--order", order, "--eye", eye_text, "--size", "64"};
  const Finished right = run_program(arguments);
  EXPECT_EQ(right.status, 0);
  EXPECT_NE(right.output.find("coverage     0 pixels miscovered"), std::string::npos) << right.output;
  EXPECT_NE(right.output.find("right for this view"), std::string::npos) << right.output;

  Drawn drawn{read_mesh(order).value(), read_ply_source(order).value()};
  const std::size_t triangles = drawn.sources.size();
  for (std::size_t i = 0; i < triangles / 2; ++i) {
    std::swap(drawn.mesh.triangles[i], drawn.mesh.triangles[triangles - 1 - i]);
    std::swap(drawn.sources[i], drawn.sources[triangles - 1 - i]);
  }
  ASSERT_TRUE(write_ply(order, drawn.mesh.view(), drawn.sources).ok());
  const Finished reversed = run_program(arguments);
  EXPECT_EQ(reversed.status, 1);
  EXPECT_NE(reversed.output.find(" is drawn after triangle "), std::string::npos) << reversed.output;
  EXPECT_NE(reversed.output.find("not right for this view"), std::string::npos) << reversed.output;

  drawn.mesh.triangles.resize(triangles / 2);
  drawn.sources.resize(triangles / 2);
  ASSERT_TRUE(write_ply(order, drawn.mesh.view(), drawn.sources).ok());
  const Finished half = run_program(arguments);
  EXPECT_EQ(half.status, 1);
  EXPECT_NE(half.output.find("missing facets"), std::string::npos) << half.output;
  EXPECT_NE(half.output.find("whole or in parts"), std::string::npos) << half.output;
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
