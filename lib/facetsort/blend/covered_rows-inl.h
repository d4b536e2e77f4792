// Internal to blend: which pixels of a tile a facet or piece covers, a row at a time.
#if defined(FACETSORT_BLEND_COVERED_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_COVERED_ROWS_INL_H
#undef FACETSORT_BLEND_COVERED_ROWS_INL_H
#else
#define FACETSORT_BLEND_COVERED_ROWS_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "facetsort/blend/bins.h"
#include "facetsort/blend/coverage.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, tile_size>;

// A row of a tile, pixel x at bit x.
using RowBits = std::uint32_t;
static_assert(tile_size == 32);

HWY_INLINE RowBits bits_between(std::uint32_t first, std::uint32_t last) {
  return (~RowBits{0} >> (31 - last)) & (~RowBits{0} << first);
}

HWY_INLINE RowBits bits_of(hn::Mask<FloatTag> mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(FloatTag(), mask, bytes);
  RowBits bits;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

HWY_INLINE hn::Mask<FloatTag> mask_of(RowBits bits) {
  alignas(8) std::uint8_t bytes[8] = {};
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(FloatTag(), bytes);
}

// The line functions that bound one facet or piece in one tile, in float: a dx + b dy + c for the pixel that is (dx, dy)
// away from (origin_x, origin_y). Where every one exceeds `error` the pixel is covered, where one is below -error it is
// not; between, float can't tell. A pixel also has to be in the entry's box.
struct TileEdges {
  // A piece that has more cuts in one tile is decided pixel by pixel.
  static constexpr int most_cuts = 16;

  float a[3 + most_cuts], b[3 + most_cuts], c[3 + most_cuts], error;
  int lines;  // three edges, then cuts
  int origin_x, origin_y;
  float near_a = 0, near_b = 0, near_c = 0;  // from the tile's first pixel: not negative beyond the near plane
  std::span<const FacetCut> cuts;            // all of the piece's

  // False when nothing is covered in the entry's box. (x0, y0) is the tile's first pixel.
  HWY_INLINE bool set_up(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry, int x0, int y0) {
    if (entry.how() == Coverage::grid) {
      set_up_on_grid(projected, entry, x0, y0);
    } else if (!set_up_homogeneous(projected, bins, entry, x0, y0)) {
      return false;
    }
    for (int i = 0; i < 3; ++i) {
      if (highest(i, entry) < -2 * error) return false;
    }
    return true;
  }

  // Whether all of the entry's box is covered for certain.
  HWY_INLINE bool cover_box(const BinEntry& entry) const {
    for (int i = 0; i < lines; ++i) {
      if (!(lowest(i, entry, entry.x0, entry.x1) > 2 * error)) return false;
    }
    return true;
  }

 private:
  // Edge functions of points on the grid, as in place_facets-inl.h. Their coefficients are differences of two points,
  // rounded once; the third is rounded from double. With S for the facet's extents and those of the vectors that its box
  // takes part in, float adds at most 2^-20 S^2: some ten roundings of products that are below S^2 / 2.
  HWY_INLINE void set_up_on_grid(const ProjectedMesh& projected, const BinEntry& entry, int x0, int y0) {
    constexpr double pixels_per_unit = 1.0 / (1 << grid_bits);
    const int lanes = static_cast<int>(hn::Lanes(FloatTag()));
    const glm::uvec3& triangle = projected.mesh.triangles[entry.facet];
    origin_x = static_cast<int>(entry.x0) / lanes * lanes;
    origin_y = static_cast<int>(entry.y0);
    // Relative to the origin's centre, in pixels; exact in double, as are all differences below.
    double x[3], y[3];
    for (int i = 0; i < 3; ++i) {
      const GridPoint point = projected.grid_points[triangle[i]];
      x[i] = point.x * pixels_per_unit - (x0 + origin_x + 0.5);
      y[i] = point.y * pixels_per_unit - (y0 + origin_y + 0.5);
    }
    const double orientation = -entry.facing();
    for (int i = 0; i < 3; ++i) {
      const int p = (i + 1) % 3, q = (i + 2) % 3;
      const double dx = (x[q] - x[p]) * orientation, dy = (y[q] - y[p]) * orientation;
      a[i] = static_cast<float>(-dy);
      b[i] = static_cast<float>(dx);
      c[i] = static_cast<float>(dy * x[p] - dx * y[p]);
    }
    lines = 3;
    cuts = {};
    const auto extent = [](const double (&v)[3]) {
      return static_cast<float>(std::max({v[0], v[1], v[2]}) - std::min({v[0], v[1], v[2]}));
    };
    const float extents = extent(x) + extent(y) + 0x1p-10f;  // covers terms in the square of a unit
    const float reach = extents + static_cast<float>(2 * lanes);
    error = 0x1p-14f * extents + 0x1p-20f * reach * reach;
  }

  // From edge functions in double, scaled to change by at most 1 a pixel.
  HWY_NOINLINE bool set_up_homogeneous(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry,
                                       int x0, int y0) {
    const FacetEdges exact =
        facet_edges(projected, entry.facet, entry.facing(), {x0 + 0.5, y0 + 0.5}, tile_size);
    origin_x = origin_y = 0;
    double largest_error = 0;
    for (lines = 0; lines < 3; ++lines) {
      largest_error =
          std::max(largest_error, set_up_line(exact.a[lines], exact.b[lines], exact.c[lines], exact.error[lines]));
    }
    cuts = bins.cuts(entry);
    if (!cuts.empty() && !set_up_cuts(exact, entry, largest_error)) return false;
    error = float_bound(largest_error);
    if (entry.crosses_near) set_up_near(projected, exact, entry);
    return true;
  }

  static float float_bound(double line_error) {
    // In float: three roundings of coefficients, two products and two sums, of values that stay below 4 tile_size.
    constexpr double float_error = 16 * tile_size * 0x1p-24;
    return static_cast<float>(std::min(line_error + float_error, 4.0 * tile_size));
  }

  // The line whose place is next; returns its error after scaling.
  double set_up_line(double line_a, double line_b, double line_c, double line_error) {
    const double slope = std::abs(line_a) + std::abs(line_b);
    // Where the slope is below what a double can divide by, everything is in doubt.
    const double scale = slope > 1e-290 ? 1 / slope : 0.0;
    a[lines] = static_cast<float>(line_a * scale);
    b[lines] = static_cast<float>(line_b * scale);
    // An edge that far from the tile has one sign on all of it.
    c[lines] = static_cast<float>(std::clamp(line_c * scale, -2.0 * tile_size, 2.0 * tile_size));
    return scale > 0 ? line_error * scale : 1.0;
  }

  // Largest value of a line in the entry's box.
  HWY_INLINE float highest(int line, const BinEntry& entry) const {
    const float left = static_cast<float>(static_cast<int>(entry.x0) - origin_x);
    const float right = static_cast<float>(static_cast<int>(entry.x1) - origin_x);
    const float top = static_cast<float>(static_cast<int>(entry.y0) - origin_y);
    const float bottom = static_cast<float>(static_cast<int>(entry.y1) - origin_y);
    return c[line] + std::max(a[line] * left, a[line] * right) + std::max(b[line] * top, b[line] * bottom);
  }

  // Smallest value of a line in the entry's rows, from column x0 to x1.
  HWY_INLINE float lowest(int line, const BinEntry& entry, int x0, int x1) const {
    const float left = static_cast<float>(x0 - origin_x), right = static_cast<float>(x1 - origin_x);
    const float top = static_cast<float>(static_cast<int>(entry.y0) - origin_y);
    const float bottom = static_cast<float>(static_cast<int>(entry.y1) - origin_y);
    return c[line] + std::min(a[line] * left, a[line] * right) + std::min(b[line] * top, b[line] * bottom);
  }

  // Cuts that leave all of the entry's box do not become lines. False when one leaves none of it.
  HWY_NOINLINE bool set_up_cuts(const FacetEdges& exact, const BinEntry& entry, double& largest_error) {
    for (const FacetCut& cut : cuts) {
      if (lines == 3 + most_cuts) {
        largest_error = 4 * tile_size;  // no float value is certain
        return true;
      }
      const CutLine line = cut_line(exact, cut, tile_size);
      const double line_error = set_up_line(line.a, line.b, line.c, line.error);
      const float bound = 2 * float_bound(line_error);
      if (highest(lines, entry) < -bound) return false;
      if (lowest(lines, entry, entry.x0, entry.x1) > bound) continue;
      largest_error = std::max(largest_error, line_error);
      ++lines;
    }
    return true;
  }

  // W of the fragment is sum(E_i W_i) / sum(E_i), so it reaches the near distance where sum(E_i (W_i - near)) >= 0.
  void set_up_near(const ProjectedMesh& projected, const FacetEdges& exact, const BinEntry& entry) {
    double sum_a = 0, sum_b = 0, sum_c = 0;
    for (int i = 0; i < 3; ++i) {
      const double beyond =
          projected.vertices[projected.mesh.triangles[entry.facet][i]].w - projected.camera.near_distance;
      sum_a += exact.a[i] * beyond;
      sum_b += exact.b[i] * beyond;
      sum_c += exact.c[i] * beyond;
    }
    const double largest = std::max({std::abs(sum_a), std::abs(sum_b), std::abs(sum_c)});
    const double scale = largest > 1e-290 ? 1 / largest : 0.0;
    near_a = static_cast<float>(sum_a * scale);
    near_b = static_cast<float>(sum_b * scale);
    near_c = static_cast<float>(sum_c * scale);
  }
};

HWY_NOINLINE RowBits settle_doubts(const ProjectedMesh& projected, const BinEntry& entry,
                                   std::span<const FacetCut> cuts, int x0, int y, RowBits doubtful) {
  RowBits covered = 0;
  for (; doubtful != 0; doubtful &= doubtful - 1) {
    const int x = std::countr_zero(doubtful);
    if (covers_pixel(projected, entry.facet, entry.facing(), cuts, x0 + x, y)) covered |= RowBits{1} << x;
  }
  return covered;
}

// The part of a row that is not nearer than the near plane.
HWY_NOINLINE RowBits beyond_near(const TileEdges& edges, int y) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto row = hn::Set(d, edges.near_b * static_cast<float>(y) + edges.near_c);
  RowBits bits = 0;
  for (int x = 0; x < tile_size; x += lanes) {
    const auto beyond = hn::Add(hn::Mul(hn::Set(d, edges.near_a), hn::Iota(d, static_cast<float>(x))), row);
    bits |= bits_of(hn::Ge(beyond, hn::Zero(d))) << x;
  }
  return bits;
}

