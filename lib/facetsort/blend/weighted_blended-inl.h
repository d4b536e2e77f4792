// Internal to blend: weighted blended order-independent transparency, in one tile.
//
// McGuire and Bavoil, "Weighted Blended Order-Independent Transparency", Journal of Computer Graphics Techniques 2 (2),
// 2013. One pass sums colours and alphas with a weight that falls with the distance, and multiplies transparencies; the
// picture is the weighted average of the colours, as opaque as all layers together.
//
// The weight is the paper's equation (7), alpha times 10 / (1e-5 + (z / 5)^2 + (z / 200)^6) within [1e-2, 3e3]. The
// paper means units of scenes that reach to 500; it falls, nearly as 1 / z^2, from 0.3 to 158. Here the unit is the
// hundredth part of the distance along the camera axis to the mesh's farthest vertex, so that no mesh's unit of length
// matters. In orthographic views, which have no distance from an eye, the nearest vertex counts as half as far as the
// farthest. Equation (10), of a depth buffer's values, was tried between the nearest and the farthest vertex: of some
// meshes it shows hardly more than the nearest layer.
#if defined(FACETSORT_BLEND_WEIGHTED_BLENDED_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_WEIGHTED_BLENDED_INL_H
#undef FACETSORT_BLEND_WEIGHTED_BLENDED_INL_H
#else
#define FACETSORT_BLEND_WEIGHTED_BLENDED_INL_H
#endif

#include "facetsort/blend/average_colour-inl.h"
#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

constexpr float farthest_weighted = 100, nearest_weighted_orthographic = 50;

// z of the equation, from ScreenDepth.
struct WeightedDistance {
  bool perspective;
  float nearest, factor;

  explicit WeightedDistance(const DepthRange& range)
      : perspective(range.perspective), nearest(range.screen_depth(range.nearest)) {
    const float farthest = range.screen_depth(range.farthest);
    constexpr float extent = farthest_weighted - nearest_weighted_orthographic;
    factor = perspective ? farthest_weighted * farthest : farthest > nearest ? extent / (farthest - nearest) : 0.0f;
  }

  HWY_INLINE hn::VFromD<FloatTag> operator()(hn::VFromD<FloatTag> depth) const {
    const FloatTag d;
    if (perspective) return hn::Div(hn::Set(d, factor), depth);  // of -1 / W: W over the farthest one
    return hn::Add(hn::Mul(hn::Sub(depth, hn::Set(d, nearest)), hn::Set(d, factor)),
                   hn::Set(d, nearest_weighted_orthographic));
  }
};

HWY_INLINE hn::VFromD<FloatTag> weight_at(hn::VFromD<FloatTag> z) {
  const FloatTag d;
  const auto by_5 = hn::Mul(z, hn::Set(d, 1.0f / 5)), by_200 = hn::Mul(z, hn::Set(d, 1.0f / 200));
  const auto square = hn::Mul(by_200, by_200);
  const auto divisor =
      hn::Add(hn::Set(d, 1e-5f), hn::Add(hn::Mul(by_5, by_5), hn::Mul(square, hn::Mul(square, square))));
  return hn::Clamp(hn::Div(hn::Set(d, 10.0f), divisor), hn::Set(d, 1e-2f), hn::Set(d, 3e3f));
}

template <bool vertex_colours>
void sum_weighted(const TileTask& task, const DepthRange& range, int tile, TileColours& sums,
                  TilePlane& transmittance) {
  const FloatTag d;
  const WeightedDistance distance(range);
  const auto one = hn::Set(d, 1.0f);
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask, hn::VFromD<FloatTag> depth)
          HWY_ATTR {
            const auto weight =
                hn::IfThenElseZero(mask, hn::Mul(alpha_of<vertex_colours>(paint, x, y), weight_at(distance(depth))));
            blend_paint<vertex_colours>(
                paint, 1.0f, x, y,
                [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag> transparency) HWY_ATTR {
                  float* sum = sums.channel[channel].pixel + pixel;
                  hn::Store(hn::Add(hn::Load(d, sum), hn::Mul(source, weight)), d, sum);
                  if (channel != 3) return;
                  float* product = transmittance.pixel + pixel;
                  hn::Store(hn::Mul(hn::Load(d, product), hn::IfThenElse(mask, transparency, one)), d, product);
                });
          });
}

void DrawWeightedBlended(const TileTask& task, const DepthRange& range, int tile) {
  TileColours sums;
  TilePlane transmittance;
  clear(sums, glm::vec4(0));
  fill(transmittance, 1);
  task.colours.empty() ? sum_weighted<true>(task, range, tile, sums, transmittance)
                       : sum_weighted<false>(task, range, tile, sums, transmittance);
  write_average(task, sums, transmittance, tile);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
