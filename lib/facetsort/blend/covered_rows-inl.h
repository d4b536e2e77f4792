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
#include <utility>

#include "facetsort/blend/bins.h"
#include "facetsort/blend/coverage.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, tile_size>;

// A row of a tile, pixel x at bit x.
using RowBits = std::uint32_t;
static_assert(tile_size == 32);

// None where the last one comes before the first. 0 <= first <= 32 and -1 <= last < 32.
HWY_INLINE RowBits bits_between(int first, int last) {
  const std::uint64_t up_to_last = (std::uint64_t{1} << (last + 1)) - 1, before_first = (std::uint64_t{1} << first) - 1;
  return static_cast<RowBits>(up_to_last & ~before_first);
}

HWY_INLINE hn::Mask<FloatTag> mask_of(RowBits bits) {
  alignas(8) std::uint8_t bytes[8] = {};
  std::memcpy(bytes, &bits, sizeof bits);
  return hn::LoadMaskBits(FloatTag(), bytes);
}

HWY_INLINE RowBits bits_of(hn::Mask<FloatTag> mask) {
  alignas(8) std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(FloatTag(), mask, bytes);
  RowBits bits = 0;
  std::memcpy(&bits, bytes, sizeof bits);
  return bits;
}

// The line functions that bound one facet or piece in one tile, in float: a dx + b dy + c for the pixel that is dx
// and dy away from (origin_x, origin_y). A pixel of the entry's box is covered where every one exceeds `error`, and is
// not where one is below -error; between, float can't tell. `error` also allows for dividing by `a`, to solve for dx.
struct TileLines {
  // A piece that has more cuts in one tile is decided pixel by pixel.
  static constexpr int most_cuts = 16;

  float a[3 + most_cuts], b[3 + most_cuts], c[3 + most_cuts], error;
  int count;  // three edges, then cuts
  int origin_x, origin_y;
  float near_a = 0, near_b = 0, near_c = 0;  // from the tile's first pixel: not negative beyond the near plane
  std::span<const FacetCut> cuts;            // all of the piece's

  // False when nothing is covered in the entry's box. (x0, y0) is the tile's first pixel.
  HWY_INLINE bool set_up(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry, int x0, int y0) {
    if (entry.how() != Coverage::grid) return set_up_homogeneous(projected, bins, entry, x0, y0);
    set_up_on_grid(projected, entry, x0, y0);
    return true;
  }

 private:
  // Edge functions of points on the grid. All that is multiplied are distances within the facet's box.
  HWY_INLINE void set_up_on_grid(const ProjectedMesh& projected, const BinEntry& entry, int x0, int y0) {
    constexpr double pixels_per_unit = 1.0 / (1 << grid_bits);
    const glm::uvec3& triangle = projected.mesh.triangles[entry.facet];
    origin_x = static_cast<int>(entry.x0);
    origin_y = static_cast<int>(entry.y0);
    // From the origin's centre, in pixels; these and the differences below are exact in double.
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
    count = 3;
    cuts = {};
    const double width = std::max(std::max(x[0], x[1]), x[2]) - std::min(std::min(x[0], x[1]), x[2]);
    const double height = std::max(std::max(y[0], y[1]), y[2]) - std::min(std::min(y[0], y[1]), y[2]);
    error = grid_error(static_cast<float>(width + height));
  }

  // From edge functions in double, scaled to change by at most 1 a pixel.
  HWY_NOINLINE bool set_up_homogeneous(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry,
                                       int x0, int y0) {
    const FacetEdges exact = facet_edges(projected, entry.facet, entry.facing(), {x0 + 0.5, y0 + 0.5}, tile_size);
    origin_x = origin_y = 0;
    double largest_error = 0;
    for (count = 0; count < 3; ++count) {
      largest_error =
          std::max(largest_error, set_up_line(exact.a[count], exact.b[count], exact.c[count], exact.error[count]));
    }
    cuts = bins.cuts(entry);
    if (!cuts.empty() && !set_up_cuts(exact, entry, largest_error)) return false;
    error = float_bound(largest_error);
    if (entry.crosses_near) set_up_near(projected, exact, entry);
    return true;
  }

  static float float_bound(double line_error) {
    // In float: a dozen roundings of terms that together stay below 4 tile_size.
    constexpr double float_error = 48 * tile_size * 0x1p-24;
    return static_cast<float>(std::min(line_error + float_error, 4.0 * tile_size));
  }

  // The line whose place is next; returns its error after scaling.
  double set_up_line(double line_a, double line_b, double line_c, double line_error) {
    const double slope = std::abs(line_a) + std::abs(line_b);
    // Where the slope is below what a double can divide by, everything is in doubt.
    const double scale = slope > 1e-290 ? 1 / slope : 0.0;
    a[count] = static_cast<float>(line_a * scale);
    b[count] = static_cast<float>(line_b * scale);
    // An edge that far from the tile has one sign on all of it.
    c[count] = static_cast<float>(std::clamp(line_c * scale, -2.0 * tile_size, 2.0 * tile_size));
    return scale > 0 ? line_error * scale : 1.0;
  }

  // The smallest and largest value of the line whose place is next, in the entry's box.
  std::pair<float, float> range(const BinEntry& entry) const {
    const auto [left, right] =
        std::minmax({a[count] * static_cast<float>(entry.x0), a[count] * static_cast<float>(entry.x1)});
    const auto [top, bottom] =
        std::minmax({b[count] * static_cast<float>(entry.y0), b[count] * static_cast<float>(entry.y1)});
    return {c[count] + left + top, c[count] + right + bottom};
  }

