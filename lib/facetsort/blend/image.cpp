#include "facetsort/blend/image.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

// One display step, plus what rounding two values n / 255 to float can add to their difference.
constexpr double display_step = 1.0 / 255 + 0x1p-23;

struct RowError {
  std::size_t wrong_pixels = 0, covered_pixels = 0;
  double squares = 0, largest = 0;
};

// A channel that is no number is infinitely wrong: it must not pass for right because it compares false.
double difference(float value, float reference) {
  const double d = std::abs(static_cast<double>(value) - static_cast<double>(reference));
  return std::isnan(d) ? std::numeric_limits<double>::infinity() : d;
}

}  // namespace

bool differs_visibly(const glm::vec4& pixel, const glm::vec4& reference) {
  for (int channel = 0; channel < 4; ++channel) {
    if (difference(pixel[channel], reference[channel]) > display_step) return true;
  }
  return false;
}

ImageError compare_images(const Image& image, const Image& reference, const std::vector<unsigned char>& covered) {
  assert(image.width == reference.width && image.height == reference.height);
  assert(image.pixels.size() == reference.pixels.size() && covered.size() == image.pixels.size());
  const auto width = static_cast<std::size_t>(image.width);
  // Sums are kept by row and added in row order, so that they round the same for any thread count.
  std::vector<RowError> rows(static_cast<std::size_t>(image.height));
  parallel_ranges(rows.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t y = begin; y < end; ++y) {
      RowError& row = rows[y];
      for (std::size_t p = y * width; p < (y + 1) * width; ++p) {
        if (!covered[p]) continue;
        ++row.covered_pixels;
        double largest_colour = 0;
        for (int channel = 0; channel < 3; ++channel) {
          const double d = difference(image.pixels[p][channel], reference.pixels[p][channel]);
          row.squares += d * d;
          largest_colour = std::max(largest_colour, d);
        }
        row.largest = std::max(row.largest, largest_colour);
        row.wrong_pixels += differs_visibly(image.pixels[p], reference.pixels[p]);
      }
    }
  });

  RowError total;
  for (const RowError& row : rows) {
    total.wrong_pixels += row.wrong_pixels;
    total.covered_pixels += row.covered_pixels;
    total.squares += row.squares;
    total.largest = std::max(total.largest, row.largest);
  }
  ImageError error;
  error.wrong_pixels = total.wrong_pixels;
  error.max_error = total.largest;
  if (total.covered_pixels > 0)
    error.rmse = std::sqrt(total.squares / (3.0 * static_cast<double>(total.covered_pixels)));
  return error;
}

}  // namespace facetsort
