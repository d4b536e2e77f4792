// Internal to exact: where elements appear to an eye, conservatively: boxes on the screen and in depth, and a hierarchy
// over them that proposes pairs.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/exact/elements.h"
#include "facetsort/exact/visibility.h"

namespace facetsort::exact_internal {

// A point as the eye sees it, rounded. Where a plane has all of the mesh in front of the eye, x and y are on it, z is 0
// and depth is along its axis; x, y are off by at most Screen::rounding(). Otherwise (x, y, z) is the direction on the
// unit sphere, and depth the squared distance.
struct SeenPoint {
  float x, y, z, depth;
};

inline constexpr std::size_t box_dimensions = 4;  // x, y, z, depth

struct ScreenBox {
  std::array<float, box_dimensions> lowest, highest;
};

// Eight boxes. An empty one has lowest above highest.
struct alignas(64) BoxBlock {
  static constexpr std::size_t size = 8;
  float lowest[box_dimensions][size], highest[box_dimensions][size];

  // Bit i: box i overlaps `box`.
  unsigned overlapping(const ScreenBox& box) const {
    std::uint32_t apart[size] = {};
    for (std::size_t d = 0; d < box_dimensions; ++d) {
      for (std::size_t i = 0; i < size; ++i) {
        apart[i] |= static_cast<std::uint32_t>(!(lowest[d][i] <= box.highest[d])) |
                    static_cast<std::uint32_t>(!(box.lowest[d] <= highest[d][i]));
      }
    }
    unsigned mask = 0;
    for (std::size_t i = 0; i < size; ++i) mask |= (apart[i] ^ 1u) << i;
    return mask;
  }
  ScreenBox box(std::size_t i) const {
    ScreenBox result;
    for (std::size_t d = 0; d < box_dimensions; ++d) {
      result.lowest[d] = lowest[d][i];
      result.highest[d] = highest[d][i];
    }
    return result;
  }
};

class Screen {
 public:
  // Places all elements; `keys` gets the depth of each by draw id, larger is farther, within the element's depth range.
  // Parallel in the caller's task arena; the same for any thread count. Keeps its storage.
  void look(const Points& points, const Elements& elements, const Eye& eye, std::vector<float>& keys);

  const Viewpoint& viewpoint() const { return viewpoint_; }
  // The side of its facet's plane that the eye is on; 0 where it has no area or is seen edge-on.
  int facing(std::uint32_t element) const { return facing_[element]; }
  const SeenPoint& seen(std::uint32_t slot) const { return seen_[slot]; }
  float rounding() const { return rounding_; }
  // Whether the slot's elements form a simple fan that faces one way: no two of them overlap.
  bool is_flat_fan(std::uint32_t slot) const { return flat_fan_[slot] != 0; }
  ScreenBox box(std::uint32_t element) const {
    return levels_[0][element / BoxBlock::size].box(element % BoxBlock::size);
  }

  std::size_t leaves() const { return levels_.empty() ? 0 : levels_[0].size(); }

  // Calls visit(a, b), a < b, for pairs of elements whose boxes overlap, a in the given leaf.
  template <typename Visit>
  void for_each_pair_of_leaf(std::size_t leaf, const Visit& visit) const {
    const BoxBlock& block = levels_[0][leaf];
    const ScreenBox leaf_box = levels_.size() > 1 ? box_of_block(0, leaf) : everywhere();
    for_each_block(leaf_box, leaf, [&](std::size_t other) {
      const BoxBlock& other_block = levels_[0][other];
      unsigned rows = other == leaf ? 0xffu : block.overlapping(box_of_block(0, other));
      for (; rows != 0; rows &= rows - 1) {
        const unsigned i = static_cast<unsigned>(std::countr_zero(rows));
        unsigned mask = other_block.overlapping(block.box(i));
        if (other == leaf) mask &= 0xfeu << i;
        for (; mask != 0; mask &= mask - 1) {
          visit(static_cast<std::uint32_t>(leaf * BoxBlock::size + i),
                static_cast<std::uint32_t>(other * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask))));
        }
      }
    });
  }

  // Calls visit(element) for the elements whose boxes overlap `box`.
  template <typename Visit>
  void for_each_overlapping(const ScreenBox& box, const Visit& visit) const {
    for_each_block(box, 0, [&](std::size_t leaf) {
      for (unsigned mask = levels_[0][leaf].overlapping(box); mask != 0; mask &= mask - 1) {
        visit(static_cast<std::uint32_t>(leaf * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask))));
      }
    });
  }

  std::size_t memory_bytes() const;

 private:
  static ScreenBox everywhere();

  ScreenBox box_of_block(std::size_t level, std::size_t block) const {
    return levels_[level + 1][block / BoxBlock::size].box(block % BoxBlock::size);
  }

  // Calls visit(leaf) for leaves from `first` on whose boxes overlap `box`.
  template <typename Visit>
  void for_each_block(const ScreenBox& box, std::size_t first, const Visit& visit) const {
    if (levels_.size() == 1) return visit(std::size_t{0});
    struct Node {
      std::size_t level, block;
    };
    std::array<Node, 128> stack;
    std::size_t depth = 0;
    stack[depth++] = {levels_.size() - 1, 0};
    while (depth > 0) {
      const auto [level, block] = stack[--depth];
      unsigned mask = levels_[level][block].overlapping(box);
      const std::size_t below = level - 1;  // the level whose blocks the boxes of this one bound
      const std::size_t first_child = first >> 3 * below;
      for (; mask != 0;) {
        const unsigned i = 31u - static_cast<unsigned>(std::countl_zero(mask));
        mask ^= 1u << i;
        const std::size_t child = block * BoxBlock::size + i;
        if (child < first_child) continue;
        if (below == 0) {
          visit(child);
        } else {
          stack[depth++] = {below, child};
        }
      }
    }
  }

  void choose_projection(const Elements& elements, const Eye& eye);
  void see_points(const Elements& elements);
  void place_elements(const Points& points, const Elements& elements, std::vector<float>& keys);
  void bound_levels();
  void bound_on_sphere(const Elements& elements, std::uint32_t element, float (&lowest)[box_dimensions],
                       float (&highest)[box_dimensions]) const;
  void find_flat_fans(const Elements& elements);

  Viewpoint viewpoint_{};
  glm::dvec3 eye_{0};  // in the frame; orthographic: unused
  glm::dvec3 right_{0}, down_{0}, forward_{0};
  bool perspective_ = false;
  float rounding_ = 0;
  std::vector<SeenPoint> seen_;
  std::vector<std::int8_t> facing_;
  std::vector<unsigned char> flat_fan_;
  std::vector<std::vector<BoxBlock>> levels_;  // [0]: elements; [k]: blocks of [k - 1]
};

}  // namespace facetsort::exact_internal
