// What a presorted mesh consists of: as the builder hands it over, as a file keeps it, and as the run time reads it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// A plane of the order tree (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree
// Structures"), the pieces that lie in it, and how many nodes are on its two sides. Seen from one side, all beyond the
// plane is behind all before it, and what lies in the plane is between them.
struct PresortedNode {
  glm::uvec3 plane;  // vertices of the mesh, not on one line; the front is where (b - a) x (c - a) points to
  std::uint32_t piece_count;
  std::uint32_t front_nodes, back_nodes;  // those in front follow this node, then come those behind
};

// A facet, whole where it has no cuts, or a convex part of it.
struct PresortedPiece {
  std::uint32_t facet;
  std::uint32_t triangle_count;  // that it is drawn as: one or more
  std::uint32_t cut_count;
};

// A vertex made by cuts: every attribute of a facet's corners can be carried over to it. Facets that share the edge
// that it lies on each have their own, at bit-identical positions.
struct PresortedVertex {
  std::uint32_t facet;
  glm::vec3 barycentric;  // weights of the facet's corners; they sum to 1 up to rounding
};

// Borrowed arrays. What is counted in nodes and pieces stands one after another: the pieces without a node (facets
// without area, drawn first), then those of each node; the triangles and the cuts of each piece.
struct PresortedView {
  MeshView mesh;  // as it came in
  // The tree; all empty where there is none.
  std::span<const PresortedVertex> made_vertices;  // their indices follow the mesh's vertices
  std::span<const glm::vec3> made_positions;       // of each
  std::span<const PresortedNode> nodes;            // preorder; the first is the root
  std::span<const PresortedPiece> pieces;
  std::span<const glm::uvec3> triangles;  // indices of vertices; wound as their facets
  std::span<const Cut> cuts;              // see Pieces
  std::span<const CutPlane> planes;       // see Pieces
};

// Owns the same.
struct PresortedData {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> facets;
  std::vector<glm::vec4> facet_colours, vertex_colours;  // as in MeshView
  std::vector<PresortedVertex> made_vertices;
  std::vector<glm::vec3> made_positions;
  std::vector<PresortedNode> nodes;
  std::vector<PresortedPiece> pieces;
  std::vector<glm::uvec3> triangles;
  std::vector<Cut> cuts;
  std::vector<CutPlane> planes;

  PresortedView view() const {
    return {{positions, facets, facet_colours, vertex_colours},
            made_vertices,
            made_positions,
            nodes,
            pieces,
            triangles,
            cuts,
            planes};
  }
};

// Plain index buffers for engines that draw them as they are: each has all facets of the mesh once, in an order that is
// good for some directions.
struct IndexBuffers {
  std::size_t buffer_count = 0;
  std::vector<std::uint32_t> facets;  // those of each buffer, back to front, one buffer after another
  // Unit vectors from the mesh towards the viewer, and the buffer for each: a view takes that of the direction nearest
  // to its own, the one of the largest dot product, from the centre of the mesh's box to the eye.
  std::vector<glm::vec3> directions;
  std::vector<std::uint32_t> buffer_of_direction;
  bool needs_culling = false;  // the engine has to leave out facets seen from behind
  // Measured share of inverted pixels.
  double mean_inverted_rate = 0, worst_inverted_rate = 0;

  std::size_t facet_count() const { return buffer_count == 0 ? 0 : facets.size() / buffer_count; }
  std::span<const std::uint32_t> buffer(std::size_t i) const {
    return std::span(facets).subspan(i * facet_count(), facet_count());
  }
};

// Which of unit vectors has the largest dot product with `direction` (any length > 0), the first of those that have.
// Precondition: there are some.
inline std::size_t nearest_direction(std::span<const glm::vec3> directions, const glm::vec3& direction) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < directions.size(); ++i) {
    if (glm::dot(directions[i], direction) > glm::dot(directions[best], direction)) best = i;
  }
  return best;
}

// The buffer for a viewer in this direction (any length > 0) from the centre of the mesh's box.
// Precondition: there are directions.
inline std::size_t nearest_buffer(const IndexBuffers& buffers, const glm::vec3& to_viewer) {
  return buffers.buffer_of_direction[nearest_direction(buffers.directions, to_viewer)];
}

}  // namespace facetsort
