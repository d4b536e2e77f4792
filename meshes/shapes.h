// Meshes made by formula: the extreme cases that tests, benches and comparisons need at any size.
#pragma once

#include <cstddef>
#include <cstdint>

#include "facetsort/mesh/mesh.h"

namespace facetsort::shapes {

// Closed tube around the (p, q) torus knot, of about `facets` facets (two triangles a quad), radius about 1; clean,
// concave, wound counter-clockwise from outside.
Mesh torus_knot(std::size_t facets, int p = 2, int q = 3);

// `layers` concentric closed icospheres of 20 * 4^subdivisions facets, radii 1, 1 - gap, 1 - 2 gap, ...
Mesh nested_shells(int layers, float gap, int subdivisions = 3);

// n long slabs (each a closed box of 12 facets) in a ring, each leaning over the next: seen from +z every slab hides part of the
// next one and the last hides part of the first, so no order of whole slabs is right. n >= 3; n = 3 is the classic.
Mesh slab_cycle(int n);

// The same ring of n long single triangles.
Mesh triangle_cycle(int n);

// Two closed shapes pushed through each other (an icosphere and a box), wound outwards.
Mesh interpenetrating(int subdivisions = 3);

// A fan of n triangles around one corner, each `aspect` times longer than wide, bent into a shallow cone.
Mesh sliver_fan(int n, float aspect);

// Closed tetrahedra whose sizes run from 1e-6 to 1e6 by powers of ten, beside and inside each other.
Mesh many_scales();

// n triangles with corners uniform in the unit cube. Deterministic in `seed`.
Mesh soup(std::size_t n, std::uint32_t seed);

// Box of side 2 around the origin: 12 facets, wound outwards.
Mesh box();

// Sphere of radius 1: 20 * 4^subdivisions facets, wound outwards.
Mesh icosphere(int subdivisions);

}  // namespace facetsort::shapes
