// facetsort compare: files, keys, and what the figures must say of meshes whose answer is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "apps/run_program.h"
#include "facetsort/blend/strategy.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

const std::set<std::string> row_keys{"mesh",
                                     "facets",
                                     "view",
                                     "eye",
                                     "projection",
                                     "strategy",
                                     "method",
                                     "facets_drawn",
                                     "pieces",
                                     "triangles_out",
                                     "passes",
                                     "bytes_per_pixel",
                                     "prepare_ms",
                                     "prepared_bytes",
                                     "order_ms",
                                     "order_ms_spread",
                                     "blend_ms",
                                     "blend_ms_spread",
                                     "peak_bytes",
                                     "covered_pixels",
                                     "wrong_pixels",
                                     "wrong_rate",
                                     "inverted_pixels",
                                     "inverted_rate",
                                     "miscovered_pixels",
                                     "unjudged_pixels",
                                     "rmse",
                                     "max_error",
                                     "worst_backtrack",
                                     "embree_rays",
                                     "embree_inverted",
                                     "embree_unjudged",
                                     "exact"};

// The mesh several times over, every facet on top of others of its own.
Mesh repeated(Mesh mesh, int times) {
  const std::vector<glm::uvec3> once = mesh.triangles;
  for (int i = 1; i < times; ++i) mesh.triangles.insert(mesh.triangles.end(), once.begin(), once.end());
  return mesh;
}

class Compare : public testing::Test {
 protected:
  Finished compare(std::vector<std::string> arguments, const RunOptions& options = {}) const {
    arguments.insert(arguments.begin(), "compare");
    arguments.insert(arguments.end(), {"--size", "64", "--repeats", "1", "--out", report_.string()});
    return run_program(arguments, options);
  }
  Json results() const { return Json::parse(file_bytes(report_ / "results.json")); }

  TemporaryFolder folder_;
  std::filesystem::path report_ = folder_.path() / "made" / "report";
  std::string shells_ = write_mesh(folder_, "shells.ply", shapes::nested_shells(3, 0.3f, 2));
  std::string pair_ = write_mesh(folder_, "pair.ply", shapes::interpenetrating(2));
};

TEST_F(Compare, WritesTheWholeReport) {
  const Finished finished = compare({shells_, pair_, "--views", "2"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(finished.error, "");  // no progress where there is no terminal
  const std::vector<Strategy> strategies = all_strategies();

  const Json document = results();
  EXPECT_FALSE(document.at("machine").get<std::string>().empty());
  EXPECT_NE(document.at("command").get<std::string>().find(" compare " + shells_), std::string::npos);
  const Json& rows = document.at("rows");
  EXPECT_EQ(rows.size(), 2 * 2 * strategies.size());
  for (const Json& row : rows) {
    std::set<std::string> keys;
    for (const auto& item : row.items()) keys.insert(item.key());
    EXPECT_EQ(keys, row_keys);
    const std::optional<Strategy> strategy = strategy_from_name(row.at("strategy").get<std::string>());
    ASSERT_TRUE(strategy);
    EXPECT_EQ(row.at("exact").is_object(), strategy->kind == StrategyKind::facet_sort && is_exact(strategy->method));
  }
  const std::string csv = file_bytes(report_ / "results.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), rows.size() + 1);
  const std::string page = file_bytes(report_ / "index.html");
  for (const std::string mesh : {"shells", "pair"}) {
    EXPECT_NE(finished.output.find(mesh), std::string::npos);
    for (const Strategy& strategy : strategies) {
      EXPECT_NE(finished.output.find(strategy.name()), std::string::npos);
      std::string stem = "pictures/" + mesh + "." + strategy.name();
      std::replace(stem.begin(), stem.end(), ':', '.');
      for (const std::string& picture : {stem + ".png", stem + ".difference.png"}) {
        const bool expected = strategy.kind != StrategyKind::reference || picture == stem + ".png";
        EXPECT_EQ(std::filesystem::exists(report_ / picture), expected) << picture;
        EXPECT_EQ(page.find(picture) != std::string::npos, expected) << picture;
      }
    }
  }
  // Nothing is left of the run but the report.
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(report_)) names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"results.json", "results.csv", "index.html", "pictures"}));
}

