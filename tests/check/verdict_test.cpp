#include "facetsort/check/verdict.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace facetsort {
namespace {

using Pixels = std::vector<std::vector<Fragment>>;

// A picture of one row.
FragmentLists lists_of(const Pixels& pixels) {
  FragmentLists lists;
  lists.width = static_cast<int>(pixels.size());
  lists.height = 1;
  lists.offsets.push_back(0);
  for (const std::vector<Fragment>& pixel : pixels) {
    lists.fragments.insert(lists.fragments.end(), pixel.begin(), pixel.end());
    lists.offsets.push_back(lists.fragments.size());
  }
  return lists;
}

std::vector<std::uint32_t> index_order(std::size_t facets) {
  std::vector<std::uint32_t> rank(facets);
  std::iota(rank.begin(), rank.end(), 0u);
  return rank;
}

Verdict judge(const Pixels& pixels, const std::vector<std::uint32_t>& rank, const JudgeOptions& options = {}) {
  return judge_order(lists_of(pixels), rank, options);
}

// Every pair looked at, as the header defines an inversion.
Verdict judge_by_definition(const FragmentLists& lists, const std::vector<std::uint32_t>& rank,
                            const JudgeOptions& options) {
  Verdict verdict;
  const double gap = options.gap_radii * options.bounding_radius;
  for (std::size_t p = 0; p < static_cast<std::size_t>(lists.width * lists.height); ++p) {
    const auto pixel = lists.pixel(p);
    std::size_t pairs = 0;
    for (const Fragment& far : pixel) {
      verdict.uncovered_fragments += rank[far.facet] == not_drawn;
      for (const Fragment& near : pixel) {
        if (rank[far.facet] == not_drawn || rank[near.facet] == not_drawn) continue;
        const double difference = far.depth - near.depth;
        const double errors = static_cast<double>(far.depth_error) + static_cast<double>(near.depth_error);
        if (rank[far.facet] <= rank[near.facet] || !(difference > std::max(gap, errors))) continue;
        ++pairs;
        const double backtrack = difference / options.bounding_radius;
        const bool same_but_smaller_ids =
            backtrack == verdict.worst_backtrack && p == verdict.worst_pixel &&
            std::pair(far.facet, near.facet) < std::pair(verdict.worst_far_facet, verdict.worst_near_facet);
        if (backtrack > verdict.worst_backtrack || same_but_smaller_ids) {
          verdict.worst_backtrack = backtrack;
          verdict.worst_pixel = p;
          verdict.worst_far_facet = far.facet;
          verdict.worst_near_facet = near.facet;
        }
      }
    }
    verdict.covered_pixels += !pixel.empty();
    verdict.inverted_pixels += pairs > 0;
    verdict.inverted_pairs += pairs;
  }
  return verdict;
}

void expect_same(const Verdict& a, const Verdict& b) {
  EXPECT_EQ(a.covered_pixels, b.covered_pixels);
  EXPECT_EQ(a.inverted_pixels, b.inverted_pixels);
  EXPECT_EQ(a.inverted_pairs, b.inverted_pairs);
  EXPECT_EQ(a.uncovered_fragments, b.uncovered_fragments);
  EXPECT_EQ(a.worst_backtrack, b.worst_backtrack);
  EXPECT_EQ(a.worst_pixel, b.worst_pixel);
  EXPECT_EQ(a.worst_far_facet, b.worst_far_facet);
  EXPECT_EQ(a.worst_near_facet, b.worst_near_facet);
}

// Depths in steps of 2^-12 and errors in steps of 2^-14, so that sums and differences are exact and ties are many.
FragmentLists random_lists(int width, int height, std::size_t layers, std::uint32_t facets, double uncertain_share,
                           std::mt19937& random) {
  FragmentLists lists;
  lists.width = width;
  lists.height = height;
  lists.offsets.push_back(0);
  std::vector<std::uint32_t> ids = index_order(facets);
  for (int p = 0; p < width * height; ++p) {
    std::vector<Fragment> pixel;
    for (std::size_t i = 0; i < layers; ++i) {
      std::swap(ids[i], ids[i + random() % (facets - i)]);
      const bool uncertain = static_cast<double>(random() % 1000) < 1000 * uncertain_share;
      const float error = static_cast<float>(uncertain ? random() % 4096 : random() % 4) * 0x1p-14f;
      pixel.push_back({ids[i], error, 3 + static_cast<double>(random() % 8192) * 0x1p-12});
    }
    std::sort(pixel.begin(), pixel.end(), [](const Fragment& a, const Fragment& b) {
      return a.depth != b.depth ? a.depth > b.depth : a.facet < b.facet;
    });
    lists.fragments.insert(lists.fragments.end(), pixel.begin(), pixel.end());
    lists.offsets.push_back(lists.fragments.size());
  }
  return lists;
}

std::vector<std::uint32_t> random_ranks(std::uint32_t facets, std::mt19937& random) {
  std::vector<std::uint32_t> rank = index_order(facets);
  std::shuffle(rank.begin(), rank.end(), random);
  for (std::uint32_t& r : rank)
    if (random() % 16 == 0) r = not_drawn;
  return rank;
}

TEST(Verdict, FindsNothingInAnEmptyPicture) {
  expect_same(judge({{}, {}, {}}, {}), Verdict{});
}

TEST(Verdict, AcceptsTheRightOrder) {
  const Verdict verdict = judge({{{0, 0, 3}, {1, 0, 2}, {2, 0, 1}}, {}, {{1, 0, 5}}}, index_order(3));
  EXPECT_EQ(verdict.covered_pixels, 2u);
  EXPECT_EQ(verdict.inverted_pixels, 0u);
  EXPECT_EQ(verdict.inverted_pairs, 0u);
  EXPECT_EQ(verdict.uncovered_fragments, 0u);
  EXPECT_EQ(verdict.worst_backtrack, 0);
}

TEST(Verdict, CountsEveryInvertedPairAndNamesTheWorst) {
  JudgeOptions options;
  options.bounding_radius = 2;
  const Verdict verdict =
      judge({{{0, 0, 9}, {1, 0, 8}}, {{3, 0, 7}, {2, 0, 6}, {1, 0, 4}, {0, 0, 2}}, {{2, 0, 5}, {0, 0, 3}}},
            index_order(4), options);
  EXPECT_EQ(verdict.covered_pixels, 3u);
  EXPECT_EQ(verdict.inverted_pixels, 2u);
  EXPECT_EQ(verdict.inverted_pairs, 7u);
  EXPECT_EQ(verdict.worst_backtrack, 2.5);
  EXPECT_EQ(verdict.worst_pixel, 1u);
  EXPECT_EQ(verdict.worst_far_facet, 3u);
  EXPECT_EQ(verdict.worst_near_facet, 0u);
}

TEST(Verdict, LeavesPairsWithinTheGapUnjudged) {
  JudgeOptions options;
  options.bounding_radius = 4;
  options.gap_radii = 0.25;
  EXPECT_EQ(judge({{{1, 0, 2}, {0, 0, 1}}}, index_order(2), options).inverted_pairs, 0u);
  EXPECT_EQ(judge({{{1, 0, std::nextafter(2, 3)}, {0, 0, 1}}}, index_order(2), options).inverted_pairs, 1u);
}

TEST(Verdict, LeavesPairsWithinTheirErrorsUnjudged) {
  JudgeOptions options;
  options.gap_radii = 0;
  EXPECT_EQ(judge({{{1, 0.5f, 2}, {0, 0.5f, 1}}}, index_order(2), options).inverted_pairs, 0u);
  EXPECT_EQ(judge({{{1, 0.5f, 2}, {0, 0.25f, 1}}}, index_order(2), options).inverted_pairs, 1u);
  // With exact depths the last bit decides, and a tie has no wrong order.
  EXPECT_EQ(judge({{{1, 0, std::nextafter(1, 2)}, {0, 0, 1}}}, index_order(2), options).inverted_pairs, 1u);
  EXPECT_EQ(judge({{{0, 0, 1}, {1, 0, 1}}}, {1, 0}, options).inverted_pairs, 0u);
}

TEST(Verdict, LooksPastAnUncertainFragment) {
  const Verdict verdict = judge({{{3, 100, 9}, {2, 0, 7}, {1, 0, 5}, {0, 0, 4}}}, index_order(4));
  EXPECT_EQ(verdict.inverted_pairs, 3u);
  EXPECT_EQ(verdict.worst_backtrack, 3);
  EXPECT_EQ(verdict.worst_far_facet, 2u);
  EXPECT_EQ(verdict.worst_near_facet, 0u);
}

TEST(Verdict, CountsFragmentsThatAreNotDrawnAndIgnoresThemOtherwise) {
  const Verdict verdict = judge({{{0, 0, 3}, {1, 0, 2}, {2, 0, 1}}, {{1, 0, 1}}}, {0, not_drawn, 1});
  EXPECT_EQ(verdict.covered_pixels, 2u);
  EXPECT_EQ(verdict.inverted_pixels, 0u);
  EXPECT_EQ(verdict.uncovered_fragments, 2u);
}

TEST(Verdict, NamesTheSmallestPixelAndIdsOfEquallyBadPairs) {
  const Verdict verdict =
      judge({{{9, 0, 2.5}, {8, 0, 1}}, {{4, 0, 5}, {7, 0, 5}, {1, 0, 3}, {2, 0, 3}}, {{3, 0, 3}, {0, 0, 1}}},
            index_order(10));
  EXPECT_EQ(verdict.worst_backtrack, 2);
  EXPECT_EQ(verdict.worst_pixel, 1u);
  EXPECT_EQ(verdict.worst_far_facet, 4u);
  EXPECT_EQ(verdict.worst_near_facet, 1u);
}

TEST(Verdict, EqualsTheDefinitionOnRandomLists) {
  std::mt19937 random(7);
  for (const std::size_t layers : {2, 3, 10, 100}) {
    for (const double uncertain_share : {0.0, 0.1, 1.0}) {
      for (const double gap_radii : {0.0, 0x1p-12, 0x1p-4}) {
        const FragmentLists lists = random_lists(6, 5, layers, 200, uncertain_share, random);
        const std::vector<std::uint32_t> rank = random_ranks(200, random);
        JudgeOptions options;
        options.bounding_radius = 2;
        options.gap_radii = gap_radii;
        SCOPED_TRACE(testing::Message() << layers << " layers, " << uncertain_share << ", " << gap_radii);
        expect_same(judge_order(lists, rank, options), judge_by_definition(lists, rank, options));
      }
    }
  }
}

TEST(Verdict, EqualsTheDefinitionOnAThousandLayers) {
  std::mt19937 random(11);
  const FragmentLists lists = random_lists(2, 2, 1000, 1500, 0.01, random);
  const std::vector<std::uint32_t> rank = random_ranks(1500, random);
  const Verdict verdict = judge_order(lists, rank, {});
  EXPECT_GT(verdict.inverted_pairs, 800'000u);
  expect_same(verdict, judge_by_definition(lists, rank, {}));
}

TEST(Verdict, IsTheSameForAnyThreadCount) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  std::mt19937 random(13);
  const FragmentLists lists = random_lists(16, 64, 20, 300, 0.1, random);
  const std::vector<std::uint32_t> rank = random_ranks(300, random);
  const Verdict verdict = judge_by_definition(lists, rank, {});
  for (const int threads : {1, 2, 8})
    expect_same(tbb::task_arena(threads).execute([&] { return judge_order(lists, rank, {}); }), verdict);
}

}  // namespace
}  // namespace facetsort
