#include "facetsort/base/new_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <iterator>
#include <span>
#include <string>
#include <string_view>

#include "facetsort/base/file_bytes.h"
#include "mesh/temporary_folder.h"

namespace facetsort {
namespace {

std::size_t file_count(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

std::string text_of(const std::filesystem::path& path) {
  const Result<FileBytes> file = FileBytes::open(path);
  if (!file.ok()) return file.status().message;
  return {reinterpret_cast<const char*>(file.value().bytes().data()), file.value().bytes().size()};
}

void write(NewFile& file, std::string_view text) {
  file.write(std::as_bytes(std::span(text)));
}

TEST(NewFile, IsThereWhenItIsFinished) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("file", "old");
  NewFile file(path);
  write(file, "new ");
  write(file, "content");
  EXPECT_EQ(text_of(path), "old");
  ASSERT_TRUE(file.finish().ok());
  EXPECT_EQ(text_of(path), "new content");
  EXPECT_EQ(file_count(folder.path()), 1u);
}

TEST(NewFile, LeavesNothingWhenItIsGivenUp) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("file", "old");
  {
    NewFile file(path);
    write(file, "half of the new");
  }
  EXPECT_EQ(text_of(path), "old");
  EXPECT_EQ(file_count(folder.path()), 1u);
}

TEST(NewFile, SharesNoTemporaryFileAndRemovesNoOthers) {
  const TemporaryFolder folder;
  constexpr int names = 1000;
  for (int i = 0; i < names; ++i) folder.write(".facetsort-" + std::to_string(i) + ".tmp", "another's");
  NewFile file(folder.path() / "file");
  write(file, "content");
  const Status status = file.finish();
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, (folder.path() / "file").string() + ": cannot be written: File exists");
  EXPECT_EQ(file_count(folder.path()), static_cast<std::size_t>(names));
}

}  // namespace
}  // namespace facetsort
