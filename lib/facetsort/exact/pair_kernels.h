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

// The slots of the corners of eight triangles; no_slot where there is a polygon, or nothing.
struct alignas(32) SlotBlock {
  static constexpr std::uint32_t no_slot = 0xffffffffu;

  std::uint32_t slot[3][BoxBlock::size];
};

// The corners of eight triangles as they are seen. Lanes that hold no triangle, but a polygon or nothing, have slot no_slot.
struct alignas(64) TriangleBlock {
  static constexpr double no_slot = -1;

  double slot[3][BoxBlock::size];
  // On the screen, y down, and nearness (see ScreenPoint).
  double x[3][BoxBlock::size], y[3][BoxBlock::size], nearness[3][BoxBlock::size];
  double facing[BoxBlock::size];
};

// levels[0]: boxes of elements; levels[k]: boxes of the blocks of levels[k - 1]; the last is one block.
using BoxLevels = std::span<const std::vector<BoxBlock>>;

// What a filter in double can tell of two elements.
struct Seen {
  enum Overlap : std::uint8_t { apart, overlapping, either, not_compared } overlap;
  // Which is behind the other if they overlap: +1 the first, -1 the second, 0 can't tell.
  std::int8_t behind;
};

struct ElementPair {
  std::uint32_t a, b;
  Seen seen;
};

// What the search reads. Blocks of elements: boxes.front() and triangles.
struct Screenful {
  BoxLevels boxes;
  std::span<const SlotBlock> slots;
  std::span<const TriangleBlock> triangles;  // none: all pairs are not_compared
  std::span<const unsigned char> flat_fan;  // by slot
  double rounding;                          // of the coordinates of triangles
};

// Appends the pairs of elements whose boxes overlap, a in block `leaf` and b after a, but those that share a slot of a
// flat fan and those that are certainly apart on the screen. Pairs with a polygon are not_compared. Returns how many
// boxes overlap, pairs left out included.
std::size_t collect_pairs(const Screenful& screen, std::size_t leaf, std::vector<ElementPair>& pairs);

// Appends the pairs of `element` with those whose boxes overlap `box`, but those certainly apart, and those for which
// skip[element] != 0.
void collect_overlapping(const Screenful& screen, std::uint32_t element, const ScreenBox& box,
                         std::span<const unsigned char> skip, std::vector<ElementPair>& pairs);

}  // namespace facetsort::exact_internal
