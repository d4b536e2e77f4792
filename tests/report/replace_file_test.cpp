#include "facetsort/report/replace_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <string>

#include "report/sample.h"

namespace facetsort {
namespace {

TEST(ReplaceFile, AFailedWriteLeavesTheOldFileAndNothingElse) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "data.txt";
  test::write_text(path, "old");
  const Status status = replace_file(path, [&](const std::filesystem::path& temporary) {
    EXPECT_EQ(temporary.parent_path(), path.parent_path());
    EXPECT_EQ(temporary.extension(), path.extension());
    EXPECT_NE(temporary, path);
    test::write_text(temporary, "half of the new");
    return Status{Fault::cannot_write, "disk full"};
  });
  EXPECT_EQ(status.message, "disk full");
  EXPECT_EQ(test::read_text(path), "old");
  EXPECT_EQ(test::file_count(folder.path()), 1u);
}

TEST(ReplaceFile, TheOldFileIsThereUntilTheNewIsComplete) {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / "data.txt";
  test::write_text(path, "old");
  const Status status = replace_file(path, [&](const std::filesystem::path& temporary) {
    test::write_text(temporary, "new");
    EXPECT_EQ(test::read_text(path), "old");
    return Status{};
  });
  EXPECT_TRUE(status.ok());
  EXPECT_EQ(test::read_text(path), "new");
  EXPECT_EQ(test::file_count(folder.path()), 1u);
}

TEST(ReplaceFile, AFileCutShortIsAFault) {
  const test::TemporaryFolder folder;
  test::write_text(folder / "data", "old");
  // The system refuses to write beyond this size, as it does on a full disk.
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &unlimited), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limited{1000, unlimited.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  const Status status = replace_file_content(folder / "data", std::string(100000, 'x'));
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, (folder / "data").string() + ": cannot be written: File too large");
  EXPECT_EQ(test::read_text(folder / "data"), "old");
  EXPECT_EQ(test::file_count(folder.path()), 1u);
}

TEST(ReplaceFile, KeepsEveryByte) {
  const test::TemporaryFolder folder;
  const std::string content("a\0b\r\n\xff", 6);
  ASSERT_TRUE(replace_file_content(folder / "data", content).ok());
  EXPECT_EQ(test::read_text(folder / "data"), content);
}

}  // namespace
}  // namespace facetsort
