#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "facetsort/report/write_report.h"
#include "report/sample.h"

namespace facetsort {
namespace {

using OrderedJson = nlohmann::ordered_json;
using test::read_text;

const std::vector<std::string>& row_keys() {
  static const std::vector<std::string> keys{"mesh",
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
                                             "embree_unjudged"};
  return keys;
}

OrderedJson written_json(const Comparison& comparison) {
  const test::TemporaryFolder folder;
  const Status status = write_json(folder / "results.json", comparison);
  EXPECT_TRUE(status.ok()) << status.message;
  return OrderedJson::parse(read_text(folder / "results.json"));
}

// RFC 4180, read back: rows of fields.
std::vector<std::vector<std::string>> parse_csv(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (quoted) {
      if (text[i] != '"') {
        fields.back() += text[i];
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        fields.back() += text[++i];
      } else {
        quoted = false;
      }
    } else if (text[i] == '"') {
      quoted = true;
    } else if (text[i] == ',') {
      fields.emplace_back();
    } else if (text.compare(i, 2, "\r\n") == 0) {
      rows.push_back(fields);
      fields.assign(1, "");
      ++i;
    } else {
      fields.back() += text[i];
    }
  }
  EXPECT_EQ(fields, std::vector<std::string>(1)) << "the last line is not ended";
  return rows;
}

std::vector<std::vector<std::string>> written_csv(const Comparison& comparison) {
  const test::TemporaryFolder folder;
  const Status status = write_csv(folder / "results.csv", comparison);
  EXPECT_TRUE(status.ok()) << status.message;
  return parse_csv(read_text(folder / "results.csv"));
}

TEST(OrderedJson, HasTheDocumentedKeysInOrder) {
  const OrderedJson json = written_json(test::make_comparison());
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{"machine", "command", "date", "size", "views", "meshes", "rows"}));
  ASSERT_EQ(json["rows"].size(), 20u);
  for (const OrderedJson& row : json["rows"]) {
    keys.clear();
    for (const auto& [key, value] : row.items()) keys.push_back(key);
    std::vector<std::string> expected = row_keys();
    expected.push_back("exact");
    EXPECT_EQ(keys, expected);
  }
}

TEST(OrderedJson, HasTheStatisticsOfTheExactOrder) {
  Comparison comparison = test::make_comparison();
  comparison.rows.push_back(test::make_exact_row("cup", 0, 54321));
  const OrderedJson json = written_json(comparison);
  EXPECT_TRUE(json["rows"].front()["exact"].is_null());
  const OrderedJson& exact = json["rows"].back()["exact"];
  std::vector<std::string> keys, times;
  for (const auto& [key, value] : exact.items()) keys.push_back(key);
  for (const auto& [key, value] : exact["times_ms"].items()) times.push_back(key);
  EXPECT_EQ(keys, (std::vector<std::string>{
                      "crossing_pairs", "crossing_pairs_uncut", "prepared_cuts", "prepared_pieces", "tree_nodes",
                      "tree_cuts", "candidate_pairs", "constraints", "searches", "components", "pieces_in_cycles",
                      "largest_component", "rejoined_cuts", "view_cuts", "unordered_pairs", "predicate_fallbacks",
                      "pieces", "triangles", "times_ms"}));
  EXPECT_EQ(times, (std::vector<std::string>{"prepare", "project", "pairs", "order", "cut"}));
  EXPECT_EQ(exact["crossing_pairs"], 7);
  EXPECT_EQ(exact["candidate_pairs"], 54321);
  EXPECT_EQ(exact["triangles"], 1030);
  EXPECT_EQ(exact["times_ms"]["pairs"], 0.625);
}

TEST(OrderedJson, KeepsEveryValue) {
  Comparison comparison = test::make_comparison();
  Row& row = comparison.rows.front();
  row.order = {0.1, 0.2};
  row.peak_bytes = 12345678901234;
  row.embree_inverted = 0;
  row.rmse = 1.0 / 3;
  const OrderedJson json = written_json(comparison);
  EXPECT_EQ(json["machine"], "a machine");
  EXPECT_EQ(json["size"], (OrderedJson{64, 64}));
  EXPECT_EQ(json["views"], 2);
  EXPECT_EQ(json["meshes"][1]["name"], "fan");
  EXPECT_EQ(json["meshes"][1]["most_layers"], 9);
  const OrderedJson& first = json["rows"][0];
  EXPECT_EQ(first["strategy"], "unsorted");
  EXPECT_EQ(first["order_ms"], 0.1);
  EXPECT_EQ(first["order_ms_spread"], 0.2);
  EXPECT_EQ(first["blend_ms"], 2.0);
  EXPECT_EQ(first["peak_bytes"], 12345678901234);
  EXPECT_EQ(first["wrong_rate"], 0.5);
  EXPECT_EQ(first["wrong_pixels"], 5000);
  EXPECT_EQ(first["embree_inverted"], 0);
  EXPECT_EQ(first["rmse"], 1.0 / 3);  // to the bit
}

