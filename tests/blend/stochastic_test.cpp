// Stochastic transparency: the masks, and pictures worked out from them.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <set>
#include <vector>

#include "blend/pictures.h"
#include "blend/sheets.h"
#include "facetsort/blend/sample_masks.h"

namespace facetsort {
namespace {

using blend_internal::SampleMasks;

SampleMasks masks_of(int samples) {
  SampleMasks masks;
  masks.set_samples(samples);
  return masks;
}

TEST(SampleMasks, CoverAlphaOfTheSamplesInTheMean) {
  for (const int samples : {1, 3, 8, 33, 64}) {
    const SampleMasks masks = masks_of(samples);
    for (const float alpha : {0.0f, 0.03f, 0.5f, 0.77f, 1.0f}) {
      SCOPED_TRACE(testing::Message() << samples << " samples, alpha " << alpha);
      constexpr int side = 200;
      std::vector<double> covered(static_cast<std::size_t>(samples), 0);
      for (int y = 0; y < side; ++y) {
        for (int x = 0; x < side; ++x) {
          const std::uint64_t mask = masks.covered(static_cast<std::uint32_t>(x * y), x, y, alpha);
          const float exact = alpha * static_cast<float>(samples);
          ASSERT_LT(std::abs(static_cast<float>(std::popcount(mask)) - exact), 1.0f);
          for (std::size_t s = 0; s < 64; ++s) {
            const bool is_covered = (mask >> s & 1) != 0;
            if (s < covered.size())
              covered[s] += is_covered;
            else
              ASSERT_FALSE(is_covered);
          }
        }
      }
      // Five standard deviations of a sample's mean.
      for (const double count : covered) EXPECT_NEAR(count / (side * side), static_cast<double>(alpha), 5 * 0.5 / side);
    }
  }
}

// What one fragment covers says nothing of what another does: both cover a sample with probability alpha squared.
TEST(SampleMasks, OfFragmentsOfAPixelAreIndependent) {
  const SampleMasks masks = masks_of(8);
  constexpr int side = 300;
  std::size_t both = 0, same = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const std::uint64_t a = masks.covered(7, x, y, 0.5f), b = masks.covered(8, x, y, 0.5f);
      both += static_cast<std::size_t>(std::popcount(a & b));
      same += a == b;
    }
  }
  EXPECT_NEAR(static_cast<double>(both) / (8.0 * side * side), 0.25, 5 * 0.15 / side);
  EXPECT_NEAR(static_cast<double>(same) / (side * side), 1.0 / 70, 5 * 0.12 / side);  // 4 of 8: 70 subsets
}

// Where alpha S is whole, the nearest layer covers exactly alpha of the samples, whichever: two layers are source-over.
TEST(Stochastic, TwoLayersAreExactWhereTheFirstCoversWholeSamples) {
  const Sheet layers[] = {{8, green, 0.37f}, {4, red, 0.75f}};
  for (const int samples : {4, 8, 20, 64}) {
    const Image image = draw_sheets(layers, sheets_view(40, 40), OrderIndependent::stochastic, samples);
    for (const glm::vec4& pixel : image.pixels) {
      ASSERT_NEAR(pixel.r, 0.75f, 1e-5f);
      ASSERT_NEAR(pixel.g, 0.25f * 0.37f, 1e-5f);
      ASSERT_NEAR(pixel.a, 1, 1e-5f);
    }
  }
}

// From the fixed masks: a sample's depth is the nearest that covers it; a layer is visible in those it is not behind;
// the sum of visible alphas is scaled to the opacity of all layers together.
TEST(Stochastic, AnyLayersAreWhatTheirMasksSay) {
  const Sheet layers[] = {{8, green, 0.4f}, {4, red, 0.7f}, {6, blue, 0.15f}, {9, {1, 1, 1}, 0.95f}};
  constexpr int nearest_first[] = {1, 2, 0, 3};
  const glm::vec4 clear_colour(0.25f, 0.5f, 0.75f, 0.5f);
  constexpr int width = 45, height = 37;
  for (const int samples : {1, 5, 16, 17, 64}) {
    SCOPED_TRACE(samples);
    const SampleMasks masks = masks_of(samples);
    const std::uint64_t all = samples == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << samples) - 1;
    const Image image =
        draw_sheets(layers, sheets_view(width, height), OrderIndependent::stochastic, samples, clear_colour);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        glm::dvec4 sum(0);
        double transparency = 1;
        std::uint64_t free = all;
        for (const int i : nearest_first) {
          const glm::vec4 colour = layers[i].premultiplied();
          sum += static_cast<double>(std::popcount(free)) / samples * glm::dvec4(colour);
          transparency *= 1 - static_cast<double>(colour.a);
          free &= ~masks.covered(static_cast<std::uint32_t>(i), x, y, colour.a);
        }
        const glm::dvec4 expected = (1 - transparency) / sum.a * sum + transparency * glm::dvec4(clear_colour);
        const glm::vec4& pixel = image.pixels[static_cast<std::size_t>(y * width + x)];
        for (int k = 0; k < 4; ++k) ASSERT_NEAR(static_cast<double>(pixel[k]), expected[k], 1e-5) << x << ", " << y;
      }
    }
  }
}

// Three layers at alpha 1/2: the third sees 1/4 of the samples in the mean.
TEST(Stochastic, TheMeanOfManyPixelsIsSourceOver) {
  const Sheet layers[] = {{4, red, 0.5f}, {6, green, 0.5f}, {8, blue, 0.5f}};
  constexpr int side = 128;
  glm::dvec4 mean(0);
  const Image image = draw_sheets(layers, sheets_view(side, side), OrderIndependent::stochastic, 64);
  for (const glm::vec4& pixel : image.pixels) {
    mean += glm::dvec4(pixel) / static_cast<double>(side * side);
  }
  // A pixel's blue strays by 0.02; the scaling of the sum, a ratio, is off by about its square.
  EXPECT_NEAR(mean.r, 0.5, 1e-3);
  EXPECT_NEAR(mean.g, 0.25, 1e-3);
  EXPECT_NEAR(mean.b, 0.125, 1e-3);
}

}  // namespace
}  // namespace facetsort
