// Internal to blend: weighted blended order-independent transparency, in one tile.
//
// McGuire and Bavoil, "Weighted Blended Order-Independent Transparency", Journal of Computer Graphics Techniques 2 (2),
// 2013. One pass sums colours and alphas with a weight that falls with the distance, and multiplies transparencies; the
// picture is the weighted average of the colours, as opaque as all layers together.
//
// The weight is the paper's equation (10), alpha max(1e-2, 3e3 (1 - d)^3), with d the value of a depth buffer whose near
// and far planes are the mesh's nearest and farthest vertex in the view: it does not depend on the unit of length, as
// equations (7) to (9) do, which are made for scenes that reach from 0.1 to 500 units.
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

template <bool vertex_colours>
void sum_weighted(const TileTask& task, const DepthRange& range, int tile, TileColours& sums, TilePlane& transmittance) {
  const FloatTag d;
  const float nearest = range.screen_depth(range.nearest), farthest = range.screen_depth(range.farthest);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1.0f);
  const auto first = hn::Set(d, nearest), inverse = hn::Set(d, farthest > nearest ? 1 / (farthest - nearest) : 0.0f);
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto from_far = hn::Sub(one, hn::Clamp(hn::Mul(hn::Sub(depth, first), inverse), zero, one));
        const auto falloff = hn::Mul(hn::Set(d, 3e3f), hn::Mul(from_far, hn::Mul(from_far, from_far)));
        const auto weight = hn::IfThenElseZero(
            mask, hn::Mul(alpha_of<vertex_colours>(paint, x, y), hn::Max(hn::Set(d, 1e-2f), falloff)));
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
  write_average_over_clear_colour(task, sums, transmittance, tile);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
