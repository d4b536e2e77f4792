// The project's own files, for tests that read them.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace facetsort {

inline std::filesystem::path project_root() {
  return FACETSORT_SOURCE_DIR;
}

// What git tracks or would add. Empty without git, or where the project is no checkout of its own.
inline std::vector<std::filesystem::path> files_known_to_git() {
  std::vector<std::filesystem::path> files;
  if (!std::filesystem::exists(project_root() / ".git")) return files;
  const std::string command =
      "git -C '" + project_root().string() + "' ls-files -z --cached --others --exclude-standard 2>/dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  if (!pipe) return files;
  std::string name;
  for (int c; (c = std::fgetc(pipe)) != EOF;) {
    if (c != '\0') {
      name.push_back(static_cast<char>(c));
      continue;
    }
    // A file that was deleted and not yet committed is still listed.
    if (std::filesystem::is_regular_file(project_root() / name)) files.emplace_back(name);
    name.clear();
  }
  const int status = pclose(pipe);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) files.clear();
  return files;
}

// What lies in the project's folders and is neither hidden nor made by a build or a run.
inline std::vector<std::filesystem::path> files_found_by_walking() {
  std::vector<std::filesystem::path> files;
  std::filesystem::recursive_directory_iterator walk(project_root());
  for (const auto& entry : walk) {
    const std::filesystem::path file = entry.path().lexically_relative(project_root());
    const bool hidden_folder = entry.is_directory() && file.filename().string().starts_with(".") && file != ".ci";
    if (hidden_folder || file == "build" || file == "report") walk.disable_recursion_pending();
    if (entry.is_regular_file()) files.push_back(file);
  }
  return files;
}

// Every file of the project, relative to its root, sorted and each once. Throws where there is none.
inline std::vector<std::filesystem::path> project_files() {
  std::vector<std::filesystem::path> files = files_known_to_git();
  if (files.empty()) files = files_found_by_walking();
  if (files.empty()) throw std::runtime_error("no file in " + project_root().string());
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  return files;
}

// All bytes of a file of the project. Throws where it can't be read.
inline std::string read_project_file(const std::filesystem::path& file) {
  std::ifstream stream(project_root() / file, std::ios::binary);
  std::string bytes(std::filesystem::file_size(project_root() / file), '\0');
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) {
    throw std::runtime_error("can't read " + file.string());
  }
  return bytes;
}

inline std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

}  // namespace facetsort
