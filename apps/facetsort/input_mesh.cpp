#include "input_mesh.h"

#include <cmath>
#include <vector>

#include "facetsort/mesh/read.h"
#include "failure.h"
#include "output.h"

namespace facetsort {
namespace {

Mesh copy_of(const MeshView& view) {
  const auto copy = [](const auto& values) { return std::vector(values.begin(), values.end()); };
  return {copy(view.positions), copy(view.triangles), copy(view.facet_colours), copy(view.vertex_colours)};
}

}  // namespace

InputMesh read_input_mesh(const std::filesystem::path& path) {
  InputMesh input;
  input.path = path;
  input.name = path.stem().string();
  if (extension_of(path) == ".fsort") {
    input.presorted = require(PresortedMesh::open(path));
    input.mesh = copy_of(input.presorted->view().mesh);
  } else {
    input.mesh = require(read_mesh(path));
  }
  input.bounds = facet_bounds(input.mesh.view());
  const float radius = input.bounds.radius();
  if (!std::isfinite(radius)) throw Failure(path.string() + ": the mesh's size is beyond the range of float32");
  if (radius > 0) input.radius = static_cast<double>(radius);
  return input;
}

}  // namespace facetsort
