// Internal to exact: facets that pass through each other, and the cuts that part them for every view.
#pragma once

#include <cstddef>

#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"

namespace facetsort::exact_internal {

struct PartedFacets {
  PartList pieces;  // of the facets that were cut, by facet
  std::size_t crossing_pairs = 0;
  std::size_t uncut_pairs = 0;  // left crossing because of `most_triangles`
  std::size_t cuts = 0;
};

// Finds all pairs of facets that cross: each has area on both sides of the other's plane, and they share a segment. In
// each pair one facet is cut along the segment, until no part crosses a facet; hence no two of all the parts cross.
// Where that leaves a facet in parts that are not convex, kinks are joined to other corners; a cut runs on beyond its
// segment only where segments cross or end, or a join cannot be had. New points are added to `points`.
// `most_triangles`: the most that all parts and whole facets may make. Parallel in the caller's task arena; the result
// does not depend on the thread count.
PartedFacets part_crossing_facets(Points& points, const std::vector<unsigned char>& degenerate,
                                  std::size_t most_triangles);

}  // namespace facetsort::exact_internal
