#include "facetsort/exact/cycles.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>

namespace facetsort::exact_internal {
namespace {

constexpr std::uint32_t none = 0xffffffffu;

std::vector<PointId> loop_of(const std::vector<PartCorner>& corners) {
  std::vector<PointId> loop;
  loop.reserve(corners.size());
  for (const PartCorner& corner : corners) loop.push_back(corner.point);
  return loop;
}

class CycleCutter {
 public:
  CycleCutter(const Points& base, const Viewpoint& from, std::vector<CycleMember> members, std::size_t most_cuts)
      : from_(from), most_cuts_(most_cuts), result_{Points(&base), {}, {}, 0, false} {
    for (std::uint32_t i = 0; i < members.size(); ++i) {
      CycleMember& member = members[i];
      std::vector<PointId> loop = loop_of(member.corners);
      parts_.push_back(
          {member.facet, member.facing, {std::move(member.corners), std::move(member.cuts)}, std::move(loop), i, true});
    }
  }

  OrderedCycle run(const std::vector<HidingPair>& pairs) {
    std::vector<std::uint32_t> all(parts_.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    tasks_.push_back({Task::cut, std::move(all), pairs});
    while (!tasks_.empty()) {
      Task task = std::move(tasks_.back());
      tasks_.pop_back();
      if (task.kind == Task::cut) {
        cut(task.parts, task.pairs);
      } else if (task.kind == Task::order) {
        order(task.parts, task.pairs);
      } else {
        for (const std::uint32_t part : task.parts) emit(part);
      }
      result_.gave_up = result_.cuts > most_cuts_;
      if (result_.gave_up) break;
    }
    return std::move(result_);
  }

 private:
  // What is left to do, the last first: a stack of our own, since cycles may go deep.
  struct Task {
    enum Kind { emit, order, cut } kind;
    std::vector<std::uint32_t> parts;
    std::vector<HidingPair> pairs;  // among the parts
  };

  struct LocalPart {
    FacetId facet;
    int facing;
    Polygon polygon;
    std::vector<PointId> loop;
    std::uint32_t member;
    bool is_whole;
  };

  SeenPart seen(std::uint32_t part) const { return {parts_[part].facet, parts_[part].facing, parts_[part].loop}; }

  void emit(std::uint32_t part) {
    const LocalPart& p = parts_[part];
    if (p.is_whole) {
      result_.order.push_back({p.member, true, 0});
      return;
    }
    result_.order.push_back({p.member, false, static_cast<std::uint32_t>(result_.pieces.parts.size())});
    result_.pieces.add(p.facet, p.polygon.corners, p.polygon.cuts);
  }

  // Each part's place among `parts`, in local_.
  void number(const std::vector<std::uint32_t>& parts) {
    local_.resize(parts_.size());
    for (std::uint32_t i = 0; i < parts.size(); ++i) local_[parts[i]] = i;
  }

  // Breaks a small component by cutting a single part along the plane of another, and emits it, where that is enough.
  bool cut_one(const std::vector<std::uint32_t>& parts, const std::vector<HidingPair>& pairs) {
    constexpr std::size_t most_parts = 12;
    if (parts.size() > most_parts) return false;
    for (const std::uint32_t part : parts) {
      for (const std::uint32_t other : parts) {
        if (other == part || side_of(parts_[other].facet, part) != in_both) continue;
        const std::size_t parts_before = parts_.size(), points_before = result_.points.size();
        const auto [beyond, before] = halve(part, parts_[other].facet, parts_[other].facing);
        std::vector<HidingPair> kept;
        for (const HidingPair& pair : pairs) {
          if (pair.first != part && pair.second != part) {
            kept.push_back(pair);
            continue;
          }
          for (const std::uint32_t half : {beyond, before}) {
            keep_pair(pair, pair.first == part ? half : pair.first, pair.second == part ? half : pair.second, kept);
          }
        }
        std::vector<std::uint32_t> left = {beyond, before};
        for (const std::uint32_t p : parts) {
          if (p != part) left.push_back(p);
        }
        number(left);
        std::vector<std::vector<std::uint32_t>> behind(left.size());
        for (const HidingPair& pair : kept) behind[local_[pair.second]].push_back(local_[pair.first]);
        const auto components = ordered_components(behind);
        if (components.size() == left.size()) {
          for (const std::vector<std::uint32_t>& component : components) emit(left[component.front()]);
          return true;
        }
        parts_.resize(parts_before);
        result_.points.truncate(points_before);
        --result_.cuts;
      }
    }
    return false;
  }

  // Takes one component apart by the plane of one of its parts.
  void cut(const std::vector<std::uint32_t>& parts, const std::vector<HidingPair>& pairs) {
    if (cut_one(parts, pairs)) return;
    number(parts);
    const std::uint32_t chosen = parts[choose_plane(parts)];
    const FacetId plane = parts_[chosen].facet;
    const int facing = parts_[chosen].facing;
    std::vector<std::uint32_t> side_parts[2], in_plane;  // beyond the plane as the eye sees it, before it
    // The one or two parts that each part has become, by side.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> halves(parts.size(), {none, none});
    for (std::uint32_t i = 0; i < parts.size(); ++i) {
      const std::uint32_t part = parts[i];
      const int side = side_of(plane, part);
      if (side == in_both) {
        halves[i] = halve(part, plane, facing);
      } else if (side == 0) {
        in_plane.push_back(part);
        continue;
      } else {
        (side * facing < 0 ? halves[i].first : halves[i].second) = part;
      }
      if (halves[i].first != none) side_parts[0].push_back(halves[i].first);
      if (halves[i].second != none) side_parts[1].push_back(halves[i].second);
    }
    std::vector<HidingPair> side_pairs[2];
    for (const HidingPair& pair : pairs) {
      const auto first = halves[local_[pair.first]], second = halves[local_[pair.second]];
      keep_pair(pair, first.first, second.first, side_pairs[0]);
      keep_pair(pair, first.second, second.second, side_pairs[1]);
    }
    tasks_.push_back({Task::order, std::move(side_parts[1]), std::move(side_pairs[1])});
    tasks_.push_back({Task::emit, std::move(in_plane), {}});
    tasks_.push_back({Task::order, std::move(side_parts[0]), std::move(side_pairs[0])});
  }

  void keep_pair(const HidingPair& pair, std::uint32_t first, std::uint32_t second, std::vector<HidingPair>& kept) {
    if (first == none || second == none) return;
    if (first == pair.first && second == pair.second) {
      kept.push_back(pair);
      return;
    }
    const Hiding relation = hiding(result_.points, from_, seen(first), seen(second));
    if (relation == Hiding::first_behind_second) kept.push_back({first, second});
    if (relation == Hiding::second_behind_first) kept.push_back({second, first});
  }

  // Brings parts in order, components that are to be taken apart in turn.
  void order(const std::vector<std::uint32_t>& parts, const std::vector<HidingPair>& pairs) {
    number(parts);
    std::vector<std::vector<std::uint32_t>> behind(parts.size());
    for (const HidingPair& pair : pairs) behind[local_[pair.second]].push_back(local_[pair.first]);
    const auto components = ordered_components(behind);
    std::vector<std::uint32_t> component_of(parts.size());
    for (std::uint32_t c = 0; c < components.size(); ++c) {
      for (const std::uint32_t node : components[c]) component_of[node] = c;
    }
    std::vector<std::vector<HidingPair>> pairs_of(components.size());
    for (const HidingPair& pair : pairs) {
      const std::uint32_t c = component_of[local_[pair.first]];
      if (c == component_of[local_[pair.second]]) pairs_of[c].push_back(pair);
    }
    for (std::size_t c = components.size(); c-- > 0;) {
      std::vector<std::uint32_t> component_parts;
      for (const std::uint32_t node : components[c]) component_parts.push_back(parts[node]);
      const Task::Kind kind = component_parts.size() == 1 ? Task::emit : Task::cut;
      tasks_.push_back({kind, std::move(component_parts), std::move(pairs_of[c])});
    }
  }

  static constexpr int in_both = 2;

  // +1 or -1: wholly on that side of the plane, or touching it; 0: in it.
  int side_of(FacetId plane, std::uint32_t part) const {
    if (result_.points.same_plane(parts_[part].facet) == result_.points.same_plane(plane)) return 0;
    bool above = false, below = false;
    for (const PointId corner : parts_[part].loop) {
      const int side = result_.points.side(plane, corner);
      above = above || side > 0;
      below = below || side < 0;
      if (above && below) return in_both;
    }
    return above - below;
  }

  // Parts of a part beyond and before the plane.
  std::pair<std::uint32_t, std::uint32_t> halve(std::uint32_t part, FacetId plane, int facing) {
    Polygon front, back;
    cut_in_two(result_.points, parts_[part].facet, parts_[part].polygon, result_.points.same_plane(plane), front, back,
               sides_);
    ++result_.cuts;
    const bool same_way = result_.points.space().faces_away[plane] == 0;
    const auto add = [&](Polygon& polygon) {
      std::vector<PointId> loop = loop_of(polygon.corners);
      parts_.push_back({parts_[part].facet, parts_[part].facing, std::move(polygon), std::move(loop),
                        parts_[part].member, false});
      return static_cast<std::uint32_t>(parts_.size() - 1);
    };
    const std::uint32_t in_front = add(front), behind = add(back);
    const bool eye_in_front = (facing > 0) == same_way;
    return eye_in_front ? std::pair(behind, in_front) : std::pair(in_front, behind);
  }

  // The part whose plane cuts the fewest others, and divides the rest evenly; judged by a sample of both.
  std::size_t choose_plane(const std::vector<std::uint32_t>& parts) const {
    constexpr std::size_t most_tried = 32, most_judged = 256;
    const std::size_t step = (parts.size() + most_tried - 1) / most_tried;
    const std::size_t judged_step = (parts.size() + most_judged - 1) / most_judged;
    // In a large component an uneven plane leaves nearly all of the work to do again; in a small one cuts are what
    // counts.
    const std::size_t cost_of_cut = parts.size() > most_judged ? 4 : parts.size();
    std::size_t chosen = 0, best_cost = std::numeric_limits<std::size_t>::max();
    for (std::size_t i = 0; i < parts.size(); i += step) {
      std::size_t cuts = 0, above = 0, below = 0;
      for (std::size_t k = 0; k < parts.size(); k += judged_step) {
        const int side = side_of(parts_[parts[i]].facet, parts[k]);
        cuts += side == in_both;
        above += side == 1;
        below += side == -1;
        if (cost_of_cut * cuts > best_cost) break;
      }
      const std::size_t cost = cost_of_cut * cuts + std::max(above, below);
      if (cost < best_cost) {
        best_cost = cost;
        chosen = i;
      }
    }
    return chosen;
  }

  const Viewpoint from_;
  const std::size_t most_cuts_;
  OrderedCycle result_;
  std::vector<LocalPart> parts_;
  std::vector<Task> tasks_;
  std::vector<std::uint32_t> local_;
  std::vector<int> sides_;
};

}  // namespace

std::vector<std::vector<std::uint32_t>> ordered_components(std::span<const std::vector<std::uint32_t>> behind) {
  const std::size_t count = behind.size();
  std::vector<std::vector<std::uint32_t>> components;
  std::vector<std::uint32_t> number(count, none), lowest(count), open;
  std::vector<unsigned char> is_open(count);
  struct Visit {
    std::uint32_t node;
    std::size_t next;
  };
  std::vector<Visit> visits;
  std::uint32_t visited = 0;
  const auto enter = [&](std::uint32_t node) {
    number[node] = lowest[node] = visited++;
    open.push_back(node);
    is_open[node] = 1;
    visits.push_back({node, 0});
  };
  for (std::uint32_t root = 0; root < count; ++root) {
    if (number[root] != none) continue;
    enter(root);
    while (!visits.empty()) {
      Visit& visit = visits.back();
      const std::uint32_t node = visit.node;
      if (visit.next < behind[node].size()) {
        const std::uint32_t other = behind[node][visit.next++];
        if (number[other] == none) {
          enter(other);
        } else if (is_open[other]) {
          lowest[node] = std::min(lowest[node], number[other]);
        }
        continue;
      }
      visits.pop_back();
      if (!visits.empty()) lowest[visits.back().node] = std::min(lowest[visits.back().node], lowest[node]);
      if (lowest[node] != number[node]) continue;
      std::vector<std::uint32_t>& component = components.emplace_back();
      std::uint32_t member;
      do {
        member = open.back();
        open.pop_back();
        is_open[member] = 0;
        component.push_back(member);
      } while (member != node);
      std::sort(component.begin(), component.end());
    }
  }
  return components;
}

OrderedCycle order_cycle(const Points& base, const Viewpoint& from, std::vector<CycleMember> members,
                         const std::vector<HidingPair>& pairs, std::size_t most_cuts) {
  return CycleCutter(base, from, std::move(members), most_cuts).run(pairs);
}

}  // namespace facetsort::exact_internal
