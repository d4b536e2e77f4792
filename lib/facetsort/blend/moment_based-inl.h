// Internal to blend: moment-based order-independent transparency, in one tile.
//
// Muenstermann, Krumpen, Klein and Peters, "Moment-Based Order-Independent Transparency", Proceedings of the ACM on
// Computer Graphics and Interactive Techniques 1 (1), 2018, with power moments. The first pass sums the absorbance
// -log(1 - alpha) of a pixel's layers and its moments, the sums of absorbance z^j, j = 1..4 or 6, with z the warped
// depth. The second adds each fragment's colour by its transmittance e^-A, A being what absorbs in front of it: of all
// sums of points that have these moments, one of which is at the fragment's depth, the points before it and a quarter
// of the one at it. The points are roots of the kernel polynomial, as in Peters and Klein, "Moment Shadow Mapping"
// (2015).
//
// Moments are kept in float, and points are found in double: their own rounding would otherwise exceed the bias.
#if defined(FACETSORT_BLEND_MOMENT_BASED_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_MOMENT_BASED_INL_H
#undef FACETSORT_BLEND_MOMENT_BASED_INL_H
#else
#define FACETSORT_BLEND_MOMENT_BASED_INL_H
#endif

#include <cmath>
#include <cstddef>

#include "facetsort/blend/average_colour-inl.h"
#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"
#include "facetsort/blend/vector_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using DoubleTag = hn::CappedTag<double, tile_size>;
using DoubleVector = hn::VFromD<DoubleTag>;

// Of what lies at the fragment's own depth, the share that counts as before it (the paper's overestimation).
constexpr double own_share = 0.25;
// An opaque layer's absorbance would be infinite: none absorbs more than this, the paper's limit; e^-10.
constexpr float least_transparency = 4.53999298e-5f;

// Moments moved a little towards those of a measure that is not a sum of few points, so that rounding can't make them
// impossible: the paper's, for moments in float.
template <int moments>
struct MomentBias;
template <>
struct MomentBias<4> {
  static constexpr double share = 5e-7, towards[] = {0, 0.375, 0, 0.375};
};
template <>
struct MomentBias<6> {
  static constexpr double share = 5e-6, towards[] = {0, 0.48, 0, 0.451, 0, 0.45};
};

// Squared norms of the orthogonal polynomials are at least the share times those of the measure above, but for
// rounding.
template <int moments>
constexpr double least_norm = 0.02 * MomentBias<moments>::share;

// A point at infinity has no weight; one that is this far has none that shows.
constexpr double farthest_point = 1e6;

template <int moments>
struct MomentTile {
  TilePlane absorbance, moment[moments];
};

// Depth between the range's nearest and farthest as z from -1 to 1: by its logarithm in perspective, as the paper warps
// it, and linearly in orthographic views, where depth has no zero.
struct DepthWarp {
  float nearest, scale;  // nearest: as ScreenDepth has it
  bool is_logarithmic;

  explicit DepthWarp(const DepthRange& range)
      : nearest(range.screen_depth(range.nearest)), is_logarithmic(range.perspective) {
    const double extent = is_logarithmic ? std::log(static_cast<double>(range.farthest) / range.nearest)
                                         : static_cast<double>(range.farthest) - range.nearest;
    scale = extent > 0 ? static_cast<float>(2 / extent) : 0.0f;
  }

  HWY_INLINE hn::VFromD<FloatTag> operator()(hn::VFromD<FloatTag> depth) const {
    const FloatTag d;
    const auto one = hn::Set(d, 1.0f), first = hn::Set(d, nearest);
    // Logarithms of distances over the nearest one: their rounding does not depend on the unit of length.
    const auto beyond = is_logarithmic ? log_of(d, hn::Max(hn::Div(first, depth), one)) : hn::Sub(depth, first);
    return hn::Clamp(hn::Sub(hn::Mul(beyond, hn::Set(d, scale)), one), hn::Neg(one), one);
  }
};

template <bool vertex_colours, int moments>
void sum_moments(const TileTask& task, const DepthWarp& warp, int tile, MomentTile<moments>& sums) {
  const FloatTag d;
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto transparency = hn::Sub(hn::Set(d, 1.0f), alpha_of<vertex_colours>(paint, x, y));
        const auto z = warp(depth);
        auto term = hn::IfThenElseZero(mask, hn::Neg(log_of(d, hn::Max(transparency, hn::Set(d, least_transparency)))));
        const auto add = [&](TilePlane& plane) HWY_ATTR {
          hn::Store(hn::Add(hn::Load(d, plane.pixel + pixel), term), d, plane.pixel + pixel);
        };
        add(sums.absorbance);
        for (int j = 0; j < moments; ++j) {
          term = hn::Mul(term, z);
          add(sums.moment[j]);
        }
      });
}

