#include "facetsort/scene/write_scene.h"

#include <tiny_gltf.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstring>
#include <limits>
#include <map>
#include <new>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "facetsort/base/new_file.h"
#include "facetsort/scene/gltf_file.h"
#include "facetsort/scene/gltf_picture.h"
#include "facetsort/scene/gltf_settings.h"

namespace facetsort {

using scene_internal::encode_picture, scene_internal::extras_of, scene_internal::SceneError;

namespace {

constexpr double radians_per_degree = 0.017453292519943295;
constexpr std::uint32_t none = 0xffffffffu;

int wrap_mode(Wrap wrap) {
  switch (wrap) {
    case Wrap::mirrored_repeat:
      return TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT;
    case Wrap::clamp_to_edge:
      return TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE;
    case Wrap::repeat:
      break;
  }
  return TINYGLTF_TEXTURE_WRAP_REPEAT;
}

const char* alpha_mode(AlphaMode mode) {
  return mode == AlphaMode::opaque ? "OPAQUE" : mode == AlphaMode::mask ? "MASK" : "BLEND";
}

// What accessors say of their numbers.
struct NumberFormat {
  int target, component_type, type;
};
constexpr NumberFormat positions_format{TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                        TINYGLTF_TYPE_VEC3};
constexpr NumberFormat colours_format{TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC4};
constexpr NumberFormat coordinates_format{TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                                          TINYGLTF_TYPE_VEC2};
constexpr NumberFormat indices_format{TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
                                      TINYGLTF_TYPE_SCALAR};

class Writer {
 public:
  Writer(const Scene& scene, std::span<const ObjectOrder> orders) : scene_(scene), orders_(orders) {}

  tinygltf::Model model();

 private:
  int add_view(const void* bytes, std::size_t count, int target);
  template <typename T>
  int add_accessor(const std::vector<T>& values, const NumberFormat& format, std::size_t count);
  void add_textures();
  void add_materials();
  const tinygltf::Primitive& vertices_of(std::uint32_t mesh);
  int mesh_for(std::uint32_t object);
  void add_object(std::uint32_t object);
  void add_camera(const SceneCamera& camera);

