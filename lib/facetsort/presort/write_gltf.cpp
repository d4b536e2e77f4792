#include "facetsort/presort/write_gltf.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/base/new_file.h"
#include "facetsort/facets/facets.h"

namespace facetsort {
namespace {

// Vertices and triangles as glTF has them: colours belong to vertices.
struct Geometry {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec4> colours;  // of vertices, or none
  std::vector<glm::uvec3> triangles;
};

Geometry geometry_of(const MeshView& mesh) {
  Geometry geometry;
  if (mesh.facet_colours.empty()) {
    geometry.positions.assign(mesh.positions.size(), glm::vec3(0));  // what no facet uses may not be a number
    for (const glm::uvec3& triangle : mesh.triangles) {
      for (int i = 0; i < 3; ++i) geometry.positions[triangle[i]] = mesh.positions[triangle[i]];
    }
    geometry.colours.assign(mesh.vertex_colours.begin(), mesh.vertex_colours.end());
    geometry.triangles.assign(mesh.triangles.begin(), mesh.triangles.end());
    return geometry;
  }
  for (std::size_t facet = 0; facet < mesh.facet_count(); ++facet) {
    const auto first = static_cast<std::uint32_t>(geometry.positions.size());
    for (int i = 0; i < 3; ++i) {
      geometry.positions.push_back(mesh.corner(facet, i));
      geometry.colours.push_back(mesh.facet_colours[facet]);
    }
    geometry.triangles.emplace_back(first, first + 1, first + 2);
  }
  return geometry;
}

template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
  return values.size() * sizeof(T);
}

// Appends values to the model's buffer, little-endian as this machine, and gives the number of their accessor.
template <typename T>
int add_accessor(tinygltf::Model& model, const std::vector<T>& values, int target, int component_type, int type,
                 std::size_t count) {
  std::vector<unsigned char>& bytes = model.buffers.front().data;
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = bytes.size();
  view.byteLength = bytes_of(values);
  view.target = target;
  bytes.resize(bytes.size() + view.byteLength);
  std::memcpy(bytes.data() + view.byteOffset, values.data(), view.byteLength);
  tinygltf::Accessor accessor;
  accessor.bufferView = static_cast<int>(model.bufferViews.size());
  accessor.componentType = component_type;
  accessor.type = type;
  accessor.count = count;
  model.bufferViews.push_back(std::move(view));
  model.accessors.push_back(std::move(accessor));
  return static_cast<int>(model.accessors.size()) - 1;
}

template <typename Values>
tinygltf::Value number_list(const Values& values) {
  tinygltf::Value::Array list;
  for (const auto value : values) list.emplace_back(static_cast<double>(value));
  return tinygltf::Value(std::move(list));
}

tinygltf::Value table_of(const MeshView& mesh, const IndexBuffers& buffers) {
  tinygltf::Value::Array directions, buffer_of_direction;
  for (const glm::vec3& direction : buffers.directions) {
    for (int axis = 0; axis < 3; ++axis) directions.emplace_back(static_cast<double>(direction[axis]));
  }
  for (const std::uint32_t buffer : buffers.buffer_of_direction)
    buffer_of_direction.emplace_back(static_cast<int>(buffer));
  const glm::vec3 centre = facet_bounds(mesh).centre();
  tinygltf::Value::Object table;
  table["directions"] = tinygltf::Value(std::move(directions));
  table["buffers"] = tinygltf::Value(std::move(buffer_of_direction));
  table["centre"] = number_list(std::vector{centre.x, centre.y, centre.z});
  table["needsCulling"] = tinygltf::Value(buffers.needs_culling);
  table["meanInvertedRate"] = tinygltf::Value(buffers.mean_inverted_rate);
  table["worstInvertedRate"] = tinygltf::Value(buffers.worst_inverted_rate);
  return tinygltf::Value(std::move(table));
}

tinygltf::Model model_of(const MeshView& mesh, const IndexBuffers& buffers) {
  const Geometry geometry = geometry_of(mesh);
  tinygltf::Model model;
  model.asset.version = "2.0";
  model.asset.generator = "facetsort";
  model.buffers.emplace_back();
  model.buffers.front().data.reserve(bytes_of(geometry.positions) + bytes_of(geometry.colours) +
                                     buffers.buffer_count * bytes_of(geometry.triangles));

  const int positions = add_accessor(model, geometry.positions, TINYGLTF_TARGET_ARRAY_BUFFER,
                                     TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, geometry.positions.size());
  glm::vec3 lowest = geometry.positions.front(), highest = lowest;
  for (const glm::vec3& position : geometry.positions) {
    lowest = glm::min(lowest, position);
    highest = glm::max(highest, position);
  }
  for (int axis = 0; axis < 3; ++axis) {
    model.accessors.back().minValues.push_back(static_cast<double>(lowest[axis]));
    model.accessors.back().maxValues.push_back(static_cast<double>(highest[axis]));
  }
  int colours = -1;
  if (!geometry.colours.empty()) {
    colours = add_accessor(model, geometry.colours, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                           TINYGLTF_TYPE_VEC4, geometry.colours.size());
  }

  tinygltf::Material& material = model.materials.emplace_back();
  material.alphaMode = "BLEND";
  material.doubleSided = !buffers.needs_culling;
  if (geometry.colours.empty()) material.pbrMetallicRoughness.baseColorFactor = {1, 1, 1, 0.5};
  material.pbrMetallicRoughness.metallicFactor = 0;

  tinygltf::Mesh& drawn = model.meshes.emplace_back();
  std::vector<glm::uvec3> triangles(geometry.triangles.size());
  for (std::size_t buffer = 0; buffer < buffers.buffer_count; ++buffer) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      triangles[i] = geometry.triangles[buffers.facets[buffer * triangles.size() + i]];
    }
    tinygltf::Primitive& primitive = drawn.primitives.emplace_back();
    primitive.attributes["POSITION"] = positions;
    if (colours >= 0) primitive.attributes["COLOR_0"] = colours;
    primitive.indices = add_accessor(model, triangles, TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER,
                                     TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT, TINYGLTF_TYPE_SCALAR, 3 * triangles.size());
    primitive.material = 0;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
  }
  tinygltf::Node& node = model.nodes.emplace_back();
  node.name = "presorted";
  node.mesh = 0;
  node.extras = table_of(mesh, buffers);
  model.scenes.emplace_back().nodes = {0};
  model.defaultScene = 0;
  return model;
}

