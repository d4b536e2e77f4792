// Lists of what hides what, and strongly connected components.
#include "facetsort/exact/hiding_graph.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace facetsort::exact_internal {
namespace {

using Lists = std::vector<std::vector<std::uint32_t>>;

NodeLists flat(const Lists& lists) {
  NodeLists result{{0}, {}};
  for (const std::vector<std::uint32_t>& list : lists) {
    result.values.insert(result.values.end(), list.begin(), list.end());
    result.begin.push_back(static_cast<std::uint32_t>(result.values.size()));
  }
  return result;
}

Lists nested(const NodeLists& lists) {
  Lists result;
  for (std::size_t i = 0; i < lists.count(); ++i) result.emplace_back(lists[i].begin(), lists[i].end());
  return result;
}

Lists components_of(const Lists& behind) {
  return nested(ComponentFinder().find(flat(behind)));
}

std::vector<HidingPair> random_pairs(std::mt19937& random, std::uint32_t nodes, std::uint32_t most) {
  std::vector<HidingPair> pairs;
  for (std::uint32_t count = static_cast<std::uint32_t>(random()) % most; count > 0; --count) {
    pairs.push_back({static_cast<std::uint32_t>(random()) % nodes, static_cast<std::uint32_t>(random()) % nodes});
  }
  return pairs;
}

TEST(HidingGraph, ListsWhatIsBehind) {
  EXPECT_EQ(nested(list_behind(0, {})), Lists{});
  const std::vector<HidingPair> pairs = {{2, 0}, {1, 0}, {0, 3}, {1, 3}};
  EXPECT_EQ(nested(list_behind(4, pairs)), (Lists{{2, 1}, {}, {}, {0, 1}}));
  EXPECT_EQ(nested(reversed(list_behind(4, pairs))), (Lists{{3}, {0, 3}, {0}, {}}));
}

TEST(HidingGraph, ReversedTwiceHasTheSameArcs) {
  std::mt19937 random(5);
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t nodes = 1 + static_cast<std::uint32_t>(random()) % 20;
    Lists lists = nested(list_behind(nodes, random_pairs(random, nodes, 60)));
    for (std::vector<std::uint32_t>& list : lists) std::sort(list.begin(), list.end());
    ASSERT_EQ(nested(reversed(reversed(flat(lists)))), lists);
  }
}

TEST(OrderedComponents, OfSmallGraphs) {
  EXPECT_EQ(components_of({}), Lists{});
  EXPECT_EQ(components_of({{}, {}, {}}), (Lists{{0}, {1}, {2}}));
  EXPECT_EQ(components_of({{1}, {2}, {}}), (Lists{{2}, {1}, {0}}));
  EXPECT_EQ(components_of({{1}, {2}, {0}}), (Lists{{0, 1, 2}}));
  EXPECT_EQ(components_of({{0}}), (Lists{{0}}));
  // 3 and 1 hide each other; 0 is before them and 2 behind.
  EXPECT_EQ(components_of({{1}, {3, 2}, {}, {1}}), (Lists{{2}, {1, 3}, {0}}));
}

TEST(OrderedComponents, AreThoseOfReachability) {
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    const std::uint32_t count = 1 + static_cast<std::uint32_t>(random()) % 30;
    const Lists behind = nested(list_behind(count, random_pairs(random, count, 2 * count)));
    std::vector<std::vector<bool>> reaches(count, std::vector<bool>(count));
    for (std::uint32_t a = 0; a < count; ++a) {
      reaches[a][a] = true;
      for (const std::uint32_t b : behind[a]) reaches[a][b] = true;
    }
    for (std::uint32_t via = 0; via < count; ++via) {
      for (std::uint32_t a = 0; a < count; ++a) {
        for (std::uint32_t b = 0; b < count; ++b) {
          if (reaches[a][via] && reaches[via][b]) reaches[a][b] = true;
        }
      }
    }
    const Lists components = components_of(behind);
    std::vector<std::size_t> place(count, count);
    for (std::size_t c = 0; c < components.size(); ++c) {
      EXPECT_TRUE(std::is_sorted(components[c].begin(), components[c].end()));
      for (const std::uint32_t node : components[c]) {
        ASSERT_EQ(place[node], count);
        place[node] = c;
      }
    }
    for (std::uint32_t a = 0; a < count; ++a) {
      ASSERT_LT(place[a], count);
      for (std::uint32_t b = 0; b < count; ++b) {
        ASSERT_EQ(place[a] == place[b], reaches[a][b] && reaches[b][a]);
        if (reaches[a][b]) {
          ASSERT_LE(place[b], place[a]);
        }
      }
    }
  }
}

// A recursive algorithm would overflow its stack.
TEST(OrderedComponents, GoDeep) {
  constexpr std::uint32_t count = 500'000;
  Lists chain(count), ring(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    if (i + 1 < count) chain[i] = {i + 1};
    ring[i] = {(i + 1) % count};
  }
  ComponentFinder finder;
  EXPECT_EQ(finder.find(flat(chain)).count(), count);
  EXPECT_EQ(finder.find(flat(ring)).count(), 1u);
}

}  // namespace
}  // namespace facetsort::exact_internal