TEST(OrderedJson, EyesAreShortAndReadBackToTheBit) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(write_json(folder / "results.json", test::make_comparison()).ok());
  const std::string text = read_text(folder / "results.json");
  EXPECT_NE(text.find("\"eye\":[0.3,-2.0,1e-20]"), std::string::npos);
  const OrderedJson eye = OrderedJson::parse(text)["rows"][0]["eye"];
  EXPECT_EQ(eye[0].get<float>(), 0.3f);
  EXPECT_EQ(eye[2].get<float>(), 1e-20f);
}

TEST(OrderedJson, WhatDoesNotApplyIsNull) {
  const OrderedJson json = written_json(test::make_comparison());
  const OrderedJson& depth_write = json["rows"][1];
  ASSERT_EQ(depth_write["strategy"], "depth_write");
  for (const char* key :
       {"method", "inverted_pixels", "inverted_rate", "miscovered_pixels", "worst_backtrack", "embree_inverted"}) {
    EXPECT_TRUE(depth_write[key].is_null()) << key;
  }
  EXPECT_EQ(json["rows"][2]["method"], "centroid_distance");
}

TEST(OrderedJson, NotANumberIsNull) {
  Comparison comparison = test::make_comparison();
  comparison.rows[0].rmse = std::nan("");
  EXPECT_TRUE(written_json(comparison)["rows"][0]["rmse"].is_null());
}

TEST(OrderedJson, TakesAnyFileName) {
  const std::string name = "a \"quoted\"\\\n\x01 name, \xc3\xa9";
  EXPECT_EQ(written_json(test::make_comparison(name))["rows"][0]["mesh"], name);
  // Not UTF-8: the byte is replaced, the document stays valid.
  EXPECT_EQ(written_json(test::make_comparison("caf\xe9"))["rows"][0]["mesh"], "caf\xef\xbf\xbd");
}

TEST(OrderedJson, EmptyComparison) {
  const OrderedJson json = written_json({});
  EXPECT_TRUE(json["rows"].is_array());
  EXPECT_TRUE(json["rows"].empty());
}

TEST(Csv, HasTheColumnsAndValuesOfTheJson) {
  const Comparison comparison = test::make_comparison();
  const auto csv = written_csv(comparison);
  const OrderedJson json = written_json(comparison);
  ASSERT_EQ(csv.size(), comparison.rows.size() + 1);
  EXPECT_EQ(csv[0], row_keys());
  for (std::size_t r = 0; r < comparison.rows.size(); ++r) {
    ASSERT_EQ(csv[r + 1].size(), row_keys().size());
    for (std::size_t c = 0; c < row_keys().size(); ++c) {
      const OrderedJson& value = json["rows"][r][row_keys()[c]];
      const std::string& field = csv[r + 1][c];
      if (value.is_null()) {
        EXPECT_EQ(field, "");
      } else if (value.is_string()) {
        EXPECT_EQ(field, value.get<std::string>());
      } else if (value.is_array()) {
        EXPECT_EQ(field, "0.3,-2.0,1e-20");
      } else {
        EXPECT_EQ(OrderedJson::parse(field), value);
      }
    }
  }
}

TEST(Csv, QuotesWhatNeedsIt) {
  for (const std::string name : {"plain", "a,b", "say \"cup\"", "two\nlines", "two\r\nlines", "\"", " spaces "}) {
    const auto csv = written_csv(test::make_comparison(name));
    ASSERT_EQ(csv.size(), 21u) << name;
    EXPECT_EQ(csv[1][0], name);
  }
}

class Unwritable : public testing::Test {
 protected:
  // A folder in the way of each file: it cannot be replaced by a file, not even by root.
  void expect_fault(Status (*write)(const std::filesystem::path&, const Comparison&)) const {
    const test::TemporaryFolder folder;
    const std::filesystem::path target = folder / "out";
    std::filesystem::create_directories(target / "inside");
    const Status in_the_way = write(target, test::make_comparison());
    EXPECT_EQ(in_the_way.fault, Fault::cannot_write);
    EXPECT_EQ(in_the_way.message.rfind(target.string() + ": ", 0), 0u) << in_the_way.message;
    EXPECT_TRUE(std::filesystem::is_directory(target / "inside"));
    EXPECT_EQ(test::file_count(folder.path()), 1u) << "a temporary file was left";

    const Status no_folder = write(folder / "missing/out", test::make_comparison());
    EXPECT_EQ(no_folder.fault, Fault::cannot_write);
    EXPECT_EQ(no_folder.message.find('\n'), std::string::npos);
    EXPECT_NE(no_folder.message.find("No such file"), std::string::npos) << no_folder.message;
  }
};

TEST_F(Unwritable, OrderedJson) {
  expect_fault(write_json);
}
TEST_F(Unwritable, Csv) {
  expect_fault(write_csv);
}
TEST_F(Unwritable, Page) {
  expect_fault(write_page);
}

TEST(Replacing, LeavesOnlyTheNewFile) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "results.json", "old");
  ASSERT_TRUE(write_json(folder / "results.json", test::make_comparison()).ok());
  EXPECT_EQ(test::file_count(folder.path()), 1u);
  EXPECT_EQ(read_text(folder / "results.json").rfind("{\n \"machine\"", 0), 0u);
}

}  // namespace
}  // namespace facetsort
