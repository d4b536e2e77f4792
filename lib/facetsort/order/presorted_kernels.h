// Internal to order: the loops that read a presorted mesh, for every instruction set. PresortedReader puts them
// together.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

#include "facetsort/order/presorted_blocks.h"

namespace facetsort::order_internal {

// The planes of a tree, and what they were made of.
struct PlaneSource {
  const PlaneArrays& planes;
  std::span<const PresortedNode> nodes;
  std::span<const glm::vec3> positions;
};

// Sides of planes, eight a byte, the first in the lowest bit: 1 where the eye is in front of a plane, or in it.
using BlockSides = std::array<std::uint8_t, most_block_nodes / 8>;
// Of all planes of the source.
void find_sides(const PlaneSource& source, const FrameEye& eye, std::span<std::uint8_t> sides);

// Of each block: what was found for an eye, and what follows from it.
struct BlockOrders {
  struct State {
    BlockSides sides{};
    float valid_until = 0;  // way that the eye has gone when the sides have to be found again
  };
  State* states;
  std::uint8_t* kept;    // triangles that are drawn
  std::uint8_t* orders;  // those of a block, from its first spot on, by number in the block, back to front
};

// Orders block `b` as its state's sides have it.
void order_block(const PresortedBlocks& blocks, std::size_t b, const BlockOrders& orders);
// What an eye's move changes of some blocks: what comes in which order; how many triangles are drawn.
struct BlockChanges {
  bool orders = false, counts = false;
};

// Brings blocks [begin, end) to an eye that has gone `way` by now.
BlockChanges order_blocks(const PresortedBlocks& blocks, const PlaneSource& source, std::size_t begin, std::size_t end,
                  const FrameEye& eye, double way, const BlockOrders& orders);

}  // namespace facetsort::order_internal
