#include "facetsort/exact/tree_walk.h"

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t nodes_per_task = 4096;

}  // namespace

void TreeWalk::prepare(const Points& points, const OrderTree& tree, std::size_t places_per_block) {
  points_ = &points;
  tree_ = &tree;
  places_per_block_ = places_per_block;
  planes_.resize(tree.nodes.size());
  places_below_.resize(tree.nodes.size());
  sides_.resize(tree.nodes.size());
  first_place_.resize(tree.nodes.size());
  for (const OrderTree::Subtree& subtree : tree.subtrees) {
    count_places(subtree.first_node, subtree.node_count, false);
    std::uint32_t& places = places_below_[subtree.first_node];
    places = static_cast<std::uint32_t>(reserved(places));
  }
  count_places(0, tree.top_nodes(), true);
}

void TreeWalk::count_places(std::size_t first_node, std::size_t node_count, bool at_top) {
  const PointSpace& space = points_->space();
  const auto below = [&](std::uint32_t node) { return node == OrderTree::none ? 0 : places_below_[node]; };
  for (std::size_t i = first_node + node_count; i-- > first_node;) {
    const OrderTree::Node& node = tree_->nodes[i];
    const CutPlane plane = points_->plane(node.plane);
    planes_[i] = filtered_plane(space.position(plane.first), space.position(plane.second), space.position(plane.third));
    const std::size_t own = at_top ? reserved(node.member_count) : node.member_count;
    places_below_[i] = static_cast<std::uint32_t>(own + below(node.front) + below(node.back));
  }
}

void TreeWalk::find_sides(const Eye& eye) {
  parallel_ranges(planes_.size(), nodes_per_task, [&](std::size_t begin, std::size_t end) {
    const PointSpace& space = points_->space();
    for (std::size_t i = begin; i < end; ++i) {
      const CutPlane plane = points_->plane(tree_->nodes[i].plane);
      sides_[i] = static_cast<std::int8_t>(eye_side(planes_[i], space.position(plane.first),
                                                    space.position(plane.second), space.position(plane.third), eye));
    }
  });
}

// To the members of nodes, and to the nodes right below: first comes what is beyond a plane, then what lies in it.
void TreeWalk::give_places(std::size_t first_node, std::size_t node_count) {
  const auto places = [&](std::uint32_t node) { return node == OrderTree::none ? 0 : places_below_[node]; };
  for (std::size_t i = first_node; i < first_node + node_count; ++i) {
    const OrderTree::Node& node = tree_->nodes[i];
    const bool from_front = is_seen_from_front(i);
    const std::uint32_t far = from_front ? node.back : node.front, near = from_front ? node.front : node.back;
    if (far != OrderTree::none) first_place_[far] = first_place_[i];
    if (near != OrderTree::none) first_place_[near] = first_place_[i] + places_below_[i] - places(near);
    first_place_[i] += places(far);
  }
}

void TreeWalk::look(const Eye& eye) {
  if (tree_->nodes.empty()) return;
  find_sides(eye);
  first_place_[0] = 0;
  give_places(0, tree_->top_nodes());
}

}  // namespace facetsort::exact_internal
