// Internal to blend: the colour of each facet of a mesh, lit. One facet a lane.
//
// The same operations on the same values as facet_colour(), so the same colours to the bit.
#if defined(FACETSORT_BLEND_COLOUR_FACETS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_COLOUR_FACETS_INL_H
#undef FACETSORT_BLEND_COLOUR_FACETS_INL_H
#else
#define FACETSORT_BLEND_COLOUR_FACETS_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "facetsort/blend/facet_kernels.h"
#include "facetsort/blend/shading.h"
#include "facetsort/mesh/mesh_view.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using LightTag = hn::CappedTag<double, facets_per_block>;
using Lights = hn::VFromD<LightTag>;
using ColourTag = hn::CappedTag<float, facets_per_block>;
using ColourFloats = hn::VFromD<ColourTag>;

struct CornerPositions {
  HWY_ALIGN float coordinate[3][3][facets_per_block];  // of a corner: x, y, z

  void gather(const MeshView& mesh, std::size_t first, std::size_t count) {
    for (std::size_t k = 0; k < facets_per_block; ++k) {
      const glm::uvec3& triangle = mesh.triangles[first + std::min(k, count - 1)];
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec3& position = mesh.positions[triangle[corner]];
        for (int axis = 0; axis < 3; ++axis) coordinate[corner][axis][k] = position[axis];
      }
    }
  }
};

struct DoubleVec3 {
  Lights x, y, z;

  static HWY_INLINE DoubleVec3 load(const float (&coordinate)[3][facets_per_block], std::size_t k) {
    const LightTag d;
    const hn::Rebind<float, LightTag> df;
    const auto axis = [&](int i) HWY_ATTR { return hn::PromoteTo(d, hn::Load(df, coordinate[i] + k)); };
    return {axis(0), axis(1), axis(2)};
  }
};

HWY_INLINE DoubleVec3 add(const DoubleVec3& a, const DoubleVec3& b) {
  return {hn::Add(a.x, b.x), hn::Add(a.y, b.y), hn::Add(a.z, b.z)};
}

HWY_INLINE DoubleVec3 subtract(const DoubleVec3& a, const DoubleVec3& b) {
  return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)};
}

HWY_INLINE Lights dot(const DoubleVec3& a, const DoubleVec3& b) {
  return hn::Add(hn::Add(hn::Mul(a.x, b.x), hn::Mul(a.y, b.y)), hn::Mul(a.z, b.z));
}

HWY_INLINE DoubleVec3 cross(const DoubleVec3& a, const DoubleVec3& b) {
  return {hn::Sub(hn::Mul(a.y, b.z), hn::Mul(b.y, a.z)), hn::Sub(hn::Mul(a.z, b.x), hn::Mul(b.z, a.x)),
          hn::Sub(hn::Mul(a.x, b.y), hn::Mul(b.x, a.y))};
}

// headlight() of facets from the k-th of the block on, as floats.
HWY_INLINE void light_vector(const CornerPositions& corners, const glm::dvec4& eye, std::size_t k, float* lights) {
  const LightTag d;
  const hn::Rebind<float, LightTag> df;
  const DoubleVec3 a = DoubleVec3::load(corners.coordinate[0], k), b = DoubleVec3::load(corners.coordinate[1], k),
                   c = DoubleVec3::load(corners.coordinate[2], k);
  const DoubleVec3 normal = cross(subtract(b, a), subtract(c, a));
  const DoubleVec3 sum = add(add(a, b), c);
  const Lights w = hn::Set(d, eye.w);
  const DoubleVec3 to_eye = subtract({hn::Set(d, 3.0 * eye.x), hn::Set(d, 3.0 * eye.y), hn::Set(d, 3.0 * eye.z)},
                                     {hn::Mul(w, sum.x), hn::Mul(w, sum.y), hn::Mul(w, sum.z)});
  const Lights squared_lengths = hn::Mul(dot(normal, normal), dot(to_eye, to_eye));
  // Degenerate facets, and those whose centroid is the eye, are lit in full.
  const Lights zero = hn::Zero(d), one = hn::Set(d, 1.0);
  const auto is_lit = hn::Gt(squared_lengths, zero);
  const Lights length = hn::Sqrt(hn::IfThenElse(is_lit, squared_lengths, one));
  const Lights cosine = hn::Min(hn::Div(hn::Abs(dot(normal, to_eye)), length), one);
  const auto light = hn::Add(hn::Set(df, ambient_light), hn::Mul(hn::Set(df, diffuse_light), hn::DemoteTo(df, cosine)));
  const auto counts = hn::DemoteTo(df, hn::IfThenElse(is_lit, one, zero));
  hn::Store(hn::IfThenElse(hn::Gt(counts, hn::Zero(df)), light, hn::Set(df, 1.0f)), df, lights + k);
}