TEST_F(Compare, SeesSixFacesFromEachEyeInside) {
  ASSERT_EQ(compare({shells_, "--inside", "2", "--strategies", "unsorted,facet_sort:exact"}).status, 0);
  const Json document = results();
  EXPECT_EQ(document.at("views"), 12);
  ASSERT_EQ(document.at("rows").size(), 24u);
  std::size_t inverted_unsorted = 0;
  for (const Json& row : document.at("rows")) {
    if (row.at("strategy") == "unsorted") {
      inverted_unsorted += row.at("inverted_pixels").get<std::size_t>();
      continue;
    }
    EXPECT_EQ(row.at("covered_pixels"), row.at("embree_rays"));
    EXPECT_EQ(row.at("inverted_pixels"), 0) << row.dump();
    EXPECT_EQ(row.at("embree_inverted"), 0) << row.dump();
    EXPECT_EQ(row.at("wrong_pixels"), 0) << row.dump();
  }
  EXPECT_GT(inverted_unsorted, 0u);
  const Finished both = compare({shells_, "--inside", "2", "--views", "3"});
  EXPECT_EQ(both.status, 2);
  EXPECT_NE(both.error.find("--inside"), std::string::npos) << both.error;
}

TEST_F(Compare, JudgesShellsAsTheyAre) {
  ASSERT_EQ(compare({shells_, "--views", "2", "--ortho"}).status, 0);
  const Json document = results();
  EXPECT_EQ(document.at("meshes")[0].at("embree_agreement"), 1.0);
  EXPECT_EQ(document.at("meshes")[0].at("most_layers"), 6);
  for (const Json& row : document.at("rows")) {
    SCOPED_TRACE(row.dump());
    const std::string strategy = row.at("strategy");
    EXPECT_EQ(row.at("projection"), "orthographic");
    EXPECT_GT(row.at("covered_pixels"), 500);
    EXPECT_EQ(row.at("unjudged_pixels"), 0);
    EXPECT_GT(row.at("embree_rays"), 500);
    EXPECT_GT(row.at("blend_ms"), 0.0);
    const bool discards = strategy == "depth_prepass" || strategy == "depth_write";
    EXPECT_EQ(row.at("miscovered_pixels"), discards ? Json(nullptr) : Json(0));
    if (strategy == "facet_sort:centroid_distance") {
      EXPECT_EQ(row.at("wrong_pixels"), 0);
      EXPECT_EQ(row.at("inverted_pixels"), 0);
      EXPECT_EQ(row.at("embree_inverted"), 0);
      EXPECT_EQ(row.at("method"), "centroid_distance");
      EXPECT_GT(row.at("prepared_bytes"), 0);
    } else if (strategy == "reference") {
      EXPECT_EQ(row.at("wrong_pixels"), 0);
      EXPECT_TRUE(row.at("inverted_pixels").is_null());
      EXPECT_TRUE(row.at("embree_inverted").is_null());
      EXPECT_GT(row.at("peak_bytes"), 6 * 1000);
    } else if (strategy == "unsorted" || strategy == "double_sided") {
      EXPECT_GT(row.at("wrong_rate"), 0.1);
      EXPECT_GT(row.at("inverted_rate"), 0.1);
      EXPECT_GT(row.at("worst_backtrack"), 0.1);
      EXPECT_GT(row.at("embree_inverted"), 50);
      EXPECT_TRUE(row.at("method").is_null());
    }
  }
}

TEST_F(Compare, TheExactOrderIsRightWhereFacetsCross) {
  ASSERT_EQ(compare({pair_, "--views", "2", "--strategies", "facet_sort,facet_sort:exact"}).status, 0);
  const Json document = results();
  for (const Json& row : document.at("rows")) {
    SCOPED_TRACE(row.dump());
    if (row.at("strategy") == "facet_sort:exact") {
      EXPECT_EQ(row.at("wrong_pixels"), 0);
      EXPECT_EQ(row.at("inverted_pixels"), 0);
      EXPECT_EQ(row.at("miscovered_pixels"), 0);
      EXPECT_EQ(row.at("embree_inverted"), 0);
      EXPECT_GT(row.at("pieces"), row.at("facets"));
      EXPECT_GT(row.at("triangles_out"), row.at("pieces"));
      EXPECT_EQ(row.at("exact").at("triangles"), row.at("triangles_out"));
      EXPECT_GT(row.at("exact").at("crossing_pairs"), 10);
    } else {
      EXPECT_GT(row.at("wrong_pixels"), 0);
      EXPECT_EQ(row.at("pieces"), row.at("facets"));
    }
  }
}

TEST_F(Compare, ThePageLeadsToAStabilityPageThatIsThere) {
  const std::vector<std::string> arguments{shells_, "--views", "1", "--strategies", "unsorted"};
  ASSERT_EQ(compare(arguments).status, 0);
  EXPECT_EQ(file_bytes(report_ / "index.html").find("stability.html"), std::string::npos);
  std::ofstream(report_ / "stability.html") << "a page";
  ASSERT_EQ(compare(arguments).status, 0);
  EXPECT_NE(file_bytes(report_ / "index.html").find("stability.html"), std::string::npos);
  EXPECT_EQ(file_bytes(report_ / "stability.html"), "a page");
}

