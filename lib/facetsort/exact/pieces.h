// Pieces: convex parts of facets, left by cuts along the planes of other facets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace facetsort {

// One side of the plane through the corners of `facet`: +1 the side that its normal (b - a) x (c - a) points to, -1 the
// other. A point in the plane belongs to neither; what covers pixels decides such points by the top-left rule, which
// gives each of them to exactly one of the two sides.
struct Cut {
  std::uint32_t facet;
  std::int32_t side;
};

// The points of `facet` on the given side of each of its cuts' planes. The pieces of a facet are disjoint and cover it:
// they come from cutting it, then its parts, in two.
struct Piece {
  std::uint32_t facet;
  std::uint32_t first_cut, cut_count;  // in Pieces::cuts
};

// What an order of a mesh with cut facets draws: draw id i below the mesh's facet count is facet i, whole; draw id
// facet count + i is pieces[i]. The planes of cuts are those of facets of the same mesh that have area.
struct Pieces {
  std::span<const Piece> pieces;
  std::span<const Cut> cuts;

  std::span<const Cut> cuts_of(const Piece& piece) const { return cuts.subspan(piece.first_cut, piece.cut_count); }
  // The facet that a draw id is, or is part of.
  std::uint32_t facet_of(std::uint32_t draw_id, std::size_t facet_count) const {
    return draw_id < facet_count ? draw_id : pieces[draw_id - facet_count].facet;
  }
};

}  // namespace facetsort
