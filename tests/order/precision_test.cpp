// Keys are sorted to the last of their bits: on every mesh and from every side the order is the one and only order of
// the whole float32 keys. So nothing is inverted, and nothing flickers under a slowly turning camera, that those keys
// would not invert or exchange.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

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
    Sorter sorter(mesh.view());
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

}  // namespace
}  // namespace facetsort
