#include "facetsort/base/file_bytes.h"

#if defined(__unix__) || defined(__APPLE__)
#define FACETSORT_MAPS_FILES 1
#include <sys/mman.h>
#else
#define FACETSORT_MAPS_FILES 0
#endif

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <new>
#include <string>
#include <system_error>
#include <utility>

namespace facetsort {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

Status cannot_read(const std::filesystem::path& path, const std::string& what) {
  return {Fault::cannot_read, path.string() + ": " + what};
}

// Null where it can't be done: some file systems map nothing.
const std::byte* map(std::FILE* file, std::size_t size) {
#if FACETSORT_MAPS_FILES
  void* const first = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fileno(file), 0);
  return first == MAP_FAILED ? nullptr : static_cast<const std::byte*>(first);
#else
  static_cast<void>(file);
  static_cast<void>(size);
  return nullptr;
#endif
}

// A pipe or a device may have no end.
Status check_regular(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) return cannot_read(path, "is a directory");
  if (!std::filesystem::exists(status)) return cannot_read(path, "cannot be opened: " + error.message());
  if (!std::filesystem::is_regular_file(status)) return cannot_read(path, "is not a regular file");
  return {};
}

}  // namespace

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
  if (this == &other) return *this;
  release();
  bytes_ = std::exchange(other.bytes_, {});
  read_ = std::exchange(other.read_, {});
  return *this;
}

void FileBytes::release() {
#if FACETSORT_MAPS_FILES
  // The interface takes a pointer that could be written through; the pages can't.
  if (read_.empty() && !bytes_.empty()) munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
#endif
  bytes_ = {};
}

Result<FileBytes> FileBytes::open(const std::filesystem::path& path) {
  if (Status status = check_regular(path); !status.ok()) return status;
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) return cannot_read(path, "cannot be opened: " + std::generic_category().message(errno));
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return cannot_read(path, "cannot be read: " + error.message());
  if (size > std::numeric_limits<std::ptrdiff_t>::max()) {
    return Status{Fault::out_of_memory, path.string() + ": larger than memory can be"};
  }

  FileBytes opened;
  if (size == 0) return opened;
  const auto length = static_cast<std::size_t>(size);
  if (const std::byte* const mapped = map(file.get(), length)) {
    opened.bytes_ = {mapped, length};
    return opened;
  }
  try {
    opened.read_.resize(length);
  } catch (const std::bad_alloc&) {
    return Status{Fault::out_of_memory, path.string() + ": not enough memory to read it"};
  }
  errno = 0;
  opened.read_.resize(std::fread(opened.read_.data(), 1, length, file.get()));
  if (std::ferror(file.get())) return cannot_read(path, "cannot be read: " + std::generic_category().message(errno));
  opened.bytes_ = opened.read_;
  return opened;
}

}  // namespace facetsort
