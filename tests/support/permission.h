// Files that may not be read.
#pragma once

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "mesh/temporary_folder.h"

namespace facetsort {

// Takes all permissions from `file` in `folder` and expects `is_refused(file)` of a child that is not root, whom
// permissions don't stop.
template <typename IsRefused>
void expect_refused_without_permission(const TemporaryFolder& folder, const std::filesystem::path& file,
                                       const IsRefused& is_refused) {
  ASSERT_EQ(chmod(folder.path().c_str(), 0755), 0);
  ASSERT_EQ(chmod(file.c_str(), 0), 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    constexpr uid_t nobody = 65534;
    if (geteuid() == 0 && setuid(nobody) != 0) _exit(2);
    _exit(is_refused(file) ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

}  // namespace facetsort
