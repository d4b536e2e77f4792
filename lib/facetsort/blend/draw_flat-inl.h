// Internal to blend: facets of one colour each drawn into one tile, in the order given, where no depth is looked at.
//
// A pixel's four channels lie together: that takes as many operations as a plane a channel where many pixels in a row
// are covered, and fewer where few are, as by small facets.
#if defined(FACETSORT_BLEND_DRAW_FLAT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_DRAW_FLAT_INL_H
#undef FACETSORT_BLEND_DRAW_FLAT_INL_H
#else
#define FACETSORT_BLEND_DRAW_FLAT_INL_H
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "facetsort/blend/covered_rows-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr int pixels_per_block = 8;

// The colours of a tile, in units of the format, and room for a whole block from any pixel on.
struct alignas(64) FlatTile {
  static constexpr std::size_t values = 4 * (tile_size * tile_size + pixels_per_block);

  float channels[values];

  float* pixel(int x, int y) { return channels + 4 * (y * tile_size + x); }
};

// A pixel, or the part of one that fits a vector; and as many pixels as fit.
using PixelTag = hn::CappedTag<float, 4>;
using PixelsTag = hn::CappedTag<float, 16>;

// What one facet adds to each pixel that it covers, in units of the format.
struct FlatSource {
  HWY_ALIGN float colour[4];
  float transparency;
};

template <bool eight_bits, class V>
HWY_INLINE V blended_values(V source, V transparency, V below) {
  const V blended = hn::Add(source, hn::Mul(below, transparency));
  return eight_bits ? hn::Round(blended) : blended;
}

template <bool eight_bits, class D>
HWY_INLINE void blend_vector(D d, hn::VFromD<D> source, hn::VFromD<D> transparency, float* channels) {
  hn::StoreU(blended_values<eight_bits>(source, transparency, hn::LoadU(d, channels)), d, channels);
}

template <bool eight_bits>
HWY_INLINE void blend_pixel(const FlatSource& source, float* pixel) {
  const PixelTag d;
  const auto transparency = hn::Set(d, source.transparency);
  for (std::size_t k = 0; k < 4; k += hn::Lanes(d)) {
    blend_vector<eight_bits>(d, hn::Load(d, source.colour + k), transparency, pixel + k);
  }
}

// Into each pixel of a square that begins at `corner`.
template <bool eight_bits>
HWY_INLINE void blend_square(const FlatSource& source, PixelSquare square, float* corner) {
  for (; square != 0; square &= square - 1) {
    const auto bit = static_cast<unsigned>(std::countr_zero(square));
    blend_pixel<eight_bits>(source, corner + 4 * (bit / square_size * tile_size + bit % square_size));
  }
}

// Into `count` pixels in a row. What is left of the last block is blended with the pixels beyond it, which are then
// stored as they were: how many there are can't be foreseen, and a wrong guess costs more than a few vectors.
template <bool eight_bits>
HWY_INLINE void blend_run(const FlatSource& source, int count, float* pixel) {
  constexpr int values_per_block = 4 * pixels_per_block;
  // The values of a block that count, from those at `count` pixels before the middle on.
  alignas(64) static constexpr auto counts = [] {
    std::array<std::int32_t, 2 * values_per_block> all{};
    std::fill_n(all.begin(), values_per_block, -1);
    return all;
  }();
  const PixelsTag d;
  const hn::RebindToSigned<PixelsTag> di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  if (lanes < 4) {
    for (; count > 0; --count, pixel += 4) blend_pixel<eight_bits>(source, pixel);
    return;
  }
  const auto colours = hn::LoadDup128(d, source.colour);
  const auto transparency = hn::Set(d, source.transparency);
  for (; count >= pixels_per_block; count -= pixels_per_block, pixel += values_per_block) {
    for (int i = 0; i < values_per_block; i += lanes) blend_vector<eight_bits>(d, colours, transparency, pixel + i);
  }
  const std::int32_t* mask = counts.data() + values_per_block - 4 * count;
  for (int i = 0; i < values_per_block; i += lanes) {
    const auto below = hn::LoadU(d, pixel + i);
    const auto blended = blended_values<eight_bits>(colours, transparency, below);
    const auto is_counted = hn::MaskFromVec(hn::BitCast(d, hn::LoadU(di, mask + i)));
    hn::StoreU(hn::IfThenElse(is_counted, blended, below), d, pixel + i);
  }
}

