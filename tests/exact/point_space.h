// What points of a mesh are defined over, as ExactSorter makes it, but with every facet in a plane of its own.
#pragma once

#include <numeric>

#include "facetsort/exact/points.h"
#include "facetsort/exact/positions.h"

namespace facetsort::exact_internal {

// Refers to the mesh.
inline PointSpace space_of(const MeshView& mesh) {
  PointSpace space;
  space.mesh = mesh;
  space.position_of_vertex = identify_positions(mesh);
  space.plane_of_facet.resize(mesh.facet_count());
  std::iota(space.plane_of_facet.begin(), space.plane_of_facet.end(), FacetId{0});
  space.faces_away.assign(mesh.facet_count(), 0);
  space.find_facets_around();
  return space;
}

}  // namespace facetsort::exact_internal
