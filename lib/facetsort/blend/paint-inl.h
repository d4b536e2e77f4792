// Internal to blend: the colours of the fragments of a tile, a plane a channel.
#if defined(FACETSORT_BLEND_PAINT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_PAINT_INL_H
#undef FACETSORT_BLEND_PAINT_INL_H
#else
#define FACETSORT_BLEND_PAINT_INL_H
#endif

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "facetsort/blend/covered_rows-inl.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/texture.h"
#include "facetsort/blend/tile_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

bool is_culled(const DrawPass& pass, const BinEntry& entry) {
  return (pass.cull == Cull::back_faces && !entry.is_front) || (pass.cull == Cull::front_faces && entry.is_front);
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
    const auto fx = hn::Add(hn::Iota(dd, 0), hn::Set(dd, static_cast<double>(x + lane)));
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
  std::uint32_t facet;
  glm::vec4 flat;  // premultiplied, where each facet has one colour
  Interpolant denominator, colour[4], place_in_texture[2];
  const Texture* texture;
  const Material* material;
  float light;

  // `edges`: in the coordinates of the tile.
  template <bool vertex_colours>
  void set_up(const TileTask& task, std::uint32_t painted, const FacetEdges& edges) {
    facet = painted;
    if constexpr (vertex_colours) {
      const MeshView& mesh = task.projected.mesh;
      light = headlight(mesh, facet, task.projected.view.homogeneous_eye());
      denominator = Interpolant::of(edges, 1, 1, 1);
      const glm::vec4 c0 = corner_colour(mesh, facet, 0), c1 = corner_colour(mesh, facet, 1),
                      c2 = corner_colour(mesh, facet, 2);
      for (int k = 0; k < 4; ++k) colour[k] = Interpolant::of(edges, c0[k], c1[k], c2[k]);
      material = material_of(mesh, facet);
      texture = texture_of(mesh, facet);
      if (texture == nullptr) return;
      const glm::uvec3& t = mesh.triangles[facet];
      const std::span<const glm::vec2> at = mesh.texture_coordinates;
      for (int k = 0; k < 2; ++k) place_in_texture[k] = Interpolant::of(edges, at[t[0]][k], at[t[1]][k], at[t[2]][k]);
    } else {
      flat = task.colours[facet];
      material = material_of(task.projected.mesh, facet);
    }
  }
};

// Whether a material leaves fragments out.
bool is_masked(const Paint& paint) {
  return paint.material != nullptr && paint.material->alpha_mode == AlphaMode::mask;
}

// Straight colours of the vector of pixels that starts at (x, y).
struct PaintColours {
  hn::VFromD<FloatTag> channel[4];
};

// Times the texture's at each pixel.
HWY_INLINE void apply_texture(const Paint& paint, int x, int y, PaintColours& colours) {
  const FloatTag d;
  HWY_ALIGN float u[tile_size], v[tile_size], texels[4][tile_size];
  hn::Store(interpolate(paint.place_in_texture[0], paint.denominator, x, y), d, u);
  hn::Store(interpolate(paint.place_in_texture[1], paint.denominator, x, y), d, v);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    // Beyond the facet's edges anything may come of the division.
    const bool is_finite = std::isfinite(u[lane]) && std::isfinite(v[lane]);
    const glm::vec4 texel = is_finite ? sample(*paint.texture, {u[lane], v[lane]}) : glm::vec4(0);
    for (int k = 0; k < 4; ++k) texels[k][lane] = texel[k];
  }
  const int channels = paint.material->alpha_mode == AlphaMode::opaque ? 3 : 4;
  for (int k = 0; k < channels; ++k) colours.channel[k] = hn::Mul(colours.channel[k], hn::Load(d, texels[k]));
}

HWY_INLINE PaintColours paint_colours(const Paint& paint, int x, int y) {
  const FloatTag d;
  PaintColours colours;
  for (int k = 0; k < 4; ++k) colours.channel[k] = interpolate(paint.colour[k], paint.denominator, x, y);
  if (paint.texture != nullptr) apply_texture(paint, x, y, colours);
  if (is_masked(paint)) {
    const auto is_out = hn::Lt(colours.channel[3], hn::Set(d, paint.material->alpha_cutoff));
    colours.channel[3] = hn::IfThenElse(is_out, hn::Zero(d), hn::Set(d, 1.0f));
  }
  return colours;
}

