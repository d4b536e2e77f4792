#include "facetsort/blend/tile_kernels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "facetsort/blend/shading.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/blend/tile_kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: foreach_target.h before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, tile_size>;

// Edges of one facet in one tile, and the cuts of its piece, scaled to change by at most 1 a pixel, in float. Where
// every line's value exceeds `error` the pixel is covered, where one is below -error it is not; between, float can't
// tell.
struct TileEdges {
  // A piece that has more cuts in one tile is decided pixel by pixel.
  static constexpr int most_cuts = 16;

  float a[3 + most_cuts], b[3 + most_cuts], c[3 + most_cuts], error;
  int lines;  // three edges, then cuts
  float near_a = 0, near_b = 0, near_c = 0;  // not negative where the fragment is not nearer than the near plane
  FacetEdges exact;                // relative to the tile's first pixel centre
  std::span<const FacetCut> cuts;  // all of the piece's

  // False when nothing is covered in the entry's box. Inlined by force: small facets cost little else.
  HWY_INLINE bool set_up(const ProjectedMesh& projected, const FacetBins& bins, const BinEntry& entry, int x0, int y0) {
    exact = facet_edges(projected, entry.facet, entry.facing, {x0 + 0.5, y0 + 0.5}, tile_size);
    double largest_error = 0;
    for (lines = 0; lines < 3; ++lines) {
      largest_error =
          std::max(largest_error, set_up_line(exact.a[lines], exact.b[lines], exact.c[lines], exact.error[lines]));
    }
    cuts = bins.cuts(entry);
    if (!cuts.empty() && !set_up_cuts(entry, largest_error)) return false;
    error = float_bound(largest_error);
    for (int i = 0; i < 3; ++i) {
      if (highest(i, entry) < -2 * error) return false;
    }
    if (entry.crosses_near) set_up_near(projected, entry);
    return true;
  }

 private:
  static float float_bound(double line_error) {
    // In float: three roundings of coefficients, two products and two sums, of values that stay below 4 tile_size.
    constexpr double float_error = 16 * tile_size * 0x1p-24;
    return static_cast<float>(std::min(line_error + float_error, 4.0 * tile_size));
  }

  // The line whose place is next; returns its error after scaling.
  double set_up_line(double line_a, double line_b, double line_c, double line_error) {
    const double slope = std::abs(line_a) + std::abs(line_b);
    // Where the slope is below what a double can divide by, everything is in doubt.
    const double scale = slope > 1e-290 ? 1 / slope : 0.0;
    a[lines] = static_cast<float>(line_a * scale);
    b[lines] = static_cast<float>(line_b * scale);
    // An edge that far from the tile has one sign on all of it.
    c[lines] = static_cast<float>(std::clamp(line_c * scale, -2.0 * tile_size, 2.0 * tile_size));
    return scale > 0 ? line_error * scale : 1.0;
  }

  // Largest value of a line in the entry's box.
  float highest(int line, const BinEntry& entry) const {
    return c[line] + std::max(a[line] * static_cast<float>(entry.x0), a[line] * static_cast<float>(entry.x1)) +
           std::max(b[line] * static_cast<float>(entry.y0), b[line] * static_cast<float>(entry.y1));
  }

  // Smallest value of a line in the whole vectors of pixels that the entry's box takes part in.
  float lowest(int line, const BinEntry& entry) const {
    const int lanes = static_cast<int>(hn::Lanes(FloatTag()));
    const float left = static_cast<float>(entry.x0 / lanes * lanes);
    const float right = static_cast<float>(entry.x1 / lanes * lanes + lanes - 1);
    return c[line] + std::min(a[line] * left, a[line] * right) +
           std::min(b[line] * static_cast<float>(entry.y0), b[line] * static_cast<float>(entry.y1));
  }

  // Cuts that leave all the pixels looked at do not become lines. False when one leaves none of the entry's box.
  HWY_NOINLINE bool set_up_cuts(const BinEntry& entry, double& largest_error) {
    for (const FacetCut& cut : cuts) {
      if (lines == 3 + most_cuts) {
        largest_error = 4 * tile_size;  // no float value is certain
        return true;
      }
      const CutLine line = cut_line(exact, cut, tile_size);
      const double line_error = set_up_line(line.a, line.b, line.c, line.error);
      const float bound = 2 * float_bound(line_error);
      if (highest(lines, entry) < -bound) return false;
      if (lowest(lines, entry) > bound) continue;
      largest_error = std::max(largest_error, line_error);
      ++lines;
    }
    return true;
  }

