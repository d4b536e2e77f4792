// A mesh or scene of the command line, read and measured.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "facetsort/blend/strategy.h"
#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh.h"
#include "facetsort/order/presorted_mesh.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

struct InputMesh {
  std::filesystem::path path;
  std::string name;  // the file's, without its extension
  Mesh mesh;
  std::optional<PresortedMesh> presorted;  // where the file is a .fsort
  std::optional<Scene> scene;              // where it is a scene, merged into `mesh`, blended objects first
  std::vector<MergedObject> objects;       // of that
  Box bounds;
  double radius = 1;  // R; 1 for a mesh that is a single point, whose R is 0

  // What the file has of a presorted mesh.
  PresortedInput presorted_input() const {
    if (!presorted) return {};
    return {presorted->has_tree() ? &presorted->view() : nullptr, presorted->index_buffers()};
  }
  SceneInput scene_input() const {
    if (!scene) return {};
    return {&*scene, objects};
  }
};

// By its name.
bool is_gltf(const std::filesystem::path& path);
// A glTF file, or a folder.
bool is_scene(const std::filesystem::path& path);

// A mesh, or the mesh in a presorted one. Throws Failure where the file is neither, or one too large for float32 to
// measure.
InputMesh read_input_mesh(const std::filesystem::path& path);
// The same; or a scene, in a glTF file or a folder (see read_scene()).
InputMesh read_input_scene(const std::filesystem::path& path);

}  // namespace facetsort
