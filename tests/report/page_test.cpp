#include <gtest/gtest.h>
#include <stdlib.h>

#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "facetsort/blend/strategy.h"
#include "facetsort/report/plots.h"
#include "facetsort/report/write_report.h"
#include "report/sample.h"

namespace facetsort {
namespace {

using test::occurrences;

// An environment variable with another value for a while.
class ChangedVariable {
 public:
  ChangedVariable(const char* name, const std::string& value) : name_(name) {
    if (const char* old = getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ChangedVariable(const ChangedVariable&) = delete;
  ChangedVariable& operator=(const ChangedVariable&) = delete;
  ~ChangedVariable() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }

 private:
  const char* name_;
  std::optional<std::string> old_;
};

std::string written_page(const Comparison& comparison) {
  const test::TemporaryFolder folder;
  const Status status = write_page(folder / "index.html", comparison);
  EXPECT_TRUE(status.ok()) << status.message;
  return test::read_text(folder / "index.html");
}

struct Tag {
  std::string name;
  bool closing = false;
  std::map<std::string, std::string> attributes;  // values as they stand, not unescaped
};

// The tag that begins at `place`, which is moved behind it. Whatever a browser would have to guess at is a fault.
Tag read_tag(const std::string& page, std::size_t& place) {
  const auto at = [&](std::size_t i) { return i < page.size() ? page[i] : '\0'; };
  const auto word = [&] {
    const std::size_t begin = place;
    while (std::isalnum(static_cast<unsigned char>(at(place))) || at(place) == '-' || at(place) == ':') ++place;
    return page.substr(begin, place - begin);
  };
  const auto skip_space = [&] {
    while (std::isspace(static_cast<unsigned char>(at(place)))) ++place;
  };
  Tag tag;
  ++place;
  tag.closing = at(place) == '/';
  place += tag.closing;
  tag.name = word();
  EXPECT_FALSE(tag.name.empty()) << "a stray < before " << page.substr(place, 40);
  for (skip_space(); at(place) != '>' && at(place) != '/' && at(place) != '\0'; skip_space()) {
    const std::string attribute = word();
    skip_space();
    std::string& value = tag.attributes[attribute];
    if (at(place) != '=') {
      EXPECT_EQ(attribute, "open");  // the only attribute of ours without a value
      if (attribute != "open") break;
      continue;
    }
    ++place;
    skip_space();
    const char quote = at(place);
    EXPECT_TRUE(quote == '"' || quote == '\'') << "an unquoted " << attribute;
    const std::size_t end = page.find(quote, place + 1);
    if (end == std::string::npos) break;
    value = page.substr(place + 1, end - place - 1);
    EXPECT_EQ(value.find('<'), std::string::npos) << value;
    place = end + 1;
  }
  if (at(place) == '/') {
    tag.attributes["/"];  // <use/> and its like need no end
    ++place;
  }
  EXPECT_EQ(at(place), '>') << "in " << tag.name;
  ++place;
  return tag;
}

// All tags of the page. The contents of <style> and <script> are no markup.
std::vector<Tag> read_tags(const std::string& page) {
  std::vector<Tag> tags;
  std::size_t place = page.find("<html");
  while ((place = page.find('<', place)) != std::string::npos) {
    tags.push_back(read_tag(page, place));
    const Tag& tag = tags.back();
    if (!tag.closing && (tag.name == "style" || tag.name == "script")) place = page.find("</" + tag.name, place);
  }
  return tags;
}

void expect_well_formed(const std::string& page) {
  static const std::set<std::string> empty_elements{"meta", "br", "img", "wbr"};
  std::vector<std::string> open;
  for (const Tag& tag : read_tags(page)) {
    if (tag.closing) {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), tag.name);
      open.pop_back();
    } else if (empty_elements.count(tag.name) == 0 && tag.attributes.count("/") == 0) {
      open.push_back(tag.name);
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(Page, SaysWhatToTakeAndShowsEachMesh) {
  const std::string page = written_page(test::make_comparison());
  expect_well_formed(page);
  EXPECT_NE(page.find("Take <b>facet_<wbr>sort:<wbr>centroid_<wbr>distance</b>"), std::string::npos);
  EXPECT_EQ(occurrences(page, "<h2>"), 3u);
  EXPECT_EQ(occurrences(page, "<svg class=\"plot\""), 5u);  // one over all, two a mesh
  EXPECT_EQ(occurrences(page, "<img loading=\"lazy\""), 6u);
  EXPECT_EQ(occurrences(page, "alt=\""), 6u);
  EXPECT_NE(page.find("No strategy is right on most meshes. The closest is <b>facet_"), std::string::npos);
  EXPECT_NE(page.find("No strategy stays under"), std::string::npos);                  // the second mesh
  EXPECT_NE(page.find("<title>novel: 0.0200 %, 3.60 ms</title>"), std::string::npos);  // a mark's tooltip
}

TEST(Page, TellsWhatTheExactOrderHadToDoInEachView) {
  Comparison comparison = test::make_comparison();
  EXPECT_EQ(written_page(comparison).find("What the exact orders had to do"), std::string::npos);
  comparison.rows.push_back(test::make_exact_row("cup", 0, 54321));
  comparison.rows.push_back(test::make_exact_row("cup", 1, 65432));
  const std::string page = written_page(comparison);
  expect_well_formed(page);
  EXPECT_EQ(occurrences(page, "What the exact orders had to do"), 1u);
  for (const char* said : {", view 1</th><td>7</td>", "<td>54,321</td>", "<td>65,432</td>",
                           ">candidate pairs</th>", ">pairs<small>ms</small></th>", "<td>0.625</td>"}) {
    EXPECT_NE(page.find(said), std::string::npos) << said;
  }
  // The table of all strategies, too.
  EXPECT_NE(page.find("<td>1,010</td><td>1,030</td>"), std::string::npos);
}

TEST(Page, EveryStrategyHasAMarkOfItsOwn) {
  Comparison comparison;
  for (const Strategy& strategy : all_strategies()) {
    comparison.rows.push_back(test::make_row("cup", 0, strategy.name(), 0.1, 1));
  }
  const std::string page = written_page(comparison);
  const std::size_t legend = page.find("<ul class=\"legend\"");
  const std::string items = page.substr(legend, page.find("</ul>", legend) - legend);
  std::set<std::string> marks;
  for (const Tag& tag : read_tags("<html>" + items)) {
    if (tag.name == "use") marks.insert(tag.attributes.at("href") + tag.attributes.at("color"));
  }
  EXPECT_EQ(marks.size(), all_strategies().size());
}

TEST(Page, LeadsToTheStabilityPageBesideIt) {
  Comparison comparison = test::make_comparison();
  EXPECT_EQ(written_page(comparison).find("stability.html"), std::string::npos);
  comparison.has_stability_page = true;
  const std::string page = written_page(comparison);
  expect_well_formed(page);
  EXPECT_EQ(occurrences(page, "<a href=\"stability.html\">"), 1u);
}

TEST(Page, NeedsNoNetwork) {
  const std::string page = written_page(test::make_comparison());
  std::size_t references = 0;
  for (const Tag& tag : read_tags(page)) {
    for (const char* name : {"href", "src", "xlink:href"}) {
      const auto reference = tag.attributes.find(name);
      if (reference == tag.attributes.end()) continue;
      ++references;
      EXPECT_EQ(reference->second.find(':'), std::string::npos) << reference->second;
      EXPECT_NE(reference->second.rfind("//", 0), 0u) << reference->second;
    }
    EXPECT_NE(tag.name, "link");
  }
  EXPECT_GT(references, 40u);
  EXPECT_EQ(page.find("@import"), std::string::npos);
  EXPECT_EQ(page.find("url("), std::string::npos);
}

TEST(Page, EveryAnchorLeadsSomewhereAndNoIdStandsTwice) {
  const std::vector<Tag> tags = read_tags(written_page(test::make_comparison()));
  std::set<std::string> ids;
  for (const Tag& tag : tags) {
    if (const auto id = tag.attributes.find("id"); id != tag.attributes.end()) {
      EXPECT_TRUE(ids.insert(id->second).second) << id->second << " stands twice";
    }
  }
  std::size_t references = 0;
  for (const Tag& tag : tags) {
    for (const char* name : {"href", "xlink:href"}) {
      const auto reference = tag.attributes.find(name);
      if (reference == tag.attributes.end() || reference->second.rfind('#', 0) != 0) continue;
      ++references;
      EXPECT_EQ(ids.count(reference->second.substr(1)), 1u) << reference->second;
    }
  }
  EXPECT_GT(references, 40u);
}

TEST(Page, WeirdNamesStayText) {
  const std::string name = "</title><script>alert(1)</script>\"'&`$(touch x)\\`%s\n\x1b'; system 'touch y";
  Comparison comparison = test::make_comparison(name, "Fran\xc3\xa7ois 100%.v2");
  comparison.command = "facetsort compare '<b>'";
  comparison.machine = "<i>";
  comparison.rows.push_back(test::make_row(name, 0, "<u>:'\"", 0.1, 1));
  const std::string page = written_page(comparison);
  expect_well_formed(page);
  EXPECT_EQ(occurrences(page, "<script"), 1u);
  EXPECT_EQ(occurrences(page, "alert(1)</script>"), 0u);
  EXPECT_EQ(page.find("<i>"), std::string::npos);
  EXPECT_EQ(page.find("<u>"), std::string::npos);
  EXPECT_NE(page.find("facetsort compare &#39;&lt;b&gt;&#39;"), std::string::npos);
  EXPECT_NE(page.find("src=\"Fran%C3%A7ois%20100%25.v2/unsorted.png\""), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists("x"));
  EXPECT_FALSE(std::filesystem::exists("y"));
}

TEST(Page, TimesAndRatesOfAnySize) {
  Comparison comparison = test::make_comparison();
  comparison.rows[0].blend.median_ms = 0;
  comparison.rows[1].blend.median_ms = 1e7;
  comparison.rows[2].wrong_rate = 1e-30;
  for (const Row& row : std::vector<Row>(comparison.rows)) {
    if (row.mesh == "cup") comparison.rows.push_back(row);
  }
  expect_well_formed(written_page(comparison));
}

TEST(Page, UnjudgedMeshesSaySo) {
  Comparison comparison = test::make_comparison();
  for (Row& row : comparison.rows) {
    row.wrong_rate.reset();
    row.inverted_rate.reset();
    row.unjudged_pixels = row.covered_pixels;
  }
  const std::string page = written_page(comparison);
  expect_well_formed(page);
  EXPECT_EQ(occurrences(page, "<svg class=\"plot\""), 0u);
  EXPECT_EQ(occurrences(page, "No strategy could be judged."), 3u);
  EXPECT_NE(page.find(">not judged<"), std::string::npos);
  EXPECT_EQ(page.find("Take <b>"), std::string::npos);
}

TEST(Page, IsTheSameEachTime) {
  EXPECT_EQ(written_page(test::make_comparison()), written_page(test::make_comparison()));
}

TEST(Page, NoRowsIsAFault) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(write_page(folder / "index.html", {}).fault, Fault::bad_argument);
  EXPECT_EQ(test::file_count(folder.path()), 0u);
}

TEST(Gnuplot, MissingIsAClearFaultAndKeepsTheOldPage) {
  const test::TemporaryFolder folder, empty;
  test::write_text(folder / "index.html", "old");
  const ChangedVariable path("PATH", empty.path().string());
  const Status status = write_page(folder / "index.html", test::make_comparison());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, (folder / "index.html").string() + ": gnuplot, which draws the plots, is not on PATH");
  EXPECT_EQ(test::read_text(folder / "index.html"), "old");
  EXPECT_EQ(test::file_count(folder.path()), 1u);
}

// A program of that name that does what the test wants.
Status with_gnuplot(const std::string& script) {
  const test::TemporaryFolder folder;
  const std::filesystem::path program = folder / "gnuplot";
  test::write_text(program, "#!/bin/sh\n" + script);
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  const ChangedVariable path("PATH", folder.path().string() + ":/usr/bin:/bin");
  return write_page(folder / "index.html", test::make_comparison());
}

TEST(Gnuplot, ItsFailureIsOneLine) {
  const Status failed = with_gnuplot("echo 'line 1' >&2; echo 'line 2: unknown terminal' >&2; echo >&2; exit 1\n");
  EXPECT_EQ(failed.fault, Fault::cannot_write);
  EXPECT_NE(failed.message.find("gnuplot failed: line 2: unknown terminal"), std::string::npos) << failed.message;
  EXPECT_EQ(failed.message.find('\n'), std::string::npos);
  EXPECT_NE(with_gnuplot("kill -9 $$\n").message.find("gnuplot failed"), std::string::npos);
  EXPECT_NE(with_gnuplot("exit 0\n").message.find("gnuplot drew no plot"), std::string::npos);
}

TEST(Gnuplot, LeavesNothingInTheTemporaryFolder) {
  const test::TemporaryFolder folder;
  const std::filesystem::path quoted = folder / "it's";
  std::filesystem::create_directory(quoted);
  const ChangedVariable temporary("TMPDIR", quoted.string());
  Plot plot;
  plot.points.push_back({1, 0.1, "a mark", {7, "#1f78d1"}, false});
  const Result<DrawnPlots> drawn = draw_plots({&plot, 1});
  ASSERT_TRUE(drawn.ok()) << drawn.status().message;
  EXPECT_EQ(drawn.value().svgs.size(), 1u);
  EXPECT_NE(drawn.value().definitions.find("gpPt6"), std::string::npos);
  EXPECT_EQ(occurrences(drawn.value().svgs[0], "<use "), 1u);
  EXPECT_EQ(test::file_count(quoted), 0u);
}

TEST(Gnuplot, NoTemporaryFolderIsAFault) {
  const test::TemporaryFolder folder;
  const ChangedVariable temporary("TMPDIR", (folder / "missing").string());
  Plot plot;
  plot.points.push_back({1, 0.1, "a mark", {7, "#1f78d1"}, false});
  EXPECT_EQ(draw_plots({&plot, 1}).status().message, "the temporary folder cannot be written");
}

// Height of the only mark in a plot with a rate.
double mark_height(double rate) {
  Plot plot;
  plot.points.push_back({1, rate, "a mark", {7, "#1f78d1"}, false});
  const Result<DrawnPlots> drawn = draw_plots({&plot, 1});
  EXPECT_TRUE(drawn.ok());
  const std::string svg = drawn.value().svgs.at(0);
  const std::size_t mark = svg.find("<use ");
  const std::size_t comma = svg.find(',', svg.find("translate(", mark));
  return std::stod(svg.substr(comma + 1));
}

TEST(Gnuplot, LargerErrorsAreHigherAndZeroIsLowest) {
  EXPECT_LT(mark_height(1), mark_height(0.1));  // SVG's y points down
  EXPECT_LT(mark_height(0.1), mark_height(0.001));
  EXPECT_LT(mark_height(0.0002), mark_height(0));
}

}  // namespace
}  // namespace facetsort