  // W of the fragment is sum(E_i W_i) / sum(E_i), so it reaches the near distance where sum(E_i (W_i - near)) >= 0.
  void set_up_near(const ProjectedMesh& projected, const BinEntry& entry) {
    double sum_a = 0, sum_b = 0, sum_c = 0;
    for (int i = 0; i < 3; ++i) {
      const double beyond =
          projected.vertices[projected.mesh.triangles[entry.facet][i]].w - projected.camera.near_distance;
      sum_a += exact.a[i] * beyond;
      sum_b += exact.b[i] * beyond;
      sum_c += exact.c[i] * beyond;
    }
    const double largest = std::max({std::abs(sum_a), std::abs(sum_b), std::abs(sum_c)});
    const double scale = largest > 1e-290 ? 1 / largest : 0.0;
    near_a = static_cast<float>(sum_a * scale);
    near_b = static_cast<float>(sum_b * scale);
    near_c = static_cast<float>(sum_c * scale);
  }
};

// Calls emit(x, y, mask) for each vector of pixels from (x, y) to the right of which the facet or piece covers some.
template <typename Emit>
HWY_INLINE void for_covered_pixels(const ProjectedMesh& projected, const BinEntry& entry, const TileEdges& edges,
                                   int x0, int y0, const Emit& emit) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto error = hn::Set(d, edges.error);
  const auto minus_error = hn::Set(d, -edges.error);
  const auto a0 = hn::Set(d, edges.a[0]), a1 = hn::Set(d, edges.a[1]), a2 = hn::Set(d, edges.a[2]);
  const int first_x = entry.x0 / lanes * lanes;
  for (int y = entry.y0; y <= entry.y1; ++y) {
    const float fy = static_cast<float>(y);
    const auto row0 = hn::Set(d, edges.b[0] * fy + edges.c[0]);
    const auto row1 = hn::Set(d, edges.b[1] * fy + edges.c[1]);
    const auto row2 = hn::Set(d, edges.b[2] * fy + edges.c[2]);
    for (int x = first_x; x <= entry.x1; x += lanes) {
      const auto fx = hn::Iota(d, static_cast<float>(x));
      const auto e0 = hn::Add(hn::Mul(a0, fx), row0);
      const auto e1 = hn::Add(hn::Mul(a1, fx), row1);
      const auto e2 = hn::Add(hn::Mul(a2, fx), row2);
      auto lowest = hn::Min(hn::Min(e0, e1), e2);
      for (int i = 3; i < edges.lines; ++i) {
        const auto row = hn::Set(d, edges.b[i] * fy + edges.c[i]);
        lowest = hn::Min(lowest, hn::Add(hn::Mul(hn::Set(d, edges.a[i]), fx), row));
      }
      const auto possible = hn::Ge(lowest, minus_error);
      if (hn::AllFalse(d, possible)) continue;
      auto covered = hn::Gt(lowest, error);
      const auto doubtful = hn::AndNot(covered, possible);
      if (HWY_UNLIKELY(!hn::AllFalse(d, doubtful))) {
        alignas(8) std::uint8_t doubtful_bits[8] = {}, covered_bits[8] = {};
        hn::StoreMaskBits(d, doubtful, doubtful_bits);
        hn::StoreMaskBits(d, covered, covered_bits);
        for (int lane = 0; lane < lanes; ++lane) {
          const bool in_box = x + lane >= entry.x0 && x + lane <= entry.x1;
          if (in_box && (doubtful_bits[lane / 8] >> (lane % 8) & 1) != 0 &&
              covers_pixel(projected, entry.facet, entry.facing, edges.cuts, x0 + x + lane, y0 + y)) {
            covered_bits[lane / 8] = static_cast<std::uint8_t>(covered_bits[lane / 8] | 1 << (lane % 8));
          }
        }
        covered = hn::LoadMaskBits(d, covered_bits);
      }
      if (entry.crosses_near) {
        const auto beyond = hn::Add(hn::Mul(hn::Set(d, edges.near_a), fx),
                                    hn::Set(d, edges.near_b * fy + edges.near_c));
        covered = hn::And(covered, hn::Ge(beyond, hn::Zero(d)));
      }
      if (!hn::AllFalse(d, covered)) emit(x, y, covered);
    }
  }
}

