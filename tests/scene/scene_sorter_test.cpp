#include "facetsort/scene/scene_sorter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/check/verdict.h"
#include "facetsort/report/allocations.h"
#include "facetsort/scene/draw_costs.h"
#include "scene/random_scene.h"
#include "support/threads.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;

Ids all_objects(const Scene& scene) {
  Ids all(scene.objects.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

SceneSorter sorter_of(const Scene& scene, const SceneSorterOptions& options) {
  Result<SceneSorter> sorter = SceneSorter::create(scene, all_objects(scene), options);
  EXPECT_TRUE(sorter.ok());
  return std::move(sorter).value();
}

SortView sort_view(const View& view) {
  return {.eye = view.homogeneous_eye(), .forward = view.forward()};
}

// What a GPU would draw.
Mesh drawn_mesh(const MergedMesh& merged, const SceneOrder& order) {
  Mesh drawn;
  drawn.positions = merged.mesh.positions;
  for (const CutVertex& vertex : order.cut_vertices) drawn.positions.push_back(vertex.position);
  for (std::size_t i = 0; i < order.indices.size(); i += 3) {
    drawn.triangles.emplace_back(order.indices[i], order.indices[i + 1], order.indices[i + 2]);
  }
  return drawn;
}

// Runs are the order, one after the other, each of one object; every facet is drawn.
void expect_whole(const MergedMesh& merged, const SceneOrder& order) {
  ASSERT_EQ(order.indices.size(), 3 * order.facets.size());
  std::size_t at = 0;
  for (const DrawRun& run : order.runs) {
    ASSERT_EQ(run.first_index, at);
    ASSERT_GT(run.index_count, 0u);
    for (; at < run.first_index + std::size_t{run.index_count}; at += 3) {
      ASSERT_EQ(merged.facet_objects[order.facets[at / 3]], run.object);
    }
  }
  ASSERT_EQ(at, order.indices.size());
  std::vector<bool> is_drawn(merged.mesh.triangles.size(), false);
  for (const std::uint32_t facet : order.facets) is_drawn[facet] = true;
  EXPECT_EQ(std::count(is_drawn.begin(), is_drawn.end(), false), 0);
  if (!order.cut_vertices.empty()) return;
  for (std::size_t k = 0; k < order.facets.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(order.indices[3 * k + static_cast<std::size_t>(i)], merged.mesh.triangles[order.facets[k]][i]);
    }
  }
}

void expect_no_inversion(const MergedMesh& merged, const SceneOrder& order, const View& view) {
  const Mesh drawn = drawn_mesh(merged, order);
  Ids rank(drawn.triangles.size());
  std::iota(rank.begin(), rank.end(), 0u);
  const JudgeOptions options{.bounding_radius = static_cast<double>(facet_bounds(drawn.view()).radius())};
  const Verdict by_lists = judge_order(collect_fragments(drawn.view(), view), rank, options);
  EXPECT_EQ(by_lists.inverted_pixels, 0u) << by_lists.worst_backtrack;
  EXPECT_GT(by_lists.covered_pixels, 0u);
  const Result<EmbreeReferee> referee = EmbreeReferee::create(drawn.view());
  ASSERT_TRUE(referee.ok());
  const Result<RayHits> hits = referee.value().cast(view);
  ASSERT_TRUE(hits.ok());
  EXPECT_EQ(judge_order(hits.value().lists, rank, options).inverted_pixels, 0u);
}

TEST(SceneSorter, ExactOrdersHaveNoInversions) {
  std::size_t in_groups = 0, cut = 0, sorted = 0;
  for (std::uint32_t seed = 1; seed <= 14; ++seed) {
    const Scene scene = random_scene(3 + seed % 9, 0.2 + 0.3 * (seed % 7), seed);
    const Method method = seed % 4 == 3 ? Method::exact_tree : seed % 4 == 2 ? Method::presorted : Method::exact;
    SceneSorter sorter = sorter_of(scene, {.method = method});
    for (const View& view : looks_at(facet_bounds(sorter.merged().mesh.view()), seed, 128)) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const SceneOrder order = sorter.sort(sort_view(view));
      expect_whole(sorter.merged(), order);
      const FragmentLists lists = collect_fragments(sorter.merged().mesh.view(), view);
      if (!lists.fragments.empty()) expect_no_inversion(sorter.merged(), order, view);
      ++sorted;
      cut += !order.cut_vertices.empty();
      in_groups += sorter.statistics().groups > 1 && sorter.statistics().groups < scene.objects.size();
    }
  }
  // That the cases are what they are meant to be: some cut, some in several groups of several objects.
  EXPECT_GT(cut, sorted / 4);
  EXPECT_GT(in_groups, sorted / 8);
}

