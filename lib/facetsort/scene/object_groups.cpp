#include "facetsort/scene/object_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "facetsort/facets/facets.h"
#include "facetsort/scene/footprints.h"

namespace facetsort::scene_internal {
namespace {

struct Direction {
  double x, y, z;

  // A point's coordinate along it, and how far rounding may have moved that: not at all along an axis.
  double along(const glm::dvec3& p) const { return x * p.x + y * p.y + z * p.z; }
  double error(const glm::dvec3& p) const {
    const bool is_axis = std::abs(x) + std::abs(y) + std::abs(z) == 1;
    return is_axis ? 0 : 0x1p-51 * (std::abs(p.x) + std::abs(p.y) + std::abs(p.z));
  }
};
constexpr std::array<Direction, Slabs::directions> directions{{{1, 0, 0},
                                                               {0, 1, 0},
                                                               {0, 0, 1},
                                                               {1, 1, 0},
                                                               {1, -1, 0},
                                                               {1, 0, 1},
                                                               {1, 0, -1},
                                                               {0, 1, 1},
                                                               {0, 1, -1},
                                                               {1, 1, 1},
                                                               {1, 1, -1},
                                                               {1, -1, 1},
                                                               {1, -1, -1}}};

bool are_parted(const Slabs& first, const Slabs& second) {
  for (std::size_t d = 0; d < Slabs::directions; ++d) {
    if (first.highest[d] <= second.lowest[d] || second.highest[d] <= first.lowest[d]) return true;
  }
  return false;
}

// By the planes between two slabs, of which the lower ends at `end` and the higher begins at `begin`: which may be
// drawn last, because some plane has it on the eye's side. Neither where rounding hides the side.
struct MayBeLast {
  bool higher, lower;
};
MayBeLast which_may_be_last(const Direction& direction, double end, double begin, const glm::vec4& eye) {
  const glm::dvec3 e(eye);
  const double at = direction.along(e), error = direction.error(e);
  if (eye.w == 0.0f) return {at - error >= 0, at + error <= 0};
  return {at - error >= end, at + error <= begin};
}

std::uint32_t root_of(std::vector<std::uint32_t>& parents, std::uint32_t member) {
  while (parents[member] != member) member = parents[member] = parents[parents[member]];
  return member;
}

// Strongly connected components (Tarjan, "Depth-first search and linear graph algorithms", 1972), each after all that
// it leads to. The stack is our own: a chain of objects may be long.
class Components {
 public:
  explicit Components(const std::vector<std::vector<std::uint32_t>>& edges)
      : edges_(edges), number_(edges.size(), 0), lowest_(edges.size(), 0), is_open_(edges.size(), false) {
    for (std::uint32_t node = 0; node < edges.size(); ++node) {
      if (number_[node] == 0) search(node);
    }
  }

  std::vector<std::vector<std::uint32_t>> found;

 private:
  struct Visit {
    std::uint32_t node;
    std::size_t next_edge;
  };

  void open(std::uint32_t node) {
    number_[node] = lowest_[node] = ++numbers_;
    is_open_[node] = true;
    open_.push_back(node);
    visits_.push_back({node, 0});
  }

  void close(std::uint32_t node) {
    if (lowest_[node] != number_[node]) return;
    std::vector<std::uint32_t>& component = found.emplace_back();
    std::uint32_t member;
    do {
      member = open_.back();
      open_.pop_back();
      is_open_[member] = false;
      component.push_back(member);
    } while (member != node);
  }

  void search(std::uint32_t start) {
    open(start);
    while (!visits_.empty()) {
      Visit& visit = visits_.back();
      const std::uint32_t node = visit.node;
      if (visit.next_edge < edges_[node].size()) {
        const std::uint32_t next = edges_[node][visit.next_edge++];
        if (number_[next] == 0) {
          open(next);
        } else if (is_open_[next]) {
          lowest_[node] = std::min(lowest_[node], number_[next]);
        }
        continue;
      }
      close(node);
      visits_.pop_back();
      if (!visits_.empty()) lowest_[visits_.back().node] = std::min(lowest_[visits_.back().node], lowest_[node]);
    }
  }

  const std::vector<std::vector<std::uint32_t>>& edges_;
  std::vector<std::uint32_t> number_, lowest_;
  std::vector<bool> is_open_;
  std::vector<std::uint32_t> open_;
  std::vector<Visit> visits_;
  std::uint32_t numbers_ = 0;
};

// Whether objects have no common part on the screen of an eye that has one chart for all.
class ScreenBoxes {
 public:
  ScreenBoxes(const glm::vec4& eye, std::span<const Slabs> slabs) {
    if (slabs.empty()) return;
    Box all = box_of(slabs.front());
    for (const Slabs& of : slabs) {
      const Box box = box_of(of);
      all.lowest = glm::min(all.lowest, box.lowest);
      all.highest = glm::max(all.highest, box.highest);
    }
    const Charts charts(eye, all);
    if (charts.count() > 1) return;
    for (const Slabs& of : slabs) footprints_.push_back(footprint_of(charts, box_of(of)));
  }

  bool are_apart(std::uint32_t first, std::uint32_t second) const {
    if (footprints_.empty()) return false;
    const Footprint &a = footprints_[first], &b = footprints_[second];
    return a.highest.x < b.lowest.x || b.highest.x < a.lowest.x || a.highest.y < b.lowest.y || b.highest.y < a.lowest.y;
  }

 private:
  // Along the axes slabs are floats.
  static Box box_of(const Slabs& slabs) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lowest[axis] = static_cast<float>(slabs.lowest[static_cast<std::size_t>(axis)]);
      box.highest[axis] = static_cast<float>(slabs.highest[static_cast<std::size_t>(axis)]);
    }
    return box;
  }

