#include "facetsort/blend/image.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

namespace facetsort {
namespace {

Image image_of(int width, int height, std::vector<glm::vec4> pixels) {
  return {width, height, PixelFormat::rgba32f, std::move(pixels)};
}

TEST(CompareImages, FindsNoErrorInEqualPictures) {
  const Image image = image_of(2, 1, {{0.1f, 0.2f, 0.3f, 0.4f}, {1, 0, 1, 1}});
  const ImageError error = compare_images(image, image, {1, 1});
  EXPECT_EQ(error.wrong_pixels, 0u);
  EXPECT_EQ(error.rmse, 0);
  EXPECT_EQ(error.max_error, 0);
}

TEST(CompareImages, ForgivesOneDisplayStepAndNotTwo) {
  for (int n = 0; n < 254; ++n) {
    const auto level = [](int step) { return static_cast<float>(step) / 255; };
    const Image reference = image_of(3, 1, std::vector<glm::vec4>(3, glm::vec4(0, level(n), 0, 1)));
    const Image image = image_of(3, 1, {{0, level(n), 0, 1}, {0, level(n + 1), 0, 1}, {0, level(n + 2), 0, 1}});
    EXPECT_EQ(compare_images(image, reference, {1, 1, 1}).wrong_pixels, 1u) << n;
    EXPECT_EQ(compare_images(reference, image, {1, 1, 1}).wrong_pixels, 1u) << n;
  }
}

TEST(CompareImages, MeasuresColourOverCoveredPixels) {
  const Image reference = image_of(2, 2, std::vector<glm::vec4>(4, glm::vec4(0)));
  const Image image = image_of(2, 2, {{0.5f, 0, 0, 0}, {0, 0.5f, 0.5f, 0}, {1, 1, 1, 1}, {0, 0, 0, 0}});
  const ImageError error = compare_images(image, reference, {1, 1, 0, 1});
  EXPECT_EQ(error.wrong_pixels, 2u);
  EXPECT_EQ(error.max_error, 0.5);
  EXPECT_DOUBLE_EQ(error.rmse, std::sqrt(0.75 / 9));
}

TEST(CompareImages, CountsAlphaAsWrongOnly) {
  const ImageError error = compare_images(image_of(1, 1, {{0, 0, 0, 1}}), image_of(1, 1, {{0, 0, 0, 0.5f}}), {1});
  EXPECT_EQ(error.wrong_pixels, 1u);
  EXPECT_EQ(error.rmse, 0);
  EXPECT_EQ(error.max_error, 0);
}

TEST(CompareImages, HasNothingToSayOfUncoveredPictures) {
  const ImageError error = compare_images(image_of(1, 1, {{1, 1, 1, 1}}), image_of(1, 1, {{0, 0, 0, 0}}), {0});
  EXPECT_EQ(error.wrong_pixels, 0u);
  EXPECT_EQ(error.rmse, 0);
  EXPECT_EQ(error.max_error, 0);
}

TEST(CompareImages, TakesNoNumberForWrong) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  const ImageError error = compare_images(image_of(1, 1, {{nan, 0, 0, 1}}), image_of(1, 1, {{0, 0, 0, 1}}), {1});
  EXPECT_EQ(error.wrong_pixels, 1u);
  EXPECT_EQ(error.max_error, std::numeric_limits<double>::infinity());
}

TEST(CompareImages, IsTheSameForAnyThreadCount) {
  const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
  std::mt19937 random(3);
  const auto level = [&] { return static_cast<float>(random() % 4096) / 4095; };
  std::vector<glm::vec4> pixels, reference_pixels;
  for (int i = 0; i < 100 * 70; ++i) {
    pixels.emplace_back(level(), level(), level(), 1);
    reference_pixels.emplace_back(level(), level(), level(), 1);
  }
  const Image image = image_of(100, 70, pixels), reference = image_of(100, 70, reference_pixels);
  const std::vector<unsigned char> covered(pixels.size(), 1);
  const ImageError expected = compare_images(image, reference, covered);
  EXPECT_NEAR(expected.rmse, std::sqrt(1.0 / 6), 0.01);  // of two uniform numbers
  for (const int threads : {1, 2, 8}) {
    const ImageError error =
        tbb::task_arena(threads).execute([&] { return compare_images(image, reference, covered); });
    EXPECT_EQ(error.wrong_pixels, expected.wrong_pixels);
    EXPECT_EQ(error.rmse, expected.rmse);
    EXPECT_EQ(error.max_error, expected.max_error);
  }
}

}  // namespace
}  // namespace facetsort
