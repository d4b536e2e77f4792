#include "facetsort/scene/draw_runs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/facets/facets.h"
#include "facetsort/scene/merge.h"
#include "scene/random_scene.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;

TEST(DrawRuns, JoinNeighboursOfAnObject) {
  const Ids objects{2, 2, 0, 0, 0, 2, 1};
  std::vector<DrawRun> runs{{9, 9, 9}};
  find_draw_runs(objects, runs);
  EXPECT_EQ(runs, (std::vector<DrawRun>{{2, 0, 6}, {0, 6, 9}, {2, 15, 3}, {1, 18, 3}}));
  EXPECT_EQ(count_draw_runs(objects), 4u);
  find_draw_runs({}, runs);
  EXPECT_TRUE(runs.empty());
  EXPECT_EQ(count_draw_runs({}), 0u);
}

// Squares across the view, each two triangles, at the given places and depths.
struct Square {
  float x, depth;
  std::uint32_t object;
};

Ids grouped(const std::vector<Square>& squares) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  Ids objects;
  for (const Square& s : squares) {
    const auto first = static_cast<std::uint32_t>(positions.size());
    for (const glm::vec2& corner : {glm::vec2(0, 0), glm::vec2(0.8f, 0), glm::vec2(0.8f, 0.8f), glm::vec2(0, 0.8f)}) {
      positions.emplace_back(s.x + corner.x, corner.y, -s.depth);
    }
    triangles.emplace_back(first, first + 1, first + 2);
    triangles.emplace_back(first, first + 2, first + 3);
    objects.insert(objects.end(), 2, s.object);
  }
  RunGrouper grouper;
  const std::uint32_t count = *std::max_element(objects.begin(), objects.end()) + 1;
  const auto places = grouper.group({0, 0, 1, 0}, {positions, triangles, objects}, count);
  Ids drawn;
  for (const std::uint32_t place : places) drawn.push_back(objects[place]);
  return drawn;
}

TEST(RunGrouper, BringsTogetherWhatHasNothingBetween) {
  // In turns, but side by side: two runs are enough.
  EXPECT_EQ(count_draw_runs(grouped({{0, 4, 0}, {1, 4, 1}, {2, 3, 0}, {3, 3, 1}, {4, 2, 0}, {5, 2, 1}})), 2u);
}

TEST(RunGrouper, KeepsWhatIsInTurnsOneBehindTheOther) {
  const Ids drawn = grouped({{0, 4, 0}, {0, 3, 1}, {0, 2, 0}, {0, 1, 1}});
  EXPECT_EQ(drawn, (Ids{0, 0, 1, 1, 0, 0, 1, 1}));
}

TEST(RunGrouper, LetsWhatIsAsideJoinEitherRun) {
  // The last square of object 0 lies aside: it joins the first.
  EXPECT_EQ(count_draw_runs(grouped({{0, 4, 0}, {0, 3, 1}, {5, 2, 0}})), 2u);
  // Here object 1 must come between.
  EXPECT_EQ(count_draw_runs(grouped({{0, 4, 0}, {0, 3, 1}, {0, 2, 0}})), 3u);
}

// The sequence of facets at every pixel is what decides a picture: it must not change, whatever the order was.
void expect_same_pictures(const Scene& scene, std::uint32_t seed) {
  std::vector<std::uint32_t> all(scene.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  const Result<MergedMesh> merged = merge(scene, all);
  ASSERT_TRUE(merged.ok());
  const Mesh& mesh = merged.value().mesh;
  RandomNumbers random(seed);
  Ids order(mesh.triangles.size());
  std::iota(order.begin(), order.end(), 0u);
  for (std::size_t k = order.size(); k > 1; --k)
    std::swap(order[k - 1], order[random.below(static_cast<std::uint32_t>(k))]);
  std::vector<glm::uvec3> triangles;
  Ids objects;
  for (const std::uint32_t facet : order) {
    triangles.push_back(mesh.triangles[facet]);
    objects.push_back(merged.value().facet_objects[facet]);
  }
  RunGrouper grouper;
  for (const View& view : looks_at(facet_bounds(mesh.view()), seed, 96)) {
    const auto places = grouper.group(view.homogeneous_eye(), {mesh.positions, triangles, objects}, all.size());
    ASSERT_EQ(places.size(), order.size());
    Ids before(order.size()), after(order.size(), not_drawn), drawn_objects;
    for (std::uint32_t k = 0; k < order.size(); ++k) {
      before[order[k]] = k;
      ASSERT_EQ(after[order[places[k]]], not_drawn) << "twice";
      after[order[places[k]]] = k;
      drawn_objects.push_back(objects[places[k]]);
    }
    EXPECT_LT(count_draw_runs(drawn_objects), count_draw_runs(objects));
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    std::size_t fragments = 0;
    for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
      const auto at_pixel = lists.pixel(pixel);
      fragments += at_pixel.size();
      for (std::size_t i = 0; i < at_pixel.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) {
          const std::uint32_t a = at_pixel[i].facet, b = at_pixel[j].facet;
          ASSERT_EQ(before[a] < before[b], after[a] < after[b]) << "facets " << a << " and " << b;
        }
      }
    }
    EXPECT_GT(fragments, 0u);
  }
}

TEST(RunGrouper, ChangesNoPicture) {
  for (std::uint32_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    expect_same_pictures(random_scene(2 + seed, 0.3 * seed, seed), seed);
  }
}

// Facets that fill the screen, and an eye that all of them surround.
TEST(RunGrouper, ChangesNoPictureOfLargeFacets) {
  Scene scene = random_scene(6, 0.5, 5);
  for (SceneObject& object : scene.objects) {
    for (int column = 0; column < 3; ++column) object.world[column] *= 40.0;
  }
  expect_same_pictures(scene, 5);
}

TEST(RunGrouper, TakesDegenerateScenes) {
  const std::vector<glm::vec3> positions{{1, 2, 3}};
  const std::vector<glm::uvec3> triangles(5, glm::uvec3(0));
  const Ids objects{0, 1, 0, 1, 0};
  RunGrouper grouper;
  EXPECT_TRUE(grouper.group({0, 0, 1, 0}, {}, 0).empty());
  for (const glm::vec4& eye : {glm::vec4(1, 2, 3, 1), glm::vec4(0, 0, 0, 1), glm::vec4(0, 0, 1, 0)}) {
    const auto places = grouper.group(eye, {positions, triangles, objects}, 2);
    Ids sorted(places.begin(), places.end());
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, (Ids{0, 1, 2, 3, 4}));
  }
}

}  // namespace
}  // namespace facetsort
