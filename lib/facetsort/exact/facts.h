// Geometric facts of a mesh that need exact decisions.
#pragma once

#include <cstddef>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

struct GeometryFacts {
  std::size_t degenerate_facets = 0;         // corners on one line: no area to draw
  std::size_t intersecting_pairs = 0;        // pairs of facets that meet apart from corners and edges they share
  std::size_t first_intersecting[2] = {0, 0};  // the pair with the smallest ids; meaningless where there is none
  std::size_t convex_closed_components = 0;  // closed, consistently wound, and convex
  std::size_t convex_closed_facets = 0;      // facets of those: back faces before front faces is exact among them
};

// Precondition: validate(mesh) is ok. Close to O(facets log facets) for real meshes (a bounding-volume hierarchy
// proposes pairs, exact predicates decide each), parallel in the caller's task arena, same result for any thread count.
GeometryFacts inspect_geometry(const MeshView& mesh);

}  // namespace facetsort
