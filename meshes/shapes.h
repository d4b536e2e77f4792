// Meshes made by formula: the extreme cases that tests, benches and comparisons need at any size.
//
// Computed in double and rounded once to float; the same on every call. Facets are wound counter-clockwise from outside
// (open ones: from +z). Arguments outside the ranges stated are programming errors.
#pragma once

#include <cstddef>
#include <cstdint>

#include "facetsort/mesh/mesh.h"

namespace facetsort::shapes {

// Fewest facets of a torus knot whose tube still keeps clear of itself.
inline constexpr std::size_t fewest_knot_facets = 500;

// Closed tube around the (p, q) torus knot, which winds p times around the axis z and q times around the ring: clean,
// concave, of radius about 1. Its count of facets (two triangles a quad, quads nearly square) is within 5 % of
// `facets`, at least fewest_knot_facets. The tube is half as thick as the knot allows, so it keeps clear of itself at
// any size. Preconditions: p and q, 1 to 8, have no common divisor.
Mesh torus_knot(std::size_t facets, int p = 2, int q = 3);

// `layers` concentric closed icospheres of 20 * 4^subdivisions facets with corners at radii 1, 1 - gap, 1 - 2 gap, ...,
// the outermost first. Each lies strictly inside the one before it.
// Preconditions: layers >= 1; gap >= 1e-5; (layers - 1) * gap < 1.
Mesh nested_shells(int layers, float gap, int subdivisions = 3);

// n long slabs (each a closed box of 12 facets) in a ring, each leaning over the next: seen from +z every slab hides
// part of the next one and the last hides part of the first, so no order of whole slabs is right. They do not touch.
// Precondition: n >= 3; n = 3 is the classic.
Mesh slab_cycle(int n);

// The same ring of n long single triangles: no order of facets is right.
// Precondition: n >= 3.
Mesh triangle_cycle(int n);

// Two closed shapes pushed through each other (an icosphere of radius 1 and a box whose faces and corners stick out).
Mesh interpenetrating(int subdivisions = 3);

// A fan of n triangles around one corner, each `aspect` times longer than wide, bent into a shallow cone.
// Preconditions: n >= 1; aspect in [1, 1e6]; the fan goes round at most once: n <= 6 * aspect.
Mesh sliver_fan(int n, float aspect);

// Closed regular tetrahedra with circumradii from 1e-6 to 1e6 by powers of ten: two of each size side by side, both
// inside the first of the next size. They do not touch. 104 facets.
Mesh many_scales();

// n triangles with corners uniform in the unit cube, not sharing vertices. Deterministic in `seed` on every machine.
Mesh soup(std::size_t n, std::uint32_t seed);

// Box of side 2 around the origin: 12 facets.
Mesh box();

// Sphere of radius 1: 20 * 4^subdivisions facets.
// Precondition: subdivisions in [0, 10].
Mesh icosphere(int subdivisions);

}  // namespace facetsort::shapes