  const Scene& scene_;
  const std::span<const ObjectOrder> orders_;
  tinygltf::Model model_;
  std::map<std::uint32_t, tinygltf::Primitive> vertices_;  // of each mesh, without indices
  std::map<std::uint32_t, int> shared_meshes_;             // of glTF, for a mesh in its own order
};

int Writer::add_view(const void* bytes, std::size_t count, int target) {
  std::vector<unsigned char>& data = model_.buffers.front().data;
  constexpr std::size_t alignment = 4, most = std::numeric_limits<std::uint32_t>::max() / 2;
  data.resize((data.size() + alignment - 1) / alignment * alignment);
  if (count > most - data.size()) throw SceneError{Fault::too_many_facets, "glTF has no room for so many facets"};
  tinygltf::BufferView view;
  view.buffer = 0;
  view.byteOffset = data.size();
  view.byteLength = count;
  view.target = target;
  data.resize(data.size() + count);
  std::memcpy(data.data() + view.byteOffset, bytes, count);
  model_.bufferViews.push_back(std::move(view));
  return static_cast<int>(model_.bufferViews.size()) - 1;
}

template <typename T>
int Writer::add_accessor(const std::vector<T>& values, const NumberFormat& format, std::size_t count) {
  tinygltf::Accessor accessor;
  accessor.bufferView = add_view(values.data(), values.size() * sizeof(T), format.target);
  accessor.componentType = format.component_type;
  accessor.type = format.type;
  accessor.count = count;
  model_.accessors.push_back(std::move(accessor));
  return static_cast<int>(model_.accessors.size()) - 1;
}

void Writer::add_textures() {
  for (std::size_t i = 0; i < scene_.textures.size(); ++i) {
    const Texture& from = scene_.textures[i];
    const std::vector<unsigned char> file = encode_picture(from);
    if (file.empty()) throw SceneError{Fault::cannot_write, "texture " + std::to_string(i) + " makes no PNG"};
    tinygltf::Image image;
    image.bufferView = add_view(file.data(), file.size(), 0);
    image.mimeType = "image/png";
    tinygltf::Sampler sampler;
    sampler.magFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.minFilter = TINYGLTF_TEXTURE_FILTER_LINEAR;
    sampler.wrapS = wrap_mode(from.wrap_u);
    sampler.wrapT = wrap_mode(from.wrap_v);
    tinygltf::Texture texture;
    texture.source = static_cast<int>(i);
    texture.sampler = static_cast<int>(i);
    model_.images.push_back(std::move(image));
    model_.samplers.push_back(std::move(sampler));
    model_.textures.push_back(std::move(texture));
  }
}

void Writer::add_materials() {
  for (const SceneMaterial& from : scene_.materials) {
    tinygltf::Material& to = model_.materials.emplace_back();
    const Material& material = from.material;
    to.name = from.name;
    to.alphaMode = alpha_mode(material.alpha_mode);
    to.alphaCutoff = static_cast<double>(material.alpha_cutoff);
    to.doubleSided = material.double_sided;
    for (int c = 0; c < 4; ++c) {
      to.pbrMetallicRoughness.baseColorFactor[static_cast<std::size_t>(c)] =
          static_cast<double>(material.base_colour[c]);
    }
    to.pbrMetallicRoughness.metallicFactor = 0;
    if (material.texture != Material::no_texture) {
      to.pbrMetallicRoughness.baseColorTexture.index = static_cast<int>(material.texture);
    }
    if (!from.transmissive) continue;
    tinygltf::Value::Object transmission;
    transmission["transmissionFactor"] = tinygltf::Value(1.0);
    to.extensions["KHR_materials_transmission"] = tinygltf::Value(std::move(transmission));
    if (model_.extensionsUsed.empty()) model_.extensionsUsed.emplace_back("KHR_materials_transmission");
  }
}

// glTF's colours belong to vertices: where facets have some, each gets vertices of its own.
struct Vertices {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec4> colours;
  std::vector<glm::vec2> coordinates;
};

Vertices vertices_as_they_are(const SceneMesh& mesh) {
  Vertices vertices{std::vector<glm::vec3>(mesh.positions.size(), glm::vec3(0)), mesh.vertex_colours,
                    std::vector<glm::vec2>(mesh.texture_coordinates.size(), glm::vec2(0))};
  for (const glm::uvec3& triangle : mesh.triangles) {  // what no facet uses may not be a number
    for (int i = 0; i < 3; ++i) {
      vertices.positions[triangle[i]] = mesh.positions[triangle[i]];
      if (!vertices.coordinates.empty()) vertices.coordinates[triangle[i]] = mesh.texture_coordinates[triangle[i]];
    }
  }
  return vertices;
}

Vertices vertices_of_facets(const SceneMesh& mesh) {
  Vertices vertices;
  for (std::size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t v = mesh.triangles[f][i];
      vertices.positions.push_back(mesh.positions[v]);
      vertices.colours.push_back(mesh.facet_colours[f]);
      if (!mesh.texture_coordinates.empty()) vertices.coordinates.push_back(mesh.texture_coordinates[v]);
    }
  }
  return vertices;
}

const tinygltf::Primitive& Writer::vertices_of(std::uint32_t mesh) {
  const auto [entry, is_new] = vertices_.try_emplace(mesh);
  if (!is_new) return entry->second;
  const SceneMesh& from = scene_.meshes[mesh];
  const Vertices vertices = from.facet_colours.empty() ? vertices_as_they_are(from) : vertices_of_facets(from);
  tinygltf::Primitive& primitive = entry->second;
  primitive.mode = TINYGLTF_MODE_TRIANGLES;
  primitive.material = static_cast<int>(from.material);
  primitive.attributes["POSITION"] = add_accessor(vertices.positions, positions_format, vertices.positions.size());
  glm::vec3 lowest = vertices.positions.front(), highest = lowest;
  for (const glm::vec3& position : vertices.positions) {
    lowest = glm::min(lowest, position);
    highest = glm::max(highest, position);
  }
  for (int axis = 0; axis < 3; ++axis) {
    model_.accessors.back().minValues.push_back(static_cast<double>(lowest[axis]));
    model_.accessors.back().maxValues.push_back(static_cast<double>(highest[axis]));
  }
  if (!vertices.colours.empty()) {
    primitive.attributes["COLOR_0"] = add_accessor(vertices.colours, colours_format, vertices.colours.size());
  }
  if (!vertices.coordinates.empty()) {
    primitive.attributes["TEXCOORD_0"] =
        add_accessor(vertices.coordinates, coordinates_format, vertices.coordinates.size());
  }
  return primitive;
}

// The mesh that an object's node shows, made where no object before has the same.
int Writer::mesh_for(std::uint32_t object) {
  const std::uint32_t mesh = scene_.objects[object].mesh;
  const SceneMesh& from = scene_.meshes[mesh];
  const ObjectOrder* order = orders_.empty() || orders_[object].empty() ? nullptr : &orders_[object];
  if (order == nullptr) {
    if (const auto found = shared_meshes_.find(mesh); found != shared_meshes_.end()) return found->second;
  }
  const std::size_t facets = order == nullptr ? from.triangles.size() : order->size();
  std::vector<std::uint32_t> indices;
  indices.reserve(3 * facets);
  for (std::size_t k = 0; k < facets; ++k) {
    const std::uint32_t facet = order == nullptr ? static_cast<std::uint32_t>(k) : (*order)[k];
    if (facet >= from.triangles.size()) {
      throw SceneError{Fault::bad_argument, "the order of object " + std::to_string(object) + " names facet " +
                                                std::to_string(facet) + " of " + std::to_string(from.triangles.size())};
    }
    for (int i = 0; i < 3; ++i) {
      indices.push_back(from.facet_colours.empty() ? from.triangles[facet][i]
                                                   : 3 * facet + static_cast<std::uint32_t>(i));
    }
  }
  tinygltf::Primitive primitive = vertices_of(mesh);
  primitive.indices = add_accessor(indices, indices_format, indices.size());
  const int number = static_cast<int>(model_.meshes.size());
  tinygltf::Mesh& to = model_.meshes.emplace_back();
  to.name = from.name;
  to.primitives.push_back(std::move(primitive));
  if (order == nullptr) shared_meshes_[mesh] = number;
  return number;
}

void Writer::add_object(std::uint32_t object) {
  tinygltf::Node node;
  node.name = scene_.objects[object].name;
  node.mesh = mesh_for(object);
  const glm::dmat4& world = scene_.objects[object].world;
  if (world != glm::dmat4(1)) {
    for (int i = 0; i < 16; ++i) node.matrix.push_back(world[i / 4][i % 4]);
  }
  node.extras = extras_of(scene_.objects[object].settings);
  model_.nodes.push_back(std::move(node));
}

void Writer::add_camera(const SceneCamera& camera) {
  tinygltf::Camera to;
  to.name = camera.name;
  to.type = camera.perspective ? "perspective" : "orthographic";
  if (camera.perspective) {
    to.perspective.yfov = camera.vertical_fov_degrees * radians_per_degree;
    to.perspective.znear = camera.near_distance;
  } else {
    to.orthographic.xmag = to.orthographic.ymag = 0.5 * camera.height_in_units;
    to.orthographic.znear = camera.near_distance;
    to.orthographic.zfar = camera.near_distance + 2 * glm::length(camera.at - camera.eye);
  }
  tinygltf::Node node;
  node.name = camera.name;
  node.camera = static_cast<int>(model_.cameras.size());
  const glm::dvec3 back = camera.eye - camera.at;
  const glm::dvec3 columns[4] = {glm::cross(camera.up, back), camera.up, back, camera.eye};
  for (int i = 0; i < 16; ++i) node.matrix.push_back(i % 4 < 3 ? columns[i / 4][i % 4] : i == 15 ? 1.0 : 0.0);
  model_.cameras.push_back(std::move(to));
  model_.nodes.push_back(std::move(node));
}

tinygltf::Model Writer::model() {
  model_.asset.version = "2.0";
  model_.asset.generator = "facetsort";
  model_.buffers.emplace_back();
  add_textures();
  add_materials();
  for (std::uint32_t object = 0; object < scene_.objects.size(); ++object) add_object(object);
  for (const SceneCamera& camera : scene_.cameras) add_camera(camera);
  tinygltf::Scene& nodes = model_.scenes.emplace_back();
  for (std::size_t i = 0; i < model_.nodes.size(); ++i) nodes.nodes.push_back(static_cast<int>(i));
  nodes.extras = extras_of(scene_.panda3d_bins);
  model_.defaultScene = 0;
  return std::move(model_);
}

bool is_text(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".gltf";
}

}  // namespace

