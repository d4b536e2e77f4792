#include "facetsort/blend/bins.h"

#include <algorithm>

#include "facetsort/base/parallel.h"

namespace facetsort::blend_internal {
namespace {

// Chunks are fixed by the facet count alone, so that bins do not depend on the thread count.
constexpr std::size_t facets_per_chunk = 8192;

}  // namespace

// Two passes: each chunk of the order counts its entries a tile; once the counts are summed, in tile and then chunk
// order, each chunk knows where its entries go, and writes them.
void FacetBins::build(const ProjectedMesh& projected, std::span<const std::uint32_t> order) {
  columns_ = (projected.view.width + tile_size - 1) / tile_size;
  rows_ = (projected.view.height + tile_size - 1) / tile_size;
  const std::size_t tile_count = static_cast<std::size_t>(tiles());
  const std::size_t facet_count = order.size();
  const std::size_t chunks = (facet_count + facets_per_chunk - 1) / facets_per_chunk;
  placed_.resize(facet_count);
  kept_.assign(chunks, 0);
  cursors_.assign(chunks * tile_count, 0);
  begins_.resize(tile_count + 1);

  const auto for_each_tile = [&](const PixelBox& box, const auto& body) {
    for (int row = box.y0 / tile_size; row <= box.y1 / tile_size; ++row) {
      for (int column = box.x0 / tile_size; column <= box.x1 / tile_size; ++column) body(row, column);
    }
  };

  parallel_ranges(chunks, 1, [&](std::size_t first_chunk, std::size_t last_chunk) {
    for (std::size_t chunk = first_chunk; chunk < last_chunk; ++chunk) {
      std::uint64_t* counts = cursors_.data() + chunk * tile_count;
      const std::size_t begin = chunk * facets_per_chunk;
      const std::size_t end = std::min(facet_count, begin + facets_per_chunk);
      Placed* next = placed_.data() + begin;
      for (std::size_t k = begin; k < end; ++k) {
        const std::uint32_t facet = order[k];
        const PixelBox box = facet_pixels(projected, facet);
        if (box.empty()) continue;
        const int facing = facet_facing(projected, facet);
        if (facing == 0) continue;
        *next++ = {box, facet, static_cast<std::int8_t>(facing)};
        for_each_tile(box, [&](int row, int column) { ++counts[row * columns_ + column]; });
      }
      kept_[chunk] = static_cast<std::size_t>(next - (placed_.data() + begin));
    }
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
      for (const Placed* placed = begin; placed != begin + kept_[chunk]; ++placed) {
        const PixelBox& box = placed->box;
        for_each_tile(box, [&](int row, int column) {
          const auto relative = [](int pixel, int tile) {
            return static_cast<std::uint8_t>(std::clamp(pixel - tile * tile_size, 0, tile_size - 1));
          };
          entries_[cursors[row * columns_ + column]++] = {placed->facet,
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
    const auto fronts = std::count_if(begin, begin + kept_[chunk], [](const Placed& p) { return p.facing > 0; });
    front_facets_ += static_cast<std::size_t>(fronts);
    back_facets_ += kept_[chunk] - static_cast<std::size_t>(fronts);
  }
}

}  // namespace facetsort::blend_internal
