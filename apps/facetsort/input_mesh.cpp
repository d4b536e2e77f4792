#include "input_mesh.h"

#include <cmath>

#include "facetsort/mesh/read.h"
#include "failure.h"

namespace facetsort {

InputMesh read_input_mesh(const std::filesystem::path& path) {
  InputMesh input;
  input.path = path;
  input.name = path.stem().string();
  input.mesh = require(read_mesh(path));
  input.bounds = facet_bounds(input.mesh.view());
  const float radius = input.bounds.radius();
  if (!std::isfinite(radius)) throw Failure(path.string() + ": the mesh's size is beyond the range of float32");
  if (radius > 0) input.radius = static_cast<double>(radius);
  return input;
}

}  // namespace facetsort
