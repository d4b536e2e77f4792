#include "facetsort/exact/needless_cuts.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

namespace facetsort::exact_internal {
namespace {

constexpr std::uint32_t none = CycleParts::none;

// Calls visit(first, second) for all parts that `first` and `second` were cut into and that overlap, where these do.
template <typename Visit>
void for_each_overlap(const CycleParts& parts, std::uint32_t first, std::uint32_t second, const Visit& visit) {
  const auto for_halves = [&](std::uint32_t parent, std::uint32_t other, const auto& visit_half) {
    const int halves = parts.overlapping_halves(parent, other);
    if ((halves & 1) != 0) visit_half(parts[parent].first_half);
    if ((halves & 2) != 0) visit_half(parts[parent].first_half + 1);
  };
  if (parts[first].first_half != none) {
    for_halves(first, second, [&](std::uint32_t half) { for_each_overlap(parts, half, second, visit); });
  } else if (parts[second].first_half != none) {
    for_halves(second, first, [&](std::uint32_t half) { for_each_overlap(parts, first, half, visit); });
  } else {
    visit(first, second);
  }
}

// Nodes in an order that changes. Labels ascend along it; where they get too dense, all are given anew.
class ChangingOrder {
 public:
  // Nodes below `most` may come in; at first those below `count` are in it.
  ChangingOrder(std::uint32_t count, std::uint32_t most) : begin_(most), end_(most + 1), label_(most + 2) {
    next_.resize(most + 2);
    previous_.resize(most + 2);
    std::uint32_t last = begin_;
    for (std::uint32_t node = 0; node < count; ++node) last = link(last, node);
    link(last, end_);
    label_all();
  }

  bool comes_before(std::uint32_t a, std::uint32_t b) const { return label_[a] < label_[b]; }
  std::uint32_t previous(std::uint32_t node) const { return previous_[node]; }

  void replace(std::uint32_t node, std::uint32_t by) {
    label_[by] = label_[node];
    link(previous_[node], by);
    link(by, next_[node]);
  }
  void remove(std::uint32_t node) { link(previous_[node], next_[node]); }
  void insert_after(std::uint32_t place, std::span<const std::uint32_t> nodes) {
    const std::uint32_t after = next_[place];
    std::uint32_t last = place;
    for (const std::uint32_t node : nodes) last = link(last, node);
    link(last, after);
    const std::uint64_t step = (label_[after] - label_[place]) / (nodes.size() + 1);
    if (step == 0) return label_all();
    std::uint64_t label = label_[place];
    for (const std::uint32_t node : nodes) label_[node] = label += step;
  }

  template <typename Visit>
  void for_each(const Visit& visit) const {
    for (std::uint32_t node = next_[begin_]; node != end_; node = next_[node]) visit(node);
  }

 private:
  std::uint32_t link(std::uint32_t node, std::uint32_t next) {
    next_[node] = next;
    previous_[next] = node;
    return next;
  }
  void label_all() {
    constexpr std::uint64_t spacing = std::uint64_t{1} << 31;  // with 2^32 nodes at most
    std::uint64_t label = 0;
    label_[begin_] = 0;
    for_each([&](std::uint32_t node) { label_[node] = label += spacing; });
    label_[end_] = label + spacing;
  }

  const std::uint32_t begin_, end_;
  std::vector<std::uint64_t> label_;
  std::vector<std::uint32_t> next_, previous_;
};

// The graph of all parts drawn. Parts that were cut no further are its first nodes, in the order they came in; joined
// ones are chains of these.
class Joiner {
 public:
  Joiner(const CycleParts& parts, std::span<const HidingPair> pairs, const std::vector<std::uint32_t>& order)
      : parts_(parts),
        most_(static_cast<std::uint32_t>(parts.count())),
        count_(static_cast<std::uint32_t>(order.size())),
        order_(count_, most_),
        node_of_part_(parts.count(), none),
        part_of_node_(order),
        next_in_chain_(count_, none),
        reached_by_(most_) {
    for (std::uint32_t node = 0; node < count_; ++node) {
      node_of_part_[order[node]] = node;
      joined_into_.push_back(node);
      first_in_chain_.push_back(node);
      last_in_chain_.push_back(node);
    }
    find_lists(pairs);
  }

  std::vector<std::uint32_t> run() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> cut;  // what lies between the halves, and their parent
    for (std::uint32_t part = 0; part < parts_.count(); ++part) {
      if (!can_be_joined(part)) continue;
      const auto [first, last] = std::minmax({node_of_part_[parts_[part].first_half],
                                              node_of_part_[parts_[part].first_half + 1]});
      cut.push_back({last - first, part});
    }
    std::sort(cut.begin(), cut.end());
    std::vector<std::uint32_t> left;
    for (const auto& [between, part] : cut) left.push_back(part);
    for (std::size_t next = 0; next < left.size(); ++next) {
      const std::uint32_t part = left[next], parent = parts_[part].parent;
      if (join(part) && parent != none && can_be_joined(parent)) left.push_back(parent);
    }
    std::vector<std::uint32_t> result;
    order_.for_each([&](std::uint32_t node) { result.push_back(part_of_node_[node]); });
    return result;
  }

 private:
  void find_lists(std::span<const HidingPair> pairs) {
    std::vector<HidingPair> all;
    all.reserve(pairs.size() + pairs.size() / 4);
    for (const HidingPair& pair : pairs) {
      const std::uint32_t first_node = node_of_part_[pair.first], second_node = node_of_part_[pair.second];
      if (first_node != none && second_node != none) {
        all.push_back({first_node, second_node});
        continue;
      }
      for_each_overlap(parts_, pair.first, pair.second, [&](std::uint32_t first, std::uint32_t second) {
        all.push_back({node_of_part_[first], node_of_part_[second]});
      });
    }
    lists_[backward] = list_behind(count_, all);
    lists_[forward] = reversed(lists_[backward]);
    visits_left_ = most_visited + visits_of_pair * all.size();
  }