  // Cuts that leave all of the entry's box do not become lines. False when one leaves none of it.
  HWY_NOINLINE bool set_up_cuts(const FacetEdges& exact, const BinEntry& entry, double& largest_error) {
    for (const FacetCut& cut : cuts) {
      if (count == 3 + most_cuts) {
        largest_error = 4 * tile_size;  // no float value is certain
        return true;
      }
      const CutLine line = cut_line(exact, cut.measured, tile_size);
      const double line_error = set_up_line(line.a, line.b, line.c, line.error);
      const float bound = 2 * float_bound(line_error);
      const auto [lowest, highest] = range(entry);
      if (highest < -bound) return false;
      if (lowest > bound) continue;
      largest_error = std::max(largest_error, line_error);
      ++count;
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
HWY_NOINLINE RowBits beyond_near(const TileLines& lines, int y) {
  const float row = lines.near_b * static_cast<float>(y) + lines.near_c;
  RowBits bits = 0;
  for (int x = 0; x < tile_size; ++x) {
    if (lines.near_a * static_cast<float>(x) + row >= 0) bits |= RowBits{1} << x;
  }
  return bits;
}

// For each row of an entry's box, the first and last pixel covered for certain, and the first and last that may be.
// What is covered is convex, so those between are too.
struct RowSpans {
  HWY_ALIGN std::int32_t covered_first[tile_size], covered_last[tile_size];
  HWY_ALIGN std::int32_t possible_first[tile_size], possible_last[tile_size];
  bool are_certain;  // all pixels that may be covered are

  // One row a lane: each line bounds the covered pixels of a row on its left or on its right.
  HWY_INLINE void find(const TileLines& lines, const BinEntry& entry) {
    const FloatTag d;
    const hn::RebindToSigned<FloatTag> di;
    // A line that changes less within a tile counts as one that changes so: the bound on the error has room for that.
    constexpr float least_slope = 1e-12f;
    const int rows = static_cast<int>(entry.y1 - entry.y0) + 1;
    const auto box_first = hn::Set(d, static_cast<float>(static_cast<int>(entry.x0) - lines.origin_x));
    const auto box_last = hn::Set(d, static_cast<float>(static_cast<int>(entry.x1) - lines.origin_x));
    const auto origin_x = hn::Set(di, lines.origin_x);
    are_certain = true;
    for (int k = 0; k < rows; k += static_cast<int>(hn::Lanes(d))) {
      const int top = static_cast<int>(entry.y0) + k - lines.origin_y;
      const auto y = hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<float>(top)));
      auto covered_from = box_first, covered_to = box_last, possible_from = box_first, possible_to = box_last;
      for (int i = 0; i < lines.count; ++i) {
        const float slope = std::abs(lines.a[i]) < least_slope ? least_slope : lines.a[i];
        const float inverse = 1 / slope;
        const auto crossing = hn::Sub(hn::Mul(hn::Set(d, -lines.b[i] * inverse), y), hn::Set(d, lines.c[i] * inverse));
        const auto doubt = hn::Set(d, lines.error * std::abs(inverse));
        const auto before = hn::Sub(crossing, doubt), after = hn::Add(crossing, doubt);
        // Which side a line bounds can't be foreseen: both are always moved, one of them by nothing.
        const auto is_left = hn::Gt(hn::Set(d, slope), hn::Zero(d));
        covered_from = hn::Max(covered_from, hn::IfThenElse(is_left, after, box_first));
        possible_from = hn::Max(possible_from, hn::IfThenElse(is_left, before, box_first));
        covered_to = hn::Min(covered_to, hn::IfThenElse(is_left, box_last, before));
        possible_to = hn::Min(possible_to, hn::IfThenElse(is_left, box_last, after));
      }
      // Within a pixel of the box, so that they are small integers.
      const auto first = [&](hn::VFromD<FloatTag> from) HWY_ATTR {
        const auto end = hn::Add(box_last, hn::Set(d, 1.0f));
        return hn::Add(hn::ConvertTo(di, hn::Ceil(hn::Min(from, end))), origin_x);
      };
      const auto last = [&](hn::VFromD<FloatTag> to) HWY_ATTR {
        const auto before_box = hn::Sub(box_first, hn::Set(d, 1.0f));
        return hn::Add(hn::ConvertTo(di, hn::Floor(hn::Max(to, before_box))), origin_x);
      };
      const auto from = first(covered_from), to = last(covered_to);
      const auto least = first(possible_from), most = last(possible_to);
      hn::Store(from, di, covered_first + k);
      hn::Store(to, di, covered_last + k);
      hn::Store(least, di, possible_first + k);
      hn::Store(most, di, possible_last + k);
      are_certain &= hn::AllTrue(di, hn::And(hn::Eq(from, least), hn::Eq(to, most)));
    }
  }

  HWY_INLINE RowBits covered(int k) const { return bits_between(covered_first[k], covered_last[k]); }
  HWY_INLINE RowBits possible(int k) const { return bits_between(possible_first[k], possible_last[k]); }
};

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
  TileLines lines;
  if (!lines.set_up(projected, bins, entry, x0, y0)) return;
  RowSpans spans;
  spans.find(lines, entry);
  for (int y = static_cast<int>(entry.y0), k = 0; y <= static_cast<int>(entry.y1); ++y, ++k) {
    RowBits bits = spans.covered(k);
    if (HWY_UNLIKELY(!spans.are_certain)) {
      const RowBits doubtful = spans.possible(k) & ~bits;
      bits |= settle_doubts(projected, entry, lines.cuts, x0, y0 + y, doubtful);
    }
    if (entry.crosses_near && bits != 0) bits &= beyond_near(lines, y);
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
