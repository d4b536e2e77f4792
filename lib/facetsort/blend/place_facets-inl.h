// Internal to blend: where each facet lies in the picture and, of small ones, which pixels they cover. One facet a
// lane.
//
// Where all corners of a facet are on the grid, the sign of an edge function is that of the cross product of the edge
// and the way from its start to the pixel, in distances on the screen. What grid_error() leaves in doubt is decided by
// covers_pixel().
#if defined(FACETSORT_BLEND_PLACE_FACETS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_PLACE_FACETS_INL_H
#undef FACETSORT_BLEND_PLACE_FACETS_INL_H
#else
#define FACETSORT_BLEND_PLACE_FACETS_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "facetsort/blend/coverage.h"
#include "facetsort/blend/facet_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using GridFloatTag = hn::CappedTag<float, facets_per_block>;
using GridTag = hn::RebindToSigned<GridFloatTag>;
using SquareTag = hn::RebindToUnsigned<GridFloatTag>;
using GridFloats = hn::VFromD<GridFloatTag>;
using GridInts = hn::VFromD<GridTag>;
using HalfSquares = hn::VFromD<SquareTag>;

struct GridCorners {
  HWY_ALIGN std::int32_t x[3][facets_per_block], y[3][facets_per_block];

  void gather(const ProjectedMesh& projected, std::size_t first, std::size_t count) {
    const glm::uvec3* triangles = projected.mesh.triangles.data() + first;
    const GridPoint* points = projected.grid_points.data();
    for (std::size_t k = 0; k < count; ++k) {
      for (int i = 0; i < 3; ++i) {
        const GridPoint point = points[triangles[k][i]];
        x[i][k] = point.x;
        y[i][k] = point.y;
      }
    }
    for (std::size_t k = count; k < facets_per_block; ++k) {
      for (int i = 0; i < 3; ++i) x[i][k] = y[i][k] = off_grid;
    }
  }
};

// What vectors find out about facets.
struct BlockPlaces {
  HWY_ALIGN std::int32_t coverage[facets_per_block];    // as Coverage
  HWY_ALIGN std::int32_t area_signs[facets_per_block];  // below 0: front
  HWY_ALIGN std::int32_t x[facets_per_block], y[facets_per_block], width[facets_per_block], height[facets_per_block];
  // Of small facets: pixels covered for certain, and those not certainly uncovered; rows 0 to 3, then 4 to 7.
  HWY_ALIGN std::uint32_t covered[2][facets_per_block], possible[2][facets_per_block];

  PixelSquare square(const std::uint32_t (&halves)[2][facets_per_block], std::size_t k) const {
    return halves[0][k] | PixelSquare{halves[1][k]} << 32;
  }
};

HWY_INLINE GridFloats in_pixels(GridInts units) {
  constexpr float pixels_per_unit = 1.0f / (1 << grid_bits);
  return hn::Mul(hn::ConvertTo(GridFloatTag(), units), hn::Set(GridFloatTag(), pixels_per_unit));
}

// An edge function at the first pixel of a facet's box, and its steps from pixel to pixel.
struct EdgeWalk {
  GridFloats value, step_x, step_y;

  // From corner p to corner q; `orientation` is that of the facet, +1 or -1; (x, y) is the pixel's centre.
  HWY_INLINE EdgeWalk(GridInts px, GridInts py, GridInts qx, GridInts qy, GridFloats orientation, GridInts x,
                      GridInts y)
      : value(), step_x(), step_y() {
    step_y = hn::Mul(in_pixels(hn::Sub(qx, px)), orientation);
    const GridFloats rise = hn::Mul(in_pixels(hn::Sub(qy, py)), orientation);
    value = hn::Sub(hn::Mul(step_y, in_pixels(hn::Sub(y, py))), hn::Mul(rise, in_pixels(hn::Sub(x, px))));
    step_x = hn::Neg(rise);
  }
};

