// Views are joined as in agglomerative clustering (Ward 1963, "Hierarchical Grouping to Optimize an Objective
// Function"), the objective being the area of pairs that are asked for both ways round in one group: one of the two is
// drawn wrongly whatever the order, and nearly all else can be drawn rightly. Then single views move between groups
// (Hartigan and Wong 1979, "A K-Means Clustering Algorithm"), from there and from other starts.
#include "facetsort/presort/view_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/view.h"

namespace facetsort::presort_internal {
namespace {

// Neighbouring views move together until all has found its place.
constexpr std::size_t most_cells = 250;
constexpr int most_sweeps = 40;
// Searches from different starts, and how often each begins anew nearby.
constexpr std::size_t searches = 4;
constexpr int restarts = 3;
// Groups reach about so far from their middle: views farther apart than twice that are never asked to agree.
constexpr int cones = 60;
constexpr float cosine_of_cone = 0.6f;
constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

std::int64_t signed_area(const SeenPair& pair) {
  return pair.second_is_behind ? std::int64_t{pair.area} : -std::int64_t{pair.area};
}

Votes votes_of(std::span<const SeenPair> pairs) {
  Votes votes;
  votes.reserve(pairs.size());
  for (const SeenPair& pair : pairs) votes.push_back({pair.pair, signed_area(pair)});
  return votes;
}

std::vector<SeenPair> pairs_of(const Votes& votes) {
  std::vector<SeenPair> pairs;
  for (const Vote& vote : votes) {
    if (vote.area == 0) continue;
    const std::int64_t area = std::min<std::int64_t>(std::abs(vote.area), std::numeric_limits<std::uint32_t>::max());
    pairs.push_back({vote.pair & 0x7fffffffu, vote.area > 0, static_cast<std::uint32_t>(area)});
  }
  return pairs;
}

// Calls visit(pair, a, b) for each pair that one of them has.
template <typename Visit>
void visit_both(const Votes& a, const Votes& b, const Visit& visit) {
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    if (j == b.size() || (i < a.size() && a[i].pair < b[j].pair)) {
      visit(a[i].pair, a[i].area, std::int64_t{0});
      ++i;
    } else if (i == a.size() || b[j].pair < a[i].pair) {
      visit(b[j].pair, std::int64_t{0}, b[j].area);
      ++j;
    } else {
      visit(a[i].pair, a[i].area, b[j].area);
      ++i;
      ++j;
    }
  }
}

Votes sum(const Votes& a, const Votes& b) {
  Votes votes;
  votes.reserve(a.size() + b.size());
  visit_both(a, b, [&](std::uint32_t pair, std::int64_t in_a, std::int64_t in_b) {
    votes.push_back({pair, in_a + in_b});
  });
  return votes;
}

// What joining costs: the area in which the two disagree.
std::int64_t disagreement(const Votes& a, const Votes& b) {
  std::int64_t area = 0;
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const std::uint32_t in_a = a[i].pair, in_b = b[j].pair;
    if (in_a == in_b && (a[i].area < 0) != (b[j].area < 0)) {
      area += std::min(std::abs(a[i].area), std::abs(b[j].area));
    }
    i += in_a <= in_b;
    j += in_b <= in_a;
  }
  return area;
}

std::uint32_t nearest(std::span<const glm::vec3> directions, const glm::vec3& direction) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < directions.size(); ++i) {
    if (glm::dot(directions[i], direction) > glm::dot(directions[best], direction)) best = i;
  }
  return static_cast<std::uint32_t>(best);
}

std::vector<glm::vec3> sphere_directions(std::size_t count) {
  std::vector<glm::vec3> directions(count);
  for (std::size_t i = 0; i < count; ++i) {
    directions[i] = glm::vec3(fibonacci_direction(static_cast<int>(i), static_cast<int>(count)));
  }
  return directions;
}

