#include "staging_folder.h"

#include <unistd.h>

#include <string>
#include <system_error>
#include <utility>

#include "failure.h"

namespace facetsort {
namespace {

namespace fs = std::filesystem;

void require_written(const fs::path& path, const std::error_code& error) {
  if (error) throw Failure(path.string() + ": cannot be written: " + error.message());
}

}  // namespace

StagingFolder::StagingFolder(fs::path target) : target_(std::move(target)) {
  std::error_code error;
  made_target_ = fs::create_directories(target_, error);
  require_written(target_, error);
  path_ = target_ / (".facetsort-" + std::to_string(getpid()));
  fs::create_directory(path_, error);
  require_written(target_, error);
}

StagingFolder::~StagingFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  if (made_target_) fs::remove(target_, ignored);  // only where it is empty
}

void StagingFolder::publish() {
  try {
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(path_)) {
      const fs::path place = target_ / fs::relative(entry.path(), path_);
      if (entry.is_directory()) {
        fs::create_directories(place);
      } else {
        fs::rename(entry.path(), place);
      }
    }
  } catch (const fs::filesystem_error& error) {
    throw Failure(error.path2().string() + ": cannot be written: " + error.code().message());
  }
}

}  // namespace facetsort