// Coverage of half a square: up to four rows of up to `width` pixels. Leaves the edges at the row after.
HWY_INLINE void cover_half(EdgeWalk& e0, EdgeWalk& e1, EdgeWalk& e2, GridFloats error, int width, int height,
                           std::uint32_t* covered_out, std::uint32_t* possible_out) {
  const SquareTag du;
  HalfSquares covered = hn::Zero(du), possible = hn::Zero(du);
  const GridFloats minus_error = hn::Neg(error);
  for (int row = 0; row < height; ++row) {
    GridFloats value0 = e0.value, value1 = e1.value, value2 = e2.value;
    HalfSquares bit = hn::Set(du, 1u << (square_size * row));
    for (int column = 0; column < width; ++column) {
      const GridFloats lowest = hn::Min(hn::Min(value0, value1), value2);
      covered = hn::Or(covered, hn::And(bit, hn::VecFromMask(du, hn::RebindMask(du, hn::Gt(lowest, error)))));
      possible = hn::Or(possible, hn::And(bit, hn::VecFromMask(du, hn::RebindMask(du, hn::Ge(lowest, minus_error)))));
      value0 = hn::Add(value0, e0.step_x);
      value1 = hn::Add(value1, e1.step_x);
      value2 = hn::Add(value2, e2.step_x);
      bit = hn::ShiftLeft<1>(bit);
    }
    e0.value = hn::Add(e0.value, e0.step_y);
    e1.value = hn::Add(e1.value, e1.step_y);
    e2.value = hn::Add(e2.value, e2.step_y);
  }
  hn::Store(covered, du, covered_out);
  hn::Store(possible, du, possible_out);
}

// A vector of facets from the k-th of the block on.
HWY_INLINE void place_vector(const GridCorners& corners, const View& view, std::size_t k, BlockPlaces& places) {
  const GridTag d;
  const GridFloatTag df;
  const GridInts x0 = hn::Load(d, corners.x[0] + k), y0 = hn::Load(d, corners.y[0] + k);
  const GridInts x1 = hn::Load(d, corners.x[1] + k), y1 = hn::Load(d, corners.y[1] + k);
  const GridInts x2 = hn::Load(d, corners.x[2] + k), y2 = hn::Load(d, corners.y[2] + k);
  const GridInts lowest_x = hn::Min(hn::Min(x0, x1), x2), highest_x = hn::Max(hn::Max(x0, x1), x2);
  const GridInts lowest_y = hn::Min(hn::Min(y0, y1), y2), highest_y = hn::Max(hn::Max(y0, y1), y2);
  const auto on_grid = hn::Ne(lowest_x, hn::Set(d, off_grid));

  // The first and last pixels with centres between the corners, give or take a unit.
  constexpr std::int32_t half_pixel = 1 << (grid_bits - 1);
  const auto first_pixel = [&](GridInts lowest) HWY_ATTR {
    return hn::ShiftRight<grid_bits>(hn::Add(lowest, hn::Set(d, half_pixel - 2)));
  };
  const auto last_pixel = [&](GridInts highest) HWY_ATTR {
    return hn::ShiftRight<grid_bits>(hn::Sub(highest, hn::Set(d, half_pixel - 1)));
  };
  const GridInts left = first_pixel(lowest_x), right = last_pixel(highest_x);
  const GridInts top = first_pixel(lowest_y), bottom = last_pixel(highest_y);
  const GridInts one = hn::Set(d, 1), zero = hn::Zero(d);
  const GridInts x = hn::Max(left, zero), y = hn::Max(top, zero);
  const GridInts width = hn::Sub(hn::Add(hn::Min(right, hn::Set(d, view.width - 1)), one), x);
  const GridInts height = hn::Sub(hn::Add(hn::Min(bottom, hn::Set(d, view.height - 1)), one), y);
  const auto empty = hn::Lt(hn::Min(width, height), one);

  const GridFloats extents =
      hn::Add(hn::Add(in_pixels(hn::Sub(highest_x, lowest_x)), in_pixels(hn::Sub(highest_y, lowest_y))),
              hn::Set(df, grid_extents_slack));
  const GridFloats error = hn::Mul(
      extents, hn::Add(hn::Set(df, grid_error_of_extents), hn::Mul(extents, hn::Set(df, grid_error_of_square))));
  const GridFloats area = hn::Sub(hn::Mul(in_pixels(hn::Sub(x1, x0)), in_pixels(hn::Sub(y2, y0))),
                                  hn::Mul(in_pixels(hn::Sub(x2, x0)), in_pixels(hn::Sub(y1, y0))));
  const auto facing_is_certain = hn::RebindMask(d, hn::Gt(hn::Abs(area), error));

  const auto as_lanes = [&](Coverage coverage) HWY_ATTR { return hn::Set(d, static_cast<std::int32_t>(coverage)); };
  const GridInts pixels_across = hn::Max(hn::Sub(right, left), hn::Sub(bottom, top));
  const auto is_small = hn::Lt(pixels_across, hn::Set(d, square_size));
  GridInts coverage = hn::IfThenElse(is_small, as_lanes(Coverage::known), as_lanes(Coverage::grid));
  coverage = hn::IfThenElse(facing_is_certain, coverage, as_lanes(Coverage::homogeneous));
  coverage = hn::IfThenElse(empty, as_lanes(Coverage::none), coverage);
  coverage = hn::IfThenElse(on_grid, coverage, as_lanes(Coverage::homogeneous));
  hn::Store(coverage, d, places.coverage + k);
  hn::Store(hn::BitCast(d, area), d, places.area_signs + k);
  hn::Store(x, d, places.x + k);
  hn::Store(y, d, places.y + k);
  hn::Store(width, d, places.width + k);
  hn::Store(height, d, places.height + k);

  const auto is_known = hn::Eq(coverage, as_lanes(Coverage::known));
  const int columns = hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(is_known, width)));
  const int rows = hn::GetLane(hn::MaxOfLanes(d, hn::IfThenElseZero(is_known, height)));
  const GridFloats orientation = hn::CopySign(hn::Set(df, 1.0f), area);
  const GridInts centre_x = hn::Add(hn::ShiftLeft<grid_bits>(x), hn::Set(d, half_pixel));
  const GridInts centre_y = hn::Add(hn::ShiftLeft<grid_bits>(y), hn::Set(d, half_pixel));
  EdgeWalk e0(x1, y1, x2, y2, orientation, centre_x, centre_y);
  EdgeWalk e1(x2, y2, x0, y0, orientation, centre_x, centre_y);
  EdgeWalk e2(x0, y0, x1, y1, orientation, centre_x, centre_y);
  constexpr int half = square_size / 2;
  cover_half(e0, e1, e2, error, columns, std::min(rows, half), places.covered[0] + k, places.possible[0] + k);
  cover_half(e0, e1, e2, error, columns, std::max(rows - half, 0), places.covered[1] + k, places.possible[1] + k);
}

