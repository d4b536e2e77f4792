// What a mesh is, and whether it may enter the pipeline: the one place where bad input is met.
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "facetsort/base/status.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Checks what every other stage takes for granted. Faults, each with the first facet that has it in the message:
// empty_mesh, too_many_facets (2^32 - 1 facets or vertices and more), size_mismatch, index_out_of_range,
// non_finite_position (of a vertex that some facet uses), bad_argument (a colour that is_colour() has not). O(facets and
// vertices), allocates nothing, thread-safe.
Status validate(const MeshView& mesh);
// Whether a straight colour can be drawn: its channels are finite and none is negative, and alpha is at most 1.
bool is_colour(const glm::vec4& straight);
// The fault of what has another: "material 3", "vertex 7".
Status not_a_colour(const std::string& owner);
// Whether each texture has its texels; size_mismatch, with the first that has not.
Status validate(std::span<const Texture> textures);

// Combinatorial facts of a valid mesh; what needs exact geometry (intersections, convexity) is in exact/facts.h.
// Corners at bit-identical positions count as one vertex (-0 equals 0), so that a mesh whose facets do not share
// vertices is judged by its shape and not by its indexing.
struct MeshFacts {
  std::size_t facets = 0;
  std::size_t vertices = 0;              // as listed
  std::size_t distinct_positions = 0;    // of vertices that facets use
  std::size_t components = 0;            // facets connected through shared edges, collapsed facets left out
  std::size_t edges = 0;                 // distinct, collapsed facets left out
  std::size_t boundary_edges = 0;        // with one facet
  std::size_t non_manifold_edges = 0;    // with three facets and more
  std::size_t misoriented_edges = 0;     // with two facets that run along it the same way
  std::size_t collapsed_facets = 0;      // two corners or more at one position
  std::size_t duplicate_facets = 0;      // same three positions as an earlier facet, in any winding
  bool closed = false;                   // no boundary edge; every edge has an even number of facets
  bool oriented = false;                 // closed or not, no edge is misoriented and none is non-manifold
  glm::vec3 lowest{0}, highest{0};       // box of the vertices that facets use
  double bounding_radius = 0;            // R: half the diagonal of that box
};

// Precondition: validate(mesh) is ok. O(facets log facets) time, O(facets) memory, thread-safe.
MeshFacts inspect(const MeshView& mesh);

}  // namespace facetsort
