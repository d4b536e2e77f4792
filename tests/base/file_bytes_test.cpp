#include "facetsort/base/file_bytes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "mesh/temporary_folder.h"

namespace facetsort {
namespace {

std::string text_of(const FileBytes& file) {
  const auto bytes = file.bytes();
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(FileBytes, AreAllThatTheFileHas) {
  const TemporaryFolder folder;
  for (const std::string& content : {std::string(), std::string("a\0\r\n\x1a\xff", 6), std::string(100000, 'x')}) {
    const Result<FileBytes> file = FileBytes::open(folder.write("file", content));
    ASSERT_TRUE(file.ok()) << file.status().message;
    EXPECT_EQ(text_of(file.value()), content);
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(file.value().bytes().data()) % 8, 0u);
  }
}

TEST(FileBytes, StayWhereTheyAreWhenMoved) {
  const TemporaryFolder folder;
  Result<FileBytes> opened = FileBytes::open(folder.write("file", "content"));
  ASSERT_TRUE(opened.ok());
  const std::byte* const first = opened.value().bytes().data();
  FileBytes other = std::move(opened).value();
  FileBytes file;
  file = std::move(other);
  EXPECT_EQ(file.bytes().data(), first);
  EXPECT_EQ(text_of(file), "content");
  // Its name may go, or to another file.
  folder.write("new", "another");
  std::filesystem::rename(folder.path() / "new", folder.path() / "file");
  EXPECT_EQ(text_of(file), "content");
}

// Linux has files that can't be mapped, and that hold less than they say.
TEST(FileBytes, AreReadWhereTheyCannotBeMapped) {
  const std::filesystem::path path = "/sys/kernel/mm/transparent_hugepage/enabled";
  std::ifstream stream(path, std::ios::binary);
  const std::string content{std::istreambuf_iterator<char>(stream), {}};
  if (content.empty()) GTEST_SKIP() << "no such file here";
  const Result<FileBytes> file = FileBytes::open(path);
  ASSERT_TRUE(file.ok()) << file.status().message;
  EXPECT_EQ(text_of(file.value()), content);
}

}  // namespace
}  // namespace facetsort
