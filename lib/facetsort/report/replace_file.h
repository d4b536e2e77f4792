// Output files appear whole or not at all: written under a temporary name in the same folder, then renamed.
// Internal to report and our programs.
#pragma once

#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "facetsort/base/status.h"
#include "facetsort/report/join.h"

namespace facetsort {

// Calls `write` with the temporary path (same folder, same extension), then renames it to `path`. When either fails
// the temporary file is removed, and a file that stood at `path` is as it was. Write: Status(const path& temporary).
template <typename Write>
Status replace_file(const std::filesystem::path& path, const Write& write) {
  static std::atomic<unsigned> counter{0};
  std::filesystem::path temporary = path;
  temporary.replace_filename(
      join(".", std::to_string(getpid()), "-", std::to_string(counter++), "-", path.filename().string()));
  Status status = write(static_cast<const std::filesystem::path&>(temporary));
  std::error_code error;
  if (status.ok()) {
    std::filesystem::rename(temporary, path, error);
    if (!error) return status;
    status = {Fault::cannot_write, path.string() + ": cannot be replaced: " + error.message()};
  }
  std::filesystem::remove(temporary, error);
  return status;
}

// The same for content that is ready in memory.
inline Status replace_file_content(const std::filesystem::path& path, std::string_view content) {
  return replace_file(path, [&](const std::filesystem::path& temporary) {
    errno = 0;
    std::ofstream file(temporary, std::ios::binary);
    file.write(content.data(), static_cast<std::streamsize>(content.size()));
    file.close();
    if (file) return Status{};
    const std::error_code reason(errno != 0 ? errno : EIO, std::generic_category());
    return Status{Fault::cannot_write, path.string() + ": cannot be written: " + reason.message()};
  });
}

}  // namespace facetsort
