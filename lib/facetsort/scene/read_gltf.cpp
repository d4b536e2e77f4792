// glTF 2.0 specification, Khronos 2021.
#include "facetsort/scene/read_gltf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "facetsort/scene/gltf_accessor.h"
#include "facetsort/scene/gltf_file.h"
#include "facetsort/scene/gltf_nodes.h"
#include "facetsort/scene/gltf_picture.h"
#include "facetsort/scene/gltf_settings.h"

namespace facetsort::scene_internal {
namespace {

// What a scene may need and still be read here: what they say is heard, or changes neither shape nor alpha.
constexpr std::array<std::string_view, 16> known_extensions{"KHR_lights_punctual",
                                                            "KHR_materials_anisotropy",
                                                            "KHR_materials_clearcoat",
                                                            "KHR_materials_dispersion",
                                                            "KHR_materials_emissive_strength",
                                                            "KHR_materials_ior",
                                                            "KHR_materials_iridescence",
                                                            "KHR_materials_sheen",
                                                            "KHR_materials_specular",
                                                            "KHR_materials_transmission",
                                                            "KHR_materials_unlit",
                                                            "KHR_materials_variants",
                                                            "KHR_materials_volume",
                                                            "KHR_mesh_quantization",
                                                            "KHR_texture_transform",
                                                            "KHR_xmp_json_ld"};

// Vertices may be shared by any number of primitives, of which each gets its own.
constexpr std::size_t most_elements = std::size_t{1} << 28;

std::string numbered(const char* kind, std::size_t index) {
  return std::string(kind) + " " + std::to_string(index);
}

float finite(double value, const std::string& place) {
  const auto as_float = static_cast<float>(value);
  if (!std::isfinite(as_float)) throw SceneError{Fault::malformed, place + ": a number that is not finite in float"};
  return as_float;
}

// Value of a number in an extension's object.
std::optional<double> number_in(const tinygltf::Value& object, const std::string& key) {
  if (!object.IsObject() || !object.Has(key) || !object.Get(key).IsNumber()) return std::nullopt;
  return object.Get(key).GetNumberAsDouble();
}

glm::dvec2 pair_in(const tinygltf::Value& object, const std::string& key, const glm::dvec2& missing) {
  if (!object.IsObject() || !object.Has(key)) return missing;
  const tinygltf::Value& list = object.Get(key);
  if (!list.IsArray() || list.ArrayLen() != 2 || !list.Get(0).IsNumber() || !list.Get(1).IsNumber()) return missing;
  return {list.Get(0).GetNumberAsDouble(), list.Get(1).GetNumberAsDouble()};
}

// Which texture coordinates the base colour takes, and what becomes of them (KHR_texture_transform).
struct TextureUse {
  std::string attribute;
  glm::dvec2 column_u{1, 0}, column_v{0, 1}, offset{0};

  glm::dvec2 transformed(const glm::dvec2& at) const { return column_u * at.x + column_v * at.y + offset; }
};

class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : model_(read_gltf_model(path)) {}

  Scene read();

 private:
  void refuse_unknown_extensions() const;
  void read_materials();
  std::uint32_t read_texture(int index, const std::string& place);
  TextureUse texture_use(const tinygltf::TextureInfo& info, const std::string& place) const;
  std::uint32_t material_of(const tinygltf::Primitive& primitive, const std::string& place);
  // The scene's meshes of a glTF mesh, one for each primitive that has facets.
  const std::vector<std::uint32_t>& meshes_of(int mesh, const std::string& place);
  std::optional<SceneMesh> read_primitive(const tinygltf::Primitive& primitive, const std::string& place);
  std::vector<std::uint32_t> read_corners(const tinygltf::Primitive& primitive, std::size_t vertices,
                                          const std::string& place) const;
  void read_attributes(const tinygltf::Primitive& primitive, std::span<const std::uint32_t> vertices,
                       const Accessor& positions, SceneMesh& mesh, const std::string& place) const;
  std::optional<Accessor> attribute(const tinygltf::Primitive& primitive, const std::string& name, std::size_t vertices,
                                    const std::string& place) const;
  void add_notes();