// Of what a binary file holds, roughly from above.
std::size_t most_bytes(const MeshView& mesh, const IndexBuffers& buffers) {
  const std::size_t vertices = mesh.facet_colours.empty() ? mesh.vertex_count() : 3 * mesh.facet_count();
  return vertices * (sizeof(glm::vec3) + sizeof(glm::vec4)) + buffers.facets.size() * sizeof(glm::uvec3) +
         buffers.directions.size() * 128;
}

}  // namespace

Status write_gltf(const std::filesystem::path& path, const MeshView& mesh, const IndexBuffers& buffers) {
  if (mesh.facet_count() == 0) return {Fault::empty_mesh, path.string() + ": glTF has no meshes without facets"};
  const bool as_text = path.extension() == ".gltf";
  if (most_bytes(mesh, buffers) / (as_text ? 1 : 2) > std::numeric_limits<std::uint32_t>::max() / 2) {
    return {Fault::too_many_facets, path.string() + ": glTF has no room for so many facets and buffers"};
  }
  try {
    std::ostringstream text;
    const tinygltf::Model model = model_of(mesh, buffers);
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, text, false, !as_text)) {
      return {Fault::cannot_write, path.string() + ": cannot be written as glTF"};
    }
    NewFile file(path);
    const std::string_view content = text.view();
    file.write(std::as_bytes(std::span(content)));
    return file.finish();
  } catch (const std::bad_alloc&) {
    return {Fault::out_of_memory, path.string() + ": not enough memory to write it"};
  }
}

}  // namespace facetsort
