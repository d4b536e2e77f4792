// Internal to blend: how the strategies end that know how opaque all layers together are, and an average colour of
// them.
#if defined(FACETSORT_BLEND_AVERAGE_COLOUR_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_AVERAGE_COLOUR_INL_H
#undef FACETSORT_BLEND_AVERAGE_COLOUR_INL_H
#else
#define FACETSORT_BLEND_AVERAGE_COLOUR_INL_H
#endif

#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Writes the tile: the average colour, covering all but the transmittance, over what is opaque, or the clear
// colour. `sums` are of
// premultiplied colours by some weight, and in the fourth channel of the alphas by the same; it is overwritten. Sums
// are float whatever the picture's format: rgba8 rounds once.
void write_average(const TileTask& task, TileColours& sums, const TilePlane& transmittance,
                                     int tile) {
  const FloatTag d;
  const bool eight_bits = task.format == PixelFormat::rgba8;
  const auto scale = hn::Set(d, channel_scale(task)), one = hn::Set(d, 1.0f);
  TileColours below;
  fill_with_what_is_below(task, tile, below);
  for (std::size_t pixel = 0; pixel < tile_size * tile_size; pixel += hn::Lanes(d)) {
    const auto through = hn::Load(d, transmittance.pixel + pixel);
    const auto weights = hn::Load(d, sums.channel[3].pixel + pixel);
    const auto covers = hn::Gt(weights, hn::Zero(d));
    const auto opacity = hn::IfThenElseZero(covers, hn::Mul(hn::Sub(one, through), scale));
    const auto divisor = hn::IfThenElse(covers, weights, one);
    for (int k = 0; k < 4; ++k) {
      float* plane = sums.channel[k].pixel + pixel;
      const auto average = hn::Div(hn::Load(d, plane), divisor);
      auto blended = hn::Add(hn::Mul(average, opacity), hn::Mul(hn::Load(d, below.channel[k].pixel + pixel), through));
      if (eight_bits) blended = hn::Round(blended);
      hn::Store(blended, d, plane);
    }
  }
  write_tile(task, sums, task.bins.tile_x(tile), task.bins.tile_y(tile));
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