  static Footprint footprint_of(const Charts& charts, const Box& box) {
    Footprint whole, part;
    for (int corner = 0; corner < 8; ++corner) {
      glm::vec3 point = box.lowest;
      for (int axis = 0; axis < 3; ++axis) {
        if ((corner >> axis & 1) != 0) point[axis] = box.highest[axis];
      }
      charts.find_one({point, point, point}, part);
      if (corner == 0) whole = part;
      whole.lowest = glm::min(whole.lowest, part.lowest);
      whole.highest = glm::max(whole.highest, part.highest);
    }
    return whole;
  }

  std::vector<Footprint> footprints_;
};

}  // namespace

Slabs slabs_of(std::span<const glm::uvec3> triangles, std::span<const glm::vec3> positions) {
  Slabs slabs;
  slabs.lowest.fill(std::numeric_limits<double>::infinity());
  slabs.highest.fill(-std::numeric_limits<double>::infinity());
  for (const glm::uvec3& triangle : triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 p(positions[triangle[i]]);
      for (std::size_t d = 0; d < Slabs::directions; ++d) {
        const double at = directions[d].along(p), error = directions[d].error(p);
        slabs.lowest[d] = std::min(slabs.lowest[d], at - error);
        slabs.highest[d] = std::max(slabs.highest[d], at + error);
      }
    }
  }
  return slabs;
}

Sequence sequence_of(const Slabs& first, const Slabs& second, const glm::vec4& eye) {
  bool first_may_be_last = false, second_may_be_last = false;
  for (std::size_t d = 0; d < Slabs::directions; ++d) {
    if (first.highest[d] <= second.lowest[d]) {
      const MayBeLast may = which_may_be_last(directions[d], first.highest[d], second.lowest[d], eye);
      second_may_be_last |= may.higher;
      first_may_be_last |= may.lower;
    }
    if (second.highest[d] <= first.lowest[d]) {
      const MayBeLast may = which_may_be_last(directions[d], second.highest[d], first.lowest[d], eye);
      first_may_be_last |= may.higher;
      second_may_be_last |= may.lower;
    }
  }
  // Where both may be, no ray meets the two: planes that seem to contradict each other are all right.
  if (first_may_be_last && second_may_be_last) return Sequence::any;
  return first_may_be_last    ? Sequence::second_before
         : second_may_be_last ? Sequence::first_before
                              : Sequence::interleaved;
}

void ObjectGroups::set_slabs(std::span<const Slabs> slabs) {
  slabs_.assign(slabs.begin(), slabs.end());
  const auto count = static_cast<std::uint32_t>(slabs.size());
  std::vector<std::uint32_t> parents(count), by_lowest(count);
  std::iota(parents.begin(), parents.end(), 0u);
  std::iota(by_lowest.begin(), by_lowest.end(), 0u);
  // From left to right, so that only neighbours along x are looked at.
  std::sort(by_lowest.begin(), by_lowest.end(), [&](std::uint32_t a, std::uint32_t b) {
    return slabs_[a].lowest[0] != slabs_[b].lowest[0] ? slabs_[a].lowest[0] < slabs_[b].lowest[0] : a < b;
  });
  for (std::uint32_t i = 0; i < count; ++i) {
    const Slabs& left = slabs_[by_lowest[i]];
    for (std::uint32_t j = i + 1; j < count && slabs_[by_lowest[j]].lowest[0] < left.highest[0]; ++j) {
      if (are_parted(left, slabs_[by_lowest[j]])) continue;
      const std::uint32_t a = root_of(parents, by_lowest[i]), b = root_of(parents, by_lowest[j]);
      parents[std::max(a, b)] = std::min(a, b);
    }
  }
  groups_.clear();
  std::vector<std::uint32_t> group_of(count);
  for (std::uint32_t object = 0; object < count; ++object) {
    const std::uint32_t root = root_of(parents, object);
    if (root == object) {
      group_of[object] = static_cast<std::uint32_t>(groups_.size());
      groups_.emplace_back();
    }
    groups_[group_of[root]].push_back(object);
  }
}

void ObjectGroups::find_edges(const glm::vec4& eye) {
  const ScreenBoxes screen(eye, slabs_);
  const auto add_edge = [&](std::size_t from, std::size_t to) {
    if (later_[from].empty() || later_[from].back() != to) later_[from].push_back(static_cast<std::uint32_t>(to));
  };
  later_.resize(groups_.size());
  for (std::vector<std::uint32_t>& list : later_) list.clear();
  for (std::size_t a = 0; a < groups_.size(); ++a) {
    for (std::size_t b = a + 1; b < groups_.size(); ++b) {
      for (const std::uint32_t first : groups_[a]) {
        for (const std::uint32_t second : groups_[b]) {
          if (screen.are_apart(first, second)) continue;
          const Sequence sequence = sequence_of(slabs_[first], slabs_[second], eye);
          if (sequence == Sequence::first_before || sequence == Sequence::interleaved) add_edge(a, b);
          if (sequence == Sequence::second_before || sequence == Sequence::interleaved) add_edge(b, a);
        }
      }
    }
  }
}

std::span<const std::vector<std::uint32_t>> ObjectGroups::find(const glm::vec4& eye) {
  find_edges(eye);
  const Components components(later_);
  std::vector<std::vector<std::uint32_t>> found;
  for (auto component = components.found.rbegin(); component != components.found.rend(); ++component) {
    std::vector<std::uint32_t>& group = found.emplace_back();
    for (const std::uint32_t part : *component) group.insert(group.end(), groups_[part].begin(), groups_[part].end());
    std::sort(group.begin(), group.end());
  }
  groups_ = std::move(found);
  return groups_;
}

}  // namespace facetsort::scene_internal
