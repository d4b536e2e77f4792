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

// What an order draws of each facet: the whole of it, some pieces, or nothing.
class DrawnParts {
 public:
  DrawnParts(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order, const Pieces& pieces)
      : whole_rank_(mesh.facet_count(), not_drawn), piece_begins_(mesh.facet_count() + 1, 0) {
    projected_.project(mesh, view);
    const std::size_t facet_count = mesh.facet_count();
    for (const std::uint32_t id : order) piece_begins_[pieces.facet_of(id, facet_count)] += id >= facet_count;
    std::exclusive_scan(piece_begins_.begin(), piece_begins_.end(), piece_begins_.begin(), std::size_t{0});
    parts_.resize(piece_begins_.back());
    std::vector<std::size_t> cursors(piece_begins_.begin(), piece_begins_.end() - 1);
    for (std::uint32_t rank = 0; rank < order.size(); ++rank) {
      const std::uint32_t facet = pieces.facet_of(order[rank], facet_count);
      if (order[rank] < facet_count) {
        whole_rank_[facet] = rank;
        continue;
      }
      const Piece& piece = pieces.pieces[order[rank] - facet_count];
      parts_[cursors[facet]++] = {rank, cuts_.size(), piece.cut_count};
      for (std::size_t i = piece.first_cut; i < piece.first_cut + piece.cut_count; ++i) {
        cuts_.push_back(
            blend_internal::facet_cut(mesh, pieces, i, blend_internal::measured_cut(mesh, pieces, piece, i)));
      }
    }
  }

  // Of the part that covers the pixel (x, y), which the facet covers.
  std::uint32_t rank(std::uint32_t facet, int x, int y) const {
    const std::span<const Part> parts =
        std::span(parts_).subspan(piece_begins_[facet], piece_begins_[facet + 1] - piece_begins_[facet]);
    if (parts.empty()) return whole_rank_[facet];
    const int facing = blend_internal::facet_facing(projected_, facet);
    for (const Part& part : parts) {
      const auto cuts = std::span(cuts_).subspan(part.first_cut, part.cut_count);
      if (blend_internal::covers_pixel(projected_, facet, facing, cuts, x, y)) return part.rank;
    }
    return not_drawn;
  }

 private:
  struct Part {
    std::uint32_t rank;
    std::size_t first_cut, cut_count;
  };

  blend_internal::ProjectedMesh projected_;
  std::vector<std::uint32_t> whole_rank_;   // by facet
  std::vector<std::size_t> piece_begins_;   // by facet, in parts_
  std::vector<Part> parts_;
  std::vector<blend_internal::FacetCut> cuts_;
};

constexpr std::size_t pixels_per_task = 4096;

}  // namespace

FragmentLists collect_fragments(const MeshView& mesh, const View& view) {
  blend_internal::ProjectedMesh projected;
  projected.project(mesh, view);
  std::vector<std::uint32_t> all(mesh.facet_count());
  std::iota(all.begin(), all.end(), 0u);
  blend_internal::FacetBins bins;
  bins.build(projected, all, {});

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
    const std::size_t x = static_cast<std::size_t>(bins.tile_x(static_cast<int>(tile))) + fragment.pixel % tile_size;
    const std::size_t y = static_cast<std::size_t>(bins.tile_y(static_cast<int>(tile))) + fragment.pixel / tile_size;
    return y * width + x;
  };
  parallel_ranges(tiles, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tile = begin; tile < end; ++tile) {
      blend_internal::collect_tile(projected, bins, static_cast<int>(tile), tile_fragments[tile]);
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
  parallel_ranges(cursors.size(), pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      std::sort(lists.fragments.begin() + static_cast<std::ptrdiff_t>(lists.offsets[pixel]),
                lists.fragments.begin() + static_cast<std::ptrdiff_t>(lists.offsets[pixel + 1]), drawn_before);
    }
  });
  return lists;
}

std::vector<std::uint32_t> fragment_ranks(const MeshView& mesh, const View& view, const FragmentLists& lists,
                                          std::span<const std::uint32_t> order, const Pieces& pieces) {
  const DrawnParts parts(mesh, view, order, pieces);
  std::vector<std::uint32_t> ranks(lists.fragments.size());
  parallel_ranges(lists.offsets.size() - 1, pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      const int x = static_cast<int>(pixel) % lists.width, y = static_cast<int>(pixel) / lists.width;
      for (std::size_t i = lists.offsets[pixel]; i < lists.offsets[pixel + 1]; ++i) {
        ranks[i] = parts.rank(lists.fragments[i].facet, x, y);
      }
    }
  });
  return ranks;
}

}  // namespace facetsort
