#include "facetsort/exact/tree_order.h"

#include <tbb/parallel_invoke.h>

#include <utility>

#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {

void RejoinedOrder::prepare(const OrderTree& tree, const Elements& elements) {
  const auto element = [&](std::uint32_t part) { return elements.element_of_draw_id[part]; };
  for (const std::uint32_t part : tree.members) members_.push_back(element(part));
  for (const OrderTree::Halving& halving : tree.halvings) {
    halvings_.push_back({element(halving.whole), element(halving.front), element(halving.back)});
  }
  moving_.assign(elements.count(), 0);
}

void RejoinedOrder::fill(const TreeWalk& walk, std::size_t first_node, std::size_t node_count, std::size_t begin,
                         std::size_t end) {
  row_.clear(begin, end);
  for (std::size_t i = first_node; i < first_node + node_count; ++i) {
    const OrderTree::Node& node = walk.tree().nodes[i];
    for (std::uint32_t k = 0; k < node.member_count; ++k) {
      row_.put(members_[node.first_member + k], walk.first_place(i) + k);
    }
    for (std::uint32_t k = 0; k < node.halving_count; ++k) row_.set_absent(halvings_[node.first_halving + k].whole);
  }
  row_.bound(begin, end);
}

// From the last node on, so that halves that were cut again are whole again, or stay cut.
void RejoinedOrder::rejoin(const TreeWalk& walk, Rejoining& rejoining, std::size_t first_node,
                           std::size_t node_count) const {
  for (std::size_t i = first_node + node_count; i-- > first_node;) {
    const OrderTree::Node& node = walk.tree().nodes[i];
    for (std::uint32_t k = 0; k < node.halving_count; ++k) {
      const OrderTree::Halving& halving = halvings_[node.first_halving + k];
      const bool from_front = walk.is_seen_from_front(i);
      rejoining.rejoin(halving.whole, from_front ? halving.back : halving.front,
                       from_front ? halving.front : halving.back);
    }
  }
}

// All below a node, and then its own halvings: what is on its two sides takes no part in each other's. Calls go as deep
// as the top of the tree, which is no chain: to take parts through a node has its price where planes are chosen.
void RejoinedOrder::find_below(const Look& look, std::uint32_t node) {
  if (node == OrderTree::none) return;
  TreeWalk& walk = look.walk;
  const OrderTree& tree = walk.tree();
  const std::size_t begin = walk.first_place(node);
  const auto rejoin_nodes = [&](std::size_t first_node, std::size_t node_count) {
    RejoiningScratch& scratch = scratch_.local();
    const unsigned long long fallbacks = exact_fallbacks();
    Rejoining rejoining(look.relation, look.screen, look.elements, row_, moving_, scratch);
    rejoin(walk, rejoining, first_node, node_count);
    scratch.counts.fallbacks += exact_fallbacks() - fallbacks;
  };
  if (node >= tree.top_nodes()) {
    const OrderTree::Subtree& subtree = tree.subtree_at(node);
    walk.look_below(subtree);
    fill(walk, node, subtree.node_count, begin, begin + walk.places_below(node));
    return rejoin_nodes(node, subtree.node_count);
  }
  fill(walk, node, 1, begin, begin + walk.reserved(tree.nodes[node].member_count));
  tbb::parallel_invoke([&] { find_below(look, tree.nodes[node].front); },
                       [&] { find_below(look, tree.nodes[node].back); });
  rejoin_nodes(node, 1);
}

void RejoinedOrder::find(TreeWalk& walk, const Relation& relation, const Screen& screen, const Elements& elements,
                         std::vector<std::uint32_t>& order) {
  walk.look(screen.viewpoint().eye);
  row_.resize(screen, walk.places(), elements.count());
  if (!walk.tree().nodes.empty()) find_below({walk, relation, screen, elements}, 0);

  counts_ = {};
  for (RejoiningScratch& scratch : scratch_) {
    const RejoiningCounts counts = std::exchange(scratch.counts, {});
    counts_.rejoined += counts.rejoined;
    counts_.tried += counts.tried;
    counts_.candidate_pairs += counts.candidate_pairs;
    counts_.fallbacks += counts.fallbacks;
  }
  for (std::size_t place = 0; place < row_.places(); ++place) {
    for (std::uint32_t element = row_.first_at(place); element != Row::none; element = row_.next(element)) {
      order.push_back(elements.draw_id[element]);
    }
  }
}

}  // namespace facetsort::exact_internal
