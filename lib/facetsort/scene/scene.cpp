#include "facetsort/scene/scene.h"

#include <cmath>
#include <cstddef>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>

#include "facetsort/mesh/inspect.h"

namespace facetsort {
namespace {

std::string part(const char* kind, std::size_t index) {
  return std::string(kind) + " " + std::to_string(index);
}

Status validate(const SceneMesh& mesh, std::size_t index, std::size_t materials) {
  Status status = facetsort::validate(MeshView{.positions = mesh.positions,
                                               .triangles = mesh.triangles,
                                               .facet_colours = mesh.facet_colours,
                                               .vertex_colours = mesh.vertex_colours});
  if (!status.ok()) return {status.fault, part("mesh", index) + ": " + status.message};
  if (mesh.material >= materials) {
    return {Fault::index_out_of_range, part("mesh", index) + " names material " + std::to_string(mesh.material) +
                                           " of " + std::to_string(materials)};
  }
  if (mesh.texture_coordinates.empty()) return {};
  if (mesh.texture_coordinates.size() != mesh.positions.size()) {
    return {Fault::size_mismatch, part("mesh", index) + " has " + std::to_string(mesh.texture_coordinates.size()) +
                                      " texture coordinates for " + std::to_string(mesh.positions.size()) +
                                      " vertices"};
  }
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::vec2& at = mesh.texture_coordinates[triangle[i]];
      if (!std::isfinite(at.x) || !std::isfinite(at.y)) {
        return {Fault::non_finite_position, part("mesh", index) + ": the texture coordinates of vertex " +
                                                std::to_string(triangle[i]) + " are not finite"};
      }
    }
  }
  return {};
}

Status validate(const SceneObject& object, std::size_t index, std::size_t meshes) {
  if (object.mesh >= meshes) {
    return {Fault::index_out_of_range,
            part("object", index) + " names mesh " + std::to_string(object.mesh) + " of " + std::to_string(meshes)};
  }
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) {
      const double value = object.world[column][row];
      const double expected = column == 3 ? 1 : 0;  // of the last row
      if (std::isfinite(value) && (row < 3 || value == expected)) continue;
      return {Fault::bad_argument, part("object", index) + " has a place that is not finite or not affine"};
    }
  }
  const EngineSettings& settings = object.settings;
  for (const double number : {settings.galacean.priority, settings.babylon.alpha_index, settings.three.group_order,
                              settings.three.render_order}) {
    if (!std::isfinite(number))
      return {Fault::bad_argument, part("object", index) + " has a setting that is not finite"};
  }
  if (settings.babylon.rendering_group_id >= EngineSettings::most_rendering_groups) {
    return {Fault::bad_argument, part("object", index) + " is in rendering group " +
                                     std::to_string(settings.babylon.rendering_group_id) + " of " +
                                     std::to_string(EngineSettings::most_rendering_groups)};
  }
  return {};
}

// Bins are there once, and those that objects name are there.
Status validate_bins(const Scene& scene) {
  std::set<std::string_view> names;
  const std::vector<Panda3DBin> own = panda3d_default_bins();
  for (const Panda3DBin& bin : own) names.insert(bin.name);
  for (const Panda3DBin& bin : scene.panda3d_bins) {
    if (!names.insert(bin.name).second) return {Fault::bad_argument, "two bins are called '" + bin.name + "'"};
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const std::optional<std::string>& bin = scene.objects[i].settings.panda3d.bin;
    if (bin && !names.contains(*bin)) {
      return {Fault::bad_argument, part("object", i) + ": no bin is called '" + *bin + "'"};
    }
  }
  return {};
}

}  // namespace

Status validate(const Scene& scene) {
  if (Status status = facetsort::validate(std::span(scene.textures)); !status.ok()) return status;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    if (!is_colour(scene.materials[i].material.base_colour)) return not_a_colour(part("material", i));
    const std::uint32_t texture = scene.materials[i].material.texture;
    if (texture == Material::no_texture || texture < scene.textures.size()) continue;
    return {Fault::index_out_of_range, part("material", i) + " names texture " + std::to_string(texture) + " of " +
                                           std::to_string(scene.textures.size())};
  }
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    if (Status status = validate(scene.meshes[i], i, scene.materials.size()); !status.ok()) return status;
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (Status status = validate(scene.objects[i], i, scene.meshes.size()); !status.ok()) return status;
  }
  return validate_bins(scene);
}

std::vector<std::uint32_t> blended_objects(const Scene& scene) {
  std::vector<std::uint32_t> objects;
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.material_of(i).material.alpha_mode == AlphaMode::blend) objects.push_back(i);
  }
  return objects;
}

std::vector<std::uint32_t> blended_first(const Scene& scene) {
  std::vector<std::uint32_t> objects = blended_objects(scene);
  for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.material_of(i).material.alpha_mode != AlphaMode::blend) objects.push_back(i);
  }
  return objects;
}

}  // namespace facetsort
