// Groups of views that one order can serve. Internal to presort.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/presort/facet_pairs.h"

namespace facetsort::presort_internal {

// What some views see: their pairs, and the direction from the mesh's centre to each eye.
struct SeenViews {
  std::vector<glm::vec3> directions;  // unit
  std::vector<std::vector<SeenPair>> pairs;
  std::size_t pair_count;  // of all that there are

  std::size_t count() const { return directions.size(); }
};

// For each pair, by how much area more the views of a group ask for the second to be behind.
std::vector<std::int64_t> group_votes(const SeenViews& views, std::span<const std::uint32_t> groups,
                                      std::uint32_t group);

// The group of each view, 0 to count - 1, such that little area is asked for both ways round within one: of that, one
// half or the other is drawn wrongly whatever the order, and nearly all else can be drawn rightly. Some groups may have
// no view. Parallel in the caller's task arena.
// Preconditions: there are views; count >= 1.
std::vector<std::uint32_t> group_views(const SeenViews& views, std::size_t count);

}  // namespace facetsort::presort_internal
