// Pieces: convex parts of facets, left by cuts along planes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace facetsort {

// One side of a plane: +1 the side that its normal (b - a) x (c - a) points to, -1 the other. A point in the plane belongs
// to neither; what covers pixels decides such points by the top-left rule, which gives each to exactly one of the two.
struct Cut {
  std::uint32_t plane;  // see Pieces
  std::int32_t side;
};

// The points of `facet` on the given side of each of its cuts' planes. The pieces of a facet are disjoint and cover it:
// they come from cutting it, then its parts, in two.
struct Piece {
  std::uint32_t facet;
  std::uint32_t first_cut, cut_count;  // in Pieces::cuts
};

// What an order of a mesh with cut facets draws: draw id i below the mesh's facet count is facet i, whole; draw id
// facet count + i is pieces[i]. A cut's plane p below the facet count is that of facet p, which has area; plane facet
// count + i is that through the vertices planes[i], which are not on one line.
struct Pieces {
  std::span<const Piece> pieces;
  std::span<const Cut> cuts;
  std::span<const glm::uvec3> planes;

  std::span<const Cut> cuts_of(const Piece& piece) const { return cuts.subspan(piece.first_cut, piece.cut_count); }
  // The vertices of the plane of a cut.
  glm::uvec3 plane_vertices(const Cut& cut, std::span<const glm::uvec3> triangles) const {
    return cut.plane < triangles.size() ? triangles[cut.plane] : planes[cut.plane - triangles.size()];
  }
  // The facet that a draw id is, or is part of.
  std::uint32_t facet_of(std::uint32_t draw_id, std::size_t facet_count) const {
    return draw_id < facet_count ? draw_id : pieces[draw_id - facet_count].facet;
  }
};

}  // namespace facetsort
