// The bytes of .fsort files, to be damaged.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "facetsort/order/presorted_mesh.h"

namespace facetsort {

using FileContent = std::vector<std::byte>;

// Where FSORT.md puts things.
constexpr std::size_t version_offset = 8, checksum_offset = 12, file_size_offset = 16, section_count_offset = 24,
                      reserved_offset = 28, table_offset = 32, entry_size = 32;
constexpr std::size_t flags_in_entry = 4, offset_in_entry = 8, size_in_entry = 16, count_in_entry = 24;

// Throws where the mesh can't be written.
inline FileContent content_of(const PresortedView& view, const IndexBuffers* buffers = nullptr) {
  std::ostringstream stream;
  if (const Status status = write_presorted(stream, view, buffers); !status.ok()) {
    throw std::runtime_error(status.message);
  }
  const std::string text = stream.str();
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

inline FileContent content_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

template <typename Value>
Value get(const FileContent& content, std::size_t offset) {
  Value value;
  std::memcpy(&value, &content.at(offset), sizeof value);
  return value;
}

template <typename Value>
void put(FileContent& content, std::size_t offset, Value value) {
  content.at(offset + sizeof value - 1);
  std::memcpy(&content[offset], &value, sizeof value);
}

// Bit by bit, as the definition says.
inline std::uint32_t plain_crc32(std::span<const std::byte> bytes) {
  std::uint32_t remainder = 0xffffffffu;
  for (const std::byte byte : bytes) {
    remainder ^= static_cast<std::uint32_t>(byte);
    for (int bit = 0; bit < 8; ++bit) remainder = remainder >> 1 ^ ((remainder & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~remainder;
}

inline void mend_checksum(FileContent& content) {
  put(content, checksum_offset, plain_crc32(std::span(content).subspan(file_size_offset)));
}

// Where the table's entry of a section begins. Throws where there is none.
inline std::size_t entry_of(const FileContent& content, const std::string& id) {
  for (std::size_t i = 0; i < get<std::uint32_t>(content, section_count_offset); ++i) {
    const std::size_t entry = table_offset + i * entry_size;
    if (std::memcmp(&content.at(entry), id.data(), 4) == 0) return entry;
  }
  throw std::runtime_error("no section " + id);
}

}  // namespace facetsort
