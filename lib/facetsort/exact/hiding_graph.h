// Internal to exact: the graph of which part hides which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/base/memory.h"

namespace facetsort::exact_internal {

// `first` is behind `second`.
struct HidingPair {
  std::uint32_t first, second;
};

// A list of numbers for each node of a graph, one after the other in memory.
struct NodeLists {
  std::vector<std::uint32_t> begin;  // of each list in `values`, and the end of the last
  std::vector<std::uint32_t> values;

  std::size_t count() const { return begin.size() - 1; }
  std::span<const std::uint32_t> operator[](std::size_t node) const {
    return std::span(values).subspan(begin[node], begin[node + 1] - begin[node]);
  }
  std::size_t memory_bytes() const { return bytes_of(begin, values); }
};

// What is behind each of `nodes` nodes, in the order of the pairs.
NodeLists list_behind(std::size_t nodes, std::span<const HidingPair> pairs);
// The same into lists that keep their storage.
void list_behind(std::size_t nodes, std::span<const HidingPair> pairs, NodeLists& lists);

// For each node those that have it in their lists, ascending.
NodeLists reversed(const NodeLists& lists);

// Strongly connected components, in an order in which nothing is behind what comes earlier (Tarjan 1972, "Depth-First
// Search and Linear Graph Algorithms"). Keeps its storage.
class ComponentFinder {
 public:
  // The nodes of each component ascend. Deterministic: among what may come next, the smallest node first, as far as the
  // lists in `behind` are ascending. Valid until the next call.
  const NodeLists& find(const NodeLists& behind);

  std::size_t memory_bytes() const {
    return components_.memory_bytes() + bytes_of(number_, lowest_, next_, open_, visits_);
  }

 private:
  void add_component(std::uint32_t root);

  NodeLists components_;
  std::vector<std::uint32_t> number_, lowest_, next_;  // by node
  std::vector<std::uint32_t> open_, visits_;           // stacks of our own: cycles may go deep
};

}  // namespace facetsort::exact_internal