HWY_INLINE DoubleVector bounded_point(DoubleVector point) {
  const DoubleTag d;
  return hn::Clamp(point, hn::Set(d, -farthest_point), hn::Set(d, farthest_point));
}

// Of a x^2 + b x + c, which has two real roots; without a sum of terms of different signs. One is at infinity where a
// is 0, or nearly.
HWY_INLINE void roots_of_quadratic(DoubleVector a, DoubleVector b, DoubleVector c, DoubleVector& low,
                                   DoubleVector& high) {
  const DoubleTag d;
  const auto half = hn::Mul(hn::Set(d, 0.5), b);
  const auto root = hn::Sqrt(hn::Max(hn::Sub(hn::Mul(half, half), hn::Mul(a, c)), hn::Zero(d)));
  const auto q = hn::Neg(hn::Add(half, hn::CopySign(root, half)));
  const auto apart_from_0 = [&](DoubleVector value) HWY_ATTR {
    const auto tiny = hn::Set(d, 1e-200);
    return hn::IfThenElse(hn::Lt(hn::Abs(value), tiny), hn::CopySign(tiny, value), value);
  };
  const auto first = bounded_point(hn::Div(q, apart_from_0(a)));
  const auto second = bounded_point(hn::Div(c, apart_from_0(q)));
  low = hn::Min(first, second);
  high = hn::Max(first, second);
}

// Of a x^3 + b x^2 + c x + e, which has three real roots, by Viete's trigonometric solution.
HWY_INLINE void roots_of_cubic(DoubleVector a, DoubleVector b, DoubleVector c, DoubleVector e, DoubleVector& low,
                               DoubleVector& middle, DoubleVector& high) {
  const DoubleTag d;
  const auto one = hn::Set(d, 1.0), half = hn::Set(d, 0.5), third = hn::Set(d, 1.0 / 3);
  // No root is farther than farthest_point, or one is at infinity: a is at least so large beside the other
  // coefficients.
  const auto others = hn::Max(hn::Abs(b), hn::Max(hn::Abs(c), hn::Abs(e)));
  const auto least = hn::Max(hn::Mul(others, hn::Set(d, 1 / farthest_point)), hn::Set(d, 1e-200));
  const auto inverse = hn::Div(one, hn::CopySign(hn::Max(hn::Abs(a), least), a));
  // x^3 + 3 B x^2 + 3 C x + E; with x = y - B: y^3 - 3 P y + 2 R.
  const auto B = hn::Mul(hn::Mul(b, inverse), third), C = hn::Mul(hn::Mul(c, inverse), third);
  const auto E = hn::Mul(e, inverse);
  const auto P = hn::Max(hn::Sub(hn::Mul(B, B), C), hn::Set(d, 1e-200));
  const auto R = hn::Add(hn::Mul(B, hn::Sub(hn::Mul(B, B), hn::Mul(hn::Set(d, 1.5), C))), hn::Mul(half, E));
  const auto radius = hn::Sqrt(P);
  const auto cosine = hn::Clamp(hn::Neg(hn::Div(R, hn::Mul(P, radius))), hn::Neg(one), one);
  const auto x = cosine_of_third(d, cosine);
  const auto sine = hn::Sqrt(hn::Max(hn::Sub(one, hn::Mul(x, x)), hn::Zero(d)));
  const auto aside = hn::Mul(hn::Set(d, 1.7320508075688772), sine);
  low = hn::Sub(hn::Mul(radius, hn::Neg(hn::Add(x, aside))), B);
  middle = hn::Sub(hn::Mul(radius, hn::Sub(aside, x)), B);
  high = hn::Sub(hn::Mul(radius, hn::Add(x, x)), B);
}

