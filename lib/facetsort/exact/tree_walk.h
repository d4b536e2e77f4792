// Internal to exact: walking an order tree for one eye.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/exact/filtered_plane.h"
#include "facetsort/base/memory.h"
#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/points.h"

namespace facetsort::exact_internal {

// Gives all members of a tree places, back to front: far sides come before near sides.
class TreeWalk {
 public:
  // The places of each subtree, and of each node at the top, are a multiple of `places_per_block`: so that threads can
  // work on them at once. Points and tree have to outlive this.
  void prepare(const Points& points, const OrderTree& tree, std::size_t places_per_block);

  // Finds the side of each plane that an eye is on, and gives the nodes at the top their places.
  // Parallel in the caller's task arena. Keeps its storage.
  void look(const Eye& eye);
  // Gives the nodes of a subtree theirs. Different threads may take different subtrees.
  void look_below(const OrderTree::Subtree& subtree) { give_places(subtree.first_node, subtree.node_count); }

  const OrderTree& tree() const { return *tree_; }
  // All places, some of which stay empty.
  std::size_t places() const { return tree_->nodes.empty() ? 0 : places_below_[0]; }
  // Where a node's members begin; before look_below(), of the root of a subtree, where all that is in it begins.
  std::uint32_t first_place(std::size_t node) const { return first_place_[node]; }
  // Of a node's members at the top, or of all in a subtree by its root.
  std::size_t reserved(std::size_t members) const {
    return (members + places_per_block_ - 1) / places_per_block_ * places_per_block_;
  }
  std::uint32_t places_below(std::size_t node) const { return places_below_[node]; }
  // Whether a node's front side is the near one. Where the eye is in the plane, neither side hides the other.
  bool is_seen_from_front(std::size_t node) const { return sides_[node] >= 0; }

  std::size_t prepared_bytes() const { return bytes_of(planes_, places_below_); }
  std::size_t memory_bytes() const { return prepared_bytes() + bytes_of(sides_, first_place_); }

 private:
  void find_sides(const Eye& eye);
  void count_places(std::size_t first_node, std::size_t node_count, bool at_top);
  void give_places(std::size_t first_node, std::size_t node_count);

  const Points* points_ = nullptr;
  const OrderTree* tree_ = nullptr;
  std::size_t places_per_block_ = 1;
  // By node.
  std::vector<FilteredPlane> planes_;
  std::vector<std::uint32_t> places_below_;  // for it and what is below it
  std::vector<std::int8_t> sides_;           // the eye's
  std::vector<std::uint32_t> first_place_;
};

}  // namespace facetsort::exact_internal