// An attribute of the facet's corners interpolated in perspective: sum(E_i v_i) / sum(E_i). In double, because the
// edge functions of a thin facet cancel.
struct Interpolant {
  double a = 0, b = 0, c = 0;

  static Interpolant of(const FacetEdges& edges, double v0, double v1, double v2) {
    return {edges.a[0] * v0 + edges.a[1] * v1 + edges.a[2] * v2, edges.b[0] * v0 + edges.b[1] * v1 + edges.b[2] * v2,
            edges.c[0] * v0 + edges.c[1] * v1 + edges.c[2] * v2};
  }
};

// Numerator over denominator for the vector of pixels that starts at (x, y).
HWY_INLINE hn::VFromD<FloatTag> interpolate(const Interpolant& numerator, const Interpolant& denominator, int x,
                                            int y) {
  const FloatTag d;
  const hn::CappedTag<double, tile_size> dd;
  const hn::Rebind<float, decltype(dd)> part;  // as many floats as a vector of doubles has lanes
  const int lanes = static_cast<int>(hn::Lanes(d)), part_lanes = static_cast<int>(hn::Lanes(dd));
  const auto evaluate = [&](const Interpolant& function, hn::VFromD<decltype(dd)> fx) {
    return hn::Add(hn::Mul(hn::Set(dd, function.a), fx), hn::Set(dd, function.b * y + function.c));
  };
  HWY_ALIGN float values[tile_size];
  for (int lane = 0; lane < lanes; lane += part_lanes) {
    const auto fx = hn::Iota(dd, static_cast<double>(x + lane));
    const auto quotient = hn::Div(evaluate(numerator, fx), evaluate(denominator, fx));
    hn::Store(hn::DemoteTo(part, quotient), part, values + lane);
  }
  return hn::Load(d, values);
}

constexpr float infinity = std::numeric_limits<float>::infinity();

double distance_along_axis(const ProjectedMesh& projected, std::uint32_t facet, int corner) {
  return glm::dot(projected.camera.forward, glm::dvec3(projected.mesh.corner(facet, corner)) - projected.camera.eye);
}

// How a facet is coloured in one tile.
struct Paint {
  glm::vec4 flat;  // premultiplied, where each facet has one colour
  Interpolant denominator, colour[4];
  float light;

  template <bool vertex_colours>
  void set_up(const TileTask& task, std::uint32_t facet, const FacetEdges& edges) {
    if constexpr (vertex_colours) {
      const MeshView& mesh = task.projected.mesh;
      light = headlight(mesh, facet, task.projected.view.homogeneous_eye());
      denominator = Interpolant::of(edges, 1, 1, 1);
      const glm::uvec3& t = mesh.triangles[facet];
      const auto& colours = mesh.vertex_colours;
      for (int k = 0; k < 4; ++k) {
        colour[k] = Interpolant::of(edges, colours[t[0]][k], colours[t[1]][k], colours[t[2]][k]);
      }
    } else {
      flat = task.colours[facet];
    }
  }
};

// Calls blend(channel, source, transparency) for the four channels of the vector of pixels that starts at (x, y), the
// source premultiplied and in units of the format.
template <bool vertex_colours, typename Blend>
HWY_INLINE void blend_paint(const Paint& paint, float channel_scale, int x, int y, const Blend& blend) {
  const FloatTag d;
  const auto scale = hn::Set(d, channel_scale);
  if constexpr (vertex_colours) {
    const auto alpha = interpolate(paint.colour[3], paint.denominator, x, y);
    const auto transparency = hn::Sub(hn::Set(d, 1.0f), alpha);
    const auto factor = hn::Mul(hn::Mul(alpha, hn::Set(d, paint.light)), scale);
    for (int k = 0; k < 3; ++k) {
      blend(k, hn::Mul(interpolate(paint.colour[k], paint.denominator, x, y), factor), transparency);
    }
    blend(3, hn::Mul(alpha, scale), transparency);
  } else {
    const auto transparency = hn::Set(d, 1.0f - paint.flat.a);
    for (int k = 0; k < 4; ++k) blend(k, hn::Mul(hn::Set(d, paint.flat[k]), scale), transparency);
  }
}

// What a channel of 1 is in units of the format.
float channel_scale(const TileTask& task) { return task.format == PixelFormat::rgba8 ? 255.0f : 1.0f; }

