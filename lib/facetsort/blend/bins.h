// Internal to blend: facets sorted into the tiles of the picture that they may cover, in draw order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/coverage.h"

namespace facetsort::blend_internal {

// Small enough that a tile's colours stay in the first-level cache, wide enough for whole vectors of any target.
inline constexpr int tile_size = 32;

// A facet in a tile; `facing` is +1 or -1.
struct BinEntry {
  std::uint32_t facet;
  std::int8_t facing;
  bool crosses_near;
  // Pixels of the tile that the facet may cover, inclusive, relative to the tile.
  std::uint8_t x0, y0, x1, y1;
};

class FacetBins {
 public:
  // `order`: facet ids in draw order. Facets seen edge-on or outside the picture
  // are left out. Parallel in the caller's task arena; the same bins for any thread count. Keeps its storage.
  void build(const ProjectedMesh& projected, std::span<const std::uint32_t> order);

  int columns() const { return columns_; }
  int tiles() const { return columns_ * rows_; }
  // In draw order.
  std::span<const BinEntry> tile(int t) const {
    return {entries_.data() + begins_[t], static_cast<std::size_t>(begins_[t + 1] - begins_[t])};
  }
  // Facets kept, by facing.
  std::size_t front_facets() const { return front_facets_; }
  std::size_t back_facets() const { return back_facets_; }

 private:
  struct Placed {
    PixelBox box;
    std::uint32_t facet;
    std::int8_t facing;
  };

  int columns_ = 0, rows_ = 0;
  std::size_t front_facets_ = 0, back_facets_ = 0;
  std::vector<Placed> placed_;
  std::vector<std::size_t> kept_;                 // a chunk: how many of its facets were placed
  std::vector<std::uint64_t> cursors_;            // a chunk and tile: count, then where its entries go
  std::vector<std::uint64_t> begins_;             // a tile
  std::vector<BinEntry> entries_;
};

}  // namespace facetsort::blend_internal