std::vector<ObjectOrder> object_orders(const Scene& scene, const MergedMesh& merged,
                                       std::span<const std::uint32_t> facets) {
  std::vector<std::uint32_t> last_place(merged.mesh.triangles.size(), none);
  for (std::size_t k = 0; k < facets.size(); ++k) last_place[facets[k]] = static_cast<std::uint32_t>(k);
  std::vector<ObjectOrder> orders(scene.objects.size());
  for (std::size_t k = 0; k < facets.size(); ++k) {
    const std::uint32_t facet = facets[k];
    if (last_place[facet] != k) continue;
    orders[merged.objects[merged.facet_objects[facet]].object].push_back(merged.facet_in_object(facet));
  }
  return orders;
}

Status write_scene(const std::filesystem::path& path, const Scene& scene, std::span<const ObjectOrder> orders) {
  const auto fault = [&](Fault what, const std::string& message) {
    return Status{what, path.string() + ": " + message};
  };
  if (scene.objects.empty()) return fault(Fault::empty_mesh, "a scene without objects");
  if (!orders.empty() && orders.size() != scene.objects.size()) {
    return fault(Fault::bad_argument,
                 std::to_string(orders.size()) + " orders for " + std::to_string(scene.objects.size()) + " objects");
  }
  try {
    const tinygltf::Model model = Writer(scene, orders).model();
    std::ostringstream text;
    if (!tinygltf::TinyGLTF().WriteGltfSceneToStream(&model, text, false, !is_text(path))) {
      return fault(Fault::cannot_write, "cannot be written as glTF");
    }
    NewFile file(path);
    const std::string_view content = text.view();
    file.write(std::as_bytes(std::span(content)));
    return file.finish();
  } catch (const SceneError& error) {
    return fault(error.fault, error.message);
  } catch (const std::bad_alloc&) {
    return fault(Fault::out_of_memory, "not enough memory to write it");
  }
}

}  // namespace facetsort
