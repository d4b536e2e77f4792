// Pairs are wishes "far before near" that contradict each other: the heaviest go into an acyclic graph first, whose
// topological order is kept up to date (Pearce and Kelly 2007, "A Dynamic Topological Sort Algorithm for Directed
// Acyclic Graphs"), and those that would close a cycle are given up. Then facets move, one at a time, to where they
// break the least.
#include "facetsort/presort/mend_order.h"

#include <algorithm>
#include <numeric>

namespace facetsort::presort_internal {
namespace {

// Wishes that would take longer to grant are given up as if they closed a cycle.
constexpr std::size_t most_visited = 20000;
constexpr int most_passes = 4;

struct Neighbour {
  std::uint32_t facet;
  std::int64_t weight;
};

// Neighbours of each facet, filled up to `count` of the room for all.
class Lists {
 public:
  template <typename FacetOf>
  Lists(std::size_t facets, std::span<const Wish> wishes, const FacetOf& facet_of)
      : begins_(facets + 1, 0), counts_(facets, 0), neighbours_(wishes.size()) {
    for (const Wish& wish : wishes) ++begins_[facet_of(wish) + 1];
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  }
  void add(std::uint32_t facet, Neighbour neighbour) { neighbours_[begins_[facet] + counts_[facet]++] = neighbour; }
  std::span<const Neighbour> operator[](std::uint32_t facet) const {
    return {neighbours_.data() + begins_[facet], counts_[facet]};
  }

 private:
  std::vector<std::size_t> begins_;
  std::vector<std::uint32_t> counts_;
  std::vector<Neighbour> neighbours_;
};

class AcyclicOrder {
 public:
  AcyclicOrder(std::span<const Wish> wishes, std::vector<std::uint32_t>& order)
      : order_(order),
        position_(order.size()),
        behind_(order.size(), wishes, [](const Wish& wish) { return wish.then; }),
        before_(order.size(), wishes, [](const Wish& wish) { return wish.first; }),
        marked_(order.size(), 0) {
    for (std::size_t i = 0; i < order.size(); ++i) position_[order[i]] = static_cast<std::uint32_t>(i);
  }

  bool add(const Wish& wish) {
    if (position_[wish.first] > position_[wish.then] && !make_room(wish.first, wish.then)) return false;
    link(wish);
    return true;
  }
  void link(const Wish& wish) {
    behind_.add(wish.then, {wish.first, wish.weight});
    before_.add(wish.first, {wish.then, wish.weight});
  }

  // Moves facets, one at a time, to where they break the least.
  std::uint64_t improve(std::span<const Wish> broken) {
    std::vector<std::uint32_t> facets;
    for (const Wish& wish : broken) {
      facets.push_back(wish.first);
      facets.push_back(wish.then);
    }
    std::sort(facets.begin(), facets.end());
    facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
    std::uint64_t gained = 0;
    for (const std::uint32_t facet : facets) gained += move_to_best(facet);
    return gained;
  }
  std::uint32_t position(std::uint32_t facet) const { return position_[facet]; }

 private:
  // Reorders what is between the positions of `near` and `far`, which is wrongly behind it; false where `far` has to
  // come after `near`.
  bool make_room(std::uint32_t far, std::uint32_t near) {
    const std::uint32_t lowest = position_[near], highest = position_[far];
    after_.clear();
    bool acyclic = search(
        near, before_, after_, [&](std::uint32_t facet) { return position_[facet] <= highest; }, far);
    if (acyclic) {
      ahead_.clear();
      acyclic = search(
          far, behind_, ahead_, [&](std::uint32_t facet) { return position_[facet] >= lowest; }, near);
      for (const std::uint32_t facet : ahead_) marked_[facet] = 0;
    }
    for (const std::uint32_t facet : after_) marked_[facet] = 0;
    if (!acyclic) return false;
    const auto by_position = [&](std::uint32_t a, std::uint32_t b) { return position_[a] < position_[b]; };
    std::sort(after_.begin(), after_.end(), by_position);
    std::sort(ahead_.begin(), ahead_.end(), by_position);
    places_.clear();
    for (const std::uint32_t facet : ahead_) places_.push_back(position_[facet]);
    for (const std::uint32_t facet : after_) places_.push_back(position_[facet]);
    std::sort(places_.begin(), places_.end());
    std::size_t next = 0;
    for (const std::uint32_t facet : ahead_) place(facet, places_[next++]);
    for (const std::uint32_t facet : after_) place(facet, places_[next++]);
    return true;
  }

