// Internal to plan: what can be told of a picture from colours and materials alone.
#pragma once

#include <cstddef>
#include <optional>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort::plan_internal {

struct Appearance {
  float lowest_alpha = 1, highest_alpha = 0;  // of the blended facets, textures included
  float colour_range = 0;  // largest difference of a channel between any two of their straight colours, light included
  float brightest = 1;     // the largest channel of any facet's colour, if above 1
  bool all_single_sided = true;  // of the blended ones
};

// One pass over facets, corners and texels. Precondition: some facet is blended.
Appearance find_appearance(const MeshView& mesh);

// The fewest layers through which, whatever they and those behind are of what can appear, less than half of a display
// step of 1/255 comes; nothing where the lowest alpha is not above 0.
std::optional<std::size_t> layers_that_matter(const Appearance& appearance);

// How far two orders of `layers` layers may differ, a channel: no pair of layers changes it by more than the product of
// their alphas times the range of colours, and no order leaves that range (see order_error_bound()).
double order_error(const Appearance& appearance, std::size_t layers);

}  // namespace facetsort::plan_internal
