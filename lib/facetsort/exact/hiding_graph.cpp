#include "facetsort/exact/hiding_graph.h"

#include <algorithm>

namespace facetsort::exact_internal {
namespace {

// Turns the lengths of lists, each at the place two after its own, into what fill() of each list's next value is to be
// counted up from: afterwards begin[i + 1] is where list i begins, and once filled, where it ends.
void begin_lists(std::vector<std::uint32_t>& begin) {
  for (std::size_t i = 2; i < begin.size(); ++i) begin[i] += begin[i - 1];
}

}  // namespace

NodeLists list_behind(std::size_t nodes, std::span<const HidingPair> pairs) {
  NodeLists lists{std::vector<std::uint32_t>(nodes + 2), std::vector<std::uint32_t>(pairs.size())};
  for (const HidingPair& pair : pairs) ++lists.begin[pair.second + 2];
  begin_lists(lists.begin);
  for (const HidingPair& pair : pairs) lists.values[lists.begin[pair.second + 1]++] = pair.first;
  lists.begin.pop_back();
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

NodeLists ordered_components(const NodeLists& behind) {
  constexpr std::uint32_t unseen = 0xffffffffu, closed = 0xfffffffeu;
  const std::size_t nodes = behind.count();
  NodeLists components{{0}, {}};
  components.values.reserve(nodes);
  std::vector<std::uint32_t> number(nodes, unseen), lowest(nodes), next(nodes);
  std::vector<std::uint32_t> open, visits;  // stacks of our own: cycles may go deep
  std::uint32_t visited = 0;
  const auto enter = [&](std::uint32_t node) {
    number[node] = lowest[node] = visited++;
    next[node] = behind.begin[node];
    open.push_back(node);
    visits.push_back(node);
  };
  // Goes on with the last visit until that enters another node, which it returns, or ends.
  const auto advance = [&](std::uint32_t node) {
    for (std::uint32_t i = next[node]; i < behind.begin[node + 1]; ++i) {
      const std::uint32_t other = behind.values[i];
      if (number[other] == unseen) {
        next[node] = i + 1;
        return other;
      }
      lowest[node] = std::min(lowest[node], number[other]);  // that of a closed one is larger than any
    }
    return unseen;
  };
  for (std::uint32_t root = 0; root < nodes; ++root) {
    if (number[root] != unseen) continue;
    enter(root);
    while (!visits.empty()) {
      const std::uint32_t node = visits.back();
      const std::uint32_t entered = advance(node);
      if (entered != unseen) {
        enter(entered);
        continue;
      }
      visits.pop_back();
      if (!visits.empty()) lowest[visits.back()] = std::min(lowest[visits.back()], lowest[node]);
      if (lowest[node] != number[node]) continue;
      const std::size_t first = components.values.size();
      std::uint32_t member;
      do {
        member = open.back();
        open.pop_back();
        number[member] = closed;
        components.values.push_back(member);
      } while (member != node);
      std::sort(components.values.begin() + static_cast<std::ptrdiff_t>(first), components.values.end());
      components.begin.push_back(static_cast<std::uint32_t>(components.values.size()));
    }
  }
  return components;
}

}  // namespace facetsort::exact_internal
