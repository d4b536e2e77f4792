// The meshes that tests run on: every *.ply of the project's own folder and of the folders in FACETSORT_MESH_PATH.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/mesh/mesh.h"
#include "facetsort/mesh/read.h"

namespace facetsort {

// FACETSORT_SOURCE_DIR/meshes, then the folders of the environment variable FACETSORT_MESH_PATH (separated by colons).
inline std::vector<std::filesystem::path> mesh_folders() {
  std::vector<std::filesystem::path> folders{std::filesystem::path(FACETSORT_SOURCE_DIR) / "meshes"};
  if (const char* list = std::getenv("FACETSORT_MESH_PATH")) {
    std::istringstream stream(list);
    for (std::string folder; std::getline(stream, folder, ':');) {
      if (!folder.empty()) folders.emplace_back(folder);
    }
  }
  return folders;
}

// Each mesh once (by file name; the project's own first), sorted by file name. Throws where a folder can't be listed.
inline std::vector<std::filesystem::path> mesh_files() {
  std::vector<std::filesystem::path> files;
  for (const std::filesystem::path& folder : mesh_folders()) {
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const auto same_name = [&](const auto& file) { return file.filename() == entry.path().filename(); };
      if (entry.path().extension() == ".ply" && std::none_of(files.begin(), files.end(), same_name)) {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.filename() < b.filename(); });
  return files;
}

// Whether a mesh of this name (its file name without the extension) is there.
inline bool has_mesh(const std::string& name) {
  const std::vector<std::filesystem::path> files = mesh_files();
  return std::any_of(files.begin(), files.end(), [&](const auto& file) { return file.stem() == name; });
}

// The mesh of this name. Throws, and so fails the test that asked, where it is missing or can't be read.
inline Mesh load(const std::string& name) {
  for (const std::filesystem::path& file : mesh_files()) {
    if (file.stem() != name) continue;
    Result<Mesh> mesh = read_mesh(file);
    if (!mesh.ok()) throw std::runtime_error(mesh.status().message);
    return std::move(mesh).value();
  }
  throw std::runtime_error("no mesh named " + name + " in meshes/ or FACETSORT_MESH_PATH");
}

}  // namespace facetsort