TEST(SceneSorter, GroupingMakesFewerRunsAndTheSameOrderOfFacets) {
  const Scene scene = random_scene(12, 1, 4);
  SceneSorter grouped = sorter_of(scene, {}), as_found = sorter_of(scene, {.group_runs = false});
  const Box box = facet_bounds(grouped.merged().mesh.view());
  const SortView view = sort_view(default_view(box, box.centre() + glm::vec3(0, 0, 3 * box.radius())));
  const SceneOrder few = grouped.sort(view), many = as_found.sort(view);
  EXPECT_LT(few.runs.size(), many.runs.size());
  EXPECT_GE(few.runs.size(), scene.objects.size());
  EXPECT_EQ(grouped.statistics().runs, few.runs.size());
  EXPECT_EQ(grouped.statistics().runs_as_found, many.runs.size());
  Ids few_facets(few.facets.begin(), few.facets.end()), many_facets(many.facets.begin(), many.facets.end());
  std::sort(few_facets.begin(), few_facets.end());
  std::sort(many_facets.begin(), many_facets.end());
  EXPECT_EQ(few_facets, many_facets);
}

TEST(SceneSorter, FacetSortIsTheSortersOwn) {
  const Scene scene = random_scene(10, 2, 6);
  for (const Method method : depth_key_methods()) {
    SceneSorter sorter = sorter_of(scene, {.method = method, .precision = Precision::whole, .group_runs = false});
    const Box box = facet_bounds(sorter.merged().mesh.view());
    const SortView view = sort_view(default_view(box, box.centre() + glm::vec3(3 * box.radius(), 0, 1)));
    const SceneOrder order = sorter.sort(view);
    EXPECT_EQ(Ids(order.facets.begin(), order.facets.end()), sort_facets(sorter.merged().mesh.view(), view, method));
    expect_whole(sorter.merged(), order);
  }
}

TEST(SceneSorter, FacetSortAllocatesNothingOnceWarm) {
  Scene scene = random_scene(60, 3, 2);
  SceneSorter sorter = sorter_of(scene, {.method = Method::centroid_distance});
  const std::vector<View> views = looks_at(facet_bounds(sorter.merged().mesh.view()), 2, 64);
  with_threads(1, [&] {
    for (const View& view : views) sorter.sort(sort_view(view));
    const AllocationScope scope;
    for (const View& view : views) {
      ASSERT_TRUE(sorter.update(scene, 7).ok());
      sorter.sort(sort_view(view));
    }
    EXPECT_EQ(scope.count().calls, 0u);
  });
}

TEST(SceneSorter, UpdatesAreAsIfMadeAnew) {
  for (const Method method : {Method::centroid_distance, Method::exact}) {
    Scene scene = random_scene(9, 1.5, 8);
    SceneSorter sorter = sorter_of(scene, {.method = method});
    const std::vector<View> views = looks_at(facet_bounds(sorter.merged().mesh.view()), 3, 64);
    sorter.sort(sort_view(views[0]));
    scene.objects[4].world[3] += glm::dvec4(0.5, 0.25, -1, 0);
    scene.objects[2].world[0] *= -1.0;
    ASSERT_TRUE(sorter.update(scene, 4).ok());
    ASSERT_TRUE(sorter.update(scene, 2).ok());
    SceneSorter anew = sorter_of(scene, {.method = method});
    for (const View& view : views) {
      const SceneOrder order = sorter.sort(sort_view(view)), expected = anew.sort(sort_view(view));
      EXPECT_EQ(Ids(order.indices.begin(), order.indices.end()), Ids(expected.indices.begin(), expected.indices.end()));
      EXPECT_EQ(std::vector<DrawRun>(order.runs.begin(), order.runs.end()),
                std::vector<DrawRun>(expected.runs.begin(), expected.runs.end()));
    }
  }
}

