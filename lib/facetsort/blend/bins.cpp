#include "facetsort/blend/bins.h"

#include <algorithm>

#include "facetsort/base/parallel.h"

namespace facetsort::blend_internal {
namespace {

template <typename Body>
void for_each_tile(const PixelBox& box, const Body& body) {
  for (int row = box.y0 / tile_size; row <= box.y1 / tile_size; ++row) {
    for (int column = box.x0 / tile_size; column <= box.x1 / tile_size; ++column) body(row, column);
  }
}

}  // namespace

// Writes what one chunk of the order has to draw to placed_, and counts it in the tiles it may cover.
void FacetBins::place(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces,
                      std::size_t chunk_index) {
  const std::size_t facet_count = projected.mesh.facet_count();
  const std::size_t begin = chunk_index * facets_per_chunk;
  const std::size_t end = std::min(order.size(), begin + facets_per_chunk);
  std::uint64_t* counts = cursors_.data() + chunk_index * static_cast<std::size_t>(tiles());
  Chunk& chunk = chunks_[chunk_index];
  chunk.pieces.clear();
  chunk.cuts.clear();
  Placed* next = placed_.data() + begin;
  for (std::size_t k = begin; k < end; ++k) {
    const std::uint32_t facet = pieces.facet_of(order[k], facet_count);
    PixelBox box = facet_pixels(projected, facet);
    if (box.empty()) continue;
    const int facing = facet_facing(projected, facet);
    if (facing == 0) continue;
    std::uint32_t placed_piece = whole_facet;
    if (order[k] >= facet_count) {
      const std::size_t first_cut = chunk.cuts.size();
      box = chunk.clipper.clip(projected, pieces, pieces.pieces[order[k] - facet_count], box, chunk.cuts);
      if (box.empty()) continue;
      if (const std::size_t count = chunk.cuts.size() - first_cut; count > 0) {
        placed_piece = static_cast<std::uint32_t>(begin + chunk.pieces.size());
        chunk.pieces.push_back({static_cast<std::uint32_t>(first_cut), static_cast<std::uint32_t>(count)});
      }
    }
    *next++ = {box, facet, placed_piece, static_cast<std::int8_t>(facing)};
    for_each_tile(box, [&](int row, int column) { ++counts[row * columns_ + column]; });
  }
  chunk.kept = static_cast<std::size_t>(next - (placed_.data() + begin));
}

// Two passes: each chunk of the order places what it has to draw and counts its entries a tile; once the counts are
// summed, in tile and then chunk order, each chunk knows where its entries go, and writes them.
void FacetBins::build(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces) {
  columns_ = (projected.view.width + tile_size - 1) / tile_size;
  rows_ = (projected.view.height + tile_size - 1) / tile_size;
  const std::size_t tile_count = static_cast<std::size_t>(tiles());
  const std::size_t chunks = (order.size() + facets_per_chunk - 1) / facets_per_chunk;
  placed_.resize(order.size());
  if (chunks_.size() < chunks) chunks_.resize(chunks);
  cursors_.assign(chunks * tile_count, 0);
  begins_.resize(tile_count + 1);

  parallel_ranges(chunks, 1, [&](std::size_t first_chunk, std::size_t last_chunk) {
    for (std::size_t chunk = first_chunk; chunk < last_chunk; ++chunk) place(projected, order, pieces, chunk);
  });

  std::uint64_t total = 0;
  for (std::size_t tile = 0; tile < tile_count; ++tile) {
    begins_[tile] = total;
    for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
      std::uint64_t& cursor = cursors_[chunk * tile_count + tile];
      const std::uint64_t count = cursor;
      cursor = total;
      total += count;
    }
  }
  begins_[tile_count] = total;
  entries_.resize(total);

  parallel_ranges(chunks, 1, [&](std::size_t first_chunk, std::size_t last_chunk) {
    for (std::size_t chunk = first_chunk; chunk < last_chunk; ++chunk) {
      std::uint64_t* cursors = cursors_.data() + chunk * tile_count;
      const Placed* begin = placed_.data() + chunk * facets_per_chunk;
      for (const Placed* placed = begin; placed != begin + chunks_[chunk].kept; ++placed) {
        const PixelBox& box = placed->box;
        for_each_tile(box, [&](int row, int column) {
          const auto relative = [](int pixel, int tile) {
            return static_cast<std::uint8_t>(std::clamp(pixel - tile * tile_size, 0, tile_size - 1));
          };
          entries_[cursors[row * columns_ + column]++] = {placed->facet,
                                                          placed->piece,
                                                          placed->facing,
                                                          box.crosses_near,
                                                          relative(box.x0, column),
                                                          relative(box.y0, row),
                                                          relative(box.x1, column),
                                                          relative(box.y1, row)};
        });
      }
    }
  });

  front_facets_ = back_facets_ = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    const Placed* begin = placed_.data() + chunk * facets_per_chunk;
    const auto fronts = std::count_if(begin, begin + chunks_[chunk].kept, [](const Placed& p) { return p.facing > 0; });
    front_facets_ += static_cast<std::size_t>(fronts);
    back_facets_ += chunks_[chunk].kept - static_cast<std::size_t>(fronts);
  }
}

}  // namespace facetsort::blend_internal