// Where a corner is off the grid, or the facet is too thin to see on it which way it faces.
HWY_NOINLINE PlacedFacet place_beside_grid(const ProjectedMesh& projected, std::uint32_t facet) {
  const PixelBox box = facet_pixels(projected, facet);
  if (box.empty()) return PlacedFacet::nothing();
  const int facing = facet_facing(projected, facet);
  return facing == 0 ? PlacedFacet::nothing() : PlacedFacet::with_box(Coverage::homogeneous, box, facing);
}

PixelSquare settle_doubts(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y,
                          PixelSquare doubtful) {
  PixelSquare covered = 0;
  for (; doubtful != 0; doubtful &= doubtful - 1) {
    const int bit = std::countr_zero(doubtful);
    if (covers_pixel(projected, facet, facing, {}, x + bit % square_size, y + bit / square_size)) {
      covered |= PixelSquare{1} << bit;
    }
  }
  return covered;
}

PlacedFacet place_facet(const ProjectedMesh& projected, std::uint32_t facet, const BlockPlaces& places, std::size_t k) {
  const Coverage coverage = static_cast<Coverage>(places.coverage[k]);
  if (coverage == Coverage::none) return PlacedFacet::nothing();
  if (coverage == Coverage::homogeneous) return place_beside_grid(projected, facet);
  const int facing = places.area_signs[k] < 0 ? 1 : -1;
  const int x = places.x[k], y = places.y[k], width = places.width[k], height = places.height[k];
  if (coverage == Coverage::grid) {
    return PlacedFacet::with_box(Coverage::grid, {x, y, x + width - 1, y + height - 1}, facing);
  }
  const PixelSquare box = first_columns(width) & first_rows(height);
  PixelSquare covered = places.square(places.covered, k) & box;
  const PixelSquare doubtful = places.square(places.possible, k) & box & ~covered;
  if (HWY_UNLIKELY(doubtful != 0)) covered |= settle_doubts(projected, facet, facing, x, y, doubtful);
  return covered != 0 ? PlacedFacet::with_pixels(x, y, facing, covered) : PlacedFacet::nothing();
}

void PlaceFacets(const ProjectedMesh& projected, std::size_t begin, std::size_t end, PlacedFacet* placed) {
  GridCorners corners;
  BlockPlaces places;
  for (std::size_t first = begin; first < end; first += facets_per_block) {
    const std::size_t count = std::min(facets_per_block, end - first);
    corners.gather(projected, first, count);
    for (std::size_t k = 0; k < count; k += hn::Lanes(GridTag())) place_vector(corners, projected.view, k, places);
    for (std::size_t k = 0; k < count; ++k) {
      *placed++ = place_facet(projected, static_cast<std::uint32_t>(first + k), places, k);
    }
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
