#include "facetsort/blend/swap_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace facetsort {
namespace {

glm::vec4 over(const glm::vec4& above, const glm::vec4& below) {
  return above + below * (1.0f - above.a);
}

TEST(SwapError, IsTheProductOfAlphasAndTheDifferenceOfColours) {
  // Straight (1, 0.5, 0) at alpha 0.5 and (0, 0.25, 1) at alpha 0.2: 0.1 times (1, 0.25, 1).
  const glm::vec4 first(0.5f, 0.25f, 0, 0.5f), second(0, 0.05f, 0.2f, 0.2f);
  const glm::vec3 error = swap_error(first, second);
  EXPECT_NEAR(error.r, 0.1f, 1e-7f);
  EXPECT_NEAR(error.g, 0.025f, 1e-7f);
  EXPECT_NEAR(error.b, 0.1f, 1e-7f);
  EXPECT_EQ(error, swap_error(second, first));
  // And it is the swap's: nothing less, nothing more.
  const glm::vec4 difference = over(first, second) - over(second, first);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(std::abs(difference[k]), error[k], 1e-7f);
  EXPECT_NEAR(difference.a, 0, 1e-7f);
}

TEST(SwapError, IsNoneForOneColourAndForWhatOnlyAddsLight) {
  const glm::vec4 thin(0.05f, 0.1f, 0.1f, 0.1f), thick(0.45f, 0.9f, 0.9f, 0.9f), light(0.3f, 0.2f, 0.1f, 0);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(swap_error(thin, thick)[k], 0, 1e-7f);
  EXPECT_EQ(swap_error(light, light), glm::vec3(0));
  // Light that is added is dimmed by what is in front of it.
  EXPECT_NEAR(swap_error(light, thick).r, 0.27f, 1e-6f);
}

TEST(OrderErrorBound, OfTwoLayersIsTheirSwap) {
  const glm::vec4 layers[] = {{0.5f, 0.25f, 0, 0.5f}, {0, 0.05f, 0.2f, 0.2f}};
  EXPECT_EQ(order_error_bound(layers), swap_error(layers[0], layers[1]));
  EXPECT_EQ(order_error_bound(std::span(layers, 1)), glm::vec3(0));
  EXPECT_EQ(order_error_bound({}), glm::vec3(0));
}

TEST(OrderErrorBound, IsNeverMoreThanTheColoursAllow) {
  // Ten layers of alpha 0.9: the swaps' sum would be 25 x 0.81.
  std::vector<glm::vec4> layers;
  for (int i = 0; i < 10; ++i) layers.emplace_back(i % 2 == 0 ? 0.9f : 0.0f, 0.9f, 0.45f, 0.9f);
  const glm::vec3 bound = order_error_bound(layers);
  EXPECT_NEAR(bound.r, 1, 1e-6f);
  EXPECT_NEAR(bound.g, 0, 1e-6f);
  EXPECT_NEAR(bound.b, 0, 1e-6f);
}

// Every order of a few layers: the bound holds, and thin layers come near it.
TEST(OrderErrorBound, HoldsForAnyTwoOrders) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0, 1);
  float closest = 0;
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(trial);
    const float most_alpha = trial % 3 == 0 ? 0.01f : trial % 3 == 1 ? 0.2f : 1.0f;  // sums below 1, and above
    std::vector<glm::vec4> layers;
    for (int i = 0; i < 2 + trial % 4; ++i) {
      const float alpha = trial % 10 == 9 && i == 0 ? 0 : most_alpha * uniform(random);
      const float scale = alpha == 0 ? 0.1f : alpha;  // one only adds light
      layers.emplace_back(scale * uniform(random), scale * uniform(random), scale * uniform(random), alpha);
    }
    const glm::vec3 bound = order_error_bound(layers);
    std::vector<std::size_t> order(layers.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    glm::vec3 lowest(INFINITY), highest(-INFINITY);
    do {
      glm::vec4 blended(0.3f, 0.6f, 0.1f, 1);
      for (const std::size_t i : order) blended = over(layers[i], blended);
      lowest = glm::min(lowest, glm::vec3(blended));
      highest = glm::max(highest, glm::vec3(blended));
    } while (std::next_permutation(order.begin(), order.end()));
    for (int k = 0; k < 3; ++k) {
      ASSERT_LE(highest[k] - lowest[k], bound[k] + 1e-6f);
      if (bound[k] > 1e-5f) closest = std::max(closest, (highest[k] - lowest[k]) / bound[k]);
    }
  }
  EXPECT_GT(closest, 0.95f);
}

}  // namespace
}  // namespace facetsort
