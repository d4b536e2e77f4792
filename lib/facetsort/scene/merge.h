// Objects of a scene as one mesh in world space, so that their facets can be sorted together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/mesh/mesh.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

// Where an object's facets and vertices are in the merged mesh: in a row, in the order of its own mesh.
struct MergedObject {
  std::uint32_t object;  // of Scene::objects
  std::uint32_t first_facet, facet_count;
  std::uint32_t first_vertex, vertex_count;
  bool is_mirrored;        // its place turns left into right: corners 1 and 2 of its facets have changed places
  bool has_split_corners;  // each facet has three vertices of its own, to carry the facet's colour
};

struct MergedMesh {
  Mesh mesh;                                 // in world space, with the scene's materials and textures
  std::vector<MergedObject> objects;         // in the order asked for
  std::vector<std::uint32_t> facet_objects;  // of each facet: which of `objects`

  // Of a facet, among those of its object's mesh.
  std::uint32_t facet_in_object(std::uint32_t facet) const { return facet - objects[facet_objects[facet]].first_facet; }
};

// Positions are transformed in double and rounded to float once. As glTF asks, a facet that is counter-clockwise in its
// mesh is so in the world too, mirrored or not. Colours: of the facets where no object has colours of vertices, else of
// the vertices, facets of one colour then having vertices of their own; white where an object has none and others do.
// Faults: too_many_facets, and non_finite_position where float has no room for a place; the message names the object.
// Preconditions: validate(scene) is ok; `objects` are some of its objects, each once. Parallel in the caller's arena.
Result<MergedMesh> merge(const Scene& scene, std::span<const std::uint32_t> objects);

// Brings merged.objects[k] up to date with the object's place and its mesh's positions in the scene, or with other
// positions in the mesh's space (skinned, morphed), one for each of its vertices. Nothing else is touched and nothing
// allocated. Facets stay the same, but for the corners of one that a new place mirrors, so what was made of the merged
// mesh can go on with its new positions (Sorter::set_positions). Fault: non_finite_position; the merged mesh then is as
// it was.
Status update(MergedMesh& merged, const Scene& scene, std::size_t k);
Status update(MergedMesh& merged, const Scene& scene, std::size_t k, std::span<const glm::vec3> positions);

}  // namespace facetsort
