#include "facetsort/blend/fragment_lists.h"

#include <algorithm>
#include <numeric>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/tile_kernels.h"

namespace facetsort {
namespace {

using blend_internal::tile_size;
using blend_internal::TileFragment;

bool drawn_before(const Fragment& a, const Fragment& b) {
  return a.depth != b.depth ? a.depth > b.depth : a.facet < b.facet;
}

}  // namespace

FragmentLists collect_fragments(const MeshView& mesh, const View& view) {
  blend_internal::ProjectedMesh projected;
  projected.project(mesh, view);
  std::vector<std::uint32_t> all(mesh.facet_count());
  std::iota(all.begin(), all.end(), 0u);
  blend_internal::FacetBins bins;
  bins.build(projected, all);

  FragmentLists lists;
  lists.width = view.width;
  lists.height = view.height;
  lists.facets_drawn = bins.front_facets() + bins.back_facets();
  const std::size_t width = static_cast<std::size_t>(view.width);
  lists.offsets.assign(width * static_cast<std::size_t>(view.height) + 1, 0);

  // offsets[p + 1] first counts pixel p; sums make it the end of p. Filling a tile moves a copy of the begins.
  const std::size_t tiles = static_cast<std::size_t>(bins.tiles());
  std::vector<std::vector<TileFragment>> tile_fragments(tiles);
  const auto pixel_of = [&](std::size_t tile, const TileFragment& fragment) {
    const std::size_t columns = static_cast<std::size_t>(bins.columns());
    const std::size_t x = tile % columns * tile_size + fragment.pixel % tile_size;
    const std::size_t y = tile / columns * tile_size + fragment.pixel / tile_size;
    return y * width + x;
  };
  parallel_ranges(tiles, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tile = begin; tile < end; ++tile) {
      const int column = static_cast<int>(tile) % bins.columns(), row = static_cast<int>(tile) / bins.columns();
      blend_internal::collect_tile(projected, bins.tile(static_cast<int>(tile)), column * tile_size, row * tile_size,
                                   tile_fragments[tile]);
      for (const TileFragment& fragment : tile_fragments[tile]) ++lists.offsets[pixel_of(tile, fragment) + 1];
    }
  });
  std::partial_sum(lists.offsets.begin(), lists.offsets.end(), lists.offsets.begin());
  lists.fragments.resize(lists.offsets.back());

  std::vector<std::uint64_t> cursors(lists.offsets.begin(), lists.offsets.end() - 1);
  parallel_ranges(tiles, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tile = begin; tile < end; ++tile) {
      for (const TileFragment& fragment : tile_fragments[tile]) {
        lists.fragments[cursors[pixel_of(tile, fragment)]++] = {fragment.facet, fragment.depth_error, fragment.depth};
      }
      tile_fragments[tile] = {};
    }
  });
  constexpr std::size_t pixels_per_task = 4096;
  parallel_ranges(cursors.size(), pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      std::sort(lists.fragments.begin() + static_cast<std::ptrdiff_t>(lists.offsets[pixel]),
                lists.fragments.begin() + static_cast<std::ptrdiff_t>(lists.offsets[pixel + 1]), drawn_before);
    }
  });
  return lists;
}

}  // namespace facetsort
