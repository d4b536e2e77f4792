// The points that define a cut's plane, as exact predicates take them.
#pragma once

#include <cstdint>

#include "facetsort/exact/predicates.h"
#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

inline PlanePoints points_of(const MeshView& mesh, const CutPlane& plane) {
  const auto position = [&](std::uint32_t vertex) { return mesh.positions[vertex]; };
  PlanePoints points{{position(plane.first), position(plane.second), position(plane.third)}};
  if (plane.is_join()) {
    points.is_join = true;
    points.edge_end = position(plane.edge_end);
    points.facet = {mesh.corner(plane.facet, 0), mesh.corner(plane.facet, 1), mesh.corner(plane.facet, 2)};
  }
  return points;
}

}  // namespace facetsort
