#include "facetsort/report/stability.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "facetsort/report/stability_findings.h"
#include "facetsort/report/stability_plot.h"
#include "report/sample.h"

namespace facetsort {
namespace {

using Json = nlohmann::json;
using test::occurrences;
using Points = std::vector<std::size_t>;
using Ranges = std::vector<PointRange>;

const std::vector<std::string> methods{"naive_centroid", "centroid_distance"};

// A point at which each method has so many inverted pixels of a thousand, by both referees.
StabilityPoint judged_point(double value, std::size_t naive, std::size_t careful) {
  StabilityPoint point;
  point.value = value;
  point.facets = 1280;
  point.lists = point.embree = {1000, 0};
  point.methods = {{naive, naive, naive}, {careful, careful, careful}};
  return point;
}

StabilityPoint unjudged_point(double value) {
  StabilityPoint point;
  point.value = value;
  point.lists = point.embree = {1000, 51};
  point.methods.resize(methods.size());
  return point;
}

// Naive breaks on both sides of 1; the careful method nowhere; 1e6 is judged by nobody, 1e7 by Embree alone.
Stability sample() {
  StabilitySweep scale{"scale", "Overall scale", "units", "All is <scaled>.", {}, 3};
  scale.points = {judged_point(1e-3, 900, 0), judged_point(0.01, 2, 0), judged_point(0.1, 1, 0),  judged_point(1, 0, 0),
                  judged_point(1e5, 20, 0),   unjudged_point(1e6),      judged_point(1e7, 500, 0)};
  scale.points.back().lists.unjudged = 1000;
  for (MethodErrors& errors : scale.points.back().methods) errors.inverted_pixels = errors.wrong_pixels = std::nullopt;
  StabilitySweep eye{"eye_distance", "Distance of the eye", "radii", "The eye moves.", {}, 1};
  eye.points = {judged_point(0, 0, 0), judged_point(1, 0, 0)};
  eye.points[0].place = "on a vertex";
  return {"a machine", "facetsort stability --out <b>", "2026-01-02T03:04:05Z", 64, 64, 3, methods, {scale, eye}};
}

std::string written(Status (*write)(const std::filesystem::path&, const Stability&), const Stability& stability) {
  const test::TemporaryFolder folder;
  const Status status = write(folder / "file", stability);
  EXPECT_TRUE(status.ok()) << status.message;
  EXPECT_EQ(test::file_count(folder.path()), 1u);
  return test::read_text(folder / "file");
}

TEST(Stability, ARefereeJudgesWhereItSeesSomethingAndLeavesAtMostATwentiethOpen) {
  EXPECT_TRUE((RefereeReach{100, 0}.judges()));
  EXPECT_TRUE((RefereeReach{100, 5}.judges()));
  EXPECT_FALSE((RefereeReach{100, 6}.judges()));
  EXPECT_FALSE((RefereeReach{0, 0}.judges()));
}

TEST(Stability, TheLargerShareOfTheTwoRefereesCounts) {
  StabilityPoint point;
  point.lists = {1000, 0};
  point.embree = {500, 0};
  point.methods = {{10, 0, 10}, {10, 0, std::nullopt}, {std::nullopt, std::nullopt, 1}, {}};
  EXPECT_DOUBLE_EQ(point.inverted_rate(0).value(), 0.02);
  EXPECT_DOUBLE_EQ(point.inverted_rate(1).value(), 0.01);
  EXPECT_DOUBLE_EQ(point.inverted_rate(2).value(), 0.002);
  EXPECT_FALSE(point.inverted_rate(3).has_value());
}

TEST(Stability, BreaksAreRunsThatUnjudgedPointsDoNotEnd) {
  const Stability stability = sample();
  const SweepFindings findings = find_breaks(stability.sweeps[0], methods.size());
  // 1 of 1000 is not over a thousandth; 1e6 lies between two broken points.
  EXPECT_EQ(findings.broken[0], (Ranges{{0, 1}, {4, 6}}));
  EXPECT_EQ(findings.broken[1], Ranges{});
  EXPECT_EQ(findings.lists_stop, (Ranges{{5, 6}}));
  EXPECT_EQ(findings.embree_stop, (Ranges{{5, 5}}));
  EXPECT_EQ(findings.nobody_judges, (Ranges{{5, 5}}));
}

TEST(Stability, TroubleBeginsNearestToTheMildestPointOnEitherSide) {
  EXPECT_EQ(first_points({{0, 1}, {4, 6}}, 3), (Points{1, 4}));
  EXPECT_EQ(first_points({{0, 0}, {2, 2}, {5, 5}, {7, 7}}, 3), (Points{2, 5}));
  EXPECT_EQ(first_points({{0, 1}, {3, 6}}, 3), Points{3});
  EXPECT_EQ(first_points({}, 3), Points{});
}

TEST(Stability, FindingsAreSentences) {
  const Stability stability = sample();
  const auto same = [](const std::string& method) { return method; };
  EXPECT_EQ(findings_text(stability.sweeps[0], methods, same),
            "naive_centroid breaks at 1e-3 to 0.01 and at 1e5 to 1e7. centroid_distance inverts nothing wherever a "
            "referee judges. The per-pixel lists cannot judge at 1e6 to 1e7; Embree cannot judge at 1e6. Where neither "
            "can, at 1e6, nothing is said.");
  StabilitySweep sweep = stability.sweeps[1];
  for (MethodErrors& errors : sweep.points[0].methods) errors.inverted_rays = 500;
  EXPECT_EQ(findings_text(sweep, methods, same),
            "naive_centroid and centroid_distance break on a vertex. Both referees judge throughout.");
  sweep.points[0] = unjudged_point(0);
  EXPECT_EQ(findings_text(sweep, methods, same),
            "naive_centroid and centroid_distance invert nothing wherever a referee judges. Neither referee can judge "
            "at 0: nothing is said there.");
  sweep.points[1].methods[0] = {1, 1, 1};
  EXPECT_EQ(findings_text(sweep, methods, same),
            "naive_centroid stays under 0.1 % wherever a referee judges. centroid_distance inverts nothing wherever a "
            "referee judges. Neither referee can judge at 0: nothing is said there.");
  sweep.points = {unjudged_point(1), unjudged_point(2)};
  EXPECT_EQ(findings_text(sweep, methods, same), "No referee can judge anywhere here.");
}

TEST(Stability, ValuesHaveThreeDigits) {
  const std::pair<double, const char*> cases[] = {{0, "0"},
                                                  {1, "1"},
                                                  {3.1622776601683795, "3.16"},
                                                  {0.01, "0.01"},
                                                  {0.0316227766, "0.0316"},
                                                  {1e-6, "1e-6"},
                                                  {3.16e-5, "3.16e-5"},
                                                  {1000, "1000"},
                                                  {1e4, "1e4"},
                                                  {1e-30, "1e-30"},
                                                  {179, "179"},
                                                  {1e12, "1e12"},
                                                  {300, "300"}};
  for (const auto& [value, text] : cases) {
    StabilityPoint point;
    point.value = value;
    EXPECT_EQ(point_text(point), text);
  }
}

TEST(Stability, JsonHasARowForEachPointAndMethodAndNullWhereNothingIsJudged) {
  const Json document = Json::parse(written(write_stability_json, sample()));
  EXPECT_EQ(document.at("methods"), Json(methods));
  EXPECT_EQ(document.at("views"), 3);
  ASSERT_EQ(document.at("sweeps").size(), 2u);
  EXPECT_EQ(document["sweeps"][0].at("breaks_at").at("naive_centroid"), (Json{0.01, 1e5}));
  EXPECT_EQ(document["sweeps"][0].at("breaks_at").at("centroid_distance"), Json::array());
  EXPECT_EQ(document["sweeps"][0].at("lists_stop_at"), Json::array({1e6}));
  ASSERT_EQ(document.at("rows").size(), 18u);
  std::size_t judged = 0;
  for (const Json& row : document.at("rows")) {
    judged += row.at("judged").get<bool>();
    EXPECT_EQ(row.at("judged").get<bool>(), !row.at("inverted_rate").is_null());
    EXPECT_EQ(row.at("value").is_null(), !row.at("place").is_null());
  }
  EXPECT_EQ(judged, 16u);
  const Json first = document["rows"][0];
  EXPECT_EQ(first.at("inverted_pixels"), 900);
  EXPECT_EQ(first.at("inverted_rate"), 0.9);
  const Json unjudged = document["rows"][10];
  EXPECT_EQ(unjudged.at("value"), 1e6);
  EXPECT_EQ(unjudged.at("unjudged_pixels"), 51);
  for (const char* count : {"inverted_pixels", "wrong_pixels", "embree_inverted"}) {
    EXPECT_TRUE(unjudged.at(count).is_null()) << count;
  }
  EXPECT_EQ(document["rows"][14].at("place"), "on a vertex");
}

TEST(Stability, CsvHasTheSameRows) {
  const Json document = Json::parse(written(write_stability_json, sample()));
  std::istringstream csv(written(write_stability_csv, sample()));
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) {
    ASSERT_EQ(line.back(), '\r');
    lines.push_back(line.substr(0, line.size() - 1));
  }
  ASSERT_EQ(lines.size(), document.at("rows").size() + 1);
  const auto fields = [](const std::string& line) { return std::count(line.begin(), line.end(), ',') + 1; };
  for (const std::string& line : lines) EXPECT_EQ(fields(line), static_cast<long>(document["rows"][0].size())) << line;
  EXPECT_EQ(lines[0].rfind("sweep,value,place,method,facets,judged,inverted_rate,", 0), 0u);
  EXPECT_EQ(lines[1], "scale,0.001,,naive_centroid,1280,true,0.9,1000,0,900,900,1000,0,900");
  EXPECT_EQ(lines[11], "scale,1000000.0,,naive_centroid,0,false,,1000,51,,,1000,51,");
}

TEST(Stability, ThePageHasEverySweepAndSaysWhatIsNotJudged) {
  const std::string page = written(write_stability_page, sample());
  for (const char* id : {"overview", "scale", "eye_distance"}) {
    EXPECT_EQ(occurrences(page, "<section id=\"" + std::string(id) + "\">"), 1u) << id;
  }
  EXPECT_EQ(occurrences(page, "<svg class=\"sweep\""), 2u);
  EXPECT_EQ(occurrences(page, "colspan=\"2\">not judged<"), 1u);
  EXPECT_EQ(occurrences(page, "<small>Embree alone</small>"), 2u);
  EXPECT_NE(page.find("<b>centroid_<wbr>distance</b> has no inverted and no wrong pixel at any of the 8 points"),
            std::string::npos);
  EXPECT_NE(page.find("<b>naive_<wbr>centroid</b> breaks at 1e-3 to 0.01 and at 1e5 to 1e7."), std::string::npos);
  // Text from outside is text.
  EXPECT_NE(page.find("All is &lt;scaled&gt;."), std::string::npos);
  EXPECT_EQ(page.find("--out <b>"), std::string::npos);
  for (const char* element : {"section", "table", "svg", "details", "ul", "td", "tr", "p", "g"}) {
    const std::string name = element;
    EXPECT_EQ(occurrences(page, "<" + name + " ") + occurrences(page, "<" + name + ">"),
              occurrences(page, "</" + name + ">"))
        << element;
  }
}

TEST(Stability, ThePageNeedsNoNetwork) {
  const std::string page = written(write_stability_page, sample());
  for (const char* outside : {"http:", "https:", "src=", "<link", "url(", "@import"}) {
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  }
}

TEST(Stability, ThePageClaimsNothingWhereNothingIsJudged) {
  Stability stability = sample();
  for (StabilitySweep& sweep : stability.sweeps) sweep.points = {unjudged_point(1), unjudged_point(10)};
  const std::string page = written(write_stability_page, stability);
  EXPECT_NE(page.find("Nothing could be judged."), std::string::npos);
  EXPECT_EQ(page.find("has no inverted"), std::string::npos);
  EXPECT_EQ(occurrences(page, "colspan=\"2\">not judged<"), 4u);
  EXPECT_EQ(occurrences(page, "<td class=\"rate0\">"), 0u);
}

// Heights of a method's marks in a plot, from the top.
std::vector<double> mark_heights(const std::string& svg, std::size_t method) {
  const std::string mark = "<use href=\"#look-" + std::to_string(method) + "\" transform=\"translate(";
  std::vector<double> heights;
  for (std::size_t place = svg.find(mark); place != std::string::npos; place = svg.find(mark, place + 1)) {
    heights.push_back(std::stod(svg.substr(svg.find(' ', place + mark.size()))));
  }
  return heights;
}

TEST(StabilityPlot, LargerIsHigherZeroIsBelowAndNothingStandsForUnjudged) {
  const std::string svg = stability_plot(sample().sweeps[0], methods);
  const std::vector<double> naive = mark_heights(svg, 0), careful = mark_heights(svg, 1);
  ASSERT_EQ(naive.size(), 6u);  // of seven points; nobody judges one
  ASSERT_EQ(careful.size(), 6u);
  EXPECT_LT(naive[0], naive[1]);  // 90 % and 0.2 %
  EXPECT_LT(naive[1], naive[2]);
  EXPECT_LT(naive[2], naive[3]);  // 0.1 % and 0
  for (const double height : careful) EXPECT_EQ(height, careful[0]);
  EXPECT_NE(careful[0], naive[3]);  // zeros do not hide each other
  EXPECT_EQ(occurrences(svg, ">not judged</text>"), 1u);
  EXPECT_NE(svg.find("<title>naive_centroid at 1e5: 2.00 % inverted</title>"), std::string::npos);
  EXPECT_NE(svg.find("<title>lists at 1e6: 5.10 % left open</title>"), std::string::npos);
  EXPECT_EQ(occurrences(svg, "class=\"judges-not\""), 3u);
}

TEST(StabilityPlot, PlacesStandLeftOfNumbers) {
  const std::string svg = stability_plot(sample().sweeps[1], methods);
  const auto x_of = [&](const std::string& text) {
    const std::size_t end = svg.find(">" + text + "</text>");
    EXPECT_NE(end, std::string::npos) << text;
    return std::stod(svg.substr(svg.rfind("x=\"", end) + 3));
  };
  EXPECT_LT(x_of("on a"), x_of("1"));
  EXPECT_EQ(x_of("on a"), x_of("vertex"));
}

TEST(Stability, TheTableHasALineForEachSweep) {
  std::ostringstream out;
  print_stability(out, sample());
  std::istringstream lines(out.str());
  std::string above, heading, scale, eye;
  std::getline(lines, above);
  std::getline(lines, heading);
  std::getline(lines, scale);
  std::getline(lines, eye);
  EXPECT_EQ(above, "                  naive  centroid  lists  Embree");
  EXPECT_EQ(heading, "sweep          centroid  distance   stop   stops");
  EXPECT_EQ(scale, "scale         0.01, 1e5         -    1e6     1e6");
  EXPECT_EQ(eye, "eye_distance          -         -      -       -");
}

TEST(Stability, AFolderThatIsNotThereIsAFault) {
  const test::TemporaryFolder folder;
  for (const auto write : {write_stability_json, write_stability_csv, write_stability_page}) {
    const Status status = write(folder / "missing" / "file", sample());
    EXPECT_EQ(status.fault, Fault::cannot_write);
    EXPECT_NE(status.message.find("missing"), std::string::npos);
  }
}

}  // namespace
}  // namespace facetsort