// The fragments, of the vector of pixels that starts at (x, y), that the material does not leave out.
template <bool vertex_colours>
HWY_INLINE hn::Mask<FloatTag> drawn_by_material(const Paint& paint, int x, int y) {
  const FloatTag d;
  if constexpr (vertex_colours) {
    return hn::Gt(paint_colours(paint, x, y).channel[3], hn::Zero(d));
  } else {
    return hn::Gt(hn::Set(d, paint.flat.a), hn::Zero(d));
  }
}

// Calls blend(channel, source, transparency) for the four channels of the vector of pixels that starts at (x, y), the
// source premultiplied and in units of the format.
template <bool vertex_colours, typename Blend>
HWY_INLINE void blend_paint(const Paint& paint, float channel_scale, int x, int y, const Blend& blend) {
  const FloatTag d;
  const auto scale = hn::Set(d, channel_scale);
  if constexpr (vertex_colours) {
    const PaintColours colours = paint_colours(paint, x, y);
    const auto alpha = colours.channel[3];
    const auto transparency = hn::Sub(hn::Set(d, 1.0f), alpha);
    const auto factor = hn::Mul(hn::Mul(alpha, hn::Set(d, paint.light)), scale);
    for (int k = 0; k < 3; ++k) {
      blend(k, hn::Mul(colours.channel[k], factor), transparency);
    }
    blend(3, hn::Mul(alpha, scale), transparency);
  } else {
    const auto transparency = hn::Set(d, 1.0f - paint.flat.a);
    for (int k = 0; k < 4; ++k) blend(k, hn::Mul(hn::Set(d, paint.flat[k]), scale), transparency);
  }
}

// Of the vector of pixels that starts at (x, y).
template <bool vertex_colours>
HWY_INLINE hn::VFromD<FloatTag> alpha_of(const Paint& paint, int x, int y) {
  if constexpr (vertex_colours) {
    const bool is_plain = paint.texture == nullptr && !is_masked(paint);
    return is_plain ? interpolate(paint.colour[3], paint.denominator, x, y) : paint_colours(paint, x, y).channel[3];
  } else {
    return hn::Set(FloatTag(), paint.flat.a);
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

// What stands in the tile before anything is blended there, in units of the format.
void fill_with_what_is_below(const TileTask& task, int tile, TileColours& colours) {
  if (task.opaque.empty()) {
    clear(colours, clear_value(task));
  } else {
    colours = task.opaque[static_cast<std::size_t>(tile)].colours;
  }
}

// Edge functions in double, in the coordinates of the tile that begins at (x0, y0).
FacetEdges edges_in_tile(const ProjectedMesh& projected, const BinEntry& entry, int x0, int y0) {
  return facet_edges(projected, entry.facet, entry.facing(), {x0 + 0.5, y0 + 0.5}, tile_size);
}

// The channels of the picture from a pixel on.
float* picture_row(Image& image, int x, int y) {
  const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width);
  return &image.pixels[row + static_cast<std::size_t>(x)].x;
}

// An 8-bit target holds no more than 1.
void write_tile(const TileTask& task, const TileColours& colours, int x0, int y0) {
  const FloatTag d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const int width = std::min(tile_size, task.image.width - x0);
  const int height = std::min(tile_size, task.image.height - y0);
  const auto scale = hn::Set(d, 1.0f / channel_scale(task));
  const auto most = hn::Set(d, task.format == PixelFormat::rgba8 ? channel_scale(task) : infinity);
  HWY_ALIGN float interleaved[4 * tile_size];
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < tile_size; x += lanes) {
      const std::size_t pixel = static_cast<std::size_t>(y * tile_size + x);
      const auto channel = [&](int k) HWY_ATTR {
        return hn::Mul(hn::Min(hn::Load(d, colours.channel[k].pixel + pixel), most), scale);
      };
      hn::StoreInterleaved4(channel(0), channel(1), channel(2), channel(3), d, interleaved + 4 * x);
    }
    std::memcpy(picture_row(task.image, x0, y0 + y), interleaved, static_cast<std::size_t>(width) * sizeof(glm::vec4));
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
