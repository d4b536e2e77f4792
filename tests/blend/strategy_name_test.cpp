// The names of strategies that take more than a method or a number.
#include <gtest/gtest.h>

#include <optional>

#include "facetsort/blend/strategy.h"

namespace facetsort {
namespace {

TEST(StrategyName, AutoMayHaveABudget) {
  const std::optional<Strategy> plain = strategy_from_name("auto"), budgeted = strategy_from_name("auto:0.001");
  ASSERT_TRUE(plain && budgeted);
  EXPECT_EQ(plain->kind, StrategyKind::automatic);
  EXPECT_EQ(plain->error_budget, 0);
  EXPECT_EQ(budgeted->error_budget, 0.001);
  EXPECT_EQ(plain->name(), "auto");
  EXPECT_EQ(budgeted->name(), "auto:0.001");
  EXPECT_EQ(strategy_from_name("auto:1e-3"), budgeted);
  EXPECT_EQ(strategy_from_name("auto:0"), plain);
  EXPECT_NE(plain, budgeted);
}

TEST(StrategyName, ABudgetIsAShare) {
  for (const char* name : {"auto:", "auto:-0.1", "auto:1.1", "auto:nan", "auto:0.1%", "auto:x"}) {
    EXPECT_FALSE(strategy_from_name(name)) << name;
  }
}

TEST(StrategyName, DepthKeysMayBeQuantised) {
  const std::optional<Strategy> whole = strategy_from_name("facet_sort:farthest_vertex");
  const std::optional<Strategy> quantised = strategy_from_name("facet_sort:farthest_vertex:quantised");
  ASSERT_TRUE(whole && quantised);
  EXPECT_EQ(whole->precision, Precision::whole);
  EXPECT_EQ(quantised->precision, Precision::quantised);
  EXPECT_EQ(quantised->method, Method::farthest_vertex);
  EXPECT_EQ(quantised->name(), "facet_sort:farthest_vertex:quantised");
  EXPECT_NE(whole, quantised);
  for (const char* name : {"facet_sort:exact:quantised", "facet_sort:quantised", "facet_sort:farthest_vertex:whole",
                           "facet_sort::quantised", "unsorted:quantised"}) {
    EXPECT_FALSE(strategy_from_name(name)) << name;
  }
}

// Those can be drawn without a plan.
TEST(StrategyName, AutoIsNotAmongThoseThatARendererDraws) {
  for (const Strategy& strategy : all_strategies()) EXPECT_NE(strategy.kind, StrategyKind::automatic);
}

}  // namespace
}  // namespace facetsort