  const tinygltf::Model model_;
  Scene scene_;
  std::map<int, std::uint32_t> texture_numbers_;         // of the scene, by that of glTF
  std::vector<std::optional<TextureUse>> texture_uses_;  // of each material
  std::optional<std::uint32_t> default_material_;
  std::map<int, std::vector<std::uint32_t>> mesh_numbers_;
  std::size_t elements_ = 0, without_facets_ = 0, skinned_ = 0, morphed_ = 0, set_aside_ = 0;
};

void Reader::refuse_unknown_extensions() const {
  for (const std::string& extension : model_.extensionsRequired) {
    if (std::find(known_extensions.begin(), known_extensions.end(), extension) != known_extensions.end()) continue;
    throw SceneError{Fault::unsupported_format, "it requires the extension " + extension + ", which is not read here"};
  }
}

std::uint32_t Reader::read_texture(int index, const std::string& place) {
  if (static_cast<std::size_t>(index) >= model_.textures.size()) {
    throw SceneError{Fault::index_out_of_range, place + " names texture " + std::to_string(index) + " of " +
                                                    std::to_string(model_.textures.size())};
  }
  const auto [entry, is_new] = texture_numbers_.try_emplace(index, static_cast<std::uint32_t>(scene_.textures.size()));
  if (!is_new) return entry->second;
  const tinygltf::Texture& from = model_.textures[static_cast<std::size_t>(index)];
  const std::string here = numbered("texture", static_cast<std::size_t>(index));
  Texture& texture = scene_.textures.emplace_back();
  decode_picture(model_, from.source, here, texture);
  if (from.sampler < 0) return entry->second;
  if (static_cast<std::size_t>(from.sampler) >= model_.samplers.size()) {
    throw SceneError{Fault::index_out_of_range, here + " names sampler " + std::to_string(from.sampler) + " of " +
                                                    std::to_string(model_.samplers.size())};
  }
  const auto wrap = [&](int mode) {
    switch (mode) {
      case TINYGLTF_TEXTURE_WRAP_REPEAT:
        return Wrap::repeat;
      case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
        return Wrap::mirrored_repeat;
      case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
        return Wrap::clamp_to_edge;
      default:
        throw SceneError{Fault::malformed, numbered("sampler", static_cast<std::size_t>(from.sampler)) +
                                               ": no wrap mode is " + std::to_string(mode)};
    }
  };
  const tinygltf::Sampler& sampler = model_.samplers[static_cast<std::size_t>(from.sampler)];
  texture.wrap_u = wrap(sampler.wrapS);
  texture.wrap_v = wrap(sampler.wrapT);
  return entry->second;
}

TextureUse Reader::texture_use(const tinygltf::TextureInfo& info, const std::string& place) const {
  int set = info.texCoord;
  TextureUse use;
  if (const auto found = info.extensions.find("KHR_texture_transform"); found != info.extensions.end()) {
    const tinygltf::Value& transform = found->second;
    const double angle = number_in(transform, "rotation").value_or(0), c = std::cos(angle), s = std::sin(angle);
    const glm::dvec2 scale = pair_in(transform, "scale", glm::dvec2(1));
    use.column_u = glm::dvec2(c, -s) * scale.x;
    use.column_v = glm::dvec2(s, c) * scale.y;
    use.offset = pair_in(transform, "offset", glm::dvec2(0));
    if (const std::optional<double> other = number_in(transform, "texCoord")) {
      set = *other >= 0 && *other < 1000 ? static_cast<int>(*other) : -1;
    }
  }
  if (set < 0) throw SceneError{Fault::malformed, place + ": no texture coordinates have such a number"};
  use.attribute = "TEXCOORD_" + std::to_string(set);
  return use;
}

void Reader::read_materials() {
  for (std::size_t i = 0; i < model_.materials.size(); ++i) {
    const tinygltf::Material& from = model_.materials[i];
    const std::string here = numbered("material", i);
    SceneMaterial& to = scene_.materials.emplace_back();
    to.name = from.name;
    const std::vector<double>& colour = from.pbrMetallicRoughness.baseColorFactor;
    if (colour.size() != 4) throw SceneError{Fault::malformed, here + ": a base colour that has not four numbers"};
    for (int c = 0; c < 4; ++c) to.material.base_colour[c] = finite(colour[static_cast<std::size_t>(c)], here);
    if (from.alphaMode == "OPAQUE") {
      to.material.alpha_mode = AlphaMode::opaque;
    } else if (from.alphaMode == "MASK") {
      to.material.alpha_mode = AlphaMode::mask;
    } else if (from.alphaMode == "BLEND") {
      to.material.alpha_mode = AlphaMode::blend;
    } else {
      throw SceneError{Fault::malformed, here + ": no alpha mode is '" + from.alphaMode.substr(0, 32) + "'"};
    }
    to.material.alpha_cutoff = finite(from.alphaCutoff, here);
    to.material.double_sided = from.doubleSided;
    if (const auto found = from.extensions.find("KHR_materials_transmission"); found != from.extensions.end()) {
      to.transmissive = number_in(found->second, "transmissionFactor").value_or(0) > 0;
    }
    std::optional<TextureUse>& use = texture_uses_.emplace_back();
    if (const tinygltf::TextureInfo& info = from.pbrMetallicRoughness.baseColorTexture; info.index >= 0) {
      to.material.texture = read_texture(info.index, here);
      use = texture_use(info, here);
    }
  }
}

// Primitives without a material have glTF's default one.
std::uint32_t Reader::material_of(const tinygltf::Primitive& primitive, const std::string& place) {
  if (primitive.material >= 0) {
    if (static_cast<std::size_t>(primitive.material) < model_.materials.size()) {
      return static_cast<std::uint32_t>(primitive.material);
    }
    throw SceneError{Fault::index_out_of_range, place + " names material " + std::to_string(primitive.material) +
                                                    " of " + std::to_string(model_.materials.size())};
  }
  if (!default_material_) {
    default_material_ = static_cast<std::uint32_t>(scene_.materials.size());
    scene_.materials.push_back(
        {.name = "default", .material = {.alpha_mode = AlphaMode::opaque, .double_sided = false}});
    texture_uses_.emplace_back();
  }
  return *default_material_;
}

std::optional<Accessor> Reader::attribute(const tinygltf::Primitive& primitive, const std::string& name,
                                          std::size_t vertices, const std::string& place) const {
  const auto found = primitive.attributes.find(name);
  if (found == primitive.attributes.end()) return std::nullopt;
  Accessor accessor(model_, found->second, place + " " + name);
  if (accessor.count() != vertices) {
    throw SceneError{Fault::size_mismatch, place + ": " + std::to_string(accessor.count()) + " of " + name + " for " +
                                               std::to_string(vertices) + " vertices"};
  }
  return accessor;
}

// Corners of triangles, three each: strips and fans taken apart.
std::vector<std::uint32_t> Reader::read_corners(const tinygltf::Primitive& primitive, std::size_t vertices,
                                                const std::string& place) const {
  std::optional<Accessor> indices;
  if (primitive.indices >= 0) {
    indices.emplace(model_, primitive.indices, place + " indices");
    if (!indices->has_indices()) throw SceneError{Fault::malformed, place + ": indices that are no plain integers"};
  }
  const std::size_t count = indices ? indices->count() : vertices;
  const auto vertex = [&](std::size_t i) {
    const std::uint32_t v = indices ? indices->index(i) : static_cast<std::uint32_t>(i);
    if (v < vertices) return v;
    throw SceneError{Fault::index_out_of_range, place + ": index " + std::to_string(i) + " names vertex " +
                                                    std::to_string(v) + " of " + std::to_string(vertices)};
  };
  const bool is_list = primitive.mode == TINYGLTF_MODE_TRIANGLES;
  if (is_list && count % 3 != 0) {
    throw SceneError{Fault::malformed, place + ": " + std::to_string(count) + " corners, no whole number of triangles"};
  }
  const std::size_t triangles = is_list ? count / 3 : count < 3 ? 0 : count - 2;
  if (triangles > most_elements) throw SceneError{Fault::too_many_facets, place + ": too many facets"};
  std::vector<std::uint32_t> corners;
  corners.reserve(3 * triangles);
  for (std::size_t t = 0; t < triangles; ++t) {
    if (is_list) {
      for (std::size_t i = 0; i < 3; ++i) corners.push_back(vertex(3 * t + i));
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      for (const std::size_t i : {t, t + 1 + t % 2, t + 2 - t % 2}) corners.push_back(vertex(i));
    } else {
      for (const std::size_t i : {t + 1, t + 2, std::size_t{0}}) corners.push_back(vertex(i));
    }
  }
  return corners;
}

void Reader::read_attributes(const tinygltf::Primitive& primitive, std::span<const std::uint32_t> vertices,
                             const Accessor& positions, SceneMesh& mesh, const std::string& place) const {
  for (const std::uint32_t v : vertices) {
    glm::vec3& position = mesh.positions.emplace_back();
    for (int axis = 0; axis < 3; ++axis) position[axis] = static_cast<float>(positions.number(v, axis));
  }
  if (const auto colours = attribute(primitive, "COLOR_0", positions.count(), place)) {
    const int components = colours->components();
    const std::string here = place + " COLOR_0";
    if (components < 3) throw SceneError{Fault::malformed, place + ": colours that have not three numbers or four"};
    for (const std::uint32_t v : vertices) {
      glm::vec4& colour = mesh.vertex_colours.emplace_back(1);
      for (int c = 0; c < components; ++c) colour[c] = finite(colours->number(v, c), here);
    }
  }
  const std::optional<TextureUse>& use = texture_uses_[mesh.material];
  if (!use) return;
  if (const auto coordinates = attribute(primitive, use->attribute, positions.count(), place)) {
    if (coordinates->components() != 2) {
      throw SceneError{Fault::malformed, place + ": texture coordinates that are no pairs"};
    }
    for (const std::uint32_t v : vertices) {
      const glm::dvec2 at = use->transformed({coordinates->number(v, 0), coordinates->number(v, 1)});
      mesh.texture_coordinates.emplace_back(finite(at.x, place), finite(at.y, place));
    }
  }
}

std::optional<SceneMesh> Reader::read_primitive(const tinygltf::Primitive& primitive, const std::string& place) {
  const bool has_facets = primitive.mode == TINYGLTF_MODE_TRIANGLES || primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP ||
                          primitive.mode == TINYGLTF_MODE_TRIANGLE_FAN;
  const auto found = primitive.attributes.find("POSITION");
  if (!has_facets || found == primitive.attributes.end()) return std::nullopt;
  const Accessor positions(model_, found->second, place + " POSITION");
  if (positions.components() != 3)
    throw SceneError{Fault::malformed, place + ": positions that have not three numbers"};
  std::vector<std::uint32_t> corners = read_corners(primitive, positions.count(), place);
  if (corners.empty()) return std::nullopt;

  // Where many primitives share one list of vertices, each takes those that it uses; else all, so that a vertex's
  // number is the file's.
  constexpr std::size_t shared_by = 4;
  std::vector<std::uint32_t> vertices;
  if (positions.count() > shared_by * corners.size()) {
    vertices = corners;
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (std::uint32_t& corner : corners) {
      corner =
          static_cast<std::uint32_t>(std::lower_bound(vertices.begin(), vertices.end(), corner) - vertices.begin());
    }
  } else {
    for (std::uint32_t v = 0; v < positions.count(); ++v) vertices.push_back(v);
  }
  elements_ += vertices.size() + corners.size() / 3;
  if (elements_ > most_elements) {
    throw SceneError{Fault::too_many_facets,
                     place + ": more than " + std::to_string(most_elements) + " facets and vertices in all"};
  }
  SceneMesh mesh;
  mesh.material = material_of(primitive, place);
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    mesh.triangles.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
  }
  read_attributes(primitive, vertices, positions, mesh, place);
  return mesh;
}

