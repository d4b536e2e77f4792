#include "facetsort/plan/appearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

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

}  // namespace

Appearance find_appearance(const MeshView& mesh) {
  Appearance appearance;
  const bool has_colours = !mesh.facet_colours.empty() || !mesh.vertex_colours.empty() || !mesh.materials.empty();
  const std::vector<ColourBounds> textures = bounds_of_textures(mesh);
  ColourBounds all;
  for (std::uint32_t facet = 0; facet < mesh.facet_count(); ++facet) {
    const Material* material = material_of(mesh, facet);
    if (material != nullptr && material->alpha_mode != AlphaMode::blend) continue;
    ++appearance.blended;
    appearance.all_single_sided = appearance.all_single_sided && is_single_sided(mesh, facet);
    if (!has_colours) {
      all.add(default_facet_colour(facet));
      continue;
    }
    // Products of bounds: no channel is negative.
    const ColourBounds* texture =
        texture_of(mesh, facet) == nullptr ? nullptr : &textures[material->texture];
    for (int corner = 0; corner < 3; ++corner) {
      const glm::vec4 colour = corner_colour(mesh, facet, corner);
      all.add(texture == nullptr ? colour : colour * texture->lowest);
      if (texture != nullptr) all.add(colour * texture->highest);
    }
  }
  if (appearance.blended == 0) return appearance;
  appearance.lowest_alpha = all.lowest.a;
  appearance.highest_alpha = all.highest.a;
  const glm::vec3 range = glm::vec3(all.highest) - least_light * glm::vec3(all.lowest);
  appearance.colour_range = std::max({range.x, range.y, range.z});
  return appearance;
}

std::optional<std::size_t> layers_that_matter(float lowest_alpha) {
  if (!(lowest_alpha > 0)) return std::nullopt;
  double light = 1;
  std::size_t layers = 0;
  while (light >= display_step / 2) {
    light *= 1 - static_cast<double>(lowest_alpha);
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
