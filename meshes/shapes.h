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

// n triangles about `size` across with centres uniform in the unit cube, not sharing vertices: the smaller, the fewer
// cross. Deterministic in `seed` on every machine.
// Precondition: size > 0.
Mesh scattered(std::size_t n, float size, std::uint32_t seed);

// A plain weave of n by n ribbons, over and under in turn, in quads from crossing to crossing: 4 n (n - 1) facets that
// do not touch but along their ribbon. Seen from straight above (+z), the quads around each of the (n - 1)^2 openings
// hide each other in a cycle, of four of their triangles.
// Precondition: n >= 2.
Mesh woven_mat(int n);

// n long teeth, a bar that they pass over and a bar that they pass under, which in turn passes under the first: seen
// from +z all n + 2 triangles are one component, and each tooth makes a cycle of three with the bars. They do not
// touch. The teeth come first. Precondition: n >= 1.
Mesh comb(int n);

// A sheet rolled up `turns` times, an Archimedean spiral of radius 1 around the axis z, 2 high, in long facets from end
// to end, facets_per_turn to each turn. Preconditions: turns >= 1; facets_per_turn >= 6 and even.
Mesh scroll(int turns, int facets_per_turn);

// n triangles that overlap in one plane exactly: z = x / 2 + y / 4, x and y multiples of 2^-10 in [0, 1), wound either
// way; none is degenerate. Deterministic in `seed` on every machine.
Mesh coplanar(std::size_t n, std::uint32_t seed);

// A square of n by n cells on the plane z = 0, 2 n^2 facets, and then `copies` - 1 times all of them again, corners
// turned round and every other copy wound the other way. Preconditions: n >= 1; copies >= 1.
Mesh duplicated_grid(int n, int copies);

// Box of side 2 around the origin: 12 facets.
Mesh box();

// Sphere of radius 1: 20 * 4^subdivisions facets.
// Precondition: subdivisions in [0, 10].
Mesh icosphere(int subdivisions);

}  // namespace facetsort::shapes