// One row of an entry whose pixels are found by edges. `box`: its columns.
HWY_INLINE RowBits covered_row(const ProjectedMesh& projected, const BinEntry& entry, const TileEdges& edges,
                               RowBits box, int x0, int y0, int y) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const float dy = static_cast<float>(y - edges.origin_y);
  const auto row0 = hn::Set(d, edges.b[0] * dy + edges.c[0]);
  const auto row1 = hn::Set(d, edges.b[1] * dy + edges.c[1]);
  const auto row2 = hn::Set(d, edges.b[2] * dy + edges.c[2]);
  RowBits covered = 0, possible = 0;
  for (int x = static_cast<int>(entry.x0) / lanes * lanes; x <= static_cast<int>(entry.x1); x += lanes) {
    const auto dx = hn::Iota(d, static_cast<float>(x - edges.origin_x));
    const auto e0 = hn::Add(hn::Mul(hn::Set(d, edges.a[0]), dx), row0);
    const auto e1 = hn::Add(hn::Mul(hn::Set(d, edges.a[1]), dx), row1);
    const auto e2 = hn::Add(hn::Mul(hn::Set(d, edges.a[2]), dx), row2);
    auto lowest = hn::Min(hn::Min(e0, e1), e2);
    for (int i = 3; i < edges.lines; ++i) {
      const auto row = hn::Set(d, edges.b[i] * dy + edges.c[i]);
      lowest = hn::Min(lowest, hn::Add(hn::Mul(hn::Set(d, edges.a[i]), dx), row));
    }
    possible |= bits_of(hn::Ge(lowest, hn::Set(d, -edges.error))) << x;
    covered |= bits_of(hn::Gt(lowest, hn::Set(d, edges.error))) << x;
  }
  covered &= box;
  const RowBits doubtful = possible & box & ~covered;
  if (HWY_UNLIKELY(doubtful != 0)) covered |= settle_doubts(projected, entry, edges.cuts, x0, y0 + y, doubtful);
  return covered;
}