const std::vector<std::uint32_t>& Reader::meshes_of(int mesh, const std::string& place) {
  if (static_cast<std::size_t>(mesh) >= model_.meshes.size()) {
    throw SceneError{Fault::index_out_of_range,
                     place + " names mesh " + std::to_string(mesh) + " of " + std::to_string(model_.meshes.size())};
  }
  const auto [entry, is_new] = mesh_numbers_.try_emplace(mesh);
  if (!is_new) return entry->second;
  const tinygltf::Mesh& from = model_.meshes[static_cast<std::size_t>(mesh)];
  const std::string here = numbered("mesh", static_cast<std::size_t>(mesh));
  for (std::size_t i = 0; i < from.primitives.size(); ++i) {
    std::optional<SceneMesh> read = read_primitive(from.primitives[i], here + ", " + numbered("primitive", i));
    if (!read) {
      ++without_facets_;
      continue;
    }
    morphed_ += !from.primitives[i].targets.empty();
    read->name = from.primitives.size() == 1 ? from.name : from.name + "." + std::to_string(i);
    entry->second.push_back(static_cast<std::uint32_t>(scene_.meshes.size()));
    scene_.meshes.push_back(std::move(*read));
  }
  return entry->second;
}

void Reader::add_notes() {
  const auto note = [&](std::size_t count, const char* what) {
    if (count > 0) scene_.notes.push_back(std::to_string(count) + " " + what);
  };
  note(without_facets_, "primitives without facets (points, lines) are left out");
  note(skinned_, "skinned nodes are shown as they are at rest");
  note(morphed_, "primitives with morph targets are shown as they are at rest");
  note(set_aside_, "nodes without a mesh have engines' settings, which those below them do not inherit");
}

