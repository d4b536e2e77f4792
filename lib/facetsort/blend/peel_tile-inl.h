// Internal to blend: depth peeling, in one tile.
#if defined(FACETSORT_BLEND_PEEL_TILE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_PEEL_TILE_INL_H
#undef FACETSORT_BLEND_PEEL_TILE_INL_H
#else
#define FACETSORT_BLEND_PEEL_TILE_INL_H
#endif

#include <algorithm>
#include <cstdint>

#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Blends one tile over another, pixel by pixel, into `result`, which may be either.
void blend_over(const TileTask& task, const TileColours& above, const TileColours& below, TileColours& result) {
  const FloatTag d;
  const bool eight_bits = task.format == PixelFormat::rgba8;
  const auto unit = hn::Set(d, 1.0f / channel_scale(task));
  for (std::size_t pixel = 0; pixel < tile_size * tile_size; pixel += hn::Lanes(d)) {
    const auto alpha = hn::Mul(hn::Load(d, above.channel[3].pixel + pixel), unit);
    const auto transparency = hn::Sub(hn::Set(d, 1.0f), alpha);
    for (int k = 0; k < 4; ++k) {
      auto blended = hn::Add(hn::Load(d, above.channel[k].pixel + pixel),
                             hn::Mul(hn::Load(d, below.channel[k].pixel + pixel), transparency));
      if (eight_bits) blended = hn::Round(blended);
      hn::Store(blended, d, result.channel[k].pixel + pixel);
    }
  }
}

bool any_finite(const TilePlane& depths) {
  return std::any_of(std::begin(depths.pixel), std::end(depths.pixel), [](float depth) { return depth < infinity; });
}

// Everitt, "Interactive Order-Independent Transparency" (2001): each pass keeps the nearest layer beyond the last one,
// which is blended under those before it.
template <bool vertex_colours>
bool peel_front_to_back(const TileTask& task, int tile, PeeledTile& peeled) {
  const FloatTag d;
  TileColours layer;
  TilePlane nearest;
  fill(nearest, infinity);
  clear(layer, glm::vec4(0));
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto stored = hn::Load(d, nearest.pixel + pixel);
        const auto last = hn::Load(d, peeled.nearest.pixel + pixel);
        mask = hn::And(mask, hn::And(hn::Gt(depth, last), hn::Lt(depth, stored)));
        if (hn::AllFalse(d, mask)) return;
        hn::Store(hn::IfThenElse(mask, depth, stored), d, nearest.pixel + pixel);
        store_layer<vertex_colours>(task, paint, pixel, x, y, mask, layer,
                                    [](hn::VFromD<FloatTag>, hn::VFromD<FloatTag> source) HWY_ATTR { return source; });
      });
  peeled.nearest = nearest;
  if (!any_finite(nearest)) return false;
  blend_over(task, peeled.front, layer, peeled.front);
  return true;
}

// Bavoil and Myers, "Order Independent Transparency with Dual Depth Peeling" (2008): each pass peels the nearest and
// the farthest layer that are left, found by the pass before, and finds the next two. Layers are kept by the larger
// value of each channel, as with the paper's MAX blending.
template <bool vertex_colours>
bool peel_from_both_ends(const TileTask& task, int tile, PeeledTile& peeled) {
  const FloatTag d;
  TileColours front_layer, back_layer;
  TilePlane next_nearest, next_farthest;
  fill(next_nearest, infinity);
  fill(next_farthest, -infinity);
  clear(front_layer, glm::vec4(0));
  clear(back_layer, glm::vec4(0));
  const auto larger = [](hn::VFromD<FloatTag> a, hn::VFromD<FloatTag> b) HWY_ATTR { return hn::Max(a, b); };
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto nearest = hn::Load(d, peeled.nearest.pixel + pixel);
        const auto farthest = hn::Load(d, peeled.farthest.pixel + pixel);
        const auto between = hn::And(mask, hn::And(hn::Gt(depth, nearest), hn::Lt(depth, farthest)));
        if (!hn::AllFalse(d, between)) {
          const auto low = hn::Load(d, next_nearest.pixel + pixel), high = hn::Load(d, next_farthest.pixel + pixel);
          hn::Store(hn::IfThenElse(between, hn::Min(depth, low), low), d, next_nearest.pixel + pixel);
          hn::Store(hn::IfThenElse(between, hn::Max(depth, high), high), d, next_farthest.pixel + pixel);
        }
        const auto at_front = hn::And(mask, hn::Eq(depth, nearest));
        if (!hn::AllFalse(d, at_front)) {
          store_layer<vertex_colours>(task, paint, pixel, x, y, at_front, front_layer, larger);
        }
        const auto at_back = hn::AndNot(at_front, hn::And(mask, hn::Eq(depth, farthest)));
        if (!hn::AllFalse(d, at_back)) {
          store_layer<vertex_colours>(task, paint, pixel, x, y, at_back, back_layer, larger);
        }
      });
  blend_over(task, peeled.front, front_layer, peeled.front);
  blend_over(task, back_layer, peeled.back, peeled.back);
  peeled.nearest = next_nearest;
  peeled.farthest = next_farthest;
  return any_finite(next_nearest);
}

void StartPeeling(const TileTask& task, int tile, PeeledTile& peeled) {
  clear(peeled.front, glm::vec4(0));
  fill_with_what_is_below(task, tile, peeled.back);
  fill(peeled.nearest, -infinity);
  fill(peeled.farthest, infinity);
}

bool PeelTile(const TileTask& task, Peeling peeling, int tile, PeeledTile& peeled) {
  const bool vertex_colours = task.colours.empty();
  if (peeling == Peeling::front_to_back) {
    return vertex_colours ? peel_front_to_back<true>(task, tile, peeled)
                          : peel_front_to_back<false>(task, tile, peeled);
  }
  return vertex_colours ? peel_from_both_ends<true>(task, tile, peeled)
                        : peel_from_both_ends<false>(task, tile, peeled);
}

void FinishPeeling(const TileTask& task, int tile, PeeledTile& peeled) {
  blend_over(task, peeled.front, peeled.back, peeled.front);
  write_tile(task, peeled.front, task.bins.tile_x(tile), task.bins.tile_y(tile));
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
