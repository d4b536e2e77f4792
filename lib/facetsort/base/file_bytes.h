// The bytes of a file, to read where they lie.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <vector>

#include "facetsort/base/status.h"

namespace facetsort {

// Mapped into memory where the platform can, so that opening costs nothing and no page is read before it is needed;
// read otherwise. A mapped file must not be shortened or written over while this lives; to replace it by renaming
// another to its name is safe.
class FileBytes {
 public:
  // Of a regular file. Faults: cannot_read, out_of_memory; the message names the file.
  static Result<FileBytes> open(const std::filesystem::path& path);

  FileBytes() = default;  // no byte
  FileBytes(FileBytes&& other) noexcept { *this = std::move(other); }
  FileBytes& operator=(FileBytes&& other) noexcept;
  ~FileBytes() { release(); }

  // Begin at a multiple of 8 in memory, and are valid as long as this object, moved or not, is.
  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  void release();

  std::span<const std::byte> bytes_;
  std::vector<std::byte> read_;  // empty where they are mapped
};

}  // namespace facetsort
