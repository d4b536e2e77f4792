#include "facetsort/blend/bins.h"

#include <algorithm>
#include <utility>

#include "facetsort/base/parallel.h"

namespace facetsort::blend_internal {
namespace {

constexpr std::size_t facets_per_task = 4096;

// Facets are looked up in draw order, which is all over memory: far enough ahead that they are there when needed.
constexpr std::size_t prefetch_distance = 32;

// What is known of a piece when it is looked up is where the rest is: half as far ahead.
void prefetch_piece(const Pieces& pieces, const Piece& piece, const PlacedFacet* facets) {
  __builtin_prefetch(facets + piece.facet);
  __builtin_prefetch(pieces.cuts.data() + piece.first_cut);
  if (piece.first_cut >= pieces.measured.size()) return;
  const auto* measured = reinterpret_cast<const char*>(pieces.measured.data() + piece.first_cut);
  constexpr std::size_t cache_line = 64;
  for (std::size_t offset = 0; offset < 2 * cache_line; offset += cache_line) __builtin_prefetch(measured + offset);
}

// Calls body(row, column, entry) for each tile of a small facet's square that has some of its pixels.
template <typename Body>
void for_each_tile_of_square(const PlacedFacet& placed, BinEntry entry, const Body& body) {
  const int x = static_cast<int>(placed.x % tile_size), y = static_cast<int>(placed.y % tile_size);
  const int row = static_cast<int>(placed.y / tile_size), column = static_cast<int>(placed.x / tile_size);
  // Rows and columns of the square in the first tile; what is left of it lies in the next one.
  const int rows = std::min(square_size, tile_size - y), columns = std::min(square_size, tile_size - x);
  const auto emit = [&](int rows_on, int columns_on, PixelSquare square) {
    if (square == 0) return;
    const int first_row = rows_on ? 0 : y, first_column = columns_on ? 0 : x;
    entry.set_rows(first_row, std::min(first_row + square_size, tile_size) - 1);
    entry.set_columns(first_column, std::min(first_column + square_size, tile_size) - 1);
    entry.detail = square;
    body(row + rows_on, column + columns_on, entry);
  };
  if (rows == square_size && columns == square_size) return emit(0, 0, placed.pixels);

  const PixelSquare here = placed.pixels & first_rows(rows);
  const PixelSquare below = rows < square_size ? placed.pixels >> (square_size * rows) : 0;
  emit(0, 0, here & first_columns(columns));
  emit(0, 1, (here & ~first_columns(columns)) >> columns % square_size);
  emit(1, 0, below & first_columns(columns));
  emit(1, 1, (below & ~first_columns(columns)) >> columns % square_size);
}

template <typename Body>
void for_each_tile_of_box(const PlacedFacet& placed, BinEntry entry, const Body& body) {
  const PixelBox box = placed.box();
  const auto relative = [](int pixel, int tile) { return std::clamp(pixel - tile * tile_size, 0, tile_size - 1); };
  for (int row = box.y0 / tile_size; row <= box.y1 / tile_size; ++row) {
    entry.set_rows(relative(box.y0, row), relative(box.y1, row));
    for (int column = box.x0 / tile_size; column <= box.x1 / tile_size; ++column) {
      entry.set_columns(relative(box.x0, column), relative(box.x1, column));
      body(row, column, entry);
    }
  }
}

// Calls body(row, column, entry) for each tile that a facet or piece may cover.
template <typename Body>
void for_each_tile(const PlacedFacet& placed, std::uint32_t facet, std::uint32_t piece, const Body& body) {
  const BinEntry entry{facet, 0, 0, 0, 0, placed.coverage, placed.is_front, placed.crosses_near, piece};
  if (placed.how() == Coverage::known) {
    for_each_tile_of_square(placed, entry, body);
  } else {
    for_each_tile_of_box(placed, entry, body);
  }
}

// For scratch: what it held is of no use.
template <typename T>
void grow(std::vector<T>& vector, std::size_t size) {
  if (vector.size() < size) vector.resize(size);
}

}  // namespace

// A piece that no cut bounds is the facet, as far as the pixels go.
FacetBins::Drawn FacetBins::place_piece(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece,
                                        std::size_t chunk_index) {
  Chunk& chunk = chunks_[chunk_index];
  const PlacedFacet& facet = facets_[piece.facet];
  Drawn drawn{facet, piece.facet, whole_facet};
  if (facet.how() == Coverage::none) return drawn;
  if (facet.how() == Coverage::known) {
    const int x = static_cast<int>(facet.x), y = static_cast<int>(facet.y);
    const PixelSquare pixels = piece_pixels(projected, pieces, piece, facet.facing(), x, y, facet.pixels);
    drawn.placed = pixels == 0 ? PlacedFacet::nothing() : PlacedFacet::with_pixels(x, y, facet.facing(), pixels);
    return drawn;
  }
  const std::size_t first_cut = chunk.cuts.size();
  const PixelBox box = chunk.clipper.clip(projected, pieces, piece, facet.box(), chunk.cuts);
  const std::size_t count = chunk.cuts.size() - first_cut;
  if (box.empty()) {
    drawn.placed = PlacedFacet::nothing();
  } else if (count > 0) {
    drawn.placed = PlacedFacet::with_box(Coverage::homogeneous, box, facet.facing());
    drawn.piece = static_cast<std::uint32_t>(chunk_index * facets_per_chunk + chunk.pieces.size());
    chunk.pieces.push_back({static_cast<std::uint32_t>(first_cut), static_cast<std::uint32_t>(count)});
  }
  return drawn;
}

// Writes what one chunk of the order has to draw to drawn_, and counts it in the tiles it may cover.
void FacetBins::place(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces,
                      std::size_t chunk_index) {
  const std::size_t facet_count = projected.mesh.facet_count();
  const std::size_t begin = chunk_index * facets_per_chunk;
  const std::size_t end = std::min(order.size(), begin + facets_per_chunk);
  std::uint64_t* counts = cursors_.data() + chunk_index * static_cast<std::size_t>(tiles());
  std::fill_n(counts, tiles(), 0u);
  Chunk& chunk = chunks_[chunk_index];
  chunk.pieces.clear();
  chunk.cuts.clear();
  chunk.fronts = 0;
  Drawn* next = drawn_.data() + begin;
  for (std::size_t k = begin; k < end; ++k) {
    const std::uint32_t ahead = order[std::min(k + prefetch_distance, end - 1)];
    const std::uint32_t nearer = order[std::min(k + prefetch_distance / 2, end - 1)];
    if (ahead < facet_count) {
      __builtin_prefetch(&facets_[ahead]);
    } else {
      __builtin_prefetch(&pieces.pieces[ahead - facet_count]);
    }
    if (nearer >= facet_count) prefetch_piece(pieces, pieces.pieces[nearer - facet_count], facets_.data());
    const std::uint32_t id = order[k];
    *next = id < facet_count ? Drawn{facets_[id], id, whole_facet}
                             : place_piece(projected, pieces, pieces.pieces[id - facet_count], chunk_index);
    if (next->placed.how() == Coverage::none) continue;
    chunk.fronts += next->placed.is_front;
    for_each_tile(next->placed, next->facet, next->piece,
                  [&](int row, int column, const BinEntry&) { ++counts[row * columns_ + column]; });
    ++next;
  }
  chunk.kept = static_cast<std::size_t>(next - (drawn_.data() + begin));
}

// Entries are stored by tile, and those of a tile by chunk: finds where each tile begins, and how far behind that each
// chunk's part does.
void FacetBins::turn_counts_into_cursors(std::size_t chunks) {
  const std::size_t tile_count = static_cast<std::size_t>(tiles());
  begins_.assign(tile_count + 1, 0);
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    std::uint64_t* counts = cursors_.data() + chunk * tile_count;
    for (std::size_t tile = 0; tile < tile_count; ++tile) {
      const std::uint64_t count = std::exchange(counts[tile], begins_[tile + 1]);
      begins_[tile + 1] += count;
    }
  }
  for (std::size_t tile = 0; tile < tile_count; ++tile) begins_[tile + 1] += begins_[tile];
}

