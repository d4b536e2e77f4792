#include "facetsort/blend/shading.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/facet_kernels.h"
#include "facetsort/blend/texture.h"

namespace facetsort {
namespace {

using blend_internal::ambient_light, blend_internal::default_hue_step, blend_internal::diffuse_light;

constexpr std::size_t facets_per_task = 4096;

// The finaliser of MurmurHash3 (Appleby 2011): every bit of the id changes half of the bits of the hash.
std::uint32_t hash(std::uint32_t id) {
  id = (id ^ (id >> 16)) * 0x85ebca6bu;
  id = (id ^ (id >> 13)) * 0xc2b2ae35u;
  return id ^ (id >> 16);
}

// To [0, 1], without a branch: hues are random, so one would be mispredicted.
float clamped(float value) {
  return 0.5f * (1 + std::abs(value) - std::abs(value - 1));
}

// In double no product below leaves the range of normal numbers, whatever the scale of the mesh.
inline float light_on(const MeshView& mesh, std::uint32_t facet, const glm::dvec4& eye) {
  const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const glm::dvec3 to_eye = 3.0 * glm::dvec3(eye) - eye.w * (a + b + c);  // three times the way from the centroid
  const double squared_lengths = glm::dot(normal, normal) * glm::dot(to_eye, to_eye);
  if (!(squared_lengths > 0)) return 1;
  const double cosine = std::abs(glm::dot(normal, to_eye)) / std::sqrt(squared_lengths);
  return ambient_light + diffuse_light * static_cast<float>(std::min(cosine, 1.0));
}

inline glm::vec4 premultiplied(const glm::vec4& straight, float light) {
  const float scale = straight.a * light;
  return {straight.r * scale, straight.g * scale, straight.b * scale, straight.a};
}

// With alpha as the mode has it; of an opaque material, corner_colour() sees to that.
glm::vec4 masked(const Material& material, glm::vec4 straight) {
  if (material.alpha_mode == AlphaMode::mask) straight.a = straight.a < material.alpha_cutoff ? 0.0f : 1.0f;
  return straight;
}

inline glm::vec4 lit_facet(const MeshView& mesh, std::uint32_t facet, const glm::dvec4& eye) {
  const Material* material = material_of(mesh, facet);
  const glm::vec4 straight = material != nullptr          ? masked(*material, corner_colour(mesh, facet, 0))
                             : mesh.facet_colours.empty() ? default_facet_colour(facet)
                                                          : mesh.facet_colours[facet];
  return premultiplied(straight, light_on(mesh, facet, eye));
}

// Weights of the corners where the ray meets the facet's plane: each is the signed volume spanned by the ray and the
// opposite edge. Rounding can leave a hit just outside; it is moved onto the facet, so that no colour is extrapolated.
std::array<double, 3> barycentric(const MeshView& mesh, std::uint32_t facet, const Ray& ray) {
  std::array<glm::dvec3, 3> corner;
  for (int i = 0; i < 3; ++i) corner[i] = glm::dvec3(mesh.corner(facet, i)) - ray.origin;
  std::array<double, 3> volume;
  for (int i = 0; i < 3; ++i) volume[i] = glm::dot(ray.direction, glm::cross(corner[(i + 1) % 3], corner[(i + 2) % 3]));
  const double sign = volume[0] + volume[1] + volume[2] < 0 ? -1 : 1;
  for (double& v : volume) v = std::max(sign * v, 0.0);
  const double sum = volume[0] + volume[1] + volume[2];
  if (!(sum > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
  return {volume[0] / sum, volume[1] / sum, volume[2] / sum};
}

}  // namespace

bool has_one_colour_per_facet(const MeshView& mesh) {
  if (mesh.facet_colours.empty() && !mesh.vertex_colours.empty()) return false;
  return mesh.facet_materials.empty() ||
         std::none_of(mesh.materials.begin(), mesh.materials.end(),
                      [](const Material& material) { return material.texture != Material::no_texture; });
}

glm::vec4 corner_colour(const MeshView& mesh, std::uint32_t facet, int corner) {
  glm::vec4 colour(1);
  if (!mesh.facet_colours.empty()) {
    colour = mesh.facet_colours[facet];
  } else if (!mesh.vertex_colours.empty()) {
    colour = mesh.vertex_colours[mesh.triangles[facet][corner]];
  }
  const Material* material = material_of(mesh, facet);
  if (material == nullptr) return colour;
  colour *= material->base_colour;
  if (material->alpha_mode == AlphaMode::opaque) colour.a = 1;
  return colour;
}

glm::vec4 default_facet_colour(std::uint32_t facet) {
  // [0, 6): red, yellow, green, ... red; 16 bits, so that all that follows is exact.
  const float hue = static_cast<float>(hash(facet) >> 16) * default_hue_step;
  return {clamped(std::abs(hue - 3) - 1), clamped(2 - std::abs(hue - 2)), clamped(2 - std::abs(hue - 4)),
          default_alpha};
}

float headlight(const MeshView& mesh, std::uint32_t facet, const glm::vec4& homogeneous_eye) {
  return light_on(mesh, facet, glm::dvec4(homogeneous_eye));
}

glm::vec4 facet_colour(const MeshView& mesh, std::uint32_t facet, const glm::vec4& homogeneous_eye) {
  assert(has_one_colour_per_facet(mesh));
  return lit_facet(mesh, facet, glm::dvec4(homogeneous_eye));
}

glm::vec4 fragment_colour(const MeshView& mesh, std::uint32_t facet, const Ray& ray, const glm::vec4& homogeneous_eye) {
  if (has_one_colour_per_facet(mesh)) return facet_colour(mesh, facet, homogeneous_eye);
  const std::array<double, 3> weight = barycentric(mesh, facet, ray);
  glm::dvec4 sum(0);
  for (int i = 0; i < 3; ++i) sum += weight[i] * glm::dvec4(corner_colour(mesh, facet, i));
  glm::vec4 straight(sum);
  if (const Texture* texture = texture_of(mesh, facet)) {
    glm::dvec2 at(0);
    for (int i = 0; i < 3; ++i) at += weight[i] * glm::dvec2(mesh.texture_coordinates[mesh.triangles[facet][i]]);
    const glm::vec4 texel = sample(*texture, at);
    const bool opaque = material_of(mesh, facet)->alpha_mode == AlphaMode::opaque;
    straight *= opaque ? glm::vec4(glm::vec3(texel), 1) : texel;
  }
  if (const Material* material = material_of(mesh, facet)) straight = masked(*material, straight);
  return premultiplied(straight, headlight(mesh, facet, homogeneous_eye));
}

void facet_colours(const MeshView& mesh, const glm::vec4& homogeneous_eye, std::vector<glm::vec4>& colours) {
  assert(has_one_colour_per_facet(mesh));
  colours.resize(mesh.facet_count());
  parallel_ranges(mesh.facet_count(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    if (mesh.facet_materials.empty()) {
      blend_internal::colour_facets(mesh, homogeneous_eye, begin, end, colours.data() + begin);
      return;
    }
    for (std::size_t facet = begin; facet < end; ++facet) {
      colours[facet] = lit_facet(mesh, static_cast<std::uint32_t>(facet), glm::dvec4(homogeneous_eye));
    }
  });
}

}  // namespace facetsort
