#include "facetsort/scene/object_groups.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "scene/random_scene.h"

namespace facetsort::scene_internal {
namespace {

Slabs slabs_of_points(const std::vector<glm::vec3>& points) {
  std::vector<glm::uvec3> triangles;
  for (std::uint32_t i = 0; i < points.size(); ++i) triangles.emplace_back(i, i, i);
  return slabs_of(triangles, points);
}

Slabs cube(const glm::vec3& centre, float half = 0.5f) {
  return slabs_of_points({centre - half, centre + half, centre + glm::vec3(half, -half, -half),
                          centre + glm::vec3(-half, half, -half), centre + glm::vec3(-half, -half, half),
                          centre + glm::vec3(half, half, -half), centre + glm::vec3(half, -half, half),
                          centre + glm::vec3(-half, half, half)});
}

TEST(ObjectGroups, TheEyesSideIsLast) {
  const Slabs left = cube({-2, 0, 0}), right = cube({2, 0, 0});
  EXPECT_EQ(sequence_of(left, right, {9, 0, 0, 1}), Sequence::first_before);
  EXPECT_EQ(sequence_of(left, right, {-9, 0, 0, 1}), Sequence::second_before);
  EXPECT_EQ(sequence_of(right, left, {-9, 0, 0, 1}), Sequence::first_before);
  EXPECT_EQ(sequence_of(left, right, {0, 0, 9, 1}), Sequence::any);  // between the two
  EXPECT_EQ(sequence_of(left, right, {1, 0, 0, 0}), Sequence::first_before);
  EXPECT_EQ(sequence_of(left, right, {-1, 0, 0, 0}), Sequence::second_before);
  EXPECT_EQ(sequence_of(left, right, {0, 1, 0, 0}), Sequence::any);
  EXPECT_EQ(sequence_of(left, cube({-2.25f, 0, 0}), {9, 0, 0, 1}), Sequence::interleaved);
}

TEST(ObjectGroups, BoxesThatTouchAreParted) {
  EXPECT_EQ(sequence_of(cube({0, 0, 0}), cube({1, 0, 0}), {9, 0, 0, 1}), Sequence::first_before);
}

// Boxes overlap along the axes, but not across an edge's direction.
TEST(ObjectGroups, SlantedPlanesPartToo) {
  const Slabs below = slabs_of_points({{0, 0, -1}, {1, 0, 1}, {0, 1, 1}});
  const Slabs above = slabs_of_points({{1, 1, -1}, {1, 0.25f, 1}, {0.25f, 1, 1}});
  EXPECT_EQ(sequence_of(below, above, {9, 9, 0, 1}), Sequence::first_before);
  EXPECT_EQ(sequence_of(below, above, {-9, -9, 0, 1}), Sequence::second_before);
}

struct RayFromEye {
  glm::dvec3 origin, direction;
};

// Where a ray meets a triangle, in lengths of its direction; well inside and in front of its origin alone.
std::optional<double> meeting(const RayFromEye& ray, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const glm::dvec3 across = glm::cross(ray.direction, c - a);
  const double determinant = glm::dot(b - a, across);
  if (std::abs(determinant) < 1e-9) return std::nullopt;
  const glm::dvec3 from = ray.origin - a, normal = glm::cross(from, b - a);
  const double u = glm::dot(from, across) / determinant, v = glm::dot(ray.direction, normal) / determinant;
  const double at = glm::dot(c - a, normal) / determinant;
  if (u < 1e-6 || v < 1e-6 || u + v > 1 - 1e-6 || at <= 0) return std::nullopt;
  return at;
}

// Whatever slabs say must hold for every ray that meets both: rays through a point of the first, and triangles of all
// points of the second.
TEST(ObjectGroups, HoldsForRays) {
  RandomNumbers random(11);
  std::size_t decided = 0, checked = 0;
  for (int trial = 0; trial < 20000; ++trial) {
    const glm::dvec3 first_centre = random.point(2), second_centre = random.point(2);
    std::vector<glm::vec3> first, second;
    for (int i = 0; i < 6; ++i) first.emplace_back(first_centre + random.point(1));
    for (int i = 0; i < 6; ++i) second.emplace_back(second_centre + random.point(1));
    const bool orthographic = trial % 3 == 0;
    const glm::vec4 eye(glm::vec3(random.point(3)), orthographic ? 0.0f : 1.0f);
    const Sequence sequence = sequence_of(slabs_of_points(first), slabs_of_points(second), eye);
    if (sequence == Sequence::interleaved) continue;
    ++decided;
    for (const glm::vec3& point : first) {
      constexpr double far = 100;
      const glm::dvec3 e(eye), p(point);
      const RayFromEye ray = orthographic ? RayFromEye{p + far * e, -e} : RayFromEye{e, p - e};
      const double at_first = orthographic ? far : 1;
      for (std::size_t i = 0; i < second.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          for (std::size_t k = 0; k < j; ++k) {
            const std::optional<double> at = meeting(ray, second[i], second[j], second[k]);
            if (!at || std::abs(*at - at_first) < 1e-6) continue;
            ++checked;
            EXPECT_EQ(sequence, at_first > *at ? Sequence::first_before : Sequence::second_before);
          }
        }
      }
    }
  }
  EXPECT_GT(decided, 3000u);
  EXPECT_GT(checked, 3000u);
}

std::vector<std::vector<std::uint32_t>> groups_of(const std::vector<Slabs>& slabs, const glm::vec4& eye) {
  ObjectGroups groups;
  groups.set_slabs(slabs);
  const auto found = groups.find(eye);
  return {found.begin(), found.end()};
}

TEST(ObjectGroups, DrawsFarOnesFirst) {
  const std::vector<Slabs> row{cube({0, 0, 0}), cube({0, 0, 4}), cube({0, 0, 2})};
  EXPECT_EQ(groups_of(row, {0, 0, 20, 1}), (std::vector<std::vector<std::uint32_t>>{{0}, {2}, {1}}));
  EXPECT_EQ(groups_of(row, {0, 0, -20, 1}), (std::vector<std::vector<std::uint32_t>>{{1}, {2}, {0}}));
}

TEST(ObjectGroups, LinksWhatOverlaps) {
  const std::vector<Slabs> chain{cube({0, 0, 0}), cube({0, 0, 9}), cube({0.75f, 0, 0}), cube({1.5f, 0, 0})};
  EXPECT_EQ(groups_of(chain, {0, 0, 20, 1}), (std::vector<std::vector<std::uint32_t>>{{0, 2, 3}, {1}}));
}

// Three long slabs, each over the next: every pair is parted, and all three are one group from above, from then on.
TEST(ObjectGroups, MakesCyclesOneGroup) {
  const auto bar = [](const glm::vec3& from, const glm::vec3& to) { return slabs_of_points({from, to}); };
  // Along x, y and z; seen from (1, 1, 1) each hides an end of the next.
  const std::vector<Slabs> bars{bar({-3, 0, 1}, {3, 0.5f, 1.5f}), bar({1, -3, 0}, {1.5f, 3, 0.5f}),
                                bar({0, 1, -3}, {0.5f, 1.5f, 3})};
  const glm::vec4 eye(20, 20, 20, 1);
  EXPECT_EQ(sequence_of(bars[0], bars[1], eye), Sequence::second_before);
  EXPECT_EQ(sequence_of(bars[1], bars[2], eye), Sequence::second_before);
  EXPECT_EQ(sequence_of(bars[2], bars[0], eye), Sequence::second_before);
  ObjectGroups groups;
  groups.set_slabs(bars);
  EXPECT_EQ(groups.find({0, 0, 20, 1}).size(), 3u);
  ASSERT_EQ(groups.find(eye).size(), 1u);
  EXPECT_EQ(groups.find(eye)[0], (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(groups.find({0, 0, 20, 1}).size(), 1u);
}

}  // namespace
}  // namespace facetsort::scene_internal
