// Internal to blend: what is opaque, in one tile, for strategies that draw over it without an order.
#if defined(FACETSORT_BLEND_OPAQUE_TILE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_OPAQUE_TILE_INL_H
#undef FACETSORT_BLEND_OPAQUE_TILE_INL_H
#else
#define FACETSORT_BLEND_OPAQUE_TILE_INL_H
#endif

#include "facetsort/blend/draw_tile-inl.h"
#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <bool vertex_colours>
void draw_nearest(const TileTask& task, int tile, DrawnTile& drawn) {
  const FloatTag d;
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask,
          hn::VFromD<FloatTag> depth) HWY_ATTR {
        const auto stored = hn::Load(d, drawn.depths.pixel + pixel);
        mask = hn::And(mask, hn::Lt(depth, stored));
        if (hn::AllFalse(d, mask)) return;
        hn::Store(hn::IfThenElse(mask, depth, stored), d, drawn.depths.pixel + pixel);
        store_layer<vertex_colours>(task, paint, pixel, x, y, mask, drawn.colours,
                                    [](hn::VFromD<FloatTag>, hn::VFromD<FloatTag> source) HWY_ATTR { return source; });
      });
}

void DrawOpaqueTile(const TileTask& task, int tile, DrawnTile& drawn) {
  StartDrawing(task, drawn);
  task.colours.empty() ? draw_nearest<true>(task, tile, drawn) : draw_nearest<false>(task, tile, drawn);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
