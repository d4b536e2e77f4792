// A file that is there only when it is complete.
#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>

#include "facetsort/base/status.h"

namespace facetsort {

// Written under another name in the same folder, then renamed: until finish() gives ok, and for good where something
// fails, what stood at the path is as it was. Faults: cannot_write; the message names the file.
class NewFile {
 public:
  // A link stays, and the file that it leads to is replaced.
  explicit NewFile(const std::filesystem::path& path);
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile() { discard(); }

  // After a fault, does nothing.
  void write(std::span<const std::byte> bytes);
  // Ok when the file stands under its own name. To be called once, last.
  Status finish();

 private:
  void fail(const std::string& what);
  void fail_with(int error);
  void discard();

  std::filesystem::path path_, temporary_;
  std::FILE* file_ = nullptr;
  Status status_;
};

}  // namespace facetsort
