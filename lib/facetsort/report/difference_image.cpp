#include "facetsort/report/difference_image.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

namespace facetsort {
namespace {

// The grey stays below this, in linear light (about 28 % of the sRGB range): darker than any difference colour.
constexpr float brightest_grey = 0.065f;
// Two 8-bit values one step apart, as floats, differ by display_step give or take this.
constexpr float rounding = 0x1p-23f;

// Of the four channels; NaN is as wrong as can be.
float largest_difference(const glm::vec4& a, const glm::vec4& b) {
  const glm::vec4 difference = glm::abs(a - b);
  if (glm::any(glm::isnan(difference))) return 1;
  return std::max({difference.r, difference.g, difference.b, difference.a});
}

float srgb_decoded(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

glm::vec4 dark_grey(const glm::vec4& pixel) {
  const float luminance = glm::dot(glm::vec3(pixel), glm::vec3(0.2126f, 0.7152f, 0.0722f));  // Rec. 709
  return {glm::vec3(brightest_grey * std::clamp(luminance, 0.0f, 1.0f)), 1};
}

}  // namespace

glm::vec3 difference_colour(float difference) {
  static constexpr std::array<glm::vec3, 5> stops{{{0.45f, 0.20f, 0.85f},
                                                   {0.80f, 0.16f, 0.55f},
                                                   {0.95f, 0.35f, 0.18f},
                                                   {0.99f, 0.68f, 0.16f},
                                                   {1.00f, 0.98f, 0.72f}}};
  const float clamped = std::clamp(difference, display_step, 1.0f);
  const float position = (1 - std::log(clamped) / std::log(display_step)) * static_cast<float>(stops.size() - 1);
  const std::size_t below = std::min(static_cast<std::size_t>(position), stops.size() - 2);
  return glm::mix(stops[below], stops[below + 1], position - static_cast<float>(below));
}

Image difference_image(const Image& image, const Image& reference) {
  assert(image.width == reference.width && image.height == reference.height);
  Image picture{reference.width, reference.height, PixelFormat::rgba32f, {}};
  picture.pixels.reserve(reference.pixel_count());
  for (std::size_t p = 0; p < reference.pixel_count(); ++p) {
    const float difference = largest_difference(image.pixels[p], reference.pixels[p]);
    if (difference > display_step + rounding) {
      const glm::vec3 colour = difference_colour(difference);
      picture.pixels.emplace_back(srgb_decoded(colour.r), srgb_decoded(colour.g), srgb_decoded(colour.b), 1.0f);
    } else {
      picture.pixels.push_back(dark_grey(reference.pixels[p]));
    }
  }
  return picture;
}

}  // namespace facetsort
