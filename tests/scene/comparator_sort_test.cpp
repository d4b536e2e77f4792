#include "facetsort/scene/comparator_sort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace facetsort::scene_internal {
namespace {

using Keyed = std::pair<int, int>;  // key and place

TEST(ComparatorSort, SortsStablyWhateverTheLength) {
  std::mt19937 random(1);
  for (const int size : {0, 1, 2, 3, 10, 31, 32, 33, 63, 64, 65, 96, 127, 128, 129, 1000}) {
    for (const int keys : {1, 4, 10000}) {
      std::vector<Keyed> list(size);
      for (int i = 0; i < size; ++i) list[i] = {std::uniform_int_distribution(1, keys)(random), i};
      std::vector<Keyed> expected = list;
      std::sort(expected.begin(), expected.end());  // by key, then by place
      sort_by_comparator(list, [](const Keyed& a, const Keyed& b) { return a.first - b.first; });
      EXPECT_EQ(list, expected) << size << " of " << keys;
    }
  }
}

TEST(ComparatorSort, TurnsOnlyStrictlyFallingRuns) {
  std::vector<Keyed> list{{3, 0}, {2, 1}, {2, 2}, {1, 3}};
  sort_by_comparator(list, [](const Keyed& a, const Keyed& b) { return a.first - b.first; });
  EXPECT_EQ(list, (std::vector<Keyed>{{1, 3}, {2, 1}, {2, 2}, {3, 0}}));
}

TEST(ComparatorSort, TakesNotANumberForATie) {
  std::vector<int> list{3, 1, 2};
  sort_by_comparator(list, [](int, int) { return std::numeric_limits<double>::quiet_NaN(); });
  EXPECT_EQ(list, (std::vector<int>{3, 1, 2}));
}

// Each of three kinds comes before one of the others and after the other.
double in_a_circle(int a, int b) {
  const double results[]{0, -1, 1};
  return results[((a - b) % 3 + 3) % 3];
}

// What [...].sort(inACircle) gives in Node 20.
TEST(ComparatorSort, ContradictsItselfAsV8Does) {
  const std::pair<std::vector<int>, std::vector<int>> cases[] = {
      {{0, 1, 2, 3, 4, 5, 6, 7, 8}, {8, 7, 6, 5, 4, 3, 2, 1, 0}},
      {{8, 3, 5, 1, 0, 7, 2, 6, 4}, {3, 0, 6, 8, 5, 2, 1, 7, 4}},
      {{2, 1, 0, 5, 4, 3, 11, 10, 9, 8}, {2, 1, 0, 5, 4, 3, 11, 10, 9, 8}}};
  for (auto [list, expected] : cases) {
    sort_by_comparator(list, in_a_circle);
    EXPECT_EQ(list, expected);
  }
}

TEST(ComparatorSort, GivesAPermutationWhateverTheComparatorSays) {
  std::vector<int> list(500), all(500);
  std::iota(list.begin(), list.end(), 0);
  std::iota(all.begin(), all.end(), 0);
  sort_by_comparator(list, in_a_circle);
  sort_by_comparator(list, [](int, int) { return -1; });
  EXPECT_TRUE(std::is_permutation(list.begin(), list.end(), all.begin()));
}

}  // namespace
}  // namespace facetsort::scene_internal