// The share of a measure that is before its point at z0, own_share of that included, from its moments; its total is 1.
HWY_INLINE DoubleVector share_before(DoubleVector z0, DoubleVector m1, DoubleVector m2, DoubleVector m3,
                                     DoubleVector m4) {
  const DoubleTag d;
  const auto least = hn::Set(d, least_norm<4>);
  // Orthogonal polynomials p1 = z - m1 and p2 = z^2 - m2 - s p1, and their squared norms.
  const auto norm1 = hn::Max(hn::Sub(m2, hn::Mul(m1, m1)), least);
  const auto s_norm1 = hn::Sub(m3, hn::Mul(m1, m2));
  const auto s = hn::Div(s_norm1, norm1);
  const auto norm2 = hn::Max(hn::Sub(hn::Sub(m4, hn::Mul(m2, m2)), hn::Mul(s, s_norm1)), least);
  const auto p1 = hn::Sub(z0, m1);
  const auto p2 = hn::Sub(hn::Sub(hn::Mul(z0, z0), m2), hn::Mul(s, p1));
  // The kernel 1 + p1(z0) p1(z) / norm1 + p2(z0) p2(z) / norm2, times norm2: one over its value at z0 is the weight
  // there, and the other points are its roots.
  const auto u = hn::Mul(p1, hn::Div(norm2, norm1));
  const auto weight0 = hn::Div(norm2, hn::Add(norm2, hn::Add(hn::Mul(u, p1), hn::Mul(p2, p2))));
  const auto b = hn::Sub(u, hn::Mul(s, p2));
  const auto c = hn::Sub(hn::Sub(norm2, hn::Mul(b, m1)), hn::Mul(p2, m2));
  DoubleVector low, high;
  roots_of_quadratic(p2, b, c, low, high);
  // The other points' weights: their sum, and that of weight times point, are known.
  const auto rest = hn::Sub(hn::Set(d, 1.0), weight0);
  const auto first = hn::Sub(m1, hn::Mul(weight0, z0));
  const auto weight_low = hn::Div(hn::Sub(hn::Mul(rest, high), first), hn::Sub(high, low));
  const auto before = hn::IfThenElseZero(hn::Lt(low, z0), hn::IfThenElse(hn::Lt(high, z0), rest, weight_low));
  return hn::Add(hn::Mul(hn::Set(d, own_share), weight0), before);
}

HWY_INLINE DoubleVector share_before(DoubleVector z0, DoubleVector m1, DoubleVector m2, DoubleVector m3,
                                     DoubleVector m4, DoubleVector m5, DoubleVector m6) {
  const DoubleTag d;
  const auto least = hn::Set(d, least_norm<6>);
  // Orthogonal polynomials p1 = z - m1, p2 = z^2 - m2 - s p1, p3 = z^3 - m3 - t p1 - r p2, and their squared norms.
  const auto norm1 = hn::Max(hn::Sub(m2, hn::Mul(m1, m1)), least);
  const auto s_norm1 = hn::Sub(m3, hn::Mul(m1, m2)), t_norm1 = hn::Sub(m4, hn::Mul(m1, m3));
  const auto s = hn::Div(s_norm1, norm1), t = hn::Div(t_norm1, norm1);
  const auto norm2 = hn::Max(hn::Sub(hn::Sub(m4, hn::Mul(m2, m2)), hn::Mul(s, s_norm1)), least);
  const auto r_norm2 = hn::Sub(hn::Sub(m5, hn::Mul(m2, m3)), hn::Mul(s, t_norm1));
  const auto r = hn::Div(r_norm2, norm2);
  const auto norm3 =
      hn::Max(hn::Sub(hn::Sub(hn::Sub(m6, hn::Mul(m3, m3)), hn::Mul(t, t_norm1)), hn::Mul(r, r_norm2)), least);
  const auto square = hn::Mul(z0, z0);
  const auto p1 = hn::Sub(z0, m1);
  const auto p2 = hn::Sub(hn::Sub(square, m2), hn::Mul(s, p1));
  const auto p3 = hn::Sub(hn::Sub(hn::Sub(hn::Mul(square, z0), m3), hn::Mul(t, p1)), hn::Mul(r, p2));
  // The kernel times norm3, as above: norm3 + u p1(z) + v p2(z) + p3(z0) p3(z).
  const auto u = hn::Mul(p1, hn::Div(norm3, norm1)), v = hn::Mul(p2, hn::Div(norm3, norm2));
  const auto weight0 =
      hn::Div(norm3, hn::Add(norm3, hn::Add(hn::Mul(u, p1), hn::Add(hn::Mul(v, p2), hn::Mul(p3, p3)))));
  const auto b = hn::Sub(v, hn::Mul(r, p3));
  const auto c = hn::Sub(hn::Sub(u, hn::Mul(t, p3)), hn::Mul(s, b));
  const auto e = hn::Sub(hn::Sub(hn::Sub(norm3, hn::Mul(c, m1)), hn::Mul(b, m2)), hn::Mul(p3, m3));
  DoubleVector low, middle, high;
  roots_of_cubic(p3, b, c, e, low, middle, high);
  // The other points' weights: their sum, and those of weight times point and times its square, are known.
  const auto rest = hn::Sub(hn::Set(d, 1.0), weight0);
  const auto first = hn::Sub(m1, hn::Mul(weight0, z0)), second = hn::Sub(m2, hn::Mul(weight0, square));
  const auto weight = [&](DoubleVector z, DoubleVector y, DoubleVector x) HWY_ATTR {
    const auto numerator = hn::Add(hn::Sub(second, hn::Mul(hn::Add(y, x), first)), hn::Mul(hn::Mul(y, x), rest));
    return hn::Div(numerator, hn::Mul(hn::Sub(z, y), hn::Sub(z, x)));
  };
  const auto without_high = hn::Sub(rest, weight(high, low, middle));
  const auto at_least_two = hn::IfThenElse(hn::Lt(high, z0), rest, without_high);
  const auto at_least_one = hn::IfThenElse(hn::Lt(middle, z0), at_least_two, weight(low, middle, high));
  return hn::Add(hn::Mul(hn::Set(d, own_share), weight0), hn::IfThenElseZero(hn::Lt(low, z0), at_least_one));
}

