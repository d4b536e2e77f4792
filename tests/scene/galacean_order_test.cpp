#include "facetsort/scene/galacean_order.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "scene/fixture.h"

namespace facetsort {
namespace {

TEST(GalaceanOrder, AsksForTransparencyBeforeTheAlphaCutoff) {
  EXPECT_EQ(galacean_queue({}), GalaceanQueue::opaque);
  EXPECT_EQ(galacean_queue({.alpha_cutoff = 0.5}), GalaceanQueue::alpha_test);
  EXPECT_EQ(galacean_queue({.is_transparent = true}), GalaceanQueue::transparent);
  EXPECT_EQ(galacean_queue({.is_transparent = true, .alpha_cutoff = 0.5}), GalaceanQueue::transparent);
}

TEST(GalaceanOrder, MeasuresAlongTheViewIfOrthographicElseStraight) {
  const GalaceanItem item{.material = {}, .bounds_min = {0, 3, -6}, .bounds_max = {2, 5, -4}};
  GalaceanCamera camera{.position = {1, 1, -1}, .forward = {0, 0.6, -0.8}, .is_orthographic = true};
  EXPECT_EQ(galacean_distance_for_sort(item, camera), 0.6 * 3 + 0.8 * 4);
  camera.is_orthographic = false;
  EXPECT_EQ(galacean_distance_for_sort(item, camera), 3 * 3 + 4 * 4);
  const double infinity = std::numeric_limits<double>::infinity();
  const GalaceanItem unbounded{.material = {}, .bounds_min = glm::dvec3(-infinity), .bounds_max = glm::dvec3(infinity)};
  EXPECT_EQ(galacean_distance_for_sort(unbounded, camera), 3);
}

TEST(GalaceanOrder, ComparesPriorityBeforeDistance) {
  const GalaceanElement near{0, 1, 2}, far{0, 1, 3}, far_but_first{0, 0.5, 4}, near_but_first{0, 0.5, 1};
  EXPECT_LT(galacean_compare_for_opaque(near, far), 0);
  EXPECT_GT(galacean_compare_for_opaque(far, near), 0);
  EXPECT_LT(galacean_compare_for_opaque(far_but_first, near), 0);
  EXPECT_EQ(galacean_compare_for_opaque(near, near), 0);
  EXPECT_LT(galacean_compare_for_transparent(far, near), 0);
  EXPECT_GT(galacean_compare_for_transparent(near, far), 0);
  EXPECT_LT(galacean_compare_for_transparent(near_but_first, far), 0);
  EXPECT_EQ(galacean_compare_for_transparent(far, far), 0);
}

GalaceanItem item_at(double z, const GalaceanMaterial& material) {
  return {.material = material, .bounds_min = {-1, -1, z - 1}, .bounds_max = {1, 1, z + 1}};
}

TEST(GalaceanOrder, DrawsTheQueuesOneAfterTheOther) {
  const GalaceanMaterial panes{.is_transparent = true}, foliage{.alpha_cutoff = 0.5};
  const std::vector<GalaceanItem> items{item_at(-1, panes), item_at(-3, foliage), item_at(-2, foliage),
                                        item_at(-9, {}),    item_at(-8, {}),     item_at(-5, panes)};
  EXPECT_EQ(text_of(galacean_draw_order(items, {})), "4f 3f 2fk 1fk 5fw 0fw");
}

TEST(GalaceanOrder, DrawsTiesInTheOrderGivenHoweverMany) {
  for (const int count : {10, 11, 63, 64, 200}) {
    const std::vector<GalaceanItem> items(count, item_at(-1, {.is_transparent = true}));
    const std::vector<ObjectDraw> draws = galacean_draw_order(items, {});
    ASSERT_EQ(draws.size(), items.size());
    for (int i = 0; i < count; ++i) EXPECT_EQ(draws[i].item, std::uint32_t(i));
  }
}

TEST(GalaceanOrder, SortsLongQueuesStably) {
  std::vector<GalaceanItem> items;
  for (int i = 0; i < 300; ++i) items.push_back(item_at(-(i * 7 % 5), {}));
  const std::vector<ObjectDraw> draws = galacean_draw_order(items, {});
  ASSERT_EQ(draws.size(), items.size());
  const auto key = [](const ObjectDraw& draw) { return std::pair(draw.item * 7 % 5, draw.item); };
  for (std::size_t i = 1; i < draws.size(); ++i) EXPECT_LT(key(draws[i - 1]), key(draws[i]));
}

TEST(GalaceanOrder, PassesOnWhatTheMaterialSaysOfDepthAndFaces) {
  const std::vector<GalaceanItem> items{
      item_at(-1, {.render_face = GalaceanRenderFace::back, .depth_write = false}),
      item_at(-2, {.render_face = GalaceanRenderFace::double_sided, .depth_test = false}),
      item_at(-3, {.is_transparent = true, .depth_write = true})};
  EXPECT_EQ(text_of(galacean_draw_order(items, {})), "0bw 1at 2f");
}

// What a queue is sorted by: equal keys are ties.
using Key = std::tuple<GalaceanQueue, double, double>;

struct RecordedScene {
  GalaceanCamera camera;
  std::vector<GalaceanItem> items;
  std::vector<Key> keys;
  std::vector<std::string> draws;
  std::map<GalaceanQueue, int> queue_sizes;

