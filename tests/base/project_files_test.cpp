// What must hold of every file of the project: no place of some machine in it, nothing left to do, nothing stray.
#include "base/project_files.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <functional>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace facetsort {
namespace {

// Below these lie the files of one user or one machine.
constexpr std::array folders_of_one_machine{"Users", "home", "media", "mnt",  "opt",
                                            "root",  "srv",  "vol",   "work", "workspace"};

// Absolute paths below such a folder. A path starts where no word, URL or variable goes on.
std::vector<std::string> machine_paths(const std::string& text) {
  if (text.find('/') == std::string::npos) return {};  // most lines
  std::vector<std::string> paths;
  static const std::regex pattern(R"((?:^|[^A-Za-z0-9_.:/)}\]*<>~\\$-])/([A-Za-z]+)/[A-Za-z0-9_.-]+)");
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    const auto& folders = folders_of_one_machine;
    if (std::find(folders.begin(), folders.end(), (*match)[1].str()) != folders.end()) {
      const std::string found = match->str();
      paths.push_back(found.substr(found.find('/')));
    }
  }
  return paths;
}

bool is_word_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_';
}

// Each word of `text` that marks work left undone. The words are put together here, or this file would have them.
std::vector<std::string> unfinished_marks(std::string_view text) {
  static const std::set<std::string, std::less<>> marks{std::string("TO") + "DO", std::string("FIX") + "ME",
                                                        std::string("XX") + "X", std::string("HA") + "CK"};
  std::vector<std::string> found;
  for (auto begin = text.begin(); begin != text.end();) {
    begin = std::find_if(begin, text.end(), is_word_character);
    const auto end = std::find_if_not(begin, text.end(), is_word_character);
    if (const auto mark = marks.find(std::string_view(begin, end)); mark != marks.end()) found.push_back(*mark);
    begin = end;
  }
  return found;
}

// Binary files say what they are in text, if anywhere, before their first zero byte.
std::string readable_text_of(const std::filesystem::path& file) {
  const std::string bytes = read_project_file(file);
  return bytes.substr(0, bytes.find('\0'));
}

// A mesh's numbers look like nothing else and take long to search; what it says of itself is in its header.
std::string prose_of(const std::filesystem::path& file) {
  const std::string text = readable_text_of(file);
  return file.extension() == ".ply" ? text.substr(0, text.find("end_header")) : text;
}

using Strings = std::vector<std::string>;

TEST(ProjectFiles, NameNoPlaceOfOneMachine) {
  for (const std::filesystem::path& file : project_files()) {
    for (const std::string& line : lines_of(prose_of(file))) {
      EXPECT_EQ(machine_paths(line), Strings{}) << file << ": " << line;
    }
  }
}

TEST(ProjectFiles, LeaveNothingToDo) {
  for (const std::filesystem::path& file : project_files()) {
    for (const std::string& line : lines_of(prose_of(file))) {
      EXPECT_EQ(unfinished_marks(line), Strings{}) << file << ": " << line;
    }
  }
}

TEST(ProjectFiles, StandWhereTheTreeHasAPlaceForThem) {
  const std::set<std::string> folders{"apps", "bench", "lib", "meshes", "tests"};
  for (const std::filesystem::path& file : project_files()) {
    const std::string top = file.begin()->string();
    if (top.starts_with(".") || file.has_parent_path() == false) continue;
    EXPECT_TRUE(folders.contains(top)) << file;
  }
}

TEST(ProjectFiles, FindsPlacesOfOneMachine) {
  const std::string home = std::string("/ho") + "me/";
  EXPECT_EQ(machine_paths("meshes from " + home + "ann/meshes"), Strings{home + "ann"});
  EXPECT_EQ(machine_paths("\"" + home + "ann\", (" + home + "bob)"), (Strings{home + "ann", home + "bob"}));
  EXPECT_EQ(machine_paths(home + "ann"), Strings{home + "ann"});
}

TEST(ProjectFiles, TakesNothingElseForAPlace) {
  for (const std::string text :
       {"#!/usr/bin/env bash", "https://example.org/a/b", "lib/facetsort/order", "x/y/z", "${root}/meshes/a.ply",
        "../lib/a", "\"/meshes/a.ply\"", "f 1 2 /1/1", "</b>", "// comment", "/* a */", "1/255", "a / b / c"}) {
    EXPECT_EQ(machine_paths(text), Strings{}) << text;
  }
}

TEST(ProjectFiles, FindsWhatIsUnfinished) {
  const std::string mark = std::string("TO") + "DO";
  EXPECT_EQ(unfinished_marks("// " + mark + ": later"), Strings{mark});
  EXPECT_EQ(unfinished_marks("facetsort-XXXXXX and todo lists"), Strings{});
}

// The fallback must see the same files as git does, or tests of a tarball would check less.
TEST(ProjectFiles, AreFoundWithoutGitToo) {
  const std::vector<std::filesystem::path> walked = files_found_by_walking();
  for (const std::filesystem::path& file : project_files()) {
    EXPECT_NE(std::find(walked.begin(), walked.end(), file), walked.end()) << file;
  }
}

}  // namespace
}  // namespace facetsort
