#include "facetsort/scene/merge.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t vertices_per_task = 16384;
constexpr glm::vec4 white(1);

bool turns_left_into_right(const glm::dmat4& world) {
  return glm::determinant(glm::dmat3(world)) < 0;
}

// Without the products of a full matrix by (x, y, z, 1): the last row is known.
glm::vec3 in_world(const glm::dmat4& world, const glm::vec3& position) {
  const glm::dvec3 p(position);
  return glm::vec3(glm::dvec3(world[0]) * p.x + glm::dvec3(world[1]) * p.y + glm::dvec3(world[2]) * p.z +
                   glm::dvec3(world[3]));
}

bool is_finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// The vertex of the object's own mesh that its i-th vertex in the merged mesh is.
std::uint32_t source_vertex(const MergedObject& object, const SceneMesh& mesh, std::size_t i) {
  if (!object.has_split_corners) return static_cast<std::uint32_t>(i);
  return mesh.triangles[i / 3][static_cast<int>(i % 3)];
}

// Whether float has room for all positions that facets use; what no facet uses may be anything.
bool has_room(const SceneMesh& mesh, std::span<const glm::vec3> positions, const glm::dmat4& world) {
  std::atomic<bool> all_finite{true};
  parallel_ranges(mesh.triangles.size(), vertices_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      for (int i = 0; i < 3; ++i) {
        if (!is_finite(in_world(world, positions[mesh.triangles[f][i]]))) {
          all_finite.store(false, std::memory_order_relaxed);
          return;
        }
      }
    }
  });
  return all_finite;
}

void place_vertices(MergedMesh& merged, const MergedObject& object, const SceneMesh& mesh, const glm::dmat4& world,
                    std::span<const glm::vec3> positions) {
  glm::vec3* to = merged.mesh.positions.data() + object.first_vertex;
  parallel_ranges(object.vertex_count, vertices_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) to[i] = in_world(world, positions[source_vertex(object, mesh, i)]);
  });
}

void place_facets(MergedMesh& merged, const MergedObject& object, const SceneMesh& mesh) {
  for (std::uint32_t f = 0; f < object.facet_count; ++f) {
    glm::uvec3 corners = object.has_split_corners ? glm::uvec3(3 * f, 3 * f + 1, 3 * f + 2) : mesh.triangles[f];
    if (object.is_mirrored) std::swap(corners.y, corners.z);
    merged.mesh.triangles[object.first_facet + f] = corners + object.first_vertex;
  }
}

// Which lists of the merged mesh are needed.
struct Attributes {
  bool facet_colours = false, vertex_colours = false, texture_coordinates = false;
};

Attributes attributes_of(const Scene& scene, std::span<const std::uint32_t> objects) {
  Attributes attributes;
  for (const std::uint32_t object : objects) {
    const SceneMesh& mesh = scene.mesh_of(object);
    attributes.facet_colours |= !mesh.facet_colours.empty();
    attributes.vertex_colours |= mesh.facet_colours.empty() && !mesh.vertex_colours.empty();
    attributes.texture_coordinates |= scene.materials[mesh.material].material.texture != Material::no_texture;
  }
  if (attributes.vertex_colours) attributes.facet_colours = false;
  return attributes;
}

void place_attributes(MergedMesh& merged, const MergedObject& object, const SceneMesh& mesh) {
  Mesh& to = merged.mesh;
  std::fill_n(to.facet_materials.begin() + object.first_facet, object.facet_count, mesh.material);
  if (!to.facet_colours.empty() && !mesh.facet_colours.empty()) {
    std::copy(mesh.facet_colours.begin(), mesh.facet_colours.end(), to.facet_colours.begin() + object.first_facet);
  }
  for (std::size_t i = 0; i < object.vertex_count; ++i) {
    const std::uint32_t from = source_vertex(object, mesh, i);
    if (!to.vertex_colours.empty() && object.has_split_corners) {
      to.vertex_colours[object.first_vertex + i] = mesh.facet_colours[i / 3];
    } else if (!to.vertex_colours.empty() && !mesh.vertex_colours.empty()) {
      to.vertex_colours[object.first_vertex + i] = mesh.vertex_colours[from];
    }
    if (!to.texture_coordinates.empty() && !mesh.texture_coordinates.empty()) {
      to.texture_coordinates[object.first_vertex + i] = mesh.texture_coordinates[from];
    }
  }
}

