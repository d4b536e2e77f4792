// Pieces: convex parts of facets, left by cuts along planes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace facetsort {

// A plane through two vertices and a third point, not all on one line. The third is a vertex or, where the plane is a
// join, the point in which the edge from `third` to `edge_end` pierces a facet's plane, which parts its ends strictly.
struct CutPlane {
  static constexpr std::uint32_t none = 0xffffffffu;

  std::uint32_t first, second, third;
  std::uint32_t edge_end = none, facet = none;

  bool is_join() const { return edge_end != none; }
  bool operator==(const CutPlane&) const = default;
};

// One side of a plane: +1 the side that its normal (b - a) x (c - a) points to, -1 the other. A point in the plane
// belongs to neither; what covers pixels decides such points by the top-left rule, which gives each to exactly one of
// the two.
struct Cut {
  std::uint32_t plane;  // see Pieces
  std::int32_t side;
};

// The points of `facet` on the given side of each of its cuts' planes. The pieces of a facet are disjoint and cover it:
// each is convex.
struct Piece {
  std::uint32_t facet;
  std::uint32_t first_cut, cut_count;  // in Pieces::cuts, each of one piece
};

// How far the corners of a facet are from the plane of a cut of it, as measure_cuts() gives it: positive on the piece's
// side, each within `error`, scaled by a power of two so that the largest magnitude lies in [1/2, 1), unless all are 0.
struct MeasuredCut {
  double volume[3], error;
};

// What an order of a mesh with cut facets draws: draw id i below the mesh's facet count is facet i, whole; draw id
// facet count + i is pieces[i]. A cut's plane p below the facet count is that of facet p, which has area; plane facet
// count + i is planes[i].
struct Pieces {
  std::span<const Piece> pieces;
  std::span<const Cut> cuts;
  std::span<const CutPlane> planes;
  // Of the first of `cuts`, as many as there are; the others are measured when they are drawn.
  std::span<const MeasuredCut> measured = {};

  std::span<const Cut> cuts_of(const Piece& piece) const { return cuts.subspan(piece.first_cut, piece.cut_count); }
  CutPlane plane_of(const Cut& cut, std::span<const glm::uvec3> triangles) const {
    if (cut.plane >= triangles.size()) return planes[cut.plane - triangles.size()];
    const glm::uvec3& facet = triangles[cut.plane];
    return {facet.x, facet.y, facet.z};
  }
  // The facet that a draw id is, or is part of.
  std::uint32_t facet_of(std::uint32_t draw_id, std::size_t facet_count) const {
    return draw_id < facet_count ? draw_id : pieces[draw_id - facet_count].facet;
  }
};

}  // namespace facetsort
