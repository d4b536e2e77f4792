// The corpus: each entry of meshes/expected.json is a test of one mesh, with a budget of error for each strategy.
// A new mesh with a budget is a new test; no C++ is needed.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <nlohmann/json.hpp>

#include "facetsort/blend/strategy.h"
#include "facetsort/check/picture_verdict.h"
#include "facetsort/check/verdict.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

std::filesystem::path meshes_folder() { return std::filesystem::path(FACETSORT_SOURCE_DIR) / "meshes"; }

const nlohmann::json& expectations() {
  static const nlohmann::json parsed = [] {
    std::ifstream file(meshes_folder() / "expected.json");
    return nlohmann::json::parse(file);
  }();
  return parsed;
}

std::vector<std::string> expected_meshes() {
  std::vector<std::string> names;
  for (const auto& [name, budgets] : expectations().at("meshes").items()) names.push_back(name);
  return names;
}

// The ways in which a mesh is turned before its error is measured: the budget holds for each.
struct Turn {
  const char* name;
  glm::mat3 matrix;
};

std::vector<Turn> turns() {
  return {{"as it is", glm::mat3(1)},
          {"mirrored", glm::mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1)},
          {"rotated", glm::mat3(glm::rotate(glm::mat4(1), 1.1f, glm::vec3(0.36f, 0.48f, 0.8f)))}};
}

struct Measured {
  std::size_t covered = 0, inverted = 0, wrong = 0, unjudged = 0, miscovered = 0;

  double inverted_rate() const { return static_cast<double>(inverted) / static_cast<double>(covered); }
  double wrong_rate() const { return static_cast<double>(wrong) / static_cast<double>(covered); }
};

void measure(const Mesh& mesh, const View& view, const FragmentLists& lists, const Strategy& strategy,
             Measured& total) {
  Image reference, picture, coverage;
  blend_lists(mesh.view(), view, lists, PixelFormat::rgba32f, reference);
  StrategyRenderer renderer(mesh.view(), strategy);
  renderer.order(view);
  renderer.draw(view, PixelFormat::rgba32f, picture);
  const JudgeOptions options{.bounding_radius = static_cast<double>(facet_bounds(mesh.view()).radius())};
  const PictureVerdict verdict = judge_picture(mesh.view(), view, lists, reference, picture, options);
  total.covered += verdict.covered_pixels;
  total.wrong += verdict.wrong_pixels;
  total.unjudged += verdict.unjudged_pixels;
  if (!strategy.draws_in_order()) return;
  total.inverted += judge_drawing(lists, renderer.ranks(view, lists), options).inverted_pixels;
  renderer.draw_coverage(view, coverage);
  for (std::size_t pixel = 0; pixel < coverage.pixels.size(); ++pixel) {
    total.miscovered += coverage.pixels[pixel].r != static_cast<float>(lists.pixel(pixel).size());
  }
}

class Corpus : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Meshes, Corpus, testing::ValuesIn(expected_meshes()),
                         [](const auto& mesh) { return mesh.param; });

TEST_P(Corpus, StaysWithinItsBudget) {
  const nlohmann::json& settings = expectations().at("views");
  const nlohmann::json& budgets = expectations().at("meshes").at(GetParam());
  ASSERT_FALSE(budgets.empty());
  const Mesh mesh = load(GetParam());
  for (const Turn& turn : turns()) {
    SCOPED_TRACE(turn.name);
    Mesh turned = mesh;
    for (glm::vec3& position : turned.positions) position = turn.matrix * position;
    if (glm::determinant(turn.matrix) < 0) {
      for (glm::uvec3& triangle : turned.triangles) std::swap(triangle.y, triangle.z);
    }
    std::map<std::string, Measured> measured;
    for (View view : views_around(facet_bounds(turned.view()), settings.at("count"), settings.at("radii"),
                                  Projection::perspective)) {
      view.width = view.height = settings.at("size");
      const FragmentLists lists = collect_fragments(turned.view(), view);
      for (const auto& [name, budget] : budgets.items()) {
        const std::optional<Strategy> strategy = strategy_from_name(name);
        ASSERT_TRUE(strategy.has_value()) << name;
        measure(turned, view, lists, *strategy, measured[name]);
      }
    }
    for (const auto& [name, budget] : budgets.items()) {
      SCOPED_TRACE(name);
      const Measured& found = measured.at(name);
      ASSERT_GT(found.covered, 0u);
      EXPECT_EQ(found.miscovered, 0u);
      EXPECT_LE(found.unjudged, found.covered / 20);
      for (const auto& [measure_name, range] : budget.items()) {
        ASSERT_TRUE(measure_name == "inverted_rate" || measure_name == "wrong_rate") << measure_name;
        const double rate = measure_name == "inverted_rate" ? found.inverted_rate() : found.wrong_rate();
        EXPECT_GE(rate, range.at(0).get<double>()) << measure_name;
        EXPECT_LE(rate, range.at(1).get<double>()) << measure_name;
      }
    }
  }
}

TEST(CorpusFile, HasABudgetForEveryMeshAndAMeshForEveryBudget) {
  std::vector<std::string> shipped;
  for (const auto& entry : std::filesystem::directory_iterator(meshes_folder())) {
    if (entry.path().extension() == ".ply") shipped.push_back(entry.path().stem());
  }
  std::sort(shipped.begin(), shipped.end());
  EXPECT_EQ(expected_meshes(), shipped);
  EXPECT_GE(shipped.size(), 8u);
  for (const std::string& mesh : shipped) {
    for (const Method method : depth_key_methods()) {
      EXPECT_TRUE(expectations().at("meshes").at(mesh).contains(Strategy{StrategyKind::facet_sort, method}.name()))
          << mesh << " has no budget for " << method_name(method);
    }
  }
}

}  // namespace
}  // namespace facetsort
