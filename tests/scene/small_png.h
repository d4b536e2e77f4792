// PNG files without compression, for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace facetsort {

// 8 bits a channel, RGBA, row after row. ISO/IEC 15948; the image is one stored block of RFC 1950 and 1951.
// Precondition: the rows with their filter bytes are fewer than 65536 bytes.
inline std::string small_png(std::uint32_t width, std::uint32_t height, const std::vector<std::uint8_t>& channels) {
  const auto big_endian = [](std::uint32_t value) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
    return bytes;
  };
  const auto chunk = [&](const std::string& content) {  // with its type
    std::uint32_t crc = 0xffffffffu;
    for (const char c : content) {
      crc ^= static_cast<unsigned char>(c);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc % 2 == 1 ? 0xedb88320u : 0u);
    }
    return big_endian(static_cast<std::uint32_t>(content.size() - 4)) + content + big_endian(~crc);
  };
  std::string rows;
  for (std::uint32_t y = 0; y < height; ++y) {
    rows += '\0';  // no filter
    for (std::uint32_t i = 0; i < 4 * width; ++i) rows += static_cast<char>(channels[y * 4 * width + i]);
  }
  std::uint32_t a = 1, b = 0;  // Adler-32
  for (const char c : rows) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto low = [](std::size_t value) { return static_cast<char>(value & 255); };
  const std::size_t size = rows.size();
  std::string stored = std::string("\x78\x01\x01", 3) + low(size) + low(size >> 8) + low(~size) + low(~size >> 8);
  return std::string("\x89PNG\r\n\x1a\n", 8) +
         chunk("IHDR" + big_endian(width) + big_endian(height) + std::string("\x08\x06\0\0\0", 5)) +
         chunk("IDAT" + stored + rows + big_endian(b << 16 | a)) + chunk("IEND");
}

}  // namespace facetsort