// Only the pairs that are asked for both ways round by views that are not far from each other, numbered anew.
SeenViews contested(const SeenViews& views) {
  std::vector<std::uint32_t> number(views.pair_count, 0);
  std::vector<std::uint8_t> asked(views.pair_count);
  for (const glm::vec3& axis : sphere_directions(cones)) {
    std::fill(asked.begin(), asked.end(), std::uint8_t{0});
    for (std::size_t view = 0; view < views.count(); ++view) {
      if (glm::dot(axis, views.directions[view]) < cosine_of_cone) continue;
      for (const SeenPair& pair : views.pairs[view]) asked[pair.pair] |= pair.second_is_behind ? 2 : 1;
    }
    for (std::size_t pair = 0; pair < asked.size(); ++pair) number[pair] |= asked[pair] == 3;
  }
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

// Moves single views between groups as long as that lets less area be asked for both ways round.
class GroupSearch {
 public:
  GroupSearch(const SeenViews& views, std::size_t count, std::vector<std::uint32_t>& groups)
      : views_(views),
        count_(count),
        groups_(groups),
        votes_(views.pair_count * count, 0),
        means_(count, glm::vec3(0)) {
    for (std::size_t view = 0; view < views.count(); ++view) add(view, groups[view], 1);
  }

  void run() {
    for (int sweep = 0; sweep < most_sweeps; ++sweep) {
      bool moved = false;
      for (std::size_t view = 0; view < views_.count(); ++view) moved |= move_to_best(view);
      if (!moved) break;
    }
  }

  // The views of one group go to others, and views around one that is picked make a group in its stead.
  template <typename Random>
  void disturb(Random& random) {
    const auto group = static_cast<std::uint32_t>(random() % count_);
    const glm::vec3 picked = views_.directions[random() % views_.count()];
    for (std::size_t view = 0; view < views_.count(); ++view) {
      if (groups_[view] == group) move(view, best_group(view, group));
    }
    const std::vector<glm::vec3> means = means_;
    for (std::size_t view = 0; view < views_.count(); ++view) {
      const glm::vec3& direction = views_.directions[view];
      const float length = glm::length(means[groups_[view]]);
      if (length * glm::dot(picked, direction) > glm::dot(means[groups_[view]], direction)) move(view, group);
    }
  }

  // The area in which each group agrees with itself, which is large where little is lost.
  double agreement() const {
    double area = 0;
    for (const double vote : votes_) area += std::abs(vote);
    return area;
  }

 private:
  void add(std::size_t view, std::uint32_t group, int sign) {
    for (const SeenPair& pair : views_.pairs[view]) {
      votes_[pair.pair * count_ + group] += static_cast<double>(sign * signed_area(pair));
    }
    means_[group] += static_cast<float>(sign) * views_.directions[view];
  }
  void move(std::size_t view, std::uint32_t group) {
    add(view, groups_[view], -1);
    groups_[view] = group;
    add(view, group, 1);
  }
  // Another than its own only where that is better; never `closed`, where there is another.
  std::uint32_t best_group(std::size_t view, std::uint32_t closed) {
    const std::uint32_t own = groups_[view];
    add(view, own, -1);
    gains_.assign(count_, 0);
    for (const SeenPair& pair : views_.pairs[view]) {
      const auto asked = static_cast<double>(signed_area(pair));
      const double* const votes = &votes_[pair.pair * count_];
      for (std::size_t group = 0; group < count_; ++group) {
        gains_[group] += std::abs(votes[group] + asked) - std::abs(votes[group]);
      }
    }
    std::uint32_t best = own;
    for (std::uint32_t group = 0; group < count_; ++group) {
      const bool is_open = group != closed && glm::dot(means_[group], views_.directions[view]) > 0;
      if (is_open && (best == closed || gains_[group] > gains_[best])) best = group;
    }
    add(view, own, 1);
    return best;
  }
  bool move_to_best(std::size_t view) {
    const std::uint32_t best = best_group(view, not_drawn);
    if (best == groups_[view]) return false;
    move(view, best);
    return true;
  }

  const SeenViews& views_;
  std::size_t count_;
  std::vector<std::uint32_t>& groups_;
  std::vector<double> votes_;     // of each pair and group; whole numbers
  std::vector<glm::vec3> means_;  // of the groups, any length
  std::vector<double> gains_;
};

// Groups by the nearest of directions that are picked at random.
template <typename Random>
std::vector<std::uint32_t> random_groups(const SeenViews& views, std::size_t count, Random& random) {
  std::vector<glm::vec3> centres(count);
  for (glm::vec3& centre : centres) centre = views.directions[random() % views.count()];
  std::vector<std::uint32_t> groups;
  for (const glm::vec3& direction : views.directions) groups.push_back(nearest(centres, direction));
  return groups;
}

}  // namespace

ViewGrouper::ViewGrouper(const SeenViews& views)
    : views_(contested(views)), cells_{sphere_directions(std::min(most_cells, views.count())), {}, views_.pair_count} {
  for (const glm::vec3& direction : views_.directions) cell_of_.push_back(nearest(cells_.directions, direction));
  std::vector<Votes> votes(cells_.count());
  parallel_ranges(cells_.count(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t cell = begin; cell < end; ++cell) {
      for (std::size_t view = 0; view < views_.count(); ++view) {
        if (cell_of_[view] == cell) votes[cell] = sum(votes[cell], votes_of(views_.pairs[view]));
      }
    }
  });
  for (const Votes& of_cell : votes) cells_.pairs.push_back(pairs_of(of_cell));
  join_cells(std::move(votes));
}