// To [0, 1].
HWY_INLINE ColourFloats clamped(ColourFloats value) {
  const ColourTag d;
  const ColourFloats one = hn::Set(d, 1.0f);
  return hn::Mul(hn::Set(d, 0.5f), hn::Sub(hn::Add(one, hn::Abs(value)), hn::Abs(hn::Sub(value, one))));
}

struct StraightColours {
  ColourFloats r, g, b, a;
};

// default_facet_colour() of facets from `first` on.
HWY_INLINE StraightColours default_colours(std::uint32_t first) {
  const ColourTag d;
  const hn::RebindToUnsigned<ColourTag> du;
  const hn::RebindToSigned<ColourTag> di;
  auto hash = hn::Add(hn::Iota(du, 0), hn::Set(du, first));
  hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<16>(hash)), hn::Set(du, 0x85ebca6bu));
  hash = hn::Mul(hn::Xor(hash, hn::ShiftRight<13>(hash)), hn::Set(du, 0xc2b2ae35u));
  hash = hn::Xor(hash, hn::ShiftRight<16>(hash));
  const ColourFloats hue =
      hn::Mul(hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<16>(hash))), hn::Set(d, default_hue_step));
  const auto away_from = [&](float centre) HWY_ATTR { return hn::Abs(hn::Sub(hue, hn::Set(d, centre))); };
  const ColourFloats one = hn::Set(d, 1.0f), two = hn::Set(d, 2.0f);
  return {clamped(hn::Sub(away_from(3), one)), clamped(hn::Sub(two, away_from(2))), clamped(hn::Sub(two, away_from(4))),
          hn::Set(d, default_alpha)};
}

StraightColours load_colours(const glm::vec4* colours) {
  const ColourTag d;
  StraightColours straight;
  hn::LoadInterleaved4(d, &colours->x, straight.r, straight.g, straight.b, straight.a);
  return straight;
}

void ColourFacets(const MeshView& mesh, const glm::vec4& homogeneous_eye, std::size_t begin, std::size_t end,
                  glm::vec4* colours) {
  const ColourTag d;
  const glm::dvec4 eye(homogeneous_eye);
  CornerPositions corners;
  HWY_ALIGN float lights[facets_per_block];
  glm::vec4 straight_copy[facets_per_block] = {}, lit_copy[facets_per_block];
  for (std::size_t first = begin; first < end; first += facets_per_block, colours += facets_per_block) {
    const std::size_t count = std::min(facets_per_block, end - first);
    const bool is_whole = count == facets_per_block;
    corners.gather(mesh, first, count);
    for (std::size_t k = 0; k < count; k += hn::Lanes(LightTag())) light_vector(corners, eye, k, lights);

    const glm::vec4* own = nullptr;
    if (!mesh.facet_colours.empty()) {
      own = mesh.facet_colours.data() + first;
      if (!is_whole) own = std::copy_n(own, count, straight_copy) - count;
    }
    glm::vec4* const lit = is_whole ? colours : lit_copy;
    for (std::size_t k = 0; k < count; k += hn::Lanes(d)) {
      const StraightColours straight =
          own ? load_colours(own + k) : default_colours(static_cast<std::uint32_t>(first + k));
      const ColourFloats scale = hn::Mul(straight.a, hn::Load(d, lights + k));
      hn::StoreInterleaved4(hn::Mul(straight.r, scale), hn::Mul(straight.g, scale), hn::Mul(straight.b, scale),
                            straight.a, d, &lit[k].x);
    }
    if (!is_whole) std::copy_n(lit_copy, count, colours);
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