// Into each pixel of a row that starts at `row`. More than one run of pixels is seen only where the near plane cuts.
template <bool eight_bits>
HWY_INLINE void blend_row(const FlatSource& source, RowBits bits, float* row) {
  while (bits != 0) {
    const int first = std::countr_zero(bits), count = std::countr_one(bits >> first);
    blend_run<eight_bits>(source, count, row + 4 * first);
    bits &= bits + (RowBits{1} << first);  // carries through the run
  }
}

// Colours of facets, and what finds the pixels of those on the grid, are all over memory: they are fetched ahead.
HWY_INLINE void prefetch_for(const TileTask& task, std::span<const BinEntry> entries, std::size_t k) {
  constexpr std::size_t distance = 16;
  if (k + distance >= entries.size()) return;
  const BinEntry& ahead = entries[k + distance];
  hwy::Prefetch(&task.colours[ahead.facet]);
  if (ahead.how() != Coverage::known) hwy::Prefetch(&task.projected.mesh.triangles[ahead.facet]);
}

template <bool eight_bits>
void draw_flat_pass(const TileTask& task, const DrawPass& pass, int tile, FlatTile& pixels) {
  if (!pass.colour_write) return;
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  const float scale = channel_scale(task);
  const std::span<const BinEntry> entries = task.bins.tile(tile);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const BinEntry& entry = entries[k];
    prefetch_for(task, entries, k);
    if (is_culled(pass, entry)) continue;
    FlatSource source;
    const glm::vec4& colour = task.colours[entry.facet];
    const float alpha = pass.blend == BlendMode::additive ? 0.0f : colour.a;
    for (int channel = 0; channel < 3; ++channel) source.colour[channel] = colour[channel] * scale;
    source.colour[3] = alpha * scale;
    source.transparency = 1.0f - alpha;
    if (entry.how() == Coverage::known) {
      blend_square<eight_bits>(source, entry.detail, pixels.pixel(entry.x0, entry.y0));
    } else {
      for_covered_rows(task.projected, task.bins, entry, x0, y0,
                       [&](int y, RowBits bits) HWY_ATTR { blend_row<eight_bits>(source, bits, pixels.pixel(0, y)); });
    }
  }
}

void clear_flat_tile(const glm::vec4& colour, FlatTile& pixels) {
  const PixelsTag d;
  if (hn::Lanes(d) < 4) {
    for (std::size_t i = 0; i < FlatTile::values; i += 4) std::memcpy(pixels.channels + i, &colour.x, sizeof colour);
    return;
  }
  HWY_ALIGN float pixel[4];
  std::memcpy(pixel, &colour.x, sizeof colour);
  const auto some = hn::LoadDup128(d, pixel);
  for (std::size_t i = 0; i < FlatTile::values; i += hn::Lanes(d)) hn::Store(some, d, pixels.channels + i);
}

// Writes a tile's part of the picture, past the caches: a picture is more than they keep until it is read.
template <bool eight_bits>
void write_flat_tile(const TileTask& task, const FlatTile& pixels, int tile) {
  // Vectors are streamed to addresses that are multiples of their size.
  static_assert(__STDCPP_DEFAULT_NEW_ALIGNMENT__ >= sizeof(glm::vec4));
  const PixelTag d;
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  const int width = std::min(tile_size, task.image.width - x0);
  const int height = std::min(tile_size, task.image.height - y0);
  const auto unit = hn::Set(d, 1.0f / channel_scale(task)), most = hn::Set(d, channel_scale(task));
  for (int y = 0; y < height; ++y) {
    const float* from = pixels.channels + 4 * y * tile_size;
    float* to = picture_row(task.image, x0, y0 + y);
    for (int i = 0; i < 4 * width; i += static_cast<int>(hn::Lanes(d))) {
      const auto values = hn::Load(d, from + i);
      hn::Stream(eight_bits ? hn::Mul(hn::Min(values, most), unit) : values, d, to + i);
    }
  }
  hwy::FlushStream();
}

template <bool eight_bits>
void draw_flat_tile(const TileTask& task, std::span<const DrawPass> passes, int tile) {
  FlatTile pixels;
  clear_flat_tile(clear_value(task), pixels);
  for (const DrawPass& pass : passes) draw_flat_pass<eight_bits>(task, pass, tile, pixels);
  write_flat_tile<eight_bits>(task, pixels, tile);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
