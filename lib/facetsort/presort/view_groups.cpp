// Single views move between groups as long as that loses less (Hartigan and Wong 1979, "A K-Means Clustering
// Algorithm"), from several starts, and from each best so far again with one group dissolved and another begun
// elsewhere (iterated local search: Lourenco, Martin and Stuetzle 2003).
#include "facetsort/presort/view_groups.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/view.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort::presort_internal {
namespace {

constexpr std::size_t searches = 4;
// So often, where views have few pairs; else as often as lets searches look at about so many.
constexpr std::size_t most_restarts = 10, pairs_looked_at = 100'000'000;
// Groups times pairs that searches hold votes for: beyond that, the pairs of the least area are left out.
constexpr std::size_t most_votes = std::size_t{1} << 24;
constexpr int most_sweeps = 40;
// Searches look at so many views, evenly spread; the best goes on with all.
constexpr std::size_t most_searched_views = 1000;
// A view only joins a group that some of its neighbours are in.
constexpr std::size_t neighbour_count = 8;
constexpr int cone_count = 60;

double signed_area(const SeenPair& pair) {
  return pair.second_is_behind ? static_cast<double>(pair.area) : -static_cast<double>(pair.area);
}

using Neighbours = std::array<std::uint32_t, neighbour_count>;

// Those of each view; itself where there are not enough.
std::vector<Neighbours> find_neighbours(std::span<const glm::vec3> directions) {
  std::vector<Neighbours> neighbours(directions.size());
  parallel_ranges(directions.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<std::pair<float, std::uint32_t>> others;
    for (std::size_t view = begin; view < end; ++view) {
      others.clear();
      for (std::uint32_t other = 0; other < directions.size(); ++other) {
        if (other != view) others.emplace_back(-glm::dot(directions[view], directions[other]), other);
      }
      const std::size_t found = std::min(neighbour_count, others.size());
      std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(found), others.end());
      neighbours[view].fill(static_cast<std::uint32_t>(view));
      for (std::size_t i = 0; i < found; ++i) neighbours[view][i] = others[i].second;
    }
  });
  return neighbours;
}

// Of the pairs marked in `kept`, leaves at most `count`: those of the most area.
void keep_largest(const SeenViews& views, std::size_t count, std::vector<std::uint32_t>& kept) {
  std::vector<std::int64_t> areas(views.pair_count, 0);
  for (const std::vector<SeenPair>& pairs : views.pairs) {
    for (const SeenPair& pair : pairs) areas[pair.pair] += kept[pair.pair] != 0 ? std::int64_t{pair.area} : 0;
  }
  std::vector<std::int64_t> sorted = areas;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count), sorted.end(), std::greater<>());
  const std::int64_t too_small = sorted[count];
  for (std::size_t pair = 0; pair < kept.size(); ++pair) kept[pair] = areas[pair] > too_small;
}

// Only the pairs that are asked for both ways round by views that may come into one group, numbered anew.
SeenViews contested(const SeenViews& views, std::size_t groups) {
  // Cones twice as wide as a group of its share of the sphere.
  const float cosine = 1 - 4 / static_cast<float>(groups);
  std::vector<std::uint32_t> number(views.pair_count, 0);
  std::vector<std::uint8_t> asked(views.pair_count);
  for (int i = 0; i < cone_count; ++i) {
    const glm::vec3 axis(fibonacci_direction(i, cone_count));
    std::fill(asked.begin(), asked.end(), std::uint8_t{0});
    for (std::size_t view = 0; view < views.count(); ++view) {
      if (glm::dot(axis, views.directions[view]) < cosine) continue;
      for (const SeenPair& pair : views.pairs[view]) asked[pair.pair] |= pair.second_is_behind ? 2 : 1;
    }
    for (std::size_t pair = 0; pair < asked.size(); ++pair) number[pair] |= asked[pair] == 3;
  }
  const std::size_t most_pairs = most_votes / groups;
  const auto found = static_cast<std::size_t>(std::count(number.begin(), number.end(), 1u));
  if (found > most_pairs) keep_largest(views, most_pairs, number);
  std::uint32_t count = 0;
  for (std::uint32_t& pair : number) pair = pair != 0 ? count++ : not_drawn;
  SeenViews few{views.directions, std::vector<std::vector<SeenPair>>(views.count()), count};
  for (std::size_t view = 0; view < views.count(); ++view) {
    for (SeenPair pair : views.pairs[view]) {
      if (number[pair.pair] == not_drawn) continue;
      pair.pair = number[pair.pair] & 0x7fffffffu;
      few.pairs[view].push_back(pair);
    }
  }
  return few;
}

class GroupSearch {
 public:
  GroupSearch(const SeenViews& views, std::span<const Neighbours> neighbours, std::size_t count,
              std::vector<std::uint32_t> groups)
      : views_(&views),
        neighbours_(neighbours),
        count_(count),
        groups_(std::move(groups)),
        votes_(views.pair_count * count, 0) {
    for (std::size_t view = 0; view < views.count(); ++view) add(view, groups_[view], 1);
  }

  void run() {
    bool moved = true;
    for (int sweep = 0; moved && sweep < most_sweeps; ++sweep) {
      moved = false;
      for (std::size_t view = 0; view < views_->count(); ++view) moved |= move_to_best(view);
    }
  }

