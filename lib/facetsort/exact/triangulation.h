// Internal to exact: an order of facets and pieces as plain triangles without T-junctions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/exact/exact_sorter.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"

namespace facetsort::exact_internal {

// `order`: draw ids, `parts` being the pieces. Every vertex that a cut made on an edge is a corner of all that meet
// there: pieces of the same facet, and neighbours across an edge of the mesh, whole ones too.
OrderedTriangles triangulate(const Points& points, const PartList& parts, std::span<const std::uint32_t> order);

struct TriangulatedParts {
  OrderedTriangles triangles;
  std::vector<std::uint32_t> counts;  // of triangles, by place in the order
};
TriangulatedParts triangulate_parts(const Points& points, const PartList& parts, std::span<const std::uint32_t> order);

// How many triangles that makes.
std::size_t count_triangles(const Points& points, const PartList& parts, std::span<const std::uint32_t> order);

}  // namespace facetsort::exact_internal
