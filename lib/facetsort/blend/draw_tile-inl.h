// Internal to blend: passes over what the bins have in one tile, in the order given.
#if defined(FACETSORT_BLEND_DRAW_TILE_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_DRAW_TILE_INL_H
#undef FACETSORT_BLEND_DRAW_TILE_INL_H
#else
#define FACETSORT_BLEND_DRAW_TILE_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <span>

#include "facetsort/blend/covered_rows-inl.h"
#include "facetsort/blend/draw_flat-inl.h"
#include "facetsort/blend/paint-inl.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Where facets are shaded by their corners, or have depth.
template <bool vertex_colours, bool depth>
void draw_shaded_pass(const TileTask& task, const DrawPass& pass, int tile, DrawnTile& drawn) {
  const FloatTag d;
  const ProjectedMesh& projected = task.projected;
  const bool eight_bits = task.format == PixelFormat::rgba8, is_additive = pass.blend == BlendMode::additive;
  const float scale = channel_scale(task);
  if (!pass.colour_write && !pass.depth_write) return;
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  Paint paint;
  for (const BinEntry& entry : task.bins.tile(tile)) {
    if (is_culled(pass, entry)) continue;
    Interpolant denominator, distance;
    bool is_set_up = false;
    const auto set_up = [&] {
      const FacetEdges edges = edges_in_tile(projected, entry, x0, y0);
      if constexpr (depth) {
        double along_axis[3];
        for (int i = 0; i < 3; ++i) along_axis[i] = distance_along_axis(projected, entry.facet, i);
        denominator = Interpolant::of(edges, 1, 1, 1);
        distance = Interpolant::of(edges, along_axis[0], along_axis[1], along_axis[2]);
      }
      paint.set_up<vertex_colours>(task, entry.facet, edges);
      is_set_up = true;
    };

    for_covered_vectors(projected, task.bins, entry, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      if (!is_set_up) set_up();
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      if constexpr (depth) {
        if (is_masked(paint)) mask = hn::And(mask, drawn_by_material<vertex_colours>(paint, x, y));
        const auto stored = hn::Load(d, drawn.depths.pixel + pixel);
        const auto fragment = interpolate(distance, denominator, x, y);
        if (pass.depth_test == DepthTest::less) mask = hn::And(mask, hn::Lt(fragment, stored));
        if (pass.depth_test == DepthTest::less_or_equal) mask = hn::And(mask, hn::Le(fragment, stored));
        if (pass.depth_write) hn::Store(hn::IfThenElse(mask, fragment, stored), d, drawn.depths.pixel + pixel);
      }
      if (!pass.colour_write) return;
      blend_paint<vertex_colours>(
          paint, scale, x, y,
          [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag> transparency) HWY_ATTR {
            if (is_additive) {
              if (channel == 3) return;
              transparency = hn::Set(d, 1.0f);
            }
            float* plane = drawn.colours.channel[channel].pixel + pixel;
            const auto below = hn::Load(d, plane);
            auto blended = hn::Add(source, hn::Mul(below, transparency));
            if (eight_bits) blended = hn::Round(blended);
            hn::Store(hn::IfThenElse(mask, blended, below), d, plane);
          });
    });
  }
}

void StartDrawing(const TileTask& task, DrawnTile& drawn) {
  clear(drawn.colours, clear_value(task));
  fill(drawn.depths, infinity);
}

void DrawPassInTile(const TileTask& task, const DrawPass& pass, int tile, DrawnTile& drawn) {
  const bool uses_depth = pass.depth_test != DepthTest::off || pass.depth_write;
  if (!task.colours.empty()) {
    draw_shaded_pass<false, true>(task, pass, tile, drawn);
  } else if (uses_depth) {
    draw_shaded_pass<true, true>(task, pass, tile, drawn);
  } else {
    draw_shaded_pass<true, false>(task, pass, tile, drawn);
  }
}

void FinishDrawing(const TileTask& task, int tile, const DrawnTile& drawn) {
  write_tile(task, drawn.colours, task.bins.tile_x(tile), task.bins.tile_y(tile));
}

void DrawTile(const TileTask& task, std::span<const DrawPass> passes, int tile) {
  const bool uses_depth = std::any_of(passes.begin(), passes.end(), [](const DrawPass& pass) {
    return pass.depth_test != DepthTest::off || pass.depth_write;
  });
  if (!task.colours.empty() && !uses_depth) {
    return task.format == PixelFormat::rgba8 ? draw_flat_tile<true>(task, passes, tile)
                                             : draw_flat_tile<false>(task, passes, tile);
  }
  DrawnTile drawn;
  StartDrawing(task, drawn);
  for (const DrawPass& pass : passes) DrawPassInTile(task, pass, tile, drawn);
  FinishDrawing(task, tile, drawn);
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
