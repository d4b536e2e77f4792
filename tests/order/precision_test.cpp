// Whole keys are sorted to the last of their bits: on every mesh and from every side the order is the one and only
// order of the float32 keys. Quantised ones do not show: they invert no more pixels than whole ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "facetsort/check/verdict.h"
#include "facetsort/order/sorter.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

constexpr double pi = 3.14159265358979323846;

bool is_the_order_of(std::span<const float> keys, std::span<const std::uint32_t> order) {
  if (order.size() != keys.size()) return false;
  std::vector<bool> seen(keys.size(), false);
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (order[k] >= keys.size() || seen[order[k]]) return false;
    seen[order[k]] = true;
    if (k == 0) continue;
    const float before = keys[order[k - 1]], here = keys[order[k]];
    if (before < here || (before == here && order[k - 1] > order[k])) return false;
  }
  return true;
}

// On a Fibonacci sphere: golden angles around, equal steps of height.
glm::dvec3 direction(int view, int views) {
  const double height = 1 - (2 * view + 1.0) / views, angle = view * pi * (3 - std::sqrt(5.0));
  const double around = std::sqrt(1 - height * height);
  return {around * std::cos(angle), height, around * std::sin(angle)};
}

TEST(Precision, WholeKeysDecideFromEverySideAndFrameByFrame) {
  for (const std::filesystem::path& file : mesh_files()) {
    SCOPED_TRACE(file.stem().string());
    const Mesh mesh = load(file.stem().string());
    const Box box = facet_bounds(mesh.view());
    Sorter sorter(mesh.view(), {.precision = Precision::whole});
    const auto expect_order_from = [&](const glm::dvec3& towards_eye, double radii) {
      const glm::dvec3 eye = glm::dvec3(box.centre()) + radii * static_cast<double>(box.radius()) * towards_eye;
      const auto order = sorter.sort({glm::vec4(glm::vec3(eye), 1), glm::vec3(-towards_eye)});
      ASSERT_TRUE(is_the_order_of(sorter.keys(), order));
    };
    for (int view = 0; view < 32; ++view) expect_order_from(direction(view, 32), view % 4 == 3 ? 0.5 : 2.5);
    for (int frame = 0; frame < 8; ++frame) {  // an orbit of a tenth of a degree a frame
      const double angle = frame * pi / 1800;
      expect_order_from({std::sin(angle), 0.25, std::cos(angle)}, 2.5);
    }
  }
}

struct PixelCounts {
  std::size_t covered = 0, inverted_by_quantised = 0, inverted_by_whole = 0;
};

PixelCounts count_pixels(const Mesh& mesh) {
  const Box box = facet_bounds(mesh.view());
  Sorter quantised(mesh.view()), whole(mesh.view(), {.precision = Precision::whole});
  PixelCounts counts;
  for (View view : views_around(box, 32, 2.5f, Projection::perspective)) {
    view.width = view.height = 256;
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    const auto verdict_on = [&](Sorter& sorter) {
      const auto order = sorter.sort({view.homogeneous_eye(), view.forward()});
      std::vector<std::uint32_t> rank(order.size());
      for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = static_cast<std::uint32_t>(k);
      return judge_order(lists, rank, {.bounding_radius = box.radius()});
    };
    const Verdict verdict = verdict_on(whole);
    counts.covered += verdict.covered_pixels;
    counts.inverted_by_whole += verdict.inverted_pixels;
    counts.inverted_by_quantised += verdict_on(quantised).inverted_pixels;
  }
  return counts;
}

TEST(Precision, QuantisedKeysInvertNoMorePixelsThanWholeOnes) {
  for (const std::filesystem::path& file : mesh_files()) {
    const std::string name = file.stem().string();
    const PixelCounts counts = count_pixels(load(name));
    const double allowed =
        std::max(0.01 * static_cast<double>(counts.inverted_by_whole), 1e-5 * static_cast<double>(counts.covered));
    EXPECT_LE(static_cast<double>(counts.inverted_by_quantised),
              static_cast<double>(counts.inverted_by_whole) + allowed)
        << name;
  }
}

}  // namespace
}  // namespace facetsort