Scene Reader::read() {
  refuse_unknown_extensions();
  read_materials();
  for (const PlacedNode& placed : placed_nodes(model_)) {
    const tinygltf::Node& node = model_.nodes[placed.node];
    const std::string here = numbered("node", placed.node);
    if (node.camera >= 0) scene_.cameras.push_back(read_camera(model_, node, placed.world, here));
    const EngineSettings settings = read_settings(node.extras_json_string, here);
    if (node.mesh < 0) {
      set_aside_ += settings != EngineSettings{};
      continue;
    }
    skinned_ += node.skin >= 0;
    for (const std::uint32_t mesh : meshes_of(node.mesh, here)) {
      scene_.objects.push_back({.name = node.name, .mesh = mesh, .world = placed.world, .settings = settings});
    }
  }
  if (!model_.scenes.empty()) {
    const std::size_t shown = shown_scene(model_);
    scene_.panda3d_bins = read_bins(model_.scenes[shown].extras_json_string, numbered("scene", shown));
  }
  if (scene_.objects.empty()) throw SceneError{Fault::empty_mesh, "no node shows a facet"};
  add_notes();
  return std::move(scene_);
}

}  // namespace

Scene read_gltf(const std::filesystem::path& path) {
  return Reader(path).read();
}

}  // namespace facetsort::scene_internal