// Every channel's clear value, rounded as the format is.
glm::vec4 clear_value(const TileTask& task) {
  return task.format == PixelFormat::rgba8 ? glm::round(task.clear_colour * 255.0f) : task.clear_colour;
}

void fill(TilePlane& plane, float value) { std::fill(std::begin(plane.pixel), std::end(plane.pixel), value); }

void clear(TileColours& colours, const glm::vec4& value) {
  for (int k = 0; k < 4; ++k) fill(colours.channel[k], value[k]);
}

template <bool vertex_colours, bool depth>
void draw_pass(const TileTask& task, const DrawPass& pass, int tile, int x0, int y0, TileColours& colours,
               TilePlane& depths) {
  const FloatTag d;
  const ProjectedMesh& projected = task.projected;
  const bool eight_bits = task.format == PixelFormat::rgba8;
  const float scale = channel_scale(task);
  TileEdges edges;
  Paint paint;
  for (const BinEntry& entry : task.bins.tile(tile)) {
    if (pass.cull == Cull::back_faces && entry.facing < 0) continue;
    if (pass.cull == Cull::front_faces && entry.facing > 0) continue;
    if (!edges.set_up(projected, task.bins, entry, x0, y0)) continue;

    Interpolant denominator, distance;
    if constexpr (depth) {
      double along_axis[3];
      for (int i = 0; i < 3; ++i) along_axis[i] = distance_along_axis(projected, entry.facet, i);
      denominator = Interpolant::of(edges.exact, 1, 1, 1);
      distance = Interpolant::of(edges.exact, along_axis[0], along_axis[1], along_axis[2]);
    }
    paint.set_up<vertex_colours>(task, entry.facet, edges.exact);

    for_covered_pixels(projected, entry, edges, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      if constexpr (depth) {
        const auto stored = hn::Load(d, depths.pixel + pixel);
        const auto fragment = interpolate(distance, denominator, x, y);
        if (pass.depth_test == DepthTest::less) mask = hn::And(mask, hn::Lt(fragment, stored));
        if (pass.depth_test == DepthTest::less_or_equal) mask = hn::And(mask, hn::Le(fragment, stored));
        if (pass.depth_write) hn::Store(hn::IfThenElse(mask, fragment, stored), d, depths.pixel + pixel);
        if (!pass.colour_write) return;
      }
      blend_paint<vertex_colours>(
          paint, scale, x, y,
          [&](int channel, hn::VFromD<FloatTag> source, hn::VFromD<FloatTag> transparency) HWY_ATTR {
            float* plane = colours.channel[channel].pixel + pixel;
            const auto below = hn::Load(d, plane);
            auto blended = hn::Add(source, hn::Mul(below, transparency));
            if (eight_bits) blended = hn::Round(blended);
            hn::Store(hn::IfThenElse(mask, blended, below), d, plane);
          });
    });
  }
}

void write_tile(const TileTask& task, const TileColours& colours, int x0, int y0) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = std::min(tile_size, task.image.width - x0);
  const int height = std::min(tile_size, task.image.height - y0);
  const auto scale = hn::Set(d, 1.0f / channel_scale(task));
  HWY_ALIGN float interleaved[4 * tile_size];
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < tile_size; x += lanes) {
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      const auto channel = [&](int k) HWY_ATTR {
        return hn::Mul(hn::Load(d, colours.channel[k].pixel + pixel), scale);
      };
      hn::StoreInterleaved4(channel(0), channel(1), channel(2), channel(3), d, interleaved + 4 * x);
    }
    const std::size_t first = static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(task.image.width) +
                              static_cast<std::size_t>(x0);
    std::memcpy(&task.image.pixels[first], interleaved, static_cast<std::size_t>(width) * sizeof(glm::vec4));
  }
}

void DrawTile(const TileTask& task, std::span<const DrawPass> passes, int tile) {
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  TileColours colours;
  TilePlane depths;
  clear(colours, clear_value(task));
  const bool uses_depth = std::any_of(passes.begin(), passes.end(), [](const DrawPass& pass) {
    return pass.depth_test != DepthTest::off || pass.depth_write;
  });
  if (uses_depth) fill(depths, infinity);
  const bool vertex_colours = task.colours.empty();
  for (const DrawPass& pass : passes) {
    if (vertex_colours && uses_depth) {
      draw_pass<true, true>(task, pass, tile, x0, y0, colours, depths);
    } else if (vertex_colours) {
      draw_pass<true, false>(task, pass, tile, x0, y0, colours, depths);
    } else if (uses_depth) {
      draw_pass<false, true>(task, pass, tile, x0, y0, colours, depths);
    } else {
      draw_pass<false, false>(task, pass, tile, x0, y0, colours, depths);
    }
  }
  write_tile(task, colours, x0, y0);
}

