#include "facetsort/scene/object_groups.h"

#include <algorithm>
#include <numeric>

#include "facetsort/scene/footprints.h"

namespace facetsort::scene_internal {
namespace {

Sequence opposite(Sequence sequence) {
  return sequence == Sequence::first_before    ? Sequence::second_before
         : sequence == Sequence::second_before ? Sequence::first_before
                                               : sequence;
}

// By planes across an axis, where the first has all of its points at `first_highest` or below, and the second at
// `second_lowest` or above. An eye between the two sees each on another side.
Sequence across_axis(float first_highest, float second_lowest, float eye, bool orthographic) {
  if (orthographic) {
    return eye > 0 ? Sequence::first_before : eye < 0 ? Sequence::second_before : Sequence::any;
  }
  return eye > second_lowest    ? Sequence::first_before
         : eye < first_highest ? Sequence::second_before
                               : Sequence::any;
}

std::uint32_t root_of(std::vector<std::uint32_t>& parents, std::uint32_t member) {
  while (parents[member] != member) member = parents[member] = parents[parents[member]];
  return member;
}

// Strongly connected components (Tarjan, "Depth-first search and linear graph algorithms", 1972), each after all that it
// leads to. The stack is our own: a chain of objects may be long.
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

// Whether boxes have no common part on the screen of an eye that has one chart for all.
class ScreenBoxes {
 public:
  ScreenBoxes(const glm::vec4& eye, std::span<const Box> boxes) {
    if (boxes.empty()) return;
    Box all = boxes.front();
    for (const Box& box : boxes) {
      all.lowest = glm::min(all.lowest, box.lowest);
      all.highest = glm::max(all.highest, box.highest);
    }
    const Charts charts(eye, all);
    if (charts.count() > 1) return;
    for (const Box& box : boxes) footprints_.push_back(footprint_of(charts, box));
  }

  bool are_apart(std::uint32_t first, std::uint32_t second) const {
    if (footprints_.empty()) return false;
    const Footprint &a = footprints_[first], &b = footprints_[second];
    return a.highest.x < b.lowest.x || b.highest.x < a.lowest.x || a.highest.y < b.lowest.y || b.highest.y < a.lowest.y;
  }

 private:
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

Sequence sequence_of(const Box& first, const Box& second, const glm::vec4& eye) {
  Sequence sequence = Sequence::interleaved;
  for (int axis = 0; axis < 3; ++axis) {
    Sequence by_axis = Sequence::interleaved;
    if (first.highest[axis] <= second.lowest[axis]) {
      by_axis = across_axis(first.highest[axis], second.lowest[axis], eye[axis], eye.w == 0.0f);
    } else if (second.highest[axis] <= first.lowest[axis]) {
      by_axis = opposite(across_axis(second.highest[axis], first.lowest[axis], eye[axis], eye.w == 0.0f));
    }
    if (by_axis == Sequence::any) return Sequence::any;
    if (by_axis == Sequence::interleaved) continue;
    // Two planes that contradict each other are both right: no ray meets the two.
    if (sequence != Sequence::interleaved && sequence != by_axis) return Sequence::any;
    sequence = by_axis;
  }
  return sequence;
}

void ObjectGroups::set_boxes(std::span<const Box> boxes) {
  boxes_.assign(boxes.begin(), boxes.end());
  const auto count = static_cast<std::uint32_t>(boxes.size());
  std::vector<std::uint32_t> parents(count), by_lowest(count);
  std::iota(parents.begin(), parents.end(), 0u);
  std::iota(by_lowest.begin(), by_lowest.end(), 0u);
  // From left to right, so that only neighbours along x are looked at.
  std::sort(by_lowest.begin(), by_lowest.end(), [&](std::uint32_t a, std::uint32_t b) {
    return boxes_[a].lowest.x != boxes_[b].lowest.x ? boxes_[a].lowest.x < boxes_[b].lowest.x : a < b;
  });
  const auto overlap = [&](const Box& a, const Box& b) {
    return glm::all(glm::lessThan(a.lowest, b.highest)) && glm::all(glm::lessThan(b.lowest, a.highest));
  };
  for (std::uint32_t i = 0; i < count; ++i) {
    const Box& box = boxes_[by_lowest[i]];
    for (std::uint32_t j = i + 1; j < count && boxes_[by_lowest[j]].lowest.x < box.highest.x; ++j) {
      if (!overlap(box, boxes_[by_lowest[j]])) continue;
      const std::uint32_t a = root_of(parents, by_lowest[i]), b = root_of(parents, by_lowest[j]);
      parents[std::max(a, b)] = std::min(a, b);
    }
  }
  clusters_.clear();
  std::vector<std::uint32_t> cluster_of(count);
  for (std::uint32_t object = 0; object < count; ++object) {
    const std::uint32_t root = root_of(parents, object);
    if (root == object) {
      cluster_of[object] = static_cast<std::uint32_t>(clusters_.size());
      clusters_.emplace_back();
    }
    clusters_[cluster_of[root]].push_back(object);
  }
}

void ObjectGroups::find_edges(const glm::vec4& eye) {
  const ScreenBoxes screen(eye, boxes_);
  const auto add_edge = [&](std::size_t from, std::size_t to) {
    if (later_[from].empty() || later_[from].back() != to) later_[from].push_back(static_cast<std::uint32_t>(to));
  };
  later_.resize(clusters_.size());
  for (std::vector<std::uint32_t>& list : later_) list.clear();
  for (std::size_t a = 0; a < clusters_.size(); ++a) {
    for (std::size_t b = a + 1; b < clusters_.size(); ++b) {
      for (const std::uint32_t first : clusters_[a]) {
        for (const std::uint32_t second : clusters_[b]) {
          if (screen.are_apart(first, second)) continue;
          const Sequence sequence = sequence_of(boxes_[first], boxes_[second], eye);
          if (sequence == Sequence::first_before) add_edge(a, b);
          if (sequence == Sequence::second_before) add_edge(b, a);
        }
      }
    }
  }
}

std::span<const std::vector<std::uint32_t>> ObjectGroups::find(const glm::vec4& eye) {
  find_edges(eye);
  const Components components(later_);
  groups_.clear();
  for (auto component = components.found.rbegin(); component != components.found.rend(); ++component) {
    std::vector<std::uint32_t>& group = groups_.emplace_back();
    for (const std::uint32_t cluster : *component) {
      group.insert(group.end(), clusters_[cluster].begin(), clusters_[cluster].end());
    }
    std::sort(group.begin(), group.end());
  }
  return groups_;
}

}  // namespace facetsort::scene_internal