  // The views of one group go to others, and those around a view that is picked make a group in its stead.
  template <typename Random>
  void disturb(Random& random) {
    const auto dissolved = static_cast<std::uint32_t>(random() % count_);
    std::vector<glm::vec3> middles(count_, glm::vec3(0));
    for (std::size_t view = 0; view < views_->count(); ++view) middles[groups_[view]] += views_->directions[view];
    for (glm::vec3& middle : middles) {
      if (const float length = glm::length(middle); length > 0) middle /= length;
    }
    middles[dissolved] = views_->directions[random() % views_->count()];
    for (std::size_t view = 0; view < views_->count(); ++view) {
      const auto group = static_cast<std::uint32_t>(nearest_direction(middles, views_->directions[view]));
      if (groups_[view] == dissolved || group == dissolved) move(view, group);
    }
  }

  // The area in which the groups agree with themselves: large where little is lost.
  double agreement() const {
    double area = 0;
    for (const double vote : votes_) area += std::abs(vote);
    return area;
  }
  const std::vector<std::uint32_t>& groups() const { return groups_; }

 private:
  void add(std::size_t view, std::uint32_t group, double sign) {
    for (const SeenPair& pair : views_->pairs[view]) votes_[pair.pair * count_ + group] += sign * signed_area(pair);
  }
  void move(std::size_t view, std::uint32_t group) {
    add(view, groups_[view], -1);
    groups_[view] = group;
    add(view, group, 1);
  }
  bool move_to_best(std::size_t view) {
    const std::uint32_t own = groups_[view];
    candidates_.clear();
    for (const std::uint32_t neighbour : neighbours_[view]) {
      const std::uint32_t group = groups_[neighbour];
      const bool is_new = std::find(candidates_.begin(), candidates_.end(), group) == candidates_.end();
      if (group != own && is_new) candidates_.push_back(group);
    }
    double most_gained = 0;
    std::uint32_t best = own;
    for (const std::uint32_t group : candidates_) {
      double gained = 0;
      for (const SeenPair& pair : views_->pairs[view]) {
        const double asked = signed_area(pair);
        const double there = votes_[pair.pair * count_ + group], here = votes_[pair.pair * count_ + own];
        gained += std::abs(there + asked) - std::abs(there) + std::abs(here - asked) - std::abs(here);
      }
      if (gained <= most_gained) continue;
      most_gained = gained;
      best = group;
    }
    if (best != own) move(view, best);
    return best != own;
  }

  const SeenViews* views_;
  std::span<const Neighbours> neighbours_;
  std::size_t count_;
  std::vector<std::uint32_t> groups_;
  std::vector<double> votes_;  // of each pair and group; whole numbers
  std::vector<std::uint32_t> candidates_;
};

// Every step-th view.
SeenViews some_views(const SeenViews& views, std::size_t step) {
  SeenViews some{{}, {}, views.pair_count};
  for (std::size_t view = 0; view < views.count(); view += step) {
    some.directions.push_back(views.directions[view]);
    some.pairs.push_back(views.pairs[view]);
  }
  return some;
}

// Groups by the nearest of directions that are picked at random.
template <typename Random>
std::vector<std::uint32_t> random_groups(const SeenViews& views, std::size_t count, Random& random) {
  std::vector<glm::vec3> middles(count);
  for (glm::vec3& middle : middles) middle = views.directions[random() % views.count()];
  std::vector<std::uint32_t> groups;
  for (const glm::vec3& direction : views.directions) {
    groups.push_back(static_cast<std::uint32_t>(nearest_direction(middles, direction)));
  }
  return groups;
}

}  // namespace

std::vector<std::int64_t> group_votes(const SeenViews& views, std::span<const std::uint32_t> groups,
                                      std::uint32_t group) {
  std::vector<std::int64_t> votes(views.pair_count, 0);
  for (std::size_t view = 0; view < views.count(); ++view) {
    if (groups[view] != group) continue;
    for (const SeenPair& pair : views.pairs[view]) {
      votes[pair.pair] += pair.second_is_behind ? std::int64_t{pair.area} : -std::int64_t{pair.area};
    }
  }
  return votes;
}

std::vector<std::uint32_t> group_views(const SeenViews& views, std::size_t count) {
  if (count == 1) return std::vector<std::uint32_t>(views.count(), 0);
  const SeenViews all = contested(views, count);
  const SeenViews few = some_views(all, (all.count() + most_searched_views - 1) / most_searched_views);
  const std::vector<Neighbours> neighbours = find_neighbours(few.directions);
  std::size_t pairs = 1;
  for (const std::vector<SeenPair>& of_view : few.pairs) pairs += of_view.size();
  const std::size_t restarts = std::min(most_restarts, pairs_looked_at / pairs);
  std::vector<std::vector<std::uint32_t>> found(searches);
  std::vector<double> agreements(searches);
  parallel_ranges(searches, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::mt19937 random(static_cast<std::mt19937::result_type>(i));
      GroupSearch best(few, neighbours, count, random_groups(few, count, random));
      best.run();
      agreements[i] = best.agreement();
      for (std::size_t restart = 0; restart < restarts; ++restart) {
        GroupSearch tried = best;
        tried.disturb(random);
        tried.run();
        const double agreement = tried.agreement();
        if (agreement <= agreements[i]) continue;
        agreements[i] = agreement;
        best = std::move(tried);
      }
      found[i] = best.groups();
    }
  });
  const auto best = std::max_element(agreements.begin(), agreements.end()) - agreements.begin();
  std::vector<std::uint32_t> groups;
  for (const glm::vec3& direction : all.directions) {
    groups.push_back(found[static_cast<std::size_t>(best)][nearest_direction(few.directions, direction)]);
  }
  const std::vector<Neighbours> all_neighbours = find_neighbours(all.directions);
  GroupSearch search(all, all_neighbours, count, std::move(groups));
  search.run();
  return search.groups();
}

}  // namespace facetsort::presort_internal
