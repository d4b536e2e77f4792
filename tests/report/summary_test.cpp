#include "facetsort/report/summary.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "facetsort/report/write_report.h"
#include "report/sample.h"

namespace facetsort {
namespace {

using test::make_row;

Comparison of_rows(std::vector<Row> rows) {
  Comparison comparison;
  comparison.rows = std::move(rows);
  return comparison;
}

std::string taken(const Comparison& comparison) {
  const Summary summary = summarise(comparison);
  EXPECT_EQ(summary.meshes.size(), 1u);
  return summary.meshes[0].recommendation ? summary.meshes[0].recommendation->strategy : "none";
}

TEST(Summary, MeansOfRatesMediansOfTimes) {
  Comparison comparison =
      of_rows({make_row("m", 0, "s", 0.1, 1), make_row("m", 1, "s", 0.2, 2), make_row("m", 2, "s", 0.6, 90)});
  comparison.rows[0].order = {7, 0.5};
  const Summary summary = summarise(comparison);
  const StrategySummary& strategy = summary.meshes.at(0).strategies.at(0);
  EXPECT_EQ(strategy.views, 3u);
  EXPECT_DOUBLE_EQ(*strategy.wrong.mean, 0.3);
  EXPECT_EQ(*strategy.wrong.worst, 0.6);
  EXPECT_EQ(strategy.blend.median_ms, 2);
  EXPECT_EQ(strategy.frame_ms, 8);  // of 8, 2 and 90: not the sum of the medians
}

TEST(Summary, ViewsThatCouldNotBeJudgedCountNeitherWay) {
  Comparison comparison = of_rows({make_row("m", 0, "s", 0.1, 1), make_row("m", 1, "s", 0, 1)});
  comparison.rows[1].wrong_rate.reset();
  comparison.rows[1].unjudged_pixels = 600;
  const StrategySummary strategy = summarise(comparison).meshes.at(0).strategies.at(0);
  EXPECT_EQ(*strategy.wrong.mean, 0.1);
  EXPECT_EQ(strategy.wrong.judged_views, 1u);
  EXPECT_FALSE(strategy.wrong.not_judged);
}

TEST(Summary, NotJudgedIsNotTheSameAsNotApplicable) {
  Comparison comparison = of_rows({make_row("m", 0, "depth_write", 0.1, 1), make_row("m", 0, "unsorted", 0, 1)});
  comparison.rows[1].wrong_rate.reset();
  comparison.rows[1].unjudged_pixels = 501;  // of 10000: over 5 %
  const Summary summary = summarise(comparison);
  EXPECT_FALSE(summary.meshes.at(0).strategies.at(0).inverted.not_judged);
  EXPECT_TRUE(summary.meshes.at(0).strategies.at(1).inverted.not_judged);
  EXPECT_TRUE(summary.meshes.at(0).strategies.at(1).wrong.not_judged);
  EXPECT_FALSE(summary.meshes.at(0).strategies.at(1).wrong.mean);
}

TEST(Summary, TakesTheFastestThatIsRightEnough) {
  const Comparison comparison =
      of_rows({make_row("m", 0, "fast and wrong", 0.5, 1), make_row("m", 0, "right", 0.0009, 3),
               make_row("m", 0, "slow and right", 0, 4), make_row("m", 0, "reference", 0, 2)});
  EXPECT_EQ(taken(comparison), "right");
  EXPECT_TRUE(summarise(comparison).meshes[0].recommendation->is_right_enough);
}

TEST(Summary, OfEquallyFastTakesTheMostRight) {
  EXPECT_EQ(taken(of_rows({make_row("m", 0, "a", 0.0009, 1), make_row("m", 0, "b", 0.0001, 1.09)})), "b");
  EXPECT_EQ(taken(of_rows({make_row("m", 0, "a", 0.0009, 1), make_row("m", 0, "b", 0.0001, 1.11)})), "a");
}

TEST(Summary, TakesTheMostRightWhereNoneIsRightEnough) {
  const Comparison comparison =
      of_rows({make_row("m", 0, "a", 0.5, 1), make_row("m", 0, "b", 0.001, 9), make_row("m", 0, "reference", 0, 2)});
  EXPECT_EQ(taken(comparison), "b");
  EXPECT_FALSE(summarise(comparison).meshes[0].recommendation->is_right_enough);
}

TEST(Summary, TakesNothingWhereNothingWasJudged) {
  Comparison comparison = of_rows({make_row("m", 0, "a", 0, 1), make_row("m", 0, "reference", 0, 2)});
  comparison.rows[0].wrong_rate.reset();
  EXPECT_EQ(taken(comparison), "none");
  EXPECT_FALSE(summarise(comparison).recommendation);
}

TEST(Summary, JudgesByInversionsWhereColoursWereNot) {
  Comparison comparison = of_rows({make_row("m", 0, "a", 0, 1), make_row("m", 0, "b", 0.3, 1)});
  comparison.rows[0].wrong_rate.reset();
  comparison.rows[0].inverted_rate = 0.2;
  EXPECT_EQ(taken(comparison), "a");
}

TEST(Summary, OverAllMeshes) {
  const Summary summary = summarise(test::make_comparison());
  ASSERT_EQ(summary.meshes.size(), 2u);
  EXPECT_EQ(summary.strategies, (std::vector<std::string>{"unsorted", "depth_write", "facet_sort:centroid_distance",
                                                          "novel", "reference"}));
  // Right on the first mesh only; on the second no sort is right enough.
  EXPECT_TRUE(summary.meshes[0].recommendation->is_right_enough);
  EXPECT_FALSE(summary.meshes[1].recommendation->is_right_enough);
  EXPECT_EQ(summary.overall[3].strategy, "novel");
  EXPECT_EQ(summary.overall[3].right_meshes, 1u);
  EXPECT_EQ(summary.overall[3].judged_meshes, 2u);
  EXPECT_DOUBLE_EQ(*summary.overall[3].mean_error, 0.0501);
  EXPECT_DOUBLE_EQ(summary.overall[3].geometric_mean_frame_ms, 3.6);
  ASSERT_TRUE(summary.recommendation);
  EXPECT_EQ(summary.recommendation->strategy, "facet_sort:centroid_distance");
  EXPECT_FALSE(summary.recommendation->is_right_enough) << "one of two is not most";
}

TEST(Summary, RightOnMostMeshesIsRightOverAll) {
  const Comparison comparison =
      of_rows({make_row("m", 0, "a", 0, 1), make_row("n", 0, "a", 0, 1), make_row("o", 0, "a", 1, 1)});
  EXPECT_TRUE(summarise(comparison).recommendation->is_right_enough);
}

TEST(Summary, NamesMeshesThatOnlyRowsKnow) {
  Comparison comparison = test::make_comparison();
  comparison.meshes.pop_back();
  const Summary summary = summarise(comparison);
  ASSERT_EQ(summary.meshes.size(), 2u);
  EXPECT_EQ(summary.meshes[1].mesh.name, "fan");
  EXPECT_EQ(summary.meshes[1].mesh.facets, 1000u);
}

std::string printed(const Comparison& comparison) {
  std::ostringstream out;
  print_summary(out, comparison);
  return out.str();
}

TEST(PrintSummary, FitsInHundredColumnsAndMarksTheOneToTake) {
  std::istringstream lines(printed(test::make_comparison()));
  std::string line, starred;
  bool dash = false;
  while (std::getline(lines, line)) {
    EXPECT_LE(line.size(), 100u) << line;
    if (line.rfind("* ", 0) == 0 && starred.empty()) starred = line;
    dash |= line.find("depth_write") != std::string::npos && line.find(" - ") != std::string::npos;
  }
  EXPECT_NE(starred.find("facet_sort:centroid_distance"), std::string::npos) << starred;
  EXPECT_NE(starred.find("0.0100"), std::string::npos) << starred;
  EXPECT_TRUE(dash) << "depth_write has no inverted rate";
}

TEST(PrintSummary, SaysWhatWasNotJudged) {
  Comparison comparison = of_rows({make_row("m", 0, "a", 0, 1)});
  comparison.rows[0].wrong_rate.reset();
  comparison.rows[0].unjudged_pixels = 9000;
  EXPECT_NE(printed(comparison).find("not judged"), std::string::npos);
  EXPECT_NE(printed(comparison).find("no strategy could be judged"), std::string::npos);
}

TEST(PrintSummary, NoNameDrivesTheTerminal) {
  const std::string text = printed(test::make_comparison("evil\x1b[2J\x7f"));
  EXPECT_NE(text.find("evil?[2J?"), std::string::npos);
  EXPECT_EQ(text.find('\x1b'), std::string::npos);
}

TEST(PrintSummary, EmptyComparison) {
  EXPECT_NE(printed({}).find("strategy"), std::string::npos);
}

}  // namespace
}  // namespace facetsort
