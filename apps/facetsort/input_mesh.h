// A mesh file of the command line, read and measured.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh.h"
#include "facetsort/order/presorted_mesh.h"

namespace facetsort {

struct InputMesh {
  std::filesystem::path path;
  std::string name;  // the file's, without its extension
  Mesh mesh;
  std::optional<PresortedMesh> presorted;  // where the file is a .fsort
  Box bounds;
  double radius = 1;  // R; 1 for a mesh that is a single point, whose R is 0

  // Null where it was not presorted, or into plain index buffers alone.
  const PresortedView* tree() const {
    return presorted && !presorted->view().pieces.empty() ? &presorted->view() : nullptr;
  }
};

// A mesh, or the mesh in a presorted one. Throws Failure where the file is neither, or one too large for float32 to measure.
InputMesh read_input_mesh(const std::filesystem::path& path);

}  // namespace facetsort
