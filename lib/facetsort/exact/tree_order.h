// Internal to exact: the order of one view, read from a tree.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/exact/elements.h"
#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/rejoining.h"
#include "facetsort/exact/relation.h"
#include "facetsort/exact/row.h"
#include "facetsort/exact/screen.h"
#include "facetsort/exact/tree_walk.h"

namespace facetsort::exact_internal {

// The order in which a tree's members come, after which the halves of what the planes cut are put together again as far
// as that can be done (see Rejoining), what was cut last first.
class RejoinedOrder {
 public:
  // Places in blocks that Row takes.
  static constexpr std::size_t places_per_block = Row::block_size;

  // The tree's parts become elements.
  void prepare(const OrderTree& tree, const Elements& elements);

  // Appends draw ids, back to front. Parallel in the caller's task arena; the same for any thread count and instruction
  // set. Keeps its storage.
  void find(TreeWalk& walk, const Relation& relation, const Screen& screen, const Elements& elements,
            std::vector<std::uint32_t>& order);

  // Of the last view.
  const RejoiningCounts& counts() const { return counts_; }

  std::size_t prepared_bytes() const { return bytes_of(members_, halvings_, moving_); }
  std::size_t memory_bytes() const { return prepared_bytes() + row_.memory_bytes(); }

 private:
  struct Look {
    TreeWalk& walk;
    const Relation& relation;
    const Screen& screen;
    const Elements& elements;
  };

  void find_below(const Look& look, std::uint32_t node);
  void fill(const TreeWalk& walk, std::size_t first_node, std::size_t node_count, std::size_t begin, std::size_t end);
  void rejoin(const TreeWalk& walk, Rejoining& rejoining, std::size_t first_node, std::size_t node_count) const;

  std::vector<std::uint32_t> members_;        // elements
  std::vector<OrderTree::Halving> halvings_;  // of elements
  Row row_;
  std::vector<unsigned char> moving_;  // by element, for Rejoining
  tbb::enumerable_thread_specific<RejoiningScratch> scratch_;
  RejoiningCounts counts_;
};

}  // namespace facetsort::exact_internal
