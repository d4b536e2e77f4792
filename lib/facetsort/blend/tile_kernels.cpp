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

// Edges of one facet in one tile, scaled to change by at most 1 a pixel, in float. Where every edge's value exceeds
// `error` the facet covers the pixel, where one is below -error it does not; between, float can't tell.
struct TileEdges {
  float a[3], b[3], c[3], error;
  float near_a = 0, near_b = 0, near_c = 0;  // not negative where the fragment is not nearer than the near plane
  FacetEdges exact;              // relative to the tile's first pixel centre

  // False when the facet covers no pixel of the entry's box.
  bool set_up(const ProjectedMesh& projected, const BinEntry& entry, int x0, int y0) {
    // In float: three roundings of coefficients, two products and two sums, of values that stay below 4 tile_size.
    constexpr double float_error = 16 * tile_size * 0x1p-24;
    exact = facet_edges(projected, entry.facet, entry.facing, {x0 + 0.5, y0 + 0.5}, tile_size);
    double largest_error = 0;
    for (int i = 0; i < 3; ++i) {
      const double slope = std::abs(exact.a[i]) + std::abs(exact.b[i]);
      // Where the slope is below what a double can divide by, everything is in doubt.
      const double scale = slope > 1e-290 ? 1 / slope : 0.0;
      a[i] = static_cast<float>(exact.a[i] * scale);
      b[i] = static_cast<float>(exact.b[i] * scale);
      // An edge that far from the tile has one sign on all of it.
      c[i] = static_cast<float>(std::clamp(exact.c[i] * scale, -2.0 * tile_size, 2.0 * tile_size));
      largest_error = std::max(largest_error, scale > 0 ? exact.error[i] * scale : 1.0);
    }
    error = static_cast<float>(std::min(largest_error + float_error, 4.0 * tile_size));
    for (int i = 0; i < 3; ++i) {
      const float highest = c[i] + std::max(a[i] * static_cast<float>(entry.x0), a[i] * static_cast<float>(entry.x1)) +
                            std::max(b[i] * static_cast<float>(entry.y0), b[i] * static_cast<float>(entry.y1));
      if (highest < -2 * error) return false;
    }
    if (entry.crosses_near) set_up_near(projected, entry);
    return true;
  }

 private:
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

// Calls emit(x, y, mask) for each vector of pixels from (x, y) to the right of which the facet covers some.
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
      const auto lowest = hn::Min(hn::Min(e0, e1), e2);
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
              covers_pixel(projected, entry.facet, entry.facing, x0 + x + lane, y0 + y)) {
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

struct TilePlanes {
  HWY_ALIGN float channel[4][tile_size * tile_size];
  HWY_ALIGN float depth[tile_size * tile_size];
};

template <bool vertex_colours, bool depth>
void draw_pass(const DrawTask& task, const DrawPass& pass, std::span<const BinEntry> entries, int x0, int y0,
               TilePlanes& planes) {
  const FloatTag d;
  const ProjectedMesh& projected = task.projected;
  const MeshView& mesh = projected.mesh;
  const bool eight_bits = task.format == PixelFormat::rgba8;
  const auto channel_scale = hn::Set(d, eight_bits ? 255.0f : 1.0f);
  const glm::vec4 homogeneous_eye = projected.view.homogeneous_eye();
  TileEdges edges;
  for (const BinEntry& entry : entries) {
    if (pass.cull == Cull::back_faces && entry.facing < 0) continue;
    if (pass.cull == Cull::front_faces && entry.facing > 0) continue;
    if (!edges.set_up(projected, entry, x0, y0)) continue;

    Interpolant denominator, distance, colour[4];
    float light = 1;
    if constexpr (vertex_colours || depth) denominator = Interpolant::of(edges.exact, 1, 1, 1);
    if constexpr (depth) {
      double along_axis[3];
      for (int i = 0; i < 3; ++i) {
        along_axis[i] =
            glm::dot(projected.camera.forward, glm::dvec3(mesh.corner(entry.facet, i)) - projected.camera.eye);
      }
      distance = Interpolant::of(edges.exact, along_axis[0], along_axis[1], along_axis[2]);
    }
    if constexpr (vertex_colours) {
      light = headlight(mesh, entry.facet, homogeneous_eye);
      const glm::uvec3& t = mesh.triangles[entry.facet];
      const auto& colours = mesh.vertex_colours;
      for (int k = 0; k < 4; ++k) {
        colour[k] = Interpolant::of(edges.exact, colours[t[0]][k], colours[t[1]][k], colours[t[2]][k]);
      }
    }

    const auto blend = [&](std::size_t pixel, hn::Mask<FloatTag> mask, int channel, hn::VFromD<FloatTag> source,
                           hn::VFromD<FloatTag> transparency) HWY_ATTR {
      float* plane = planes.channel[channel] + pixel;
      const auto below = hn::Load(d, plane);
      auto blended = hn::Add(source, hn::Mul(below, transparency));
      if (eight_bits) blended = hn::Round(blended);
      hn::Store(hn::IfThenElse(mask, blended, below), d, plane);
    };
    const glm::vec4 flat = vertex_colours ? glm::vec4(0) : task.colours[entry.facet];

    for_covered_pixels(projected, entry, edges, x0, y0, [&](int x, int y, hn::Mask<FloatTag> mask) HWY_ATTR {
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      if constexpr (depth) {
        const auto stored = hn::Load(d, planes.depth + pixel);
        const auto fragment = interpolate(distance, denominator, x, y);
        if (pass.depth_test == DepthTest::less) mask = hn::And(mask, hn::Lt(fragment, stored));
        if (pass.depth_test == DepthTest::less_or_equal) mask = hn::And(mask, hn::Le(fragment, stored));
        if (pass.depth_write) hn::Store(hn::IfThenElse(mask, fragment, stored), d, planes.depth + pixel);
        if (!pass.colour_write) return;
      }
      if constexpr (vertex_colours) {
        const auto alpha = interpolate(colour[3], denominator, x, y);
        const auto transparency = hn::Sub(hn::Set(d, 1.0f), alpha);
        const auto factor = hn::Mul(hn::Mul(alpha, hn::Set(d, light)), channel_scale);
        for (int k = 0; k < 3; ++k) {
          blend(pixel, mask, k, hn::Mul(interpolate(colour[k], denominator, x, y), factor), transparency);
        }
        blend(pixel, mask, 3, hn::Mul(alpha, channel_scale), transparency);
      } else {
        const auto transparency = hn::Set(d, 1.0f - flat.a);
        for (int k = 0; k < 4; ++k) blend(pixel, mask, k, hn::Mul(hn::Set(d, flat[k]), channel_scale), transparency);
      }
    });
  }
}

void write_tile(const DrawTask& task, const TilePlanes& planes, int x0, int y0) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = std::min(tile_size, task.image.width - x0);
  const int height = std::min(tile_size, task.image.height - y0);
  const auto scale = hn::Set(d, task.format == PixelFormat::rgba8 ? 1.0f / 255.0f : 1.0f);
  HWY_ALIGN float interleaved[4 * tile_size];
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < tile_size; x += lanes) {
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      const auto channel = [&](int k) HWY_ATTR { return hn::Mul(hn::Load(d, planes.channel[k] + pixel), scale); };
      hn::StoreInterleaved4(channel(0), channel(1), channel(2), channel(3), d, interleaved + 4 * x);
    }
    const std::size_t first = static_cast<std::size_t>(y0 + y) * static_cast<std::size_t>(task.image.width) +
                              static_cast<std::size_t>(x0);
    std::memcpy(&task.image.pixels[first], interleaved, static_cast<std::size_t>(width) * sizeof(glm::vec4));
  }
}

