#include "facetsort/scene/read_scene.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "facetsort/mesh/read.h"
#include "facetsort/scene/gltf_file.h"
#include "facetsort/scene/read_gltf.h"

namespace facetsort {
namespace {

constexpr float alpha_without_colours = 0.5f;

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_gltf(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".gltf" || extension == ".glb";
}

bool is_scene_file(const std::filesystem::path& path) {
  constexpr std::array<std::string_view, 4> mesh_extensions{".ply", ".obj", ".off", ".stl"};
  return is_gltf(path) ||
         std::find(mesh_extensions.begin(), mesh_extensions.end(), extension_of(path)) != mesh_extensions.end();
}

Scene scene_of(Mesh mesh, const std::string& name) {
  const bool has_colours = !mesh.facet_colours.empty() || !mesh.vertex_colours.empty();
  Scene scene;
  scene.materials.push_back({.name = name});
  if (!has_colours) scene.materials.back().material.base_colour.a = alpha_without_colours;
  scene.meshes.push_back({.name = name,
                          .positions = std::move(mesh.positions),
                          .triangles = std::move(mesh.triangles),
                          .facet_colours = std::move(mesh.facet_colours),
                          .vertex_colours = std::move(mesh.vertex_colours)});
  scene.objects.push_back({.name = name});
  return scene;
}

Status with_file(const std::filesystem::path& path, Fault fault, const std::string& message) {
  // What opening the file says names it already.
  const bool is_named = message.starts_with(path.string());
  return {fault, is_named ? message : path.string() + ": " + message};
}

Result<Scene> read_file(const std::filesystem::path& path) {
  try {
    if (!is_gltf(path)) {
      Result<Mesh> mesh = read_mesh(path);
      if (!mesh.ok()) return mesh.status();
      return scene_of(std::move(mesh).value(), path.filename().string());
    }
    Scene scene = scene_internal::read_gltf(path);
    if (const Status status = validate(scene); !status.ok()) return with_file(path, status.fault, status.message);
    return scene;
  } catch (const scene_internal::SceneError& error) {
    return with_file(path, error.fault, error.message);
  } catch (const std::bad_alloc&) {
    return with_file(path, Fault::out_of_memory, "not enough memory to read it");
  }
}

template <typename T>
void append(std::vector<T>& to, std::vector<T>& from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

// Numbers in `from` go on from those of `to`.
void append(Scene& to, Scene from) {
  const auto meshes = static_cast<std::uint32_t>(to.meshes.size());
  const auto materials = static_cast<std::uint32_t>(to.materials.size());
  const auto textures = static_cast<std::uint32_t>(to.textures.size());
  for (SceneMesh& mesh : from.meshes) mesh.material += materials;
  for (SceneObject& object : from.objects) object.mesh += meshes;
  for (SceneMaterial& material : from.materials) {
    if (material.material.texture != Material::no_texture) material.material.texture += textures;
  }
  append(to.meshes, from.meshes);
  append(to.materials, from.materials);
  append(to.textures, from.textures);
  append(to.objects, from.objects);
  append(to.cameras, from.cameras);
  // The same bin may be told in each file.
  std::erase_if(from.panda3d_bins, [&](const Panda3DBin& bin) {
    return std::find(to.panda3d_bins.begin(), to.panda3d_bins.end(), bin) != to.panda3d_bins.end();
  });
  append(to.panda3d_bins, from.panda3d_bins);
  append(to.notes, from.notes);
}

}  // namespace

Result<Scene> read_scene(std::span<const std::filesystem::path> files) {
  Scene scene;
  for (const std::filesystem::path& file : files) {
    Result<Scene> read = read_file(file);
    if (!read.ok()) return read.status();
    for (const Panda3DBin& bin : read.value().panda3d_bins) {
      const auto other = std::find_if(scene.panda3d_bins.begin(), scene.panda3d_bins.end(),
                                      [&](const Panda3DBin& known) { return known.name == bin.name; });
      if (other != scene.panda3d_bins.end() && *other != bin) {
        return with_file(file, Fault::bad_argument, "the bin '" + bin.name + "' is another in a file before");
      }
    }
    append(scene, std::move(read).value());
  }
  if (scene.objects.empty()) return Status{Fault::empty_mesh, "no file to make a scene of"};
  return scene;
}

Result<Scene> read_scene(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_directory(path, error)) return read_file(path);
  std::vector<std::filesystem::path> files;
  for (std::filesystem::directory_iterator entry(path, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code ignored;
    if (is_scene_file(entry->path()) && !entry->is_directory(ignored)) files.push_back(entry->path());
  }
  if (error) return Status{Fault::cannot_read, path.string() + ": the folder can't be listed: " + error.message()};
  if (files.empty()) return Status{Fault::empty_mesh, path.string() + ": no glTF and no mesh file in this folder"};
  std::sort(files.begin(), files.end());
  return read_scene(files);
}

}  // namespace facetsort
