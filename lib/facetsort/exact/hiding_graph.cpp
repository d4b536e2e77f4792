#include "facetsort/exact/hiding_graph.h"

#include <algorithm>

namespace facetsort::exact_internal {
namespace {

// In number_: below them are those of open nodes.
constexpr std::uint32_t unseen = 0xffffffffu, closed = 0xfffffffeu;

// Turns the lengths of lists, each at the place two after its own, into what fill() of each list's next value is to be
// counted up from: afterwards begin[i + 1] is where list i begins, and once filled, where it ends.
void begin_lists(std::vector<std::uint32_t>& begin) {
  for (std::size_t i = 2; i < begin.size(); ++i) begin[i] += begin[i - 1];
}

}  // namespace

void list_behind(std::size_t nodes, std::span<const HidingPair> pairs, NodeLists& lists) {
  lists.begin.assign(nodes + 2, 0);
  lists.values.resize(pairs.size());
  for (const HidingPair& pair : pairs) ++lists.begin[pair.second + 2];
  begin_lists(lists.begin);
  for (const HidingPair& pair : pairs) lists.values[lists.begin[pair.second + 1]++] = pair.first;
  lists.begin.pop_back();
}

NodeLists list_behind(std::size_t nodes, std::span<const HidingPair> pairs) {
  NodeLists lists;
  list_behind(nodes, pairs, lists);
  return lists;
}

NodeLists reversed(const NodeLists& lists) {
  const std::size_t nodes = lists.count();
  NodeLists result{std::vector<std::uint32_t>(nodes + 2), std::vector<std::uint32_t>(lists.values.size())};
  for (const std::uint32_t value : lists.values) ++result.begin[value + 2];
  begin_lists(result.begin);
  for (std::uint32_t node = 0; node < nodes; ++node) {
    for (const std::uint32_t value : lists[node]) result.values[result.begin[value + 1]++] = node;
  }
  result.begin.pop_back();
  return result;
}

// Closes what was opened from `root` on.
void ComponentFinder::add_component(std::uint32_t root) {
  const std::size_t first = components_.values.size();
  std::uint32_t member;
  do {
    member = open_.back();
    open_.pop_back();
    number_[member] = closed;
    components_.values.push_back(member);
  } while (member != root);
  std::sort(components_.values.begin() + static_cast<std::ptrdiff_t>(first), components_.values.end());
  components_.begin.push_back(static_cast<std::uint32_t>(components_.values.size()));
}

const NodeLists& ComponentFinder::find(const NodeLists& behind) {
  const std::size_t nodes = behind.count();
  components_.begin.assign(1, 0);
  components_.begin.reserve(nodes + 1);
  components_.values.clear();
  components_.values.reserve(nodes);
  number_.assign(nodes, unseen);
  lowest_.resize(nodes);
  next_.resize(nodes);
  std::uint32_t visited = 0;
  const auto enter = [&](std::uint32_t node) {
    number_[node] = lowest_[node] = visited++;
    next_[node] = behind.begin[node];
    open_.push_back(node);
    visits_.push_back(node);
  };
  // Goes on with the last visit until that enters another node, which it returns, or ends.
  const auto advance = [&](std::uint32_t node) {
    for (std::uint32_t i = next_[node]; i < behind.begin[node + 1]; ++i) {
      const std::uint32_t other = behind.values[i];
      if (number_[other] == unseen) {
        next_[node] = i + 1;
        return other;
      }
      lowest_[node] = std::min(lowest_[node], number_[other]);  // that of a closed one is larger than any
    }
    return unseen;
  };
  for (std::uint32_t root = 0; root < nodes; ++root) {
    if (number_[root] != unseen) continue;
    if (behind.begin[root] == behind.begin[root + 1]) {  // so it is with most: a component of its own
      number_[root] = closed;
      components_.values.push_back(root);
      components_.begin.push_back(static_cast<std::uint32_t>(components_.values.size()));
      continue;
    }
    enter(root);
    while (!visits_.empty()) {
      const std::uint32_t node = visits_.back();
      const std::uint32_t entered = advance(node);
      if (entered != unseen) {
        enter(entered);
        continue;
      }
      visits_.pop_back();
      if (!visits_.empty()) lowest_[visits_.back()] = std::min(lowest_[visits_.back()], lowest_[node]);
      if (lowest_[node] == number_[node]) add_component(node);
    }
  }
  return components_;
}

}  // namespace facetsort::exact_internal
