#include "input_mesh.h"

#include <cmath>
#include <utility>
#include <vector>

#include "facetsort/mesh/read.h"
#include "facetsort/scene/read_scene.h"
#include "failure.h"
#include "output.h"

namespace facetsort {
namespace {

Mesh copy_of(const MeshView& view) {
  const auto copy = [](const auto& values) { return std::vector(values.begin(), values.end()); };
  return {copy(view.positions), copy(view.triangles), copy(view.facet_colours), copy(view.vertex_colours)};
}

void measure_bounds(InputMesh& input) {
  input.bounds = facet_bounds(input.mesh.view());
  const float radius = input.bounds.radius();
  if (!std::isfinite(radius)) throw Failure(input.path.string() + ": the mesh's size is beyond the range of float32");
  if (radius > 0) input.radius = static_cast<double>(radius);
}

}  // namespace

bool is_gltf(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".gltf" || extension == ".glb";
}

bool is_scene(const std::filesystem::path& path) {
  return is_gltf(path) || std::filesystem::is_directory(path);
}

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
  measure_bounds(input);
  return input;
}

InputMesh read_input_scene(const std::filesystem::path& path) {
  if (!is_scene(path)) return read_input_mesh(path);
  InputMesh input;
  input.path = path;
  input.name = (path.has_filename() ? path : path.parent_path()).stem().string();
  input.scene = require(read_scene(path));
  MergedMesh merged = require(merge(*input.scene, blended_first(*input.scene)));
  input.mesh = std::move(merged.mesh);
  input.objects = std::move(merged.objects);
  measure_bounds(input);
  return input;
}

}  // namespace facetsort
