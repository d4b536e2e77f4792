// Internal to exact: the parts of a mesh that an order is made of, laid out for sorting, and what does not depend on
// the view.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/exact/filtered_plane.h"
#include "facetsort/exact/pair_kernels.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/facets/facets.h"

namespace facetsort::exact_internal {

inline constexpr std::uint32_t no_element = 0xffffffffu;

// Whole facets and pieces. Points are renumbered by first use as slots; those that coincide share one.
struct Elements {
  std::size_t count() const { return facet.size(); }
  std::span<const PointId> corners(std::uint32_t element) const {
    return std::span(corner_point).subspan(first_corner[element], first_corner[element + 1] - first_corner[element]);
  }
  std::span<const std::uint32_t> slots(std::uint32_t element) const {
    return std::span(corner_slot).subspan(first_corner[element], first_corner[element + 1] - first_corner[element]);
  }
  // Of the edges that begin at the corners, numbered. Precondition: they were asked for.
  std::span<const std::uint32_t> lines(std::uint32_t element) const {
    return std::span(corner_line).subspan(first_corner[element], first_corner[element + 1] - first_corner[element]);
  }
  // Whether a slot is known to lie on one of these lines. Precondition as above.
  bool is_on_line(std::uint32_t slot, std::uint32_t line) const {
    const auto begin = slot_line.begin() + slot_line_begin[slot], end = slot_line.begin() + slot_line_begin[slot + 1];
    return std::binary_search(begin, end, line);
  }
  bool is_whole(std::size_t element) const { return draw_id[element] == facet[element]; }
  std::size_t memory_bytes() const;

  FacetFrame frame;
  glm::dvec3 extent{0};      // largest magnitude of each coordinate in the frame
  double largest_error = 0;  // of slot_position, beyond the rounding of vertices

  std::vector<FacetId> facet;
  std::vector<std::uint32_t> draw_id;
  std::vector<unsigned char> has_area;
  std::vector<FilteredPlane> plane;
  std::vector<float> longest_edge_squared;  // in the frame, rounded up
  std::vector<std::uint32_t> first_corner;  // count() + 1
  std::vector<PointId> corner_point;
  std::vector<std::uint32_t> corner_slot;
  std::vector<std::uint32_t> corner_line;                 // see lines()
  std::vector<std::uint32_t> slot_line_begin, slot_line;  // slots + 1 begins; those of a slot ascend
  std::vector<std::uint32_t> first_extra_patch;  // count() + 1: patches of those with more than four corners

  std::vector<SlotBlock> slot_blocks;
  std::vector<OutlineIds> outline_ids;  // see Outlines; only where asked for
  std::vector<PointId> slot_point;
  std::vector<glm::dvec3> slot_position;  // in the frame
  // The elements around a slot where those form a simple fan (see below), else none; slots + 1 begins.
  std::vector<std::uint32_t> fan_begin, fan_element;

  std::vector<std::uint32_t> element_of_draw_id;  // or no_element
};

// A simple fan: whole facets with area around a vertex, each sharing an edge with the next, wound alike, closed, no two
// others in one plane. Such a fan does not cross itself, so where all its facets face the same way they do not overlap
// on the screen: their outline around the vertex is a simple closed curve in an annulus, which winds once at most.
//
// `parts`: the draw ids of all elements, in their order. Fans are only found where no facets cross.
Elements make_elements(const Points& points, const PartList& pieces, const std::vector<unsigned char>& degenerate,
                       std::span<const std::uint32_t> parts, bool with_fans);

// Calls visit(patch, corners) for each patch, or outline, of an element: its place among those of all elements, and
// which four of the element's corners it has, the last of a triangle twice. Of more than four corners there are
// several, a fan around the first corner.
template <typename Visit>
void for_each_patch(const Elements& elements, std::uint32_t element, const Visit& visit) {
  const std::size_t count = elements.slots(element).size();
  const auto corners = [&](std::size_t j) {
    return std::array<std::size_t, 4>{0, 2 * j + 1, 2 * j + 2, std::min(2 * j + 3, count - 1)};
  };
  if (count <= 4) return visit(std::size_t{element}, corners(0));
  const std::uint32_t first = elements.first_extra_patch[element], last = elements.first_extra_patch[element + 1];
  for (std::uint32_t extra = first; extra < last; ++extra) visit(elements.count() + extra, corners(extra - first));
}

// Fills in outline_ids and the lines of edges.
void find_outline_ids(const Points& points, const PartList& pieces, Elements& elements);

// Draw ids of all facets that have no pieces, and all pieces.
std::vector<std::uint32_t> parts_to_draw(const PartList& pieces, std::size_t facet_count);
// Puts parts in an order in which neighbours in space are neighbours in memory: each run of 8, of 64, of 512 ... is
// compact.
void sort_spatially(const Points& points, const PartList& pieces, std::vector<std::uint32_t>& parts);

}  // namespace facetsort::exact_internal
