#include "facetsort/presort/mend_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

namespace facetsort::presort_internal {
namespace {

std::vector<std::uint32_t> index_order(std::size_t count) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

std::int64_t cost(const std::vector<Wish>& wishes, const std::vector<std::uint32_t>& order) {
  std::vector<std::size_t> position(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) position[order[i]] = i;
  std::int64_t sum = 0;
  for (const Wish& wish : wishes) sum += position[wish.first] > position[wish.then] ? wish.weight : 0;
  return sum;
}

TEST(MendOrder, LeavesWhatIsRight) {
  std::vector<std::uint32_t> order = index_order(5);
  mend_order(std::vector<Wish>{{0, 3, 1}, {1, 2, 1}}, order);
  EXPECT_EQ(order, index_order(5));
}

TEST(MendOrder, GrantsAllWishesThatAgree) {
  std::mt19937 random(5);
  for (const std::size_t count : {2u, 10u, 300u}) {
    std::vector<std::uint32_t> wanted = index_order(count);
    std::shuffle(wanted.begin(), wanted.end(), random);
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::int64_t> weights;
    for (std::size_t i = 0; i < 5 * count; ++i) {
      const std::size_t a = random() % count, b = random() % count;
      if (a != b) weights[{wanted[std::min(a, b)], wanted[std::max(a, b)]}] += 1 + random() % 9;
    }
    std::vector<Wish> wishes;
    for (const auto& [facets, weight] : weights) wishes.push_back({facets.first, facets.second, weight});
    std::vector<std::uint32_t> order = index_order(count);
    mend_order(wishes, order);
    EXPECT_EQ(cost(wishes, order), 0);
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, index_order(count));
  }
}

TEST(MendOrder, BreaksTheLightestWishOfACycle) {
  for (std::uint32_t lightest = 0; lightest < 3; ++lightest) {
    std::vector<Wish> wishes;
    for (std::uint32_t i = 0; i < 3; ++i) wishes.push_back({i, (i + 1) % 3, i == lightest ? 2 : 5 + i});
    std::vector<std::uint32_t> order = index_order(3);
    mend_order(wishes, order);
    EXPECT_EQ(cost(wishes, order), 2);
  }
}

// All orders are tried.
TEST(MendOrder, IsNearTheBestOfRandomContradictions) {
  std::mt19937 random(9);
  std::int64_t best_sum = 0, found_sum = 0;
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Wish> wishes;
    for (std::uint32_t a = 0; a < 7; ++a) {
      for (std::uint32_t b = a + 1; b < 7; ++b) {
        const std::int64_t weight = 1 + random() % 20;
        wishes.push_back(random() % 2 == 0 ? Wish{a, b, weight} : Wish{b, a, weight});
      }
    }
    std::vector<std::uint32_t> order = index_order(7), tried = order;
    std::int64_t best = cost(wishes, tried);
    while (std::next_permutation(tried.begin(), tried.end())) best = std::min(best, cost(wishes, tried));
    mend_order(wishes, order);
    best_sum += best;
    found_sum += cost(wishes, order);
  }
  EXPECT_LT(static_cast<double>(found_sum), 1.15 * static_cast<double>(best_sum));
}

}  // namespace
}  // namespace facetsort::presort_internal