  // Whether both halves of a part are drawn, each in one.
  bool can_be_joined(std::uint32_t part) const {
    const std::uint32_t half = parts_[part].first_half;
    return half != none && node_of_part_[half] != none && node_of_part_[half + 1] != none;
  }

  std::uint32_t node_with(std::uint32_t leaf) {
    while (joined_into_[leaf] != leaf) leaf = joined_into_[leaf] = joined_into_[joined_into_[leaf]];
    return leaf;
  }

  // Searches for what lies on paths from the first half towards the second and back, on both sides by turns. Where no
  // path connects them, returns the direction in which all is found, in reached_.
  std::optional<int> search(const std::array<std::uint32_t, 2>& halves) {
    std::size_t visited[2] = {0, 0};
    const std::optional<int> direction = search(halves, visits_left_ > 0 ? most_visited : most_visited_late, visited);
    visits_left_ -= std::min(visits_left_, visited[forward] + visited[backward]);
    return direction;
  }

  std::optional<int> search(const std::array<std::uint32_t, 2>& halves, std::size_t most, std::size_t (&visited)[2]) {
    std::size_t next[2] = {0, 0};
    last_search_ += 2;
    for (const int direction : {forward, backward}) {
      reached_[direction].assign(1, halves[direction]);
      reached_by_[halves[direction]] = last_search_ + direction;
    }
    while (visited[forward] + visited[backward] < most) {
      const int direction = visited[forward] <= visited[backward] ? forward : backward;
      std::vector<std::uint32_t>& reached = reached_[direction];
      if (next[direction] == reached.size()) return direction;
      const std::uint32_t node = reached[next[direction]++];
      for (std::uint32_t leaf = first_in_chain_[node]; leaf != none; leaf = next_in_chain_[leaf]) {
        visited[direction] += 1 + lists_[direction][leaf].size();
        for (const std::uint32_t other_leaf : lists_[direction][leaf]) {
          const std::uint32_t other = node_with(other_leaf);
          if (reached_by_[other] == last_search_ + direction) continue;
          if (reached_by_[other] == last_search_ + (1 - direction)) return std::nullopt;
          const bool between = direction == forward ? order_.comes_before(other, halves[backward])
                                                    : order_.comes_before(halves[forward], other);
          if (!between) continue;
          reached_by_[other] = last_search_ + direction;
          reached.push_back(other);
        }
      }
    }
    return std::nullopt;
  }

  bool join(std::uint32_t part) {
    std::array<std::uint32_t, 2> halves = {node_of_part_[parts_[part].first_half],
                                           node_of_part_[parts_[part].first_half + 1]};
    if (order_.comes_before(halves[1], halves[0])) std::swap(halves[0], halves[1]);
    const std::optional<int> direction = search(halves);
    if (!direction) return false;
    // What has to follow the first half comes after both now, or what has to precede the second half before both.
    std::vector<std::uint32_t>& moved = reached_[*direction];
    std::sort(moved.begin(), moved.end(), [&](std::uint32_t a, std::uint32_t b) { return order_.comes_before(a, b); });
    for (const std::uint32_t node : moved) order_.remove(node);
    std::erase(moved, halves[*direction]);
    const std::uint32_t joined = add_joined(part, halves);
    order_.replace(halves[1 - *direction], joined);
    order_.insert_after(*direction == forward ? joined : order_.previous(joined), moved);
    return true;
  }

  std::uint32_t add_joined(std::uint32_t part, const std::array<std::uint32_t, 2>& halves) {
    const std::uint32_t node = static_cast<std::uint32_t>(part_of_node_.size());
    part_of_node_.push_back(part);
    node_of_part_[part] = node;
    joined_into_[halves[0]] = joined_into_[halves[1]] = node;
    joined_into_.push_back(node);
    next_in_chain_[last_in_chain_[halves[0]]] = first_in_chain_[halves[1]];
    first_in_chain_.push_back(first_in_chain_[halves[0]]);
    last_in_chain_.push_back(last_in_chain_[halves[1]]);
    return node;
  }

  static constexpr int forward = 0, backward = 1;
  // Where a search takes longer, the cut stays. In the one large cycle of plant_63k it takes so long to have all that
  // can be joined; where all searches together have come by every pair so often, they are cut short.
  static constexpr std::size_t most_visited = 1 << 22, most_visited_late = 1 << 15, visits_of_pair = 512;

  const CycleParts& parts_;
  const std::uint32_t most_, count_;
  ChangingOrder order_;
  std::vector<std::uint32_t> node_of_part_, part_of_node_;
  std::vector<std::uint32_t> joined_into_, first_in_chain_, last_in_chain_;  // by node
  std::vector<std::uint32_t> next_in_chain_;
  NodeLists lists_[2];  // by direction: what must come after and before
  std::vector<std::uint32_t> reached_[2];
  std::vector<std::uint32_t> reached_by_;  // by node: the last search that did, and its direction
  std::uint32_t last_search_ = 0;
  std::size_t visits_left_ = 0;
};

}  // namespace

std::vector<std::uint32_t> undo_needless_cuts(const CycleParts& parts, std::span<const HidingPair> pairs,
                                              const std::vector<std::uint32_t>& order) {
  return Joiner(parts, pairs, order).run();
}

}  // namespace facetsort::exact_internal
