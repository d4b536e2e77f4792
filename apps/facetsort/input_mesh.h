// A mesh file of the command line, read and measured.
#pragma once

#include <filesystem>
#include <string>

#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

struct InputMesh {
  std::filesystem::path path;
  std::string name;  // the file's, without its extension
  Mesh mesh;
  Box bounds;
  double radius = 1;  // R; 1 for a mesh that is a single point, whose R is 0
};

// Throws Failure where the file is no mesh, or one too large for float32 to measure.
InputMesh read_input_mesh(const std::filesystem::path& path);

}  // namespace facetsort
