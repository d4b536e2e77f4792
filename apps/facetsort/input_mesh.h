// A mesh file of the command line, read and measured.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "facetsort/blend/strategy.h"
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

  // What the file has of a presorted mesh.
  PresortedInput presorted_input() const {
    if (!presorted) return {};
    return {presorted->view().pieces.empty() ? nullptr : &presorted->view(), presorted->index_buffers()};
  }
};

// A mesh, or the mesh in a presorted one. Throws Failure where the file is neither, or one too large for float32 to
// measure.
InputMesh read_input_mesh(const std::filesystem::path& path);

}  // namespace facetsort