  // Everything that can be reached from `start` within bounds; false where that is `goal`, or too much.
  template <typename InBounds>
  bool search(std::uint32_t start, const Lists& lists, std::vector<std::uint32_t>& found, const InBounds& in_bounds,
              std::uint32_t goal) {
    found.push_back(start);
    marked_[start] = 1;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (found.size() > most_visited) return false;
      for (const Neighbour& next : lists[found[i]]) {
        if (next.facet == goal) return false;
        if (marked_[next.facet] || !in_bounds(next.facet)) continue;
        marked_[next.facet] = 1;
        found.push_back(next.facet);
      }
    }
    return true;
  }

  void place(std::uint32_t facet, std::uint32_t position) {
    order_[position] = facet;
    position_[facet] = position;
  }

  std::uint64_t move_to_best(std::uint32_t facet) {
    // Between which of its neighbours the facet comes: to come after one behind it costs nothing more, after one before
    // it costs that pair.
    steps_.clear();
    for (const Neighbour& n : behind_[facet]) steps_.push_back({position_[n.facet], -n.weight});
    for (const Neighbour& n : before_[facet]) steps_.push_back({position_[n.facet], n.weight});
    std::sort(steps_.begin(), steps_.end(), [](const Step& a, const Step& b) { return a.position < b.position; });
    std::int64_t cost = 0, current = 0;
    for (const Step& step : steps_) {
      if (step.position < position_[facet]) current += step.change;
    }
    std::int64_t least = current;
    std::size_t best_begin = 0, best_end = 0;
    bool found = false;
    const std::size_t here = position_[facet];
    std::size_t best_distance = 0;
    for (std::size_t i = 0; i <= steps_.size(); ++i) {
      // Before steps_[i]: positions (previous, next).
      const std::size_t begin = i == 0 ? 0 : steps_[i - 1].position + std::size_t{1};
      const std::size_t end = i == steps_.size() ? order_.size() : steps_[i].position;
      const std::size_t distance = end <= here ? here - end + 1 : begin > here ? begin - here : 0;
      if (cost < least || (found && cost == least && distance < best_distance)) {
        least = cost;
        best_begin = begin;
        best_end = end;
        best_distance = distance;
        found = true;
      }
      if (i < steps_.size()) cost += steps_[i].change;
    }
    if (!found) return 0;
    if (best_end <= here) {  // to just before the one at best_end
      for (std::size_t p = here; p > best_end; --p) place(order_[p - 1], static_cast<std::uint32_t>(p));
      place(facet, static_cast<std::uint32_t>(best_end));
    } else {  // to just after the one at best_begin - 1
      for (std::size_t p = here; p + 1 < best_begin; ++p) place(order_[p + 1], static_cast<std::uint32_t>(p));
      place(facet, static_cast<std::uint32_t>(best_begin - 1));
    }
    return static_cast<std::uint64_t>(current - least);
  }

  struct Step {
    std::uint32_t position;
    std::int64_t change;
  };

  std::vector<std::uint32_t>& order_;
  std::vector<std::uint32_t> position_;
  Lists behind_, before_;
  std::vector<char> marked_;
  std::vector<std::uint32_t> after_, ahead_, places_;
  std::vector<Step> steps_;
};

}  // namespace

void mend_order(std::span<const Wish> wishes, std::vector<std::uint32_t>& order) {
  std::vector<Wish> by_weight(wishes.begin(), wishes.end());
  std::stable_sort(by_weight.begin(), by_weight.end(),
                   [](const Wish& a, const Wish& b) { return a.weight > b.weight; });
  AcyclicOrder acyclic(wishes, order);
  std::vector<Wish> given_up;
  for (const Wish& wish : by_weight) {
    if (!acyclic.add(wish)) given_up.push_back(wish);
  }
  for (const Wish& wish : given_up) acyclic.link(wish);
  for (int pass = 0; pass < most_passes; ++pass) {
    if (acyclic.improve(given_up) == 0) break;
    given_up.clear();
    for (const Wish& wish : by_weight) {
      if (acyclic.position(wish.first) > acyclic.position(wish.then)) given_up.push_back(wish);
    }
  }
}

}  // namespace facetsort::presort_internal