void ViewGrouper::join_cells(std::vector<Votes> votes) {
  const auto count = static_cast<std::uint32_t>(cells_.count());
  // Views on opposite sides have nothing in common but what they disagree in.
  std::vector<glm::vec3> means = cells_.directions;
  std::vector<std::int64_t> costs(cells_.count() * cells_.count(), never);
  std::vector<char> gone(count, 0);
  const auto update = [&](std::uint32_t a, std::uint32_t b) {
    const bool apart = glm::dot(means[a], means[b]) < 0;
    const std::int64_t cost = apart ? never - 1 : disagreement(votes[a], votes[b]);
    costs[std::size_t{std::min(a, b)} * count + std::max(a, b)] = cost;
  };
  parallel_ranges(count, 1, [&](std::size_t begin, std::size_t end) {
    for (auto a = static_cast<std::uint32_t>(begin); a < end; ++a) {
      for (std::uint32_t b = a + 1; b < count; ++b) update(a, b);
    }
  });
  for (std::uint32_t left = count; left > 1; --left) {
    const auto least = static_cast<std::size_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
    const Join join{static_cast<std::uint32_t>(least / count), static_cast<std::uint32_t>(least % count)};
    joins_.push_back(join);
    votes[join.kept] = sum(votes[join.kept], votes[join.gone]);
    votes[join.gone] = {};
    gone[join.gone] = 1;
    means[join.kept] += means[join.gone];
    for (std::uint32_t other = 0; other < count; ++other) {
      costs[std::size_t{std::min(other, join.gone)} * count + std::max(other, join.gone)] = never;
    }
    parallel_ranges(count, 1, [&](std::size_t begin, std::size_t end) {
      for (auto other = static_cast<std::uint32_t>(begin); other < end; ++other) {
        if (other != join.kept && !gone[other]) update(join.kept, other);
      }
    });
  }
}

std::vector<std::uint32_t> ViewGrouper::joined_groups(std::size_t count) const {
  std::vector<std::uint32_t> groups(cells_.count());
  std::iota(groups.begin(), groups.end(), 0u);
  for (std::size_t i = 0; i + count < cells_.count(); ++i) {
    std::replace(groups.begin(), groups.end(), joins_[i].gone, joins_[i].kept);
  }
  std::vector<std::uint32_t> kept = groups;
  std::sort(kept.begin(), kept.end());
  kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
  for (std::uint32_t& group : groups) {
    group = static_cast<std::uint32_t>(std::lower_bound(kept.begin(), kept.end(), group) - kept.begin());
  }
  return groups;
}

std::vector<std::uint32_t> ViewGrouper::groups(std::size_t count) const {
  if (count < 2) return std::vector<std::uint32_t>(views_.count(), 0);
  std::vector<std::vector<std::uint32_t>> found(searches);
  std::vector<double> agreements(searches);
  parallel_ranges(searches, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      std::mt19937 random(static_cast<std::mt19937::result_type>(i));
      std::vector<std::uint32_t> groups = i == 0 ? joined_groups(count) : random_groups(cells_, count, random);
      for (int restart = 0; restart <= restarts; ++restart) {
        std::vector<std::uint32_t> tried = groups;
        GroupSearch search(cells_, count, tried);
        if (restart > 0) search.disturb(random);
        search.run();
        const double agreement = search.agreement();
        if (restart > 0 && agreement <= agreements[i]) continue;
        agreements[i] = agreement;
        groups = std::move(tried);
      }
      found[i] = std::move(groups);
    }
  });
  const auto best =
      static_cast<std::size_t>(std::max_element(agreements.begin(), agreements.end()) - agreements.begin());
  std::vector<std::uint32_t> groups;
  for (const std::uint32_t cell : cell_of_) groups.push_back(found[best][cell]);
  GroupSearch(views_, count, groups).run();
  return groups;
}

std::vector<std::int64_t> group_votes(const SeenViews& views, std::span<const std::uint32_t> groups,
                                      std::uint32_t group) {
  std::vector<std::int64_t> votes(views.pair_count, 0);
  for (std::size_t view = 0; view < views.count(); ++view) {
    if (groups[view] != group) continue;
    for (const SeenPair& pair : views.pairs[view]) votes[pair.pair] += signed_area(pair);
  }
  return votes;
}

}  // namespace facetsort::presort_internal
