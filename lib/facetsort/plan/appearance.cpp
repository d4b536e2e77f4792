#include "facetsort/plan/appearance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "facetsort/blend/shading.h"

namespace facetsort::plan_internal {
namespace {

constexpr double display_step = 1.0 / 255;
constexpr float least_light = 0.25f;  // of headlight()

struct ColourBounds {
  glm::vec4 lowest{std::numeric_limits<float>::infinity()}, highest{-std::numeric_limits<float>::infinity()};

  void add(const glm::vec4& colour) {
    lowest = glm::min(lowest, colour);
    highest = glm::max(highest, colour);
  }
};

std::vector<ColourBounds> bounds_of_textures(const MeshView& mesh) {
  std::vector<ColourBounds> bounds(mesh.textures.size());
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    for (const glm::vec4& texel : mesh.textures[i].texels) bounds[i].add(texel);
  }
  return bounds;
}

// Of one facet, before light; products of bounds, as no channel is negative.
ColourBounds bounds_of_facet(const MeshView& mesh, std::uint32_t facet, const std::vector<ColourBounds>& textures) {
  ColourBounds bounds;
  if (mesh.facet_colours.empty() && mesh.vertex_colours.empty() && mesh.materials.empty()) {
    bounds.add(default_facet_colour(facet));
    return bounds;
  }
  const ColourBounds* texture =
      texture_of(mesh, facet) == nullptr ? nullptr : &textures[material_of(mesh, facet)->texture];
  for (int corner = 0; corner < 3; ++corner) {
    const glm::vec4 colour = corner_colour(mesh, facet, corner);
    bounds.add(texture == nullptr ? colour : colour * texture->lowest);
    if (texture != nullptr) bounds.add(colour * texture->highest);
  }
  return bounds;
}

float brightest_of(const ColourBounds& bounds) {
  return std::max({bounds.highest.r, bounds.highest.g, bounds.highest.b});
}

}  // namespace

Appearance find_appearance(const MeshView& mesh) {
  Appearance appearance;
  const std::vector<ColourBounds> textures = bounds_of_textures(mesh);
  ColourBounds blended;
  for (std::uint32_t facet = 0; facet < mesh.facet_count(); ++facet) {
    const Material* material = material_of(mesh, facet);
    const bool is_blended = material == nullptr || material->alpha_mode == AlphaMode::blend;
    const ColourBounds bounds = bounds_of_facet(mesh, facet, textures);
    appearance.brightest = std::max(appearance.brightest, brightest_of(bounds));
    if (!is_blended) continue;
    appearance.all_single_sided = appearance.all_single_sided && is_single_sided(mesh, facet);
    blended.add(bounds.lowest);
    blended.add(bounds.highest);
  }
  appearance.lowest_alpha = blended.lowest.a;
  appearance.highest_alpha = blended.highest.a;
  const glm::vec3 range = glm::vec3(blended.highest) - least_light * glm::vec3(blended.lowest);
  appearance.colour_range = std::max({range.x, range.y, range.z});
  return appearance;
}

std::optional<std::size_t> layers_that_matter(const Appearance& appearance) {
  const double lowest_alpha = static_cast<double>(appearance.lowest_alpha);
  if (!(lowest_alpha > 0)) return std::nullopt;
  double light = static_cast<double>(appearance.brightest);
  std::size_t layers = 0;
  while (light >= display_step / 2) {
    light *= 1 - lowest_alpha;
    ++layers;
    if (layers > std::size_t{1} << 20) return std::nullopt;
  }
  return layers;
}

double order_error(const Appearance& appearance, std::size_t layers) {
  const double alpha = static_cast<double>(appearance.highest_alpha), count = static_cast<double>(layers);
  const double of_swaps = count * (count - 1) / 2 * alpha * alpha;
  const double opacity = 1 - std::pow(1 - std::min(alpha, 1.0), count);
  return std::min(of_swaps, opacity) * static_cast<double>(appearance.colour_range);
}

}  // namespace facetsort::plan_internal
