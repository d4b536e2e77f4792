#include "facetsort/scene/gltf_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <span>

#include "facetsort/scene/gltf_file.h"

namespace facetsort::scene_internal {
namespace {

// A texel takes 16 bytes here, and a picture of one colour next to none in its file.
constexpr std::size_t most_texels = std::size_t{1} << 26;

// IEC 61966-2-1.
double linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

double srgb(double value) {
  return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

struct Size {
  std::size_t width, height;
};

std::size_t big_endian(std::span<const unsigned char> bytes, std::size_t at, std::size_t count) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < count; ++i) value = value << 8 | bytes[at + i];
  return value;
}

// ISO/IEC 15948: the signature, then a chunk of the size.
std::optional<Size> png_size(std::span<const unsigned char> file) {
  constexpr std::array<unsigned char, 8> signature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  constexpr std::size_t width_at = 16, height_at = 20, end = 24;
  if (file.size() < end || !std::equal(signature.begin(), signature.end(), file.begin())) return std::nullopt;
  return Size{big_endian(file, width_at, 4), big_endian(file, height_at, 4)};
}

// ISO/IEC 10918-1: segments up to the first that starts a frame.
std::optional<Size> jpeg_size(std::span<const unsigned char> file) {
  if (file.size() < 4 || file[0] != 0xff || file[1] != 0xd8) return std::nullopt;
  for (std::size_t at = 2; at + 9 <= file.size();) {
    if (file[at] != 0xff) return std::nullopt;
    const unsigned char marker = file[at + 1];
    if (marker == 0xff) {  // a byte of padding
      ++at;
      continue;
    }
    const bool starts_frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (starts_frame) return Size{big_endian(file, at + 7, 2), big_endian(file, at + 5, 2)};
    at += 2 + big_endian(file, at + 2, 2);
  }
  return std::nullopt;
}

std::span<const unsigned char> picture_file(const tinygltf::Model& model, const tinygltf::Image& image,
                                            const std::string& place) {
  if (image.bufferView >= 0) return bytes_of_view(model, image.bufferView, place);
  if (image.image.empty()) throw SceneError{Fault::cannot_read, place + ": '" + image.uri + "' can't be read"};
  return image.image;
}

// As stb has it, four channels of 8 or 16 bits.
tinygltf::Image decoded(std::span<const unsigned char> file, const std::string& place) {
  std::optional<Size> size = png_size(file);
  if (!size) size = jpeg_size(file);
  if (!size) throw SceneError{Fault::unsupported_format, place + " is neither PNG nor JPEG"};
  if (size->width == 0 || size->height == 0 || size->width > most_texels / size->height ||
      file.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) {
    throw SceneError{Fault::unsupported_format, place + " has " + std::to_string(size->width) + " x " +
                                                    std::to_string(size->height) + " texels: none, or too many"};
  }
  tinygltf::Image image;
  std::string error, warning;
  if (!tinygltf::LoadImageData(&image, 0, &error, &warning, 0, 0, file.data(), static_cast<int>(file.size()),
                               nullptr)) {
    throw SceneError{Fault::malformed, place + " can't be decoded"};
  }
  const std::size_t texels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  if (image.component != 4 || image.image.size() != texels * 4 * (image.bits == 16 ? 2 : 1)) {
    throw SceneError{Fault::malformed, place + " was decoded to something else than its size says"};
  }
  return image;
}

template <typename Channel>
void convert(const std::vector<unsigned char>& bytes, std::vector<glm::vec4>& texels) {
  constexpr double largest = std::numeric_limits<Channel>::max();
  std::vector<float> linear_values(std::size_t{std::numeric_limits<Channel>::max()} + 1);
  for (std::size_t i = 0; i < linear_values.size(); ++i) {
    linear_values[i] = static_cast<float>(linear(static_cast<double>(i) / largest));
  }
  for (std::size_t t = 0; t < texels.size(); ++t) {
    std::array<Channel, 4> channels;
    std::memcpy(channels.data(), bytes.data() + t * sizeof channels, sizeof channels);
    for (int c = 0; c < 3; ++c) texels[t][c] = linear_values[channels[static_cast<std::size_t>(c)]];
    texels[t].a = static_cast<float>(channels[3] / largest);
  }
}

unsigned char to_byte(double value) {
  return static_cast<unsigned char>(std::lround(255 * std::min(std::max(0.0, value), 1.0)));
}

}  // namespace

void decode_picture(const tinygltf::Model& model, int image, const std::string& place, Texture& texture) {
  if (image < 0 || static_cast<std::size_t>(image) >= model.images.size()) {
    throw SceneError{Fault::unsupported_format, place + " has no picture that is PNG or JPEG"};
  }
  const std::string here = place + ", picture " + std::to_string(image);
  const tinygltf::Image found = decoded(picture_file(model, model.images[static_cast<std::size_t>(image)], here), here);
  texture.width = found.width;
  texture.height = found.height;
  texture.texels.resize(static_cast<std::size_t>(found.width) * static_cast<std::size_t>(found.height));
  if (found.bits == 16) {
    convert<std::uint16_t>(found.image, texture.texels);
  } else {
    convert<std::uint8_t>(found.image, texture.texels);
  }
}

std::vector<unsigned char> encode_picture(const Texture& texture) {
  tinygltf::Image image;
  image.width = texture.width;
  image.height = texture.height;
  image.component = 4;
  image.bits = 8;
  image.pixel_type = TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
  for (const glm::vec4& texel : texture.texels) {
    for (int c = 0; c < 3; ++c) image.image.push_back(to_byte(srgb(static_cast<double>(texel[c]))));
    image.image.push_back(to_byte(static_cast<double>(texel.a)));
  }
  // tinygltf hands out a picture's bytes only as a file or, as here, in a data URI.
  const std::string folder, name = "picture.png";
  std::string uri, type;
  std::vector<unsigned char> bytes;
  if (!tinygltf::WriteImageData(&folder, &name, &image, true, &uri, nullptr) ||
      !tinygltf::DecodeDataURI(&bytes, type, uri, 0, false)) {
    bytes.clear();
  }
  return bytes;
}

}  // namespace facetsort::scene_internal
