// Running the facetsort program as a user does: arguments in; exit status, standard output and standard error out.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

#include "facetsort/mesh/mesh.h"
#include "facetsort/mesh/write.h"
#include "mesh/temporary_folder.h"

namespace facetsort {

struct Finished {
  int status = -1;  // exit status; -1 where a signal ended it
  std::string output, error;
};

inline std::string file_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot open " + path.string());
  return {std::istreambuf_iterator<char>(file), {}};
}

struct RunOptions {
  std::string standard_output = {};        // a file or device in place of Finished::output
  std::vector<std::string> settings = {};  // "NAME=value", before the tests' own environment
};

// The program has neither a terminal nor any input.
inline Finished run_program(const std::vector<std::string>& arguments, const RunOptions& options = {}) {
  const TemporaryFolder folder;
  const std::string output = (folder.path() / "output").string(), error = (folder.path() / "error").string();
  const std::string& written = options.standard_output.empty() ? output : options.standard_output;

  std::vector<std::string> words{FACETSORT_PROGRAM};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv, environment;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::vector<std::string> settings = options.settings;
  for (std::string& setting : settings) environment.push_back(setting.data());
  for (char** inherited = environ; *inherited != nullptr; ++inherited) environment.push_back(*inherited);
  environment.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, written.c_str(), O_WRONLY | O_CREAT, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, error.c_str(), O_WRONLY | O_CREAT, 0600);
  pid_t process = 0;
  const int failure = posix_spawn(&process, argv[0], &actions, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) throw std::runtime_error("cannot run " + words[0]);

  Finished finished;
  int outcome = 0;
  while (waitpid(process, &outcome, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(outcome)) finished.status = WEXITSTATUS(outcome);
  if (options.standard_output.empty()) finished.output = file_bytes(output);
  finished.error = file_bytes(error);
  return finished;
}

// The path of a mesh file in `folder`, as an argument.
inline std::string write_mesh(const TemporaryFolder& folder, const std::string& name, const Mesh& mesh) {
  const std::filesystem::path path = folder.path() / name;
  const Status status = write_ply(path, mesh.view());
  if (!status.ok()) throw std::runtime_error(status.message);
  return path.string();
}

}  // namespace facetsort
