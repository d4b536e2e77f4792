// facetsort stability: files, and what the figures must say of conditions whose effect is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "apps/run_program.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;

class StabilityVerb : public testing::Test {
 protected:
  Finished stability(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "stability");
    arguments.insert(arguments.end(), {"--out", report_.string()});
    return run_program(arguments);
  }

  // The rows of a run over some sweeps, in small pictures.
  Json rows(const std::string& sweeps, const std::string& methods, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"--sweeps", sweeps, "--methods", methods, "--size", "48", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Finished finished = stability(arguments);
    EXPECT_EQ(finished.status, 0) << finished.error;
    return Json::parse(finished.output).at("rows");
  }

  TemporaryFolder folder_;
  std::filesystem::path report_ = folder_.path() / "made" / "report";
};

// What a method's share of inverted pixels is at a value; the test fails where it is not judged.
double inverted_rate(const Json& rows, const std::string& sweep, const std::string& method, double value) {
  for (const Json& row : rows) {
    if (row.at("sweep") != sweep || row.at("method") != method || row.at("value").is_null()) continue;
    if (std::abs(row.at("value").get<double>() / value - 1) > 1e-9) continue;
    EXPECT_TRUE(row.at("judged").get<bool>()) << row;
    return row.at("inverted_rate").is_null() ? -1 : row.at("inverted_rate").get<double>();
  }
  ADD_FAILURE() << "no row of " << sweep << " at " << value;
  return -1;
}

