// What the per-frame sort and its peers are timed on, and how their results are checked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "facetsort/order/sorter.h"
#include "subjects.h"

namespace facetsort::bench {

// Knots of 1,000 to 4,000,000 facets and the large meshes at hand, each in spatial order ("knot_1000000", "bunny_70k")
// and with its facets shuffled ("knot_1000000_random"); meshes from files also as they are ("bunny_70k_as_read").
std::vector<Subject> sort_subjects();
// Those in spatial order alone.
std::vector<Subject> spatial_subjects();

// One for each of frames_around().
std::vector<SortView> sort_views(const Mesh& mesh);

// A permutation of all facets, farther keys first, equal keys by smaller id.
bool is_back_to_front(std::span<const std::uint32_t> order, std::span<const float> keys);
bool has_corners_in_order(std::span<const std::uint32_t> indices, std::span<const glm::uvec3> triangles,
                          std::span<const std::uint32_t> order);

}  // namespace facetsort::bench