void DrawTile(const DrawTask& task, std::span<const BinEntry> entries, int x0, int y0) {
  TilePlanes planes;
  for (int k = 0; k < 4; ++k) {
    const float value =
        task.format == PixelFormat::rgba8 ? std::round(task.clear_colour[k] * 255.0f) : task.clear_colour[k];
    std::fill(std::begin(planes.channel[k]), std::end(planes.channel[k]), value);
  }
  const bool uses_depth = std::any_of(task.passes.begin(), task.passes.end(), [](const DrawPass& pass) {
    return pass.depth_test != DepthTest::off || pass.depth_write;
  });
  if (uses_depth) {
    std::fill(std::begin(planes.depth), std::end(planes.depth), std::numeric_limits<float>::infinity());
  }
  const bool vertex_colours = task.colours.empty();
  for (const DrawPass& pass : task.passes) {
    if (vertex_colours && uses_depth) {
      draw_pass<true, true>(task, pass, entries, x0, y0, planes);
    } else if (vertex_colours) {
      draw_pass<true, false>(task, pass, entries, x0, y0, planes);
    } else if (uses_depth) {
      draw_pass<false, true>(task, pass, entries, x0, y0, planes);
    } else {
      draw_pass<false, false>(task, pass, entries, x0, y0, planes);
    }
  }
  write_tile(task, planes, x0, y0);
}

void CollectTile(const ProjectedMesh& projected, std::span<const BinEntry> entries, int x0, int y0,
                 std::vector<TileFragment>& fragments) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  TileEdges edges;
  for (const BinEntry& entry : entries) {
    if (!edges.set_up(projected, entry, x0, y0)) continue;
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
HWY_EXPORT(CollectTile);

void draw_tile(const DrawTask& task, std::span<const BinEntry> entries, int x0, int y0) {
  HWY_DYNAMIC_DISPATCH(DrawTile)(task, entries, x0, y0);
}

void collect_tile(const ProjectedMesh& projected, std::span<const BinEntry> entries, int x0, int y0,
                  std::vector<TileFragment>& fragments) {
  HWY_DYNAMIC_DISPATCH(CollectTile)(projected, entries, x0, y0, fragments);
}

}  // namespace facetsort::blend_internal
#endif  // HWY_ONCE
