// Internal to order: the order tree as it is read. Small subtrees are blocks, each ordered by itself; the nodes above
// them, the top, order the blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/order/presorted_data.h"

namespace facetsort::order_internal {

// Whatever a block counts fits a byte. Smaller ones keep their order in more of the small moves of an eye, but more of
// them, and of the nodes above them, cost more in every move.
constexpr std::size_t most_block_triangles = 192, most_block_nodes = 192;

// Planes in a frame in which the vertices that they go through are within 1 of the origin: the eye (E, w) is in front
// where dot(normal, E) + offset * w is positive. The largest component of a normal is 1. Where float can't tell a
// normal, it and the offset are 0.
struct PlaneArrays {
  std::vector<float> x, y, z, offset;  // and whole vectors beyond the last can be read
  std::vector<std::uint32_t> node;     // of each

  void add(const glm::vec4& plane, std::uint32_t node_of_plane);
  void pad();
  std::size_t size() const { return node.size(); }
};

struct PlaneFrame {
  glm::dvec3 origin{0};
  double scale = 1;  // a power of two
};

// An eye as it is, and in the frame of planes: its largest component (E, w) is in [0.5, 1].
struct FrameEye {
  glm::vec4 eye;
  glm::dvec4 in_frame;
};
FrameEye frame_eye(const PlaneFrame& frame, const glm::vec4& eye);

// What changes dot(normal, E) + offset * w by no more, for any plane of PlaneArrays.
double distance_between(const FrameEye& a, const FrameEye& b);

// Nodes of a block have slots, in preorder from 0 on. One is for children that a node does not have, and is written but
// not read; one is for the end of the block.
constexpr std::uint8_t no_slot = 255, end_slot = 254;

// A node with nodes below it, and the triangles on its sides and in its plane. What comes first is told by whether the
// eye is in front, 0 or 1: sizes[in_front] is that of the subtree in slots[in_front], which slots[in_front + 1]
// follows.
struct Branch {
  std::uint8_t slot, own_size;
  std::uint8_t sizes[2];  // front, back
  std::uint8_t slots[3];  // front, back, front
  std::uint8_t unused = 0;
};

// Where a triangle stands: its node's slot, and its place among that node's.
struct Spot {
  std::uint8_t slot, place;
};

// When a triangle is drawn, where back faces are culled: the side of its node's plane that it is seen from.
enum class Facing : std::uint8_t { front, back, always };

// Loops over the triangles of a block take so many at a time: blocks are filled up with spots at their end.
constexpr std::size_t triangles_at_a_time = 4;

// Triangles in a row: of a subtree, or of a node of the top, or of pieces without a node.
struct Block {
  std::uint32_t first_triangle, first_spot, first_plane, first_branch;
  std::uint8_t triangle_count, plane_count, branch_count;
};

// A node above the blocks. What is below it is told by element: nodes of the top, then blocks, then nothing.
struct TopNode {
  std::uint32_t front, back;
  std::uint32_t front_blocks, back_blocks;  // how many blocks these are
  std::uint32_t first_own, own_count;       // blocks in its plane
};

struct PresortedBlocks {
  PlaneFrame frame;
  std::vector<Block> blocks;  // in the order of the tree; the first are those without a node
  std::size_t loose_blocks = 0;
  std::vector<Branch> branches;
  std::vector<Spot> spots;      // of the triangles of each block
  std::vector<Facing> facings;  // of each triangle, where back faces are culled
  PlaneArrays planes;           // of branches; where back faces are culled, of all nodes, by slot
  std::vector<TopNode> top;     // preorder
  PlaneArrays top_planes;       // of each

  std::size_t memory_bytes() const;
};

// Precondition: the view is sound: counts add up, vertices and facets exist, no plane's vertices are on one line.
PresortedBlocks make_blocks(const PresortedView& mesh, bool culls_back_faces);

}  // namespace facetsort::order_internal
