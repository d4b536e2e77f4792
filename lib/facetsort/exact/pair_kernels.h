// Internal to exact: the search for pairs of overlapping boxes, vectorised, for the best instruction set at run time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace facetsort::exact_internal {

// What a box bounds. On the plane of the screen `diagonal` is x + y: with the two diagonals, thin facets askew have
// tight boxes. On the sphere it is z.
enum BoxDimension : std::size_t { across, down, diagonal, other_diagonal, in_depth, of_key };
inline constexpr std::size_t box_dimensions = 6;

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

// Eight boxes on the screen alone.
struct alignas(64) PlaceBlock {
  static constexpr std::size_t dimensions = in_depth, size = BoxBlock::size;
  float lowest[dimensions][size], highest[dimensions][size];
};

// The slots of the corners of eight triangles; no_slot where there is a polygon, or nothing.
struct alignas(32) SlotBlock {
  static constexpr std::uint32_t no_slot = 0xffffffffu;

  std::uint32_t slot[3][BoxBlock::size];
};

// An element as it is seen, rounded: its corners clockwise with y down, the last of a triangle twice.
struct alignas(64) Patch {
  static constexpr std::uint32_t unknown = 0xffffffffu, several = 0xfffffffeu;

  struct Corner {
    float x, y, nearness;  // see ScreenPoint
    std::uint32_t slot;
  };
  Corner corner[4];

  // Of what has more corners, the slots tell that there are several patches, where the first is, and how many there
  // are; together they make up the element. What has no area on the screen is unknown.
  bool is_one() const { return corner[0].slot < several; }
  bool is_unknown() const { return corner[0].slot == unknown; }
  bool is_triangle() const { return corner[3].slot == corner[2].slot; }
  std::uint32_t first_of_several() const { return corner[1].slot; }
  std::uint32_t number_of_several() const { return corner[2].slot; }
};

// levels[0]: boxes of elements; levels[k]: boxes of the blocks of levels[k - 1]; the last is one block.
using BoxLevels = std::span<const std::vector<BoxBlock>>;

// What a filter can tell of two elements.
struct Seen {
  enum Overlap : std::uint8_t { apart, overlapping, either, not_compared } overlap;
  // Which is behind the other if they overlap: +1 the first, -1 the second, 0 can't tell.
  std::int8_t behind;
};

struct ElementPair {
  std::uint32_t a, b;
  Seen seen;
};

// What the search reads.
struct Screenful {
  BoxLevels boxes;
  std::span<const SlotBlock> slots;
  std::span<const Patch> patches;  // of elements, then those of which there are several; none: nothing is compared
  std::span<const float> keys;     // of elements: larger is farther
  std::span<const unsigned char> flat_fan;  // by slot
  float rounding;                           // of the coordinates of patches
};

// Appends the pairs of elements whose boxes overlap on the screen and in depth, a in block `leaf` and b after a, but
// those that share a slot of a flat fan, those that are certainly apart on the screen, and those where the one behind
// certainly is the one with the larger key. Returns how many boxes overlap, pairs left out included.
std::size_t collect_pairs(const Screenful& screen, std::size_t leaf, std::vector<ElementPair>& pairs);

// What an element is pulled past: from the rank `begin`, where it is pulled to, to its own, but nothing that is pulled
// farther itself, and nothing that was looked at when the element was pulled to `searched`.
struct PassedRanks {
  std::uint32_t begin, end, searched;
  std::span<const std::uint32_t> place;    // by rank: where each is pulled to
  std::span<const std::uint32_t> rank_of;  // elements

  bool contain(std::uint32_t element) const {
    const std::uint32_t rank = rank_of[element];
    return rank >= begin && rank < end && place[rank] >= begin && (rank < searched || place[rank] < searched);
  }
};

// Appends the pairs of `element` with those that it passes and whose boxes overlap `box` on the screen and in keys, but
// those certainly apart and those certainly in front of it.
void collect_passed(const Screenful& screen, std::uint32_t element, const ScreenBox& box, const PassedRanks& passed,
                    std::vector<ElementPair>& pairs);

// Up to four corners of an element, wound as its facet is; the last of three comes twice. What has more corners is made
// of several. Here is what they are known by: `slot` the point, `edge` the line of the edge to the next corner, `after`
// and `before` the lines of the element's edges from and to the corner. Lines are numbered; a diagonal has none.
struct alignas(64) OutlineIds {
  static constexpr std::uint32_t no_line = 0xffffffffu;

  std::uint32_t slot[4], edge[4], after[4], before[4];
};

// And where they are on the screen.
struct alignas(32) OutlinePlaces {
  float x[4], y[4];
};

struct Outlines {
  std::span<const OutlineIds> ids;             // of elements, then those of which an element has several
  std::span<const OutlinePlaces> places;       // of the same; none: nothing is known of places
  std::span<const std::uint32_t> first_extra;  // by element: where its several begin after the elements, and end
  std::span<const std::int8_t> facing;         // by element
  std::span<const float> span;                 // by element: its width and height
  float rounding;                              // of places
};

// Elements in a row of places, each with a list of them that may be empty.
struct RowView {
  static constexpr std::uint32_t none = 0xffffffffu;

  std::span<const std::uint32_t> first_at;  // by place
  std::span<const std::uint32_t> next;      // by element
  // Boxes around what is in 1, 8 and 64 places, or larger; those of empty places are empty.
  std::span<const PlaceBlock> places, eights, sixty_fours;
};

// What may overlap an element.
struct Candidate {
  std::uint32_t element;
  Seen::Overlap overlap;
};

// Of those in a row from place `begin` to `end`, appends the ones that are not certainly apart from `element`, whose
// box is `box`. Stops when there are any, and returns the place to go on from.
std::size_t collect_in_row(const Outlines& outlines, const RowView& row, std::uint32_t element, const ScreenBox& box,
                           std::size_t begin, std::size_t end, std::vector<Candidate>& candidates);

}  // namespace facetsort::exact_internal