Status no_room(std::uint32_t object) {
  return {Fault::non_finite_position, "object " + std::to_string(object) + " reaches beyond the numbers of float"};
}

}  // namespace

Result<MergedMesh> merge(const Scene& scene, std::span<const std::uint32_t> objects) {
  constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max() - std::size_t{1};
  const Attributes attributes = attributes_of(scene, objects);
  MergedMesh merged;
  std::size_t facets = 0, vertices = 0;
  for (const std::uint32_t index : objects) {
    const SceneMesh& mesh = scene.mesh_of(index);
    const bool splits = attributes.vertex_colours && !mesh.facet_colours.empty();
    const std::size_t own_vertices = splits ? 3 * mesh.triangles.size() : mesh.positions.size();
    if (facets + mesh.triangles.size() > most || vertices + own_vertices > most) {
      return Status{Fault::too_many_facets,
                    "object " + std::to_string(index) + ": the scene has more facets than ids of 32 bits"};
    }
    merged.objects.push_back({.object = index,
                              .first_facet = static_cast<std::uint32_t>(facets),
                              .facet_count = static_cast<std::uint32_t>(mesh.triangles.size()),
                              .first_vertex = static_cast<std::uint32_t>(vertices),
                              .vertex_count = static_cast<std::uint32_t>(own_vertices),
                              .is_mirrored = turns_left_into_right(scene.objects[index].world),
                              .has_split_corners = splits});
    facets += mesh.triangles.size();
    vertices += own_vertices;
  }

  Mesh& mesh = merged.mesh;
  mesh.positions.resize(vertices);
  mesh.triangles.resize(facets);
  mesh.facet_materials.resize(facets);
  merged.facet_objects.resize(facets);
  if (attributes.facet_colours) mesh.facet_colours.assign(facets, white);
  if (attributes.vertex_colours) mesh.vertex_colours.assign(vertices, white);
  if (attributes.texture_coordinates) mesh.texture_coordinates.assign(vertices, glm::vec2(0));
  for (const SceneMaterial& material : scene.materials) mesh.materials.push_back(material.material);
  mesh.textures = scene.textures;
  for (std::size_t k = 0; k < merged.objects.size(); ++k) {
    const MergedObject& object = merged.objects[k];
    const SceneMesh& from = scene.mesh_of(object.object);
    const glm::dmat4& world = scene.objects[object.object].world;
    if (!has_room(from, from.positions, world)) return no_room(object.object);
    place_vertices(merged, object, from, world, from.positions);
    place_facets(merged, object, from);
    place_attributes(merged, object, from);
    std::fill_n(merged.facet_objects.begin() + object.first_facet, object.facet_count, static_cast<std::uint32_t>(k));
  }
  return merged;
}

Status update(MergedMesh& merged, const Scene& scene, std::size_t k) {
  return update(merged, scene, k, scene.mesh_of(merged.objects[k].object).positions);
}

Status update(MergedMesh& merged, const Scene& scene, std::size_t k, std::span<const glm::vec3> positions) {
  MergedObject& object = merged.objects[k];
  const SceneMesh& mesh = scene.mesh_of(object.object);
  assert(positions.size() == mesh.positions.size() && mesh.triangles.size() == object.facet_count);
  const glm::dmat4& world = scene.objects[object.object].world;
  if (!has_room(mesh, positions, world)) return no_room(object.object);
  place_vertices(merged, object, mesh, world, positions);
  if (const bool is_mirrored = turns_left_into_right(world); is_mirrored != object.is_mirrored) {
    object.is_mirrored = is_mirrored;
    place_facets(merged, object, mesh);
  }
  return {};
}

}  // namespace facetsort
