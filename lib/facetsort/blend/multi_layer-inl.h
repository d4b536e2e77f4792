// Internal to blend: multi-layer alpha blending, in one tile.
//
// Salvi and Vaidyanathan, "Multi-Layer Alpha Blending", I3D 2014. A pixel keeps K fragments by depth; one more is put
// in its place, and the farthest two of them then become one, blended, at the nearer one's depth. So K layers are
// exact, and of more, those that lie in front of what was merged out of order.
#if defined(FACETSORT_BLEND_MULTI_LAYER_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_MULTI_LAYER_INL_H
#undef FACETSORT_BLEND_MULTI_LAYER_INL_H
#else
#define FACETSORT_BLEND_MULTI_LAYER_INL_H
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "facetsort/blend/fragment_pass-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {

inline glm::vec4 over(const glm::vec4& above, const glm::vec4& below) {
  return above + below * (1.0f - above.a);
}

// Where `count` layers, nearest first, have room for one more. At one depth what is drawn later is in front.
HWY_INLINE void insert_layer(KeptLayer* layers, std::size_t count, const KeptLayer& layer) {
  std::size_t place = count;
  for (; place > 0 && layers[place - 1].depth >= layer.depth; --place) layers[place] = layers[place - 1];
  layers[place] = layer;
}

HWY_INLINE void insert_into_full(KeptLayer* layers, std::size_t most, const KeptLayer& layer) {
  KeptLayer& last = layers[most - 1];
  if (layer.depth > last.depth) {
    last.colour = over(last.colour, layer.colour);
    return;
  }
  const glm::vec4 farthest = last.colour;
  insert_layer(layers, most - 1, layer);
  last.colour = over(last.colour, farthest);
}

template <bool vertex_colours>
void keep_layers(const TileTask& task, int tile, std::size_t most, KeptLayer* layers, std::uint8_t* counts) {
  for_each_fragment<vertex_colours>(task, tile,
                                    [&](std::uint32_t, std::size_t pixel, float depth, const glm::vec4& colour) {
                                      KeptLayer* here = layers + pixel * most;
                                      if (counts[pixel] == most) return insert_into_full(here, most, {depth, colour});
                                      insert_layer(here, counts[pixel]++, {depth, colour});
                                    });
}

void DrawMultiLayer(const TileTask& task, std::span<KeptLayer> layers, int tile) {
  const std::size_t pixels = tile_size * tile_size, most = layers.size() / pixels;
  std::uint8_t counts[pixels] = {};
  static_assert(most_kept_layers < 256);
  task.colours.empty() ? keep_layers<true>(task, tile, most, layers.data(), counts)
                       : keep_layers<false>(task, tile, most, layers.data(), counts);
  // Layers are float whatever the picture's format: rgba8 rounds once.
  const bool eight_bits = task.format == PixelFormat::rgba8;
  const float scale = channel_scale(task);
  TileColours colours;
  fill_with_what_is_below(task, tile, colours);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    glm::vec4 blended;
    for (int k = 0; k < 4; ++k) blended[k] = colours.channel[k].pixel[pixel];
    const KeptLayer* here = layers.data() + pixel * most;
    for (std::size_t k = counts[pixel]; k-- > 0;) {
      blended = here[k].colour * scale + blended * (1.0f - here[k].colour.a);
    }
    for (int k = 0; k < 4; ++k) {
      colours.channel[k].pixel[pixel] = eight_bits ? std::nearbyint(blended[k]) : blended[k];
    }
  }
  write_tile(task, colours, task.bins.tile_x(tile), task.bins.tile_y(tile));
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
