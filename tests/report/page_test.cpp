#include <gtest/gtest.h>
#include <stdlib.h>

#include <optional>
#include <regex>
#include <set>
#include <string>

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

// Every element is closed in turn: what a browser would have to guess at is a fault here.
void expect_well_formed(const std::string& page) {
  static const std::set<std::string> empty_elements{"meta", "br", "img", "wbr", "link"};
  static const std::regex tag("<(/?)([a-zA-Z][a-zA-Z0-9]*)((?:[^>\"']|\"[^\"]*\"|'[^']*')*)>");
  std::string body = page;
  for (const char* name : {"style", "script"}) {
    const std::string begin = std::string("<") + name + ">", end = std::string("</") + name + ">";
    const std::size_t from = body.find(begin) + begin.size();
    body.erase(from, body.find(end) - from);
  }
  std::vector<std::string> open;
  std::string between;
  std::size_t last = body.find("<html");
  for (std::sregex_iterator match(body.begin() + static_cast<std::ptrdiff_t>(last), body.end(), tag), end; match != end;
       ++match) {
    const std::string name = (*match)[2], attributes = (*match)[3];
    if ((*match)[1].length() > 0) {
      ASSERT_FALSE(open.empty());
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    } else if (empty_elements.count(name) == 0 && (attributes.empty() || attributes.back() != '/')) {
      open.push_back(name);
    }
    const std::string text = match->prefix();
    EXPECT_EQ(text.find('<'), std::string::npos) << text;
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
  EXPECT_NE(page.find("No strategy stays under"), std::string::npos);                  // the second mesh
  EXPECT_NE(page.find("<title>novel: 0.0200 %, 3.60 ms</title>"), std::string::npos);  // a mark's tooltip
}

TEST(Page, NeedsNoNetwork) {
  const std::string page = written_page(test::make_comparison());
  static const std::regex outside("(src|href)=[\"'](https?:)?//|@import|url\\(");
  EXPECT_FALSE(std::regex_search(page, outside));
}

TEST(Page, EveryAnchorLeadsSomewhereAndNoIdStandsTwice) {
  const std::string page = written_page(test::make_comparison());
  std::set<std::string> ids;
  static const std::regex id("\\sid=[\"']([^\"']*)[\"']");
  for (std::sregex_iterator match(page.begin(), page.end(), id), end; match != end; ++match) {
    EXPECT_TRUE(ids.insert((*match)[1]).second) << (*match)[1] << " stands twice";
  }
  static const std::regex reference("href=[\"']#([^\"']*)[\"']");
  std::size_t references = 0;
  for (std::sregex_iterator match(page.begin(), page.end(), reference), end; match != end; ++match, ++references) {
    EXPECT_EQ(ids.count((*match)[1]), 1u) << (*match)[1];
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
  static const std::regex place("<use [^>]*translate\\(([0-9.]+),([0-9.]+)\\)");
  std::smatch match;
  EXPECT_TRUE(std::regex_search(drawn.value().svgs.at(0), match, place));
  return std::stod(match[2]);
}

TEST(Gnuplot, LargerErrorsAreHigherAndZeroIsLowest) {
  EXPECT_LT(mark_height(1), mark_height(0.1));  // SVG's y points down
  EXPECT_LT(mark_height(0.1), mark_height(0.001));
  EXPECT_LT(mark_height(0.0002), mark_height(0));
}

}  // namespace
}  // namespace facetsort
