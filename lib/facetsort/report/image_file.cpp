#include "facetsort/report/image_file.h"

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "facetsort/report/replace_file.h"

namespace facetsort {
namespace {

// Clamped to 0..1; NaN becomes 0.
std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::lround(255.0f * std::min(std::max(0.0f, value), 1.0f)));
}

// IEC 61966-2-1.
float srgb_encoded(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

std::vector<std::uint8_t> srgb_bytes(const Image& image) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(4 * image.pixel_count());
  for (const glm::vec4& pixel : image.pixels) {
    const float alpha = std::min(pixel.a, 1.0f);
    for (int channel = 0; channel < 3; ++channel) {
      bytes.push_back(to_byte(alpha > 0 ? srgb_encoded(pixel[channel] / alpha) : 0.0f));
    }
    bytes.push_back(to_byte(alpha));
  }
  return bytes;
}

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

// OpenImageIO's messages may run over several lines; ours have one.
Status write_fault(const std::filesystem::path& path, std::string reason) {
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return {Fault::cannot_write, path.string() + ": cannot be written: " + reason};
}

Status write_pixels(const std::filesystem::path& path, const std::filesystem::path& temporary,
                    const OIIO::ImageSpec& spec, OIIO::TypeDesc type, const void* pixels) {
  const std::unique_ptr<OIIO::ImageOutput> output = OIIO::ImageOutput::create(temporary.string());
  if (!output) return write_fault(path, OIIO::geterror());
  // Not one expression: close() must be called even after a failed write, and its own failure counts.
  if (!output->open(temporary.string(), spec)) return write_fault(path, output->geterror());
  const bool written = output->write_image(type, pixels);
  const bool closed = output->close();
  return written && closed ? Status{} : write_fault(path, output->geterror());
}

}  // namespace

Status write_image(const std::filesystem::path& path, const Image& image) {
  const std::string extension = extension_of(path);
  if (extension != ".exr" && extension != ".png") {
    return {Fault::unsupported_format, path.string() + ": pictures are written as .exr or .png"};
  }
  if (image.width < 1 || image.height < 1 ||
      image.pixel_count() != static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    return {Fault::bad_argument, path.string() + ": the picture has no pixels or not as many as its size says"};
  }
  const bool exr = extension == ".exr";
  OIIO::ImageSpec spec(image.width, image.height, 4, exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", exr ? "Linear" : "sRGB");
  if (exr) {
    spec.attribute("compression", "zip");
  } else {
    spec.attribute("oiio:UnassociatedAlpha", 1);  // ours is straight already: not to be divided again
  }
  return replace_file(path, [&](const std::filesystem::path& temporary) {
    if (exr) return write_pixels(path, temporary, spec, OIIO::TypeDesc::FLOAT, image.pixels.data());
    const std::vector<std::uint8_t> bytes = srgb_bytes(image);
    return write_pixels(path, temporary, spec, OIIO::TypeDesc::UINT8, bytes.data());
  });
}

}  // namespace facetsort
