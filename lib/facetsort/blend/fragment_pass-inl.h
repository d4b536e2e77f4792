// Internal to blend: the fragments of a tile with their depths, in the order given, as depth peeling and the
// order-independent strategies see them.
#if defined(FACETSORT_BLEND_FRAGMENT_PASS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_FRAGMENT_PASS_INL_H
#undef FACETSORT_BLEND_FRAGMENT_PASS_INL_H
#else
#define FACETSORT_BLEND_FRAGMENT_PASS_INL_H
#endif

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "facetsort/blend/covered_rows-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Depth that is linear on the screen, as what graphics hardware stores is, so that it takes no division a pixel:
// -1 / W in perspective and the distance along the camera axis in orthographic views: both grow with the distance, and
// a step of -1 / W in float32 is as fine, for the distance it stands for, as a step of the distance itself.
struct ScreenDepth {
  Interpolant line;
  float nearest, farthest;  // of the facet's corners; a thin facet's line strays beyond

  void set_up(const ProjectedMesh& projected, const BinEntry& entry, const FacetEdges& edges) {
    constexpr double largest_float = std::numeric_limits<float>::max();
    double value[3], w[3];
    for (int i = 0; i < 3; ++i) {
      w[i] = projected.vertices[projected.mesh.triangles[entry.facet][i]].w;
      value[i] = projected.camera.perspective ? -1 : distance_along_axis(projected, entry.facet, i);
    }
    // sum(E_i W_i) is the same at every pixel.
    const double sum = edges.c[0] * w[0] + edges.c[1] * w[1] + edges.c[2] * w[2];
    const double scale = sum > 1e-290 ? 1 / sum : 0.0;
    line = Interpolant::of(edges, value[0] * scale, value[1] * scale, value[2] * scale);
    auto [low, high] = std::minmax({value[0], value[1], value[2]});
    if (projected.camera.perspective) {
      low = -1 / std::max(std::min({w[0], w[1], w[2]}), projected.camera.near_distance);
      high = -1 / std::max({w[0], w[1], w[2]});
    }
    nearest = static_cast<float>(std::clamp(low, -largest_float, largest_float));
    farthest = static_cast<float>(std::clamp(high, -largest_float, largest_float));
  }

  // At the vector of pixels that starts at (x, y).
  HWY_INLINE hn::VFromD<FloatTag> at(int x, int y) const {
    const FloatTag d;
    const hn::CappedTag<double, tile_size> dd;
    const hn::Rebind<float, decltype(dd)> part;
    const int lanes = static_cast<int>(hn::Lanes(d)), part_lanes = static_cast<int>(hn::Lanes(dd));
    const auto row = hn::Set(dd, line.b * y + line.c);
    HWY_ALIGN float values[tile_size];
    for (int lane = 0; lane < lanes; lane += part_lanes) {
      const auto fx = hn::Add(hn::Iota(dd, 0), hn::Set(dd, static_cast<double>(x + lane)));
      hn::Store(hn::DemoteTo(part, hn::Add(hn::Mul(hn::Set(dd, line.a), fx), row)), part, values + lane);
    }
    return hn::Clamp(hn::Load(d, values), hn::Set(d, nearest), hn::Set(d, farthest));
  }
};

// Runs over the tile once: visit(paint, pixel, x, y, mask, depth) for every vector of pixels in which something is
// covered and not behind what is opaque, the depth being ScreenDepth.
template <bool vertex_colours, typename Visit>
void fragment_pass(const TileTask& task, int tile, const Visit& visit) {
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  const FloatTag d;
  const float* opaque_depths =
      task.opaque.empty() ? nullptr : task.opaque[static_cast<std::size_t>(tile)].depths.pixel;
  Paint paint;
  ScreenDepth depth;
  for (const BinEntry& entry : task.bins.tile(tile)) {
    bool is_set_up = false;
    const auto set_up = [&] {
      const FacetEdges edges = edges_in_tile(task.projected, entry, x0, y0);
      depth.set_up(task.projected, entry, edges);
      paint.set_up<vertex_colours>(task, entry.facet, edges);
      is_set_up = true;
    };
    for_covered_vectors(task.projected, task.bins, entry, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      if (!is_set_up) set_up();
      if (is_masked(paint)) mask = hn::And(mask, drawn_by_material<vertex_colours>(paint, x, y));
      const auto pixel = static_cast<std::size_t>(y * tile_size + x);
      const auto distance = depth.at(x, y);
      if (opaque_depths != nullptr) {
        mask = hn::And(mask, hn::Le(distance, hn::Load(d, opaque_depths + pixel)));
        if (hn::AllFalse(d, mask)) return;
      }
      visit(paint, pixel, x, y, mask, distance);
    });
  }
}

// The same one fragment at a time: visit(facet, pixel, depth, colour), the colour premultiplied.
template <bool vertex_colours, typename Visit>
void for_each_fragment(const TileTask& task, int tile, const Visit& visit) {
  const FloatTag d;
  fragment_pass<vertex_colours>(
      task, tile,
      [&](const Paint& paint, std::size_t pixel, int x, int y, hn::Mask<FloatTag> mask, hn::VFromD<FloatTag> depth)
          HWY_ATTR {
            HWY_ALIGN float depths[tile_size], channels[4][tile_size];
            hn::Store(depth, d, depths);
            if constexpr (vertex_colours) {
              blend_paint<true>(paint, 1.0f, x, y,
                                [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag>)
                                    HWY_ATTR { hn::Store(source, d, channels[channel]); });
            }
            for (RowBits bits = bits_of(mask); bits != 0; bits &= bits - 1) {
              const auto i = static_cast<std::size_t>(std::countr_zero(bits));
              if constexpr (vertex_colours) {
                visit(paint.facet, pixel + i, depths[i],
                      glm::vec4(channels[0][i], channels[1][i], channels[2][i], channels[3][i]));
              } else {
                visit(paint.facet, pixel + i, depths[i], paint.flat);
              }
            }
          });
}

// Into a layer, as a render target keeps it. `combine(stored, source)` says what becomes of what is there.
template <bool vertex_colours, typename Combine>
HWY_INLINE void store_layer(const TileTask& task, const Paint& paint, std::size_t pixel, int x, int y,
                            hn::Mask<FloatTag> mask, TileColours& layer, const Combine& combine) {
  const FloatTag d;
  const bool eight_bits = task.format == PixelFormat::rgba8;
  blend_paint<vertex_colours>(paint, channel_scale(task), x, y,
                              [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag>) HWY_ATTR {
                                float* plane = layer.channel[channel].pixel + pixel;
                                const auto stored = hn::Load(d, plane);
                                if (eight_bits) source = hn::Round(source);
                                hn::Store(hn::IfThenElse(mask, combine(stored, source), stored), d, plane);
                              });
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