// Boxes in a row: only the group of the one that moved is made again, and none where nothing moved.
TEST(SceneSorter, PreparesOnlyWhatChanged) {
  Scene scene = random_scene(0, 1, 1);
  for (int i = 0; i < 8; ++i) {
    SceneObject object{.name = "box", .mesh = 0};
    object.world[3] = glm::dvec4(4 * i, 0, 0, 1);
    scene.objects.push_back(object);
  }
  SceneSorter sorter = sorter_of(scene, {});
  sorter.sort({.eye = {100, 3, 2, 1}});
  EXPECT_EQ(sorter.statistics().groups, 8u);
  EXPECT_EQ(sorter.statistics().prepared_groups, 8u);
  sorter.sort({.eye = {-100, 3, 2, 1}});
  EXPECT_EQ(sorter.statistics().prepared_groups, 0u);
  scene.objects[5].world[3].y = 1;
  ASSERT_TRUE(sorter.update(scene, 5).ok());
  sorter.sort({.eye = {100, 3, 2, 1}});
  EXPECT_EQ(sorter.statistics().prepared_groups, 1u);
}

TEST(SceneSorter, IsTheSameForAnyThreadCount) {
  const Scene scene = random_scene(30, 1.5, 12);
  for (const Method method : {Method::centroid_distance, Method::exact}) {
    const auto sorted_with = [&](int threads) {
      return with_threads(threads, [&] {
        SceneSorter sorter = sorter_of(scene, {.method = method});
        Ids all;
        for (const View& view : looks_at(facet_bounds(sorter.merged().mesh.view()), 4, 64)) {
          const SceneOrder order = sorter.sort(sort_view(view));
          all.insert(all.end(), order.indices.begin(), order.indices.end());
        }
        return all;
      });
    };
    EXPECT_EQ(sorted_with(1), sorted_with(4));
  }
}

TEST(SceneSorter, TakesNoObjects) {
  const Scene scene = random_scene(3, 1, 1);
  for (const Method method : {Method::centroid_distance, Method::exact}) {
    Result<SceneSorter> sorter = SceneSorter::create(scene, {}, {.method = method});
    ASSERT_TRUE(sorter.ok());
    const SceneOrder order = sorter.value().sort({});
    EXPECT_TRUE(order.indices.empty());
    EXPECT_TRUE(order.runs.empty());
  }
}

TEST(SceneSorter, PassesOnWhatMergeRefuses) {
  Scene scene = random_scene(3, 1, 1);
  scene.objects[1].world[3].z = -1e300;
  const Result<SceneSorter> sorter = SceneSorter::create(scene, all_objects(scene));
  ASSERT_FALSE(sorter.ok());
  EXPECT_EQ(sorter.status().fault, Fault::non_finite_position);
}

TEST(DrawCosts, CompareTheChoices) {
  Scene scene = random_scene(10, 0.8, 9);
  scene.materials.push_back({.name = "stone", .material = {.alpha_mode = AlphaMode::opaque}});
  scene.meshes[0].material = 1;
  const Result<std::vector<DrawCost>> costs = draw_costs(scene, {.eye = {9, 5, 7, 1}});
  ASSERT_TRUE(costs.ok());
  ASSERT_EQ(costs.value().size(), 3u);
  const DrawCost &whole = costs.value()[0], &keys = costs.value()[1], &exact = costs.value()[2];
  EXPECT_EQ(whole.choice, "whole_objects");
  EXPECT_EQ(whole.draws, blended_objects(scene).size());
  EXPECT_LT(whole.draws, scene.objects.size());
  EXPECT_EQ(keys.choice, "facet_sort:centroid_distance");
  EXPECT_EQ(keys.triangles, whole.triangles);
  EXPECT_GE(keys.draws_as_found, keys.draws);
  EXPECT_EQ(exact.choice, "exact");
  EXPECT_GE(exact.triangles, whole.triangles);
  EXPECT_GE(exact.draws, whole.draws);
}

}  // namespace
}  // namespace facetsort
