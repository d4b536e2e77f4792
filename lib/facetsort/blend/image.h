// Pictures: what the blend target makes and what pictures are compared as.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace facetsort {

// Both linear, premultiplied alpha. rgba8 rounds to n / 255 after every blend, as an 8-bit render target does.
enum class PixelFormat { rgba32f, rgba8 };

// Row-major, row 0 on top, four channels a pixel. Both formats keep their values in float (an rgba8 picture's are
// whole numbers over 255), so that one piece of code compares, writes and shows either.
struct Image {
  int width = 0, height = 0;
  PixelFormat format = PixelFormat::rgba32f;
  std::vector<glm::vec4> pixels;

  std::size_t pixel_count() const { return pixels.size(); }
};

// Whether some channel differs by more than one display step (1/255), or is no number.
bool differs_visibly(const glm::vec4& pixel, const glm::vec4& reference);

// How far a picture is from the reference picture.
struct ImageError {
  std::size_t wrong_pixels = 0;  // differs_visibly()
  double rmse = 0;               // over linear RGB of the covered pixels
  double max_error = 0;          // largest difference in linear RGB
};

// `covered` (one a pixel) tells which pixels count. Precondition: same size.
ImageError compare_images(const Image& image, const Image& reference, const std::vector<unsigned char>& covered);

}  // namespace facetsort