// Writes the entries of one chunk.
void FacetBins::fill(std::size_t chunk_index) {
  const std::size_t tile_count = static_cast<std::size_t>(tiles());
  std::uint64_t* cursors = cursors_.data() + chunk_index * tile_count;
  for (std::size_t tile = 0; tile < tile_count; ++tile) cursors[tile] += begins_[tile];
  const std::span<const Drawn> drawn = std::span(drawn_).subspan(chunk_index * facets_per_chunk);
  for (const Drawn& one : drawn.first(chunks_[chunk_index].kept)) {
    for_each_tile(one.placed, one.facet, one.piece, [&](int row, int column, const BinEntry& entry) {
      entries_[cursors[row * columns_ + column]++] = entry;
    });
  }
}

// Each facet in the order in which they lie in memory.
void FacetBins::place_mesh(const ProjectedMesh& projected) {
  columns_ = (projected.view.width + tile_size - 1) / tile_size;
  rows_ = (projected.view.height + tile_size - 1) / tile_size;
  grow(facets_, projected.mesh.facet_count());
  parallel_ranges(projected.mesh.facet_count(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    place_facets(projected, begin, end, facets_.data() + begin);
    if (projected.mesh.facet_materials.empty()) return;
    for (std::size_t facet = begin; facet < end; ++facet) {
      if (!facets_[facet].is_front && is_single_sided(projected.mesh, facet)) facets_[facet] = PlacedFacet::nothing();
    }
  });
}

// Facets are looked up in draw order, in two passes: each chunk of the order counts its entries a tile; once the counts
// are summed each chunk knows where its entries go, and writes them.
void FacetBins::sort_into_tiles(const ProjectedMesh& projected, std::span<const std::uint32_t> order,
                                const Pieces& pieces) {
  const std::size_t tile_count = static_cast<std::size_t>(tiles());
  const std::size_t chunks = (order.size() + facets_per_chunk - 1) / facets_per_chunk;
  grow(drawn_, order.size());
  grow(chunks_, chunks);
  grow(cursors_, chunks * tile_count);
  parallel_ranges(chunks, 1, [&](std::size_t first_chunk, std::size_t last_chunk) {
    for (std::size_t chunk = first_chunk; chunk < last_chunk; ++chunk) place(projected, order, pieces, chunk);
  });
  turn_counts_into_cursors(chunks);
  grow(entries_, begins_[tile_count]);
  parallel_ranges(chunks, 1, [&](std::size_t first_chunk, std::size_t last_chunk) {
    for (std::size_t chunk = first_chunk; chunk < last_chunk; ++chunk) fill(chunk);
  });

  front_facets_ = back_facets_ = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    front_facets_ += chunks_[chunk].fronts;
    back_facets_ += chunks_[chunk].kept - chunks_[chunk].fronts;
  }
}

void FacetBins::build(const ProjectedMesh& projected, std::span<const std::uint32_t> order, const Pieces& pieces) {
  place_mesh(projected);
  sort_into_tiles(projected, order, pieces);
}

}  // namespace facetsort::blend_internal
