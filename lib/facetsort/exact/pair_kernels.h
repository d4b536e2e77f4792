// Internal to exact: the search for pairs of overlapping boxes, vectorised, for the best instruction set at run time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace facetsort::exact_internal {

inline constexpr std::size_t box_dimensions = 4;  // x, y, z on the screen, and depth

struct ScreenBox {
  std::array<float, box_dimensions> lowest, highest;
};

// Eight boxes. An empty one has lowest above highest.
struct alignas(64) BoxBlock {
  static constexpr std::size_t size = 8;
  float lowest[box_dimensions][size], highest[box_dimensions][size];

  ScreenBox box(std::size_t i) const {
    ScreenBox result;
    for (std::size_t d = 0; d < box_dimensions; ++d) {
      result.lowest[d] = lowest[d][i];
      result.highest[d] = highest[d][i];
    }
    return result;
  }
};

// The corners of eight triangles, by slot.
struct alignas(32) SlotBlock {
  std::uint32_t slot[3][BoxBlock::size];
};

// levels[0]: boxes of elements; levels[k]: boxes of the blocks of levels[k - 1]; the last is one block.
using BoxLevels = std::span<const std::vector<BoxBlock>>;

struct ElementPair {
  std::uint32_t a, b;
};

// Appends the pairs of elements whose boxes overlap, a in block `leaf` of levels[0] and b after a, but those that share
// a slot s with flat_fan[s] != 0. `slots`: the corners of each block's elements; no_element stands for none. Returns how
// many pairs overlap, left out ones included.
std::size_t collect_pairs(BoxLevels levels, std::span<const SlotBlock> slots, std::span<const unsigned char> flat_fan,
                          std::size_t leaf, std::vector<ElementPair>& pairs);

// Appends the elements whose boxes overlap `box`.
void collect_overlapping(BoxLevels levels, const ScreenBox& box, std::vector<std::uint32_t>& elements);

}  // namespace facetsort::exact_internal