// Depth for peeling: linear on the screen, as what graphics hardware stores is, so that it takes no division a pixel.
// -1 / W in perspective and the distance along the camera axis in orthographic views: both grow with the distance, and
// a step of -1 / W in float32 is as fine, for the distance it stands for, as a step of the distance itself.
struct PeelDepth {
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
      const auto fx = hn::Iota(dd, static_cast<double>(x + lane));
      hn::Store(hn::DemoteTo(part, hn::Add(hn::Mul(hn::Set(dd, line.a), fx), row)), part, values + lane);
    }
    return hn::Clamp(hn::Load(d, values), hn::Set(d, nearest), hn::Set(d, farthest));
  }
};

// Runs over the tile once: peel(paint, pixel, x, y, mask, depth) for every vector of pixels in which something is
// covered.
template <bool vertex_colours, typename Peel>
void peel_pass(const TileTask& task, int tile, const Peel& peel) {
  const int x0 = task.bins.tile_x(tile), y0 = task.bins.tile_y(tile);
  TileEdges edges;
  Paint paint;
  PeelDepth depth;
  for (const BinEntry& entry : task.bins.tile(tile)) {
    if (!edges.set_up(task.projected, task.bins, entry, x0, y0)) continue;
    depth.set_up(task.projected, entry, edges.exact);
    paint.set_up<vertex_colours>(task, entry.facet, edges.exact);
    for_covered_pixels(task.projected, entry, edges, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      peel(paint, static_cast<std::size_t>(y * tile_size + x), x, y, mask, depth.at(x, y));
    });
  }
}

// The layer of one pass, as a render target keeps it. `combine(stored, source)` says what becomes of what is there.
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
  peel_pass<vertex_colours>(
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
  peel_pass<vertex_colours>(
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

void StartPeeling(const TileTask& task, PeeledTile& peeled) {
  clear(peeled.front, glm::vec4(0));
  clear(peeled.back, clear_value(task));
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

void CollectTile(const ProjectedMesh& projected, const FacetBins& bins, int tile,
                 std::vector<TileFragment>& fragments) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int x0 = bins.tile_x(tile), y0 = bins.tile_y(tile);
  TileEdges edges;
  for (const BinEntry& entry : bins.tile(tile)) {
    if (!edges.set_up(projected, bins, entry, x0, y0)) continue;
    for_covered_pixels(projected, entry, edges, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      alignas(8) std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, mask, bits);
      for (int lane = 0; lane < lanes && x + lane <= entry.x1; ++lane) {
        if ((bits[lane / 8] >> (lane % 8) & 1) == 0) continue;
        const PixelDepth depth = depth_at_pixel(projected, entry.facet, entry.facing, x0 + x + lane, y0 + y);
        fragments.push_back({entry.facet, static_cast<std::uint16_t>(y * tile_size + x + lane),
                             static_cast<float>(depth.error), depth.depth});
      }
    });
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::blend_internal {

HWY_EXPORT(DrawTile);
HWY_EXPORT(StartPeeling);
HWY_EXPORT(PeelTile);
HWY_EXPORT(FinishPeeling);
HWY_EXPORT(CollectTile);

void draw_tile(const TileTask& task, std::span<const DrawPass> passes, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawTile)(task, passes, tile);
}

void start_peeling(const TileTask& task, PeeledTile& peeled) { HWY_DYNAMIC_DISPATCH(StartPeeling)(task, peeled); }

bool peel_tile(const TileTask& task, Peeling peeling, int tile, PeeledTile& peeled) {
  return HWY_DYNAMIC_DISPATCH(PeelTile)(task, peeling, tile, peeled);
}

void finish_peeling(const TileTask& task, int tile, PeeledTile& peeled) {
  HWY_DYNAMIC_DISPATCH(FinishPeeling)(task, tile, peeled);
}

void collect_tile(const ProjectedMesh& projected, const FacetBins& bins, int tile,
                  std::vector<TileFragment>& fragments) {
  HWY_DYNAMIC_DISPATCH(CollectTile)(projected, bins, tile, fragments);
}

}  // namespace facetsort::blend_internal
#endif
