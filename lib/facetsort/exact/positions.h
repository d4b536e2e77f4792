// Internal to exact: vertices and points by position, for meshes whose facets do not share vertices and for points that
// are defined in several ways; and facets without area.
#pragma once

#include <cstdint>
#include <vector>

#include "facetsort/exact/points.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::exact_internal {

// Maps each vertex to the smallest vertex index at its position. Positions compare by their bits (after -0 became 0),
// so that vertices no facet uses may hold anything. Parallel in the caller's task arena.
std::vector<std::uint32_t> identify_positions(const MeshView& mesh);

// Maps each point to the smallest added one that coincides with it; vertices to themselves. Exact, but where more than
// a few different points round to the same place, not all that coincide are found. Parallel likewise.
std::vector<PointId> identify_points(const Points& points);

// Whether the corners of each facet lie on one line: it has no area and no plane. Parallel likewise.
std::vector<unsigned char> find_degenerate_facets(const MeshView& mesh);

}  // namespace facetsort::exact_internal
