// A folder of results that changes only when all of them are there.
#pragma once

#include <filesystem>

namespace facetsort {

// Files are written to path(), a hidden folder inside `target`, and moved into place by publish(): a run that fails or
// is given up leaves earlier results as they were. All throw Failure where the file system refuses.
class StagingFolder {
 public:
  // Makes `target` where it is missing.
  explicit StagingFolder(std::filesystem::path target);
  StagingFolder(const StagingFolder&) = delete;
  StagingFolder& operator=(const StagingFolder&) = delete;
  // Takes away what was not published, and a `target` that was made for nothing.
  ~StagingFolder();

  const std::filesystem::path& path() const { return path_; }
  // Moves every file to the same place under `target`, over what is there; other files there stay.
  void publish();

 private:
  std::filesystem::path target_, path_;
  bool made_target_ = false;
};

}  // namespace facetsort
