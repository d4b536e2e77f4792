// Internal to blend: facets and pieces sorted into the tiles of the picture that they may cover, in draw order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/coverage.h"
#include "facetsort/blend/facet_kernels.h"

namespace facetsort::blend_internal {

// Small enough that a tile's colours stay in the first-level cache, wide enough for whole vectors of any target.
inline constexpr int tile_size = 32;

// A facet, or a piece of it, in a tile.
struct BinEntry {
  std::uint32_t facet;
  // Pixels of the tile that it may cover, inclusive, relative to the tile.
  std::uint32_t x0 : 5, y0 : 5, x1 : 5, y1 : 5;
  std::uint32_t coverage : 2, is_front : 1, crosses_near : 1;
  // Coverage::known: the PixelSquare from (x0, y0) on. Otherwise the piece for FacetBins::cuts(), or whole_facet.
  std::uint64_t detail;

  Coverage how() const { return static_cast<Coverage>(coverage); }
  int facing() const { return is_front ? 1 : -1; }
  void set_columns(int first, int last) {
    x0 = static_cast<std::uint32_t>(first) & 31u;
    x1 = static_cast<std::uint32_t>(last) & 31u;
  }
  void set_rows(int first, int last) {
    y0 = static_cast<std::uint32_t>(first) & 31u;
    y1 = static_cast<std::uint32_t>(last) & 31u;
  }
};
static_assert(tile_size == 1 << 5 && sizeof(BinEntry) == 16);

inline constexpr std::uint32_t whole_facet = 0xffffffffu;

class FacetBins {
 public:
  // `order`: draw ids of the mesh and `pieces`, in draw order. Those seen edge-on, outside the picture or too small to
  // cover a pixel's centre are left out. Parallel in the caller's task arena; the same bins for any thread count. Keeps
  // its storage.
  void build(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces);
  // The two halves of that: for several orders of one mesh, the first is done once.
  void place_mesh(const ProjectedMesh& projected);
  void sort_into_tiles(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces);

  int tiles() const { return columns_ * rows_; }
  // The tile's upper left pixel.
  int tile_x(int t) const { return t % columns_ * tile_size; }
  int tile_y(int t) const { return t / columns_ * tile_size; }
  // In draw order.
  std::span<const BinEntry> tile(int t) const {
    return {entries_.data() + begins_[t], static_cast<std::size_t>(begins_[t + 1] - begins_[t])};
  }
  // Those of a piece's cuts that matter: together with the facet's edges they bound what it covers.
  std::span<const FacetCut> cuts(const BinEntry& entry) const {
    if (entry.how() == Coverage::known || entry.detail == whole_facet) return {};
    const Chunk& chunk = chunks_[entry.detail / facets_per_chunk];
    const PlacedPiece& piece = chunk.pieces[entry.detail % facets_per_chunk];
    return std::span(chunk.cuts).subspan(piece.first_cut, piece.cut_count);
  }
  // Facets and pieces kept, by facing.
  std::size_t front_facets() const { return front_facets_; }
  std::size_t back_facets() const { return back_facets_; }

 private:
  // Chunks are fixed by the length of the order alone, so that bins do not depend on the thread count.
  static constexpr std::uint32_t facets_per_chunk = 8192;

  // A facet or piece to be drawn.
  struct Drawn {
    PlacedFacet placed;
    std::uint32_t facet, piece;
  };
  struct PlacedPiece {
    std::uint32_t first_cut, cut_count;
  };
  // What one chunk of the order leaves.
  struct Chunk {
    std::size_t kept = 0, fronts = 0;  // how many are drawn, and how many of them are seen from the front
    std::vector<PlacedPiece> pieces;
    std::vector<FacetCut> cuts;
    PieceClipper clipper;
  };

  void place(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces,
             std::size_t chunk_index);
  Drawn place_piece(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece, std::size_t chunk_index);
  void turn_counts_into_cursors(std::size_t chunks);
  void fill(std::size_t chunk_index);

  int columns_ = 0, rows_ = 0;
  std::size_t front_facets_ = 0, back_facets_ = 0;
  std::vector<PlacedFacet> facets_;  // by id
  std::vector<Drawn> drawn_;         // a chunk's from the start of its part of the order on
  std::vector<Chunk> chunks_;
  std::vector<std::uint64_t> cursors_;  // a chunk and tile: its count, then where its entries go
  std::vector<std::uint64_t> begins_;   // a tile
  std::vector<BinEntry> entries_;
};

}  // namespace facetsort::blend_internal
