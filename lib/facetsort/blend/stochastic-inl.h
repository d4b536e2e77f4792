// Internal to blend: stochastic transparency, in one tile.
//
// Enderton, Sintorn, Shirley and Luebke, "Stochastic Transparency", I3D 2010, with its depth-based accumulation and its
// alpha correction. The first pass draws depth alone into S samples a pixel: a fragment covers a random subset of them,
// alpha S in the mean. The second adds each fragment's colour, by the share of samples whose depth it is not behind,
// which is its visibility in the mean. The transparency of all layers together needs no samples: it is multiplied in
// the second pass, into a target of its own, and the sums are scaled to it.
#if defined(FACETSORT_BLEND_STOCHASTIC_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_STOCHASTIC_INL_H
#undef FACETSORT_BLEND_STOCHASTIC_INL_H
#else
#define FACETSORT_BLEND_STOCHASTIC_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>

#include "facetsort/blend/average_colour-inl.h"
#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/sample_masks.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// The samples of a pixel lie together, in whole vectors; those beyond S are never covered, and lie before everything.
using SampleTag = hn::CappedTag<float, samples_per_vector>;

HWY_INLINE hn::Mask<SampleTag> sample_mask(std::uint64_t samples) {
  alignas(8) std::uint8_t bytes[8] = {};
  std::memcpy(bytes, &samples, sizeof samples);
  return hn::LoadMaskBits(SampleTag(), bytes);
}

HWY_INLINE void draw_depth(float* depths, std::size_t samples, std::uint64_t covered, float depth) {
  const SampleTag d;
  const auto drawn = hn::Set(d, depth);
  for (std::size_t s = 0; s < samples; s += hn::Lanes(d)) {
    const auto stored = hn::Load(d, depths + s);
    hn::Store(hn::IfThenElse(sample_mask(covered >> s), hn::Min(drawn, stored), stored), d, depths + s);
  }
}

HWY_INLINE std::size_t samples_not_before(const float* depths, std::size_t samples, float depth) {
  const SampleTag d;
  const auto drawn = hn::Set(d, depth);
  std::size_t count = 0;
  for (std::size_t s = 0; s < samples; s += hn::Lanes(d)) {
    count += hn::CountTrue(d, hn::Le(drawn, hn::Load(d, depths + s)));
  }
  return count;
}

template <bool vertex_colours>
void draw_stochastic(const TileTask& task, const SampleMasks& masks, float* depths, std::size_t room, int tile,
                     TileColours& sums, TilePlane& transmittance) {
  const std::size_t samples = static_cast<std::size_t>(masks.samples());
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  for_each_fragment<vertex_colours>(
      task, tile, [&](std::uint32_t facet, std::size_t pixel, float depth, const glm::vec4& colour) {
        const int x = x0 + static_cast<int>(pixel % tile_size), y = y0 + static_cast<int>(pixel / tile_size);
        draw_depth(depths + pixel * room, samples, masks.covered(facet, x, y, colour.a), depth);
      });
  for_each_fragment<vertex_colours>(
      task, tile, [&](std::uint32_t, std::size_t pixel, float depth, const glm::vec4& colour) {
        const auto visible = static_cast<float>(samples_not_before(depths + pixel * room, samples, depth));
        for (int k = 0; k < 4; ++k) sums.channel[k].pixel[pixel] += visible * colour[k];
        transmittance.pixel[pixel] *= 1.0f - colour.a;
      });
}

void DrawStochastic(const TileTask& task, const SampleMasks& masks, std::span<SampleVector> depths, int tile) {
  const std::size_t pixels = tile_size * tile_size, room = depths.size() / pixels * samples_per_vector;
  const auto samples = static_cast<std::size_t>(masks.samples());
  float* first = depths.data()->depth;
  if (!task.bins.tile(tile).empty()) {
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
      float* here = first + pixel * room;
      std::fill(std::fill_n(here, samples, infinity), here + room, -infinity);
    }
  }
  TileColours sums;
  TilePlane transmittance;
  clear(sums, glm::vec4(0));
  fill(transmittance, 1);
  task.colours.empty() ? draw_stochastic<true>(task, masks, first, room, tile, sums, transmittance)
                       : draw_stochastic<false>(task, masks, first, room, tile, sums, transmittance);
  write_average(task, sums, transmittance, tile);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