// Calls emit(y, bits) for each row of the tile in which the facet or piece covers some pixels.
template <typename Emit>
HWY_INLINE void for_covered_rows(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry, int x0,
                                 int y0, const Emit& emit) {
  if (entry.how() == Coverage::known) {
    int y = static_cast<int>(entry.y0);
    for (PixelSquare square = entry.detail; square != 0; square >>= square_size, ++y) {
      const RowBits bits = static_cast<RowBits>(square & first_rows(1)) << entry.x0;
      if (bits != 0) emit(y, bits);
    }
    return;
  }
  TileEdges edges;
  if (!edges.set_up(projected, bins, entry, x0, y0)) return;
  const RowBits box = bits_between(entry.x0, entry.x1);
  const bool covers_box = edges.cover_box(entry);
  for (int y = static_cast<int>(entry.y0); y <= static_cast<int>(entry.y1); ++y) {
    RowBits bits = covers_box ? box : covered_row(projected, entry, edges, box, x0, y0, y);
    if (entry.crosses_near && bits != 0) bits &= beyond_near(edges, y);
    if (bits != 0) emit(y, bits);
  }
}

// The same as emit(x, y, mask) for each vector of pixels from (x, y) to the right of which some are covered.
template <typename Emit>
HWY_INLINE void for_covered_vectors(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry,
                                    int x0, int y0, const Emit& emit) {
  const int lanes = static_cast<int>(hn::Lanes(FloatTag()));
  const RowBits all_lanes = ~RowBits{0} >> (tile_size - lanes);
  for_covered_rows(projected, bins, entry, x0, y0, [&](int y, RowBits bits) HWY_ATTR {
    for (int x = 0; x < tile_size; x += lanes) {
      const RowBits part = bits >> x & all_lanes;
      if (part != 0) emit(x, y, mask_of(part));
    }
  });
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
