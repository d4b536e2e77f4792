#include "facetsort/base/new_file.h"

#include <cerrno>
#include <system_error>
#include <utility>

namespace facetsort {

NewFile::NewFile(const std::filesystem::path& path) : path_(path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path_, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    // A rename would put a file in the place of a device.
    fail(std::filesystem::is_directory(status) ? "is a directory" : "is not a regular file");
    return;
  }
  if (std::filesystem::is_symlink(path_, error)) path_ = std::filesystem::weakly_canonical(path_, error);
  // "x": never over a file that is there, so that two writers never share one.
  constexpr int most_names = 1000;
  for (int i = 0; i < most_names && !file_; ++i) {
    temporary_ = path_.parent_path() / (".facetsort-" + std::to_string(i) + ".tmp");
    file_ = std::fopen(temporary_.c_str(), "wbx");
    if (!file_ && errno != EEXIST) break;
  }
  if (file_) return;
  temporary_.clear();  // it is another's
  fail_with(errno);
}

void NewFile::write(std::span<const std::byte> bytes) {
  if (file_ && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail_with(errno);
}

Status NewFile::finish() {
  if (!file_) return status_;
  // What the buffer holds is written here at the latest, and a full disk shows.
  if (std::fclose(std::exchange(file_, nullptr)) != 0) {
    fail_with(errno);
  } else if (std::error_code error; std::filesystem::rename(temporary_, path_, error), error) {
    fail("cannot be written: " + error.message());
  } else {
    temporary_.clear();
  }
  return status_;
}

void NewFile::fail_with(int error) {
  fail("cannot be written: " + std::generic_category().message(error));
}

void NewFile::fail(const std::string& what) {
  status_ = {Fault::cannot_write, path_.string() + ": " + what};
  discard();
}

void NewFile::discard() {
  if (file_) std::fclose(std::exchange(file_, nullptr));
  std::error_code ignored;
  if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
  temporary_.clear();
}

}  // namespace facetsort