TEST_F(Compare, TakesTheStrategiesNamed) {
  const Finished finished =
      compare({shells_, "--views", "1", "--format", "rgba8", "--strategies",
               "depth_write,facet_sort,facet_sort:centroid_distance,facet_sort:parametric_centre", "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(finished.output, file_bytes(report_ / "results.json"));
  std::vector<std::string> strategies;
  const Json document = Json::parse(finished.output);
  for (const Json& row : document.at("rows")) strategies.push_back(row.at("strategy"));
  EXPECT_EQ(strategies,
            (std::vector<std::string>{"depth_write", "facet_sort:centroid_distance", "facet_sort:centroid_depth"}));
}

TEST_F(Compare, TiesAreRightEitherWayAndNotJudgedWhereTheyAreTooMany) {
  const std::string twice = write_mesh(folder_, "twice.ply", repeated(shapes::icosphere(2), 2));
  const std::string often = write_mesh(folder_, "often.ply", repeated(shapes::icosphere(2), 9));
  ASSERT_EQ(compare({twice, often, "--views", "1", "--strategies", "unsorted,facet_sort,reference"}).status, 0);
  const Json document = results();
  const Json& rows = document.at("rows");
  ASSERT_EQ(rows.size(), 6u);
  // Two layers at each depth have few orders, none of which has the near pair under a far one.
  EXPECT_EQ(rows[0].at("unjudged_pixels"), 0);
  EXPECT_GT(rows[0].at("wrong_rate"), 0.1);
  // Nine at each depth have too many.
  EXPECT_GT(rows[3].at("unjudged_pixels"), 100);
  EXPECT_TRUE(rows[3].at("wrong_pixels").is_null());
  EXPECT_TRUE(rows[3].at("wrong_rate").is_null());
  // What draws the smaller id of equal depths first, as the reference does, has no such pixel.
  for (const std::size_t row : {1, 2, 4, 5}) {
    EXPECT_EQ(rows[row].at("unjudged_pixels"), 0);
    EXPECT_EQ(rows[row].at("wrong_pixels"), 0);
  }
}

TEST_F(Compare, NothingIsSaidOfRaysThatCannotBeJudged) {
  // The only ray, through the middle, meets the edge that both facets share.
  Mesh square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  const Finished finished = run_program({"compare", write_mesh(folder_, "square.ply", square), "--views", "1", "--size",
                                         "1", "--repeats", "1", "--out", report_.string()});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json document = results();
  EXPECT_TRUE(document.at("meshes")[0].at("embree_agreement").is_null());
  for (const Json& row : document.at("rows")) {
    EXPECT_EQ(row.at("covered_pixels"), 1);
    EXPECT_EQ(row.at("embree_rays"), 1);
    EXPECT_EQ(row.at("embree_unjudged"), 1);
    EXPECT_TRUE(row.at("embree_inverted").is_null());
    EXPECT_EQ(row.at("wrong_pixels"), 0);
  }
}

TEST_F(Compare, AFailureLeavesEarlierResultsAlone) {
  ASSERT_EQ(compare({shells_, "--views", "1", "--strategies", "unsorted,reference"}).status, 0);
  const std::string before = file_bytes(report_ / "results.json");
  const std::string missing = (folder_.path() / "missing.ply").string();
  const Finished bad_mesh = compare({shells_, missing});
  EXPECT_EQ(bad_mesh.status, 2);
  EXPECT_NE(bad_mesh.error.find(missing), std::string::npos);
  const Finished no_plots = compare({shells_}, {.standard_output = "", .settings = {"PATH=/nowhere"}});
  EXPECT_EQ(no_plots.status, 2);
  EXPECT_NE(no_plots.error.find("gnuplot"), std::string::npos) << no_plots.error;
  EXPECT_EQ(file_bytes(report_ / "results.json"), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(report_), {}), 4);
}

TEST_F(Compare, AnOutputThatCannotBeMadeLeavesNothing) {
  const std::filesystem::path taken = folder_.write("taken", "a file");
  const Finished finished = run_program({"compare", shells_, "--out", (taken / "report").string()});
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.error.find("taken"), std::string::npos) << finished.error;
  EXPECT_EQ(file_bytes(taken), "a file");
}

TEST_F(Compare, TwoMeshesOfOneNameAreRefused) {
  std::filesystem::create_directory(folder_.path() / "other");
  const std::string other = (folder_.path() / "other" / "shells.ply").string();
  std::filesystem::copy_file(shells_, other);
  const Finished finished = compare({shells_, other});
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.error.find("'shells'"), std::string::npos) << finished.error;
  EXPECT_FALSE(std::filesystem::exists(report_));
}

}  // namespace
}  // namespace facetsort