TEST_F(StabilityVerb, WritesTheWholeReport) {
  const Finished finished = stability({"--sweeps", "cycle_length,layer_gap", "--size", "32"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  EXPECT_EQ(finished.error, "");  // no progress where there is no terminal
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(report_)) names.insert(entry.path().filename());
  EXPECT_EQ(names, (std::set<std::string>{"stability.json", "stability.csv", "stability.html"}));
  const Json document = Json::parse(file_bytes(report_ / "stability.json"));
  EXPECT_FALSE(document.at("machine").get<std::string>().empty());
  EXPECT_NE(document.at("command").get<std::string>().find(" stability --sweeps "), std::string::npos);
  EXPECT_EQ(document.at("size"), Json({32, 32}));
  EXPECT_EQ(document.at("methods").at(0), "naive_centroid");
  EXPECT_GE(document.at("methods").size(), 7u);
  const std::string page = file_bytes(report_ / "stability.html");
  for (const char* sweep : {"cycle_length", "layer_gap"}) {
    EXPECT_NE(finished.output.find(std::string("\n") + sweep + " "), std::string::npos);
    EXPECT_NE(page.find(std::string("<section id=\"") + sweep + "\">"), std::string::npos);
  }
  for (const Json& sweep : document.at("sweeps")) {
    EXPECT_FALSE(sweep.at("findings").get<std::string>().empty());
    EXPECT_FALSE(sweep.at("description").get<std::string>().empty());
  }
}

TEST_F(StabilityVerb, CoversEveryConditionInEightToTwentySteps) {
  const Finished finished = stability({"--methods", "centroid_distance", "--size", "16", "--json"});
  ASSERT_EQ(finished.status, 0) << finished.error;
  const Json all = Json::parse(finished.output);
  const struct {
    const char* sweep;
    double lowest, highest;
  } ranges[] = {{"origin_distance", 1, 1e7}, {"scale", 1e-30, 1e30},      {"scale_contrast", 1, 1e12},
                {"aspect_ratio", 1, 1e8},    {"layer_gap", 1e-7, 0.1},    {"field_of_view", 0.01, 179},
                {"near_far_ratio", 10, 1e9}, {"eye_distance", 1e-6, 1e6}, {"layers", 1, 1000},
                {"cycle_length", 3, 1000},   {"nesting", 1, 100}};
  EXPECT_EQ(all.at("sweeps").size(), std::size(ranges));
  for (const auto& [sweep, lowest, highest] : ranges) {
    std::vector<double> values;
    std::size_t points = 0;
    for (const Json& row : all.at("rows")) {
      if (row.at("sweep") != sweep) continue;
      ++points;
      EXPECT_GT(row.at("covered_pixels"), 0) << row;
      if (!row.at("value").is_null()) values.push_back(row.at("value"));
    }
    EXPECT_GE(points, 8u) << sweep;
    EXPECT_LE(points, 20u) << sweep;
    ASSERT_FALSE(values.empty()) << sweep;
    EXPECT_TRUE(std::is_sorted(values.begin(), values.end())) << sweep;
    EXPECT_NEAR(values.front() / lowest, 1, 1e-9) << sweep;
    EXPECT_NEAR(values.back() / highest, 1, 1e-9) << sweep;
  }
}

TEST_F(StabilityVerb, NaiveKeysLeaveTheRangeOfFloatAndOursDoNot) {
  const Json all = rows("scale", "naive_centroid,centroid_distance");
  for (const double value : {1e-30, 1e20, 1e30}) {
    EXPECT_GT(inverted_rate(all, "scale", "naive_centroid", value), 0.1) << value;
  }
  EXPECT_EQ(inverted_rate(all, "scale", "naive_centroid", 1), 0);
  for (const Json& row : all) {
    EXPECT_TRUE(row.at("judged").get<bool>());
    EXPECT_GT(row.at("covered_pixels"), 1000);
    if (row.at("method") == "centroid_distance") {
      EXPECT_EQ(row.at("inverted_pixels"), 0) << row;
      EXPECT_EQ(row.at("wrong_pixels"), 0) << row;
      EXPECT_EQ(row.at("embree_inverted"), 0) << row;
    }
  }
}

TEST_F(StabilityVerb, NaiveKeysLoseTheirDigitsFarFromTheOriginBeforeOursDo) {
  const Json all = rows("origin_distance", "naive_centroid,centroid_distance");
  for (const double value : {1.0, 1e4}) {
    EXPECT_EQ(inverted_rate(all, "origin_distance", "naive_centroid", value), 0);
    EXPECT_EQ(inverted_rate(all, "origin_distance", "centroid_distance", value), 0);
  }
  EXPECT_EQ(inverted_rate(all, "origin_distance", "centroid_distance", 5e5), 0);
  EXPECT_GT(inverted_rate(all, "origin_distance", "naive_centroid", 5e5), 0.001);
  EXPECT_GT(inverted_rate(all, "origin_distance", "naive_centroid", 1e6), 0.03);
}

TEST_F(StabilityVerb, APointWhoseFacetsCoincideIsNotJudged) {
  std::size_t farthest = 0;
  for (const Json& row : rows("origin_distance", "centroid_depth")) {
    if (row.at("value") != 1e7) continue;
    ++farthest;
    EXPECT_FALSE(row.at("judged").get<bool>());
    EXPECT_GT(row.at("unjudged_pixels").get<double>(), 0.05 * row.at("covered_pixels").get<double>());
    EXPECT_GT(row.at("embree_unjudged").get<double>(), 0.05 * row.at("embree_rays").get<double>());
    for (const char* count : {"inverted_rate", "inverted_pixels", "wrong_pixels", "embree_inverted"}) {
      EXPECT_TRUE(row.at(count).is_null()) << count;
    }
  }
  EXPECT_EQ(farthest, 1u);
  EXPECT_NE(file_bytes(report_ / "stability.html").find("\">not judged</td>"), std::string::npos);
}

TEST_F(StabilityVerb, ACycleMakesEveryKeyWrong) {
  const Json all = rows("cycle_length",
                        "naive_centroid,centroid_distance,centroid_depth,bounds_centre,first_vertex,nearest_vertex,"
                        "farthest_vertex");
  EXPECT_EQ(all.size() % 7, 0u);
  for (const Json& row : all) {
    EXPECT_GT(row.at("inverted_rate"), 0.001) << row;
    EXPECT_GT(row.at("wrong_pixels"), 0) << row;
    EXPECT_GT(row.at("embree_inverted"), 0) << row;
  }
}

TEST_F(StabilityVerb, ExactIsRightWhereverARefereeJudges) {
  // All but the deepest nesting, whose 32,000 facets are too many for a quick test.
  const Json all = rows(
      "origin_distance,scale,scale_contrast,aspect_ratio,layer_gap,field_of_view,near_far_ratio,eye_distance,layers,"
      "cycle_length",
      "exact");
  std::size_t judged = 0;
  for (const Json& row : all) {
    judged += row.at("judged").get<bool>();
    for (const char* count : {"inverted_pixels", "wrong_pixels", "embree_inverted"}) {
      EXPECT_EQ(row.at(count).is_null() ? 0 : row.at(count).get<int>(), 0) << count << " of " << row;
    }
  }
  // Nearly everywhere: that the order is right where nobody looks would say nothing.
  EXPECT_GT(judged, all.size() * 9 / 10);
}

TEST_F(StabilityVerb, DoesNotDependOnTheNumberOfThreads) {
  const std::string sweeps = "eye_distance", methods = "naive_centroid,nearest_vertex,exact";
  EXPECT_EQ(rows(sweeps, methods, {"--threads", "1"}), rows(sweeps, methods, {"--threads", "5"}));
}

TEST_F(StabilityVerb, TellsBadUsageInOneLineAndWritesNothing) {
  const std::pair<std::vector<std::string>, const char*> cases[] = {{{"--sweeps", "scale,gravity"}, "gravity"},
                                                                    {{"--methods", "alphabetical"}, "alphabetical"},
                                                                    {{"--size", "1"}, "--size"},
                                                                    {{"--size", "many"}, "--size"}};
  for (const auto& [arguments, said] : cases) {
    const Finished finished = stability(arguments);
    EXPECT_EQ(finished.status, 2);
    EXPECT_NE(finished.error.find(said), std::string::npos) << finished.error;
    EXPECT_EQ(std::count(finished.error.begin(), finished.error.end(), '\n'), 1) << finished.error;
  }
  EXPECT_FALSE(std::filesystem::exists(report_));
  const std::filesystem::path taken = folder_.write("taken", "a file");
  const Finished finished =
      run_program({"stability", "--sweeps", "cycle_length", "--out", (taken / "report").string()});
  EXPECT_EQ(finished.status, 2);
  EXPECT_NE(finished.error.find("taken"), std::string::npos) << finished.error;
}

}  // namespace
}  // namespace facetsort