  explicit RecordedScene(const nlohmann::json& scene)
      : camera{vector_of(scene["position"]), vector_of(scene["forward"]), scene["isOrthographic"]},
        draws(words_of(scene["draws"])) {
    constexpr GalaceanRenderFace faces[]{GalaceanRenderFace::front, GalaceanRenderFace::back,
                                         GalaceanRenderFace::double_sided};  // as RenderFace counts them
    for (const nlohmann::json& item : scene["items"]) {
      const nlohmann::json& material = scene["materials"].at(item.at(0).get<std::size_t>());
      items.push_back({.material = {.is_transparent = material.at(0),
                                    .alpha_cutoff = material.at(1),
                                    .render_face = faces[material.at(2).get<std::size_t>()],
                                    .depth_test = material.at(4)},
                       .priority = item.at(1),
                       .bounds_min = vector_of(item.at(2)),
                       .bounds_max = vector_of(item.at(3))});
      // Given only where the material says other than what its transparency left.
      const bool transparent = material.at(0), depth_write = material.at(3);
      if (depth_write == transparent) items.back().material.depth_write = depth_write;
      const GalaceanQueue queue = galacean_queue(items.back().material);
      const double distance = galacean_distance_for_sort(items.back(), camera);
      EXPECT_EQ(distance, item.at(4).get<double>());
      keys.emplace_back(queue, items.back().priority, distance);
      ++queue_sizes[queue];
      // The engine's alpha-test queue has these, too: for the shadows they cast.
      if (queue == GalaceanQueue::transparent) ++queue_sizes[GalaceanQueue::alpha_test];
    }
  }

  const Key& key_of(const std::string& draw) const { return keys.at(std::stoul(draw)); }
};

// The draws with each run of ties as a set, where the engine promises no order of them; else as they are.
std::vector<std::multiset<std::string>> up_to_ties(const RecordedScene& scene, const std::vector<std::string>& draws) {
  constexpr int insertion_sorted = 10;  // by the engine's quicksort, and so stably
  std::vector<std::multiset<std::string>> runs;
  for (std::size_t i = 0; i < draws.size(); ++i) {
    const Key& key = scene.key_of(draws[i]);
    const bool ties = i > 0 && key == scene.key_of(draws[i - 1]);
    const bool ordered = scene.queue_sizes.at(std::get<GalaceanQueue>(key)) <= insertion_sorted;
    if (!ties || ordered) runs.emplace_back();
    runs.back().insert(draws[i]);
  }
  return runs;
}

TEST(GalaceanOrder, AgreesWithRecordedScenes) {
  const nlohmann::json scenes = read_scenes("galacean");
  ASSERT_GE(scenes.size(), 500u);
  std::map<std::string, int> counts;
  for (const nlohmann::json& recorded : scenes) {
    const RecordedScene scene(recorded);
    const std::vector<std::string> ours = words_of(text_of(galacean_draw_order(scene.items, scene.camera)));
    ASSERT_EQ(ours.size(), scene.draws.size());
    ASSERT_EQ(up_to_ties(scene, ours), up_to_ties(scene, scene.draws)) << recorded;

    ++counts[scene.camera.is_orthographic ? "orthographic" : "perspective"];
    if (ours != scene.draws) ++counts["ties drawn otherwise"];
    for (const GalaceanItem& item : scene.items) {
      if (item.material.is_transparent && item.material.alpha_cutoff > 0) ++counts["transparent with a cutoff"];
    }
    for (const std::string& draw : scene.draws) {
      for (const char flag : draw) ++counts[std::string(1, flag)];
    }
    for (std::size_t i = 1; i < ours.size(); ++i) {
      const auto [queue, priority, distance] = scene.key_of(ours[i]);
      const auto [last_queue, last_priority, last_distance] = scene.key_of(ours[i - 1]);
      if (queue != last_queue) continue;
      const std::string name =
          "queue " + std::to_string(int(queue)) + (scene.queue_sizes.at(queue) > 10 ? " long" : "");
      ++counts[name + (priority == last_priority ? " priority ties" : " priority decides")];
      if (priority != last_priority) continue;
      const double difference = std::abs(distance - last_distance);
      ++counts[name + (difference == 0 ? " distance ties" : " distance decides")];
      if (difference > 0 && difference < 1e-12) ++counts["distance nearly ties"];
    }
  }
  for (const int queue : {0, 1, 2}) {
    for (const char* length : {"", " long"}) {
      for (const char* happening : {" priority ties", " priority decides", " distance ties", " distance decides"}) {
        const std::string name = "queue " + std::to_string(queue) + length + happening;
        EXPECT_GE(counts[name], 20) << name;
      }
    }
  }
  for (const char* happening : {"perspective", "orthographic", "transparent with a cutoff", "distance nearly ties",
                                "ties drawn otherwise", "a", "b", "f", "w", "t", "k"}) {
    EXPECT_GE(counts[happening], 20) << happening;
  }
}

}  // namespace
}  // namespace facetsort