// Of what is in front of the fragments at warped depths z; any value where the mask is not set.
template <int moments>
HWY_INLINE hn::VFromD<FloatTag> transmittance_before(const MomentTile<moments>& sums, std::size_t pixel,
                                                     hn::VFromD<FloatTag> z, hn::Mask<FloatTag> mask) {
  using Bias = MomentBias<moments>;
  const FloatTag d;
  const DoubleTag dd;
  const hn::Rebind<float, DoubleTag> part;
  HWY_ALIGN float depths[tile_size], shares[tile_size];
  hn::Store(z, d, depths);
  hn::Store(hn::Zero(d), d, shares);
  const RowBits wanted = bits_of(mask), part_lanes = ~RowBits{0} >> (tile_size - hn::Lanes(dd));
  for (std::size_t lane = 0; lane < hn::Lanes(d); lane += hn::Lanes(dd)) {
    if ((wanted >> lane & part_lanes) == 0) continue;
    const auto load = [&](const float* values) HWY_ATTR { return hn::PromoteTo(dd, hn::Load(part, values + lane)); };
    const auto total = hn::Max(load(sums.absorbance.pixel + pixel), hn::Set(dd, 1e-30));
    const auto factor = hn::Div(hn::Set(dd, 1 - Bias::share), total);
    const auto moment = [&](int j) HWY_ATTR {
      return hn::Add(hn::Mul(load(sums.moment[j - 1].pixel + pixel), factor),
                     hn::Set(dd, Bias::share * Bias::towards[j - 1]));
    };
    const auto share = [&]() HWY_ATTR {
      if constexpr (moments == 4)
        return share_before(load(depths), moment(1), moment(2), moment(3), moment(4));
      else
        return share_before(load(depths), moment(1), moment(2), moment(3), moment(4), moment(5), moment(6));
    }();
    hn::Store(hn::DemoteTo(part, hn::Clamp(share, hn::Zero(dd), hn::Set(dd, 1.0))), part, shares + lane);
  }
  return exp_of(d, hn::Neg(hn::Mul(hn::Load(d, sums.absorbance.pixel + pixel), hn::Load(d, shares))));
}

template <bool vertex_colours, int moments>
void draw_moment_based(const TileTask& task, const DepthRange& range, int tile) {
  const FloatTag d;
  const DepthWarp warp(range);
  MomentTile<moments> sums;
  fill(sums.absorbance, 0);
  for (TilePlane& plane : sums.moment) fill(plane, 0);
  sum_moments<vertex_colours>(task, warp, tile, sums);

  TileColours colours;
  clear(colours, glm::vec4(0));
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto visible = hn::IfThenElseZero(mask, transmittance_before<moments>(sums, pixel, warp(depth), mask));
        blend_paint<vertex_colours>(paint, 1.0f, x, y,
                                    [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag>) HWY_ATTR {
                                      float* sum = colours.channel[channel].pixel + pixel;
                                      hn::Store(hn::Add(hn::Load(d, sum), hn::Mul(source, visible)), d, sum);
                                    });
      });
  TilePlane& transmittance = sums.absorbance;
  for (std::size_t pixel = 0; pixel < tile_size * tile_size; pixel += hn::Lanes(d)) {
    float* here = transmittance.pixel + pixel;
    hn::Store(exp_of(d, hn::Neg(hn::Load(d, here))), d, here);
  }
  write_average(task, colours, transmittance, tile);
}

void DrawMomentBased(const TileTask& task, const DepthRange& range, int moments, int tile) {
  if (task.colours.empty()) {
    return moments == 4 ? draw_moment_based<true, 4>(task, range, tile) : draw_moment_based<true, 6>(task, range, tile);
  }
  return moments == 4 ? draw_moment_based<false, 4>(task, range, tile) : draw_moment_based<false, 6>(task, range, tile);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
