// Geometric facts of a mesh that need exact decisions.
#pragma once

#include <cstddef>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Corners at bit-identical positions count as one (-0 equals 0), so a mesh whose facets do not share vertices is judged
// by its shape and not by its indexing.
struct GeometryFacts {
  std::size_t degenerate_facets = 0;  // corners on one line: no area to draw

  // Pairs of facets with a point in common beyond the corner or the edge they share. Touching counts, and so do facets
  // of one plane that overlap or fold onto each other along an edge; a duplicate (all three corners shared) does not,
  // nor does a degenerate facet.
  std::size_t intersecting_pairs = 0;
  std::size_t first_intersecting[2] = {0, 0};  // the pair with the smallest ids; meaningless where there is none

  // Components (facets connected through shared edges; facets with two corners at one position left out) that are the
  // boundary of a convex body: every edge has two facets, wound the same way round and outwards, no edge is reflex, no
  // facet is degenerate and none intersects another of the component. Flat edges are allowed.
  std::size_t convex_closed_components = 0;
  std::size_t convex_closed_facets = 0;  // facets of those: back faces before front faces is exact among each one's
};

// Precondition: validate(mesh) is ok. Close to O(facets log facets) for real meshes (a bounding-volume hierarchy
// proposes pairs, exact predicates decide each), parallel in the caller's task arena, same result for any thread count.
GeometryFacts inspect_geometry(const MeshView& mesh);

}  // namespace facetsort
