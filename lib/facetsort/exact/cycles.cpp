#include "facetsort/exact/cycles.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/cycle_parts.h"
#include "facetsort/exact/needless_cuts.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::uint32_t none = CycleParts::none;

// What is left to take apart: parts, and what is behind each of them by their places in `parts`. Without lists, parts
// that are in order.
struct Component {
  std::vector<std::uint32_t> parts;
  NodeLists behind;
};

// Where a part is as the eye sees a plane; or how it is to be drawn: with all that is beyond the plane, with all that
// is before it, or cut in two, one half with each.
enum class Place : unsigned char { beyond, before, across, in_plane };

// The facet whose plane is cut along, with the eye's side of it, and the places in the component of what to cut.
struct Cutting {
  FacetId facet = 0;
  int facing = 0;
  std::vector<std::uint32_t> cut;
};

// Decides which parts of a component to cut by the plane of one of them. Everything here is in double: cutting another
// part than would be best is no fault.
class PlaneCuts {
 public:
  // Judged by every `step`-th part, where it is only to be judged.
  PlaneCuts(const CycleParts& parts, const Component& component, const NodeLists& before, std::uint32_t chosen,
            std::uint32_t step = 1)
      : parts_(parts),
        component_(component),
        before_(before),
        facet_(parts[component.parts[chosen]].facet),
        facing_(parts[component.parts[chosen]].facing),
        plane_(parts.plane_towards_eye(facet_, facing_)),
        step_(step) {
    if (step > 1) return;
    const std::uint32_t count = static_cast<std::uint32_t>(component.parts.size());
    places_.reserve(count);
    for (std::uint32_t i = 0; i < count; ++i) places_.push_back(find_place(i));
  }

  // What it costs to take the component apart by this plane: the parts across it, those that have to be cut twice, over
  // what is gained, which is the entropy of the division in two.
  double cost() const {
    double beyond = 0, before = 0, across = 0, cut = 0;
    for (std::uint32_t i = 0; i < component_.parts.size(); i += step_) {
      const Place place = place_of(i);
      beyond += place == Place::beyond;
      before += place == Place::before;
      across += place == Place::across;
      cut += place == Place::across && !may_be_beyond(i) && !may_be_before(i);
    }
    const bool judged_all = step_ == 1;
    if (beyond + before == 0 || (across == 0 && judged_all)) return std::numeric_limits<double>::infinity();
    constexpr double cost_of_plane = 0.5;  // of planes that nothing is across, the one that divides best is chosen
    constexpr double least_gain = 0.3;     // what is cut changes, even where all else is on one side
    const auto times_logarithm = [](double x) { return x > 0 ? x * std::log(x) : 0; };
    const double gain = times_logarithm(beyond + before) - times_logarithm(beyond) - times_logarithm(before);
    return (cost_of_plane + across + cut) / std::max(gain, least_gain);
  }

  // Of the parts across the plane, as few as a greedy search finds to be enough for nothing that is drawn beyond the
  // plane to have to come after something before it.
  Cutting fewest() {
    find_crossing_parts();
    cut_where_sides_conflict();
    Cutting cutting{facet_, facing_, {}};
    for (const CrossingPart& part : crossing_) {
      if (part.drawn == Place::across) cutting.cut.push_back(part.index);
    }
    return cutting;
  }

 private:
  // A part across the plane.
  struct CrossingPart {
    std::uint32_t index;
    RoundedPlane cut;  // through the eye and the line along which the plane cuts it; positive before the plane
    bool may_be_beyond, may_be_before;  // as far as parts that are not across the plane tell
    Place drawn;
  };

  Place place_of(std::uint32_t i) const { return places_.empty() ? find_place(i) : places_[i]; }

  Place find_place(std::uint32_t i) const {
    constexpr double rounding = 0x1p-40;
    const std::uint32_t part = component_.parts[i];
    if (parts_.in_one_plane(parts_[part].facet, facet_)) return Place::in_plane;
    const double error = rounding * (parts_[part].reach + std::abs(plane_.offset));
    bool before = false, beyond = false;
    for (const glm::dvec3& place : parts_.places(part)) {
      const double side = plane_(place);
      before = before || side > error;
      beyond = beyond || side < -error;
    }
    return before && beyond ? Place::across : before ? Place::before : beyond ? Place::beyond : Place::in_plane;
  }

  // Whether nothing behind the part has to be drawn later than what is beyond the plane.
  bool may_be_beyond(std::uint32_t i) const {
    const auto behind = component_.behind[i];
    return std::none_of(behind.begin(), behind.end(), [&](std::uint32_t other) {
      const Place place = place_of(other);
      return place == Place::before || place == Place::in_plane;
    });
  }
  bool may_be_before(std::uint32_t i) const {
    const auto before = before_[i];
    return std::none_of(before.begin(), before.end(), [&](std::uint32_t other) {
      const Place place = place_of(other);
      return place == Place::beyond || place == Place::in_plane;
    });
  }

  void find_crossing_parts() {
    const std::uint32_t count = static_cast<std::uint32_t>(component_.parts.size());
    crossing_of_.assign(count, none);
    for (std::uint32_t i = 0; i < count; ++i) {
      if (place_of(i) != Place::across) continue;
      const bool beyond = may_be_beyond(i), before = may_be_before(i);
      crossing_of_[i] = static_cast<std::uint32_t>(crossing_.size());
      crossing_.push_back({i, line_of_cut(component_.parts[i]), beyond, before,
                           beyond ? Place::beyond : before ? Place::before : Place::across});
    }
  }

  RoundedPlane line_of_cut(std::uint32_t part) const {
    const auto places = parts_.places(part);
    glm::dvec3 ends[2] = {places[0], places[0]}, nearest = places[0];
    int found = 0;
    for (std::size_t i = 0, last = places.size() - 1; i < places.size(); last = i++) {
      const double side = plane_(places[i]), last_side = plane_(places[last]);
      if (side > plane_(nearest)) nearest = places[i];
      if ((side < 0) == (last_side < 0) || found == 2) continue;
      ends[found++] = places[i] + (side / (side - last_side)) * (places[last] - places[i]);
    }
    const RoundedPlane line = parts_.plane_through_eye(ends[0], ends[1]);
    return line(nearest) < 0 ? -line : line;
  }

  bool half_reaches(const CrossingPart& part, Place half, const CrossingPart& other) const {
    const auto places = parts_.places(component_.parts[other.index]);
    return std::any_of(places.begin(), places.end(), [&](const glm::dvec3& place) {
      return (part.cut(place) > 0) == (half == Place::before);
    });
  }

  // Whether `part`, which is behind `other`, would come later if they were drawn so.
  bool conflict(const CrossingPart& part, Place drawn, const CrossingPart& other, Place other_drawn) const {
    if (drawn == Place::beyond || other_drawn == Place::before) return false;
    if (drawn == Place::across && other_drawn == Place::across) return false;
    if (drawn == Place::across) return half_reaches(part, Place::before, other);
    if (other_drawn == Place::across) return half_reaches(other, Place::beyond, part);
    return true;
  }

  // With other parts across the plane, if this one is drawn so.
  std::size_t count_conflicts(const CrossingPart& part, Place drawn) const {
    std::size_t conflicts = 0;
    for (const std::uint32_t i : component_.behind[part.index]) {
      if (crossing_of_[i] == none) continue;
      const CrossingPart& other = crossing_[crossing_of_[i]];
      conflicts += conflict(other, other.drawn, part, drawn);
    }
    for (const std::uint32_t i : before_[part.index]) {
      if (crossing_of_[i] == none) continue;
      const CrossingPart& other = crossing_[crossing_of_[i]];
      conflicts += conflict(part, drawn, other, other.drawn);
    }
    return conflicts;
  }

  // Cuts parts until there is no conflict, always the one that has most.
  void cut_where_sides_conflict() {
    // Conflicts, as many as there were when the part was added, and its place in crossing_.
    std::vector<std::pair<std::size_t, std::uint32_t>> heap;
    const auto add = [&](std::uint32_t i) {
      const std::size_t conflicts = count_conflicts(crossing_[i], crossing_[i].drawn);
      if (conflicts == 0) return;
      heap.push_back({conflicts, i});
      std::push_heap(heap.begin(), heap.end());
    };
    for (std::uint32_t i = 0; i < crossing_.size(); ++i) {
      if (crossing_[i].drawn != Place::across) add(i);
    }
    while (!heap.empty()) {
      std::pop_heap(heap.begin(), heap.end());
      const auto [conflicts, i] = heap.back();
      heap.pop_back();
      CrossingPart& part = crossing_[i];
      if (part.drawn == Place::across) continue;
      if (count_conflicts(part, part.drawn) < conflicts) {
        add(i);
        continue;
      }
      part.drawn = Place::across;
      for (const auto& others : {component_.behind[part.index], before_[part.index]}) {
        for (const std::uint32_t other : others) {
          if (crossing_of_[other] != none && crossing_[crossing_of_[other]].drawn != Place::across) {
            add(crossing_of_[other]);
          }
        }
      }
    }
  }

  const CycleParts& parts_;
  const Component& component_;
  const NodeLists& before_;
  const FacetId facet_;
  const int facing_;
  const RoundedPlane plane_;
  const std::uint32_t step_;
  std::vector<Place> places_;               // by place in the component; empty where some are judged only
  std::vector<CrossingPart> crossing_;
  std::vector<std::uint32_t> crossing_of_;  // by place in the component
};

class CycleCutter {
 public:
  CycleCutter(const Points& base, const Viewpoint& from, const std::vector<CycleMember>& members,
              std::size_t most_cuts)
      : members_(members.size()),
        most_cuts_(most_cuts),
        parts_(base, from,
               from.eye.w != 0 ? glm::dvec3(from.eye) : base.position(members.front().corners.front().point)) {
    for (const CycleMember& member : members) {
      parts_.add_member(member.facet, member.facing, member.corners, member.cuts);
    }
  }

  OrderedCycle run(const std::vector<HidingPair>& pairs) {
    separated_.reserve(pairs.size() + pairs.size() / 4);
    // More than half of the cuts often turn out needless.
    constexpr std::size_t cuts_for_one_needed = 4;
    constexpr std::size_t no_limit = std::numeric_limits<std::size_t>::max() / cuts_for_one_needed;
    const std::size_t most_made = cuts_for_one_needed * std::min(most_cuts_, no_limit);
    order_components(all_of(pairs));
    while (!left_.empty() && cuts_ <= most_made && !contradiction_) {
      const Component component = std::move(left_.back());
      left_.pop_back();
      if (component.behind.begin.empty()) {
        order_.insert(order_.end(), component.parts.begin(), component.parts.end());
      } else if (!cut_one(component)) {
        cut(component);
      }
    }
    if (cuts_ > most_made || contradiction_) return {parts_.take_points(), {}, {}, cuts_, true};
    order_ = undo_needless_cuts(parts_, separated_, order_);
    // Every cut has made one part more.
    cuts_ = order_.size() - members_;
    if (cuts_ > most_cuts_) return {parts_.take_points(), {}, {}, cuts_, true};
    return result();
  }

 private:
  Component all_of(const std::vector<HidingPair>& pairs) const {
    Component all{{}, list_behind(parts_.count(), pairs)};
    for (std::uint32_t part = 0; part < parts_.count(); ++part) all.parts.push_back(part);
    return all;
  }

  // Breaks a small component by a single cut of one part along the plane of another, where that is enough.
  bool cut_one(const Component& component) {
    constexpr std::size_t most_parts = 16;
    const std::uint32_t count = static_cast<std::uint32_t>(component.parts.size());
    if (count > most_parts) return false;
    std::vector<std::uint32_t> behind(count), before(count);  // bits
    for (std::uint32_t i = 0; i < count; ++i) {
      for (const std::uint32_t other : component.behind[i]) {
        behind[i] |= 1u << other;
        before[other] |= 1u << i;
      }
    }
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t part = component.parts[i];
      for (const std::uint32_t by : component.parts) {
        const FacetId facet = parts_[by].facet;
        if (parts_.in_one_plane(facet, parts_[part].facet) || !parts_.halve(part, facet, parts_[by].facing)) continue;
        // The half beyond takes the part's bit, the other the bit after all.
        std::vector<std::uint32_t> left = behind;
        left[i] = 0;
        left.push_back(0);
        for (std::uint32_t others = behind[i] | before[i]; others != 0; others &= others - 1) {
          const std::uint32_t other = static_cast<std::uint32_t>(std::countr_zero(others));
          const std::uint32_t halves = parts_.overlapping_halves(part, component.parts[other]);
          if ((behind[i] >> other & 1) != 0) {
            left[i] |= (halves & 1) << other;
            left[count] |= (halves >> 1) << other;
          } else {
            left[other] = (left[other] & ~(1u << i)) | (halves & 1) << i | (halves >> 1) << count;
          }
        }
        parts_.undo_halve(part);
        if (has_order(left)) return split(component, {facet, parts_[by].facing, {i}});
      }
    }
    return false;
  }

  // Whether parts can be drawn one after the other, each after those behind it, which are given as bits.
  static bool has_order(const std::vector<std::uint32_t>& behind) {
    std::uint32_t left = (2u << (behind.size() - 1)) - 1;
    for (bool drew = true; drew && left != 0;) {
      drew = false;
      for (std::uint32_t i = 0; i < behind.size(); ++i) {
        if ((left >> i & 1) == 0 || (behind[i] & left) != 0) continue;
        left &= ~(1u << i);
        drew = true;
      }
    }
    return left == 0;
  }

  // Takes a component apart by the plane of one of its parts.
  void cut(const Component& component) {
    constexpr std::size_t most_tried = 48, judged_in_full = 1024, most_judged = 1024, parts_to_share_work = 512;
    const std::uint32_t count = static_cast<std::uint32_t>(component.parts.size());
    const NodeLists before = reversed(component.behind);
    const std::uint32_t tried_step = static_cast<std::uint32_t>((count + most_tried - 1) / most_tried);
    const std::uint32_t judged_step =
        count <= judged_in_full ? 1 : static_cast<std::uint32_t>((count + most_judged - 1) / most_judged);
    std::vector<double> costs((count + tried_step - 1) / tried_step);
    const auto judge = [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t chosen = static_cast<std::uint32_t>(i) * tried_step;
        costs[i] = PlaneCuts(parts_, component, before, chosen, judged_step).cost();
      }
    };
    if (count < parts_to_share_work) {
      judge(0, costs.size());
    } else {
      // Isolated, so that a thread that waits takes up no other cycle meanwhile.
      tbb::this_task_arena::isolate([&] { parallel_ranges(costs.size(), 1, judge); });
    }
    const auto best = static_cast<std::uint32_t>(std::min_element(costs.begin(), costs.end()) - costs.begin());
    if (split(component, PlaneCuts(parts_, component, before, best * tried_step).fewest())) return;
    // In a cycle of parts that do not cross, the plane of each part cuts some other, or else the part would come first
    // or last: this ends with the first plane.
    for (const std::uint32_t by : component.parts) {
      Cutting cutting{parts_[by].facet, parts_[by].facing, {}};
      for (std::uint32_t i = 0; i < count; ++i) {
        if (!parts_.in_one_plane(parts_[component.parts[i]].facet, parts_[by].facet)) cutting.cut.push_back(i);
      }
      if (split(component, cutting)) return;
    }
    contradiction_ = true;
  }

  // Cuts, and brings what there is then in order. Returns false where the plane parts none of what is to be cut.
  bool split(const Component& component, const Cutting& cutting) {
    const std::uint32_t count = static_cast<std::uint32_t>(component.parts.size());
    bool any = false;
    for (const std::uint32_t i : cutting.cut) {
      if (!parts_.halve(component.parts[i], cutting.facet, cutting.facing)) continue;
      ++cuts_;
      any = true;
    }
    if (!any) return false;
    Component parted;
    std::vector<std::uint32_t> place;  // of the half beyond the cut, the other follows
    place.reserve(count + 1);
    for (const std::uint32_t part : component.parts) {
      place.push_back(static_cast<std::uint32_t>(parted.parts.size()));
      const std::uint32_t half = parts_[part].first_half;
      if (half == none) {
        parted.parts.push_back(part);
      } else {
        parted.parts.insert(parted.parts.end(), {half, half + 1});
      }
    }
    place.push_back(static_cast<std::uint32_t>(parted.parts.size()));
    parted.behind = lists_of_halves(component, parted.parts, place);
    order_components(parted);
    return true;
  }

  // What is behind each of `parted`, which are the parts of a component or their halves.
  NodeLists lists_of_halves(const Component& component, const std::vector<std::uint32_t>& parted,
                            const std::vector<std::uint32_t>& place) const {
    const auto is_cut = [&](std::uint32_t i) { return place[i + 1] - place[i] == 2; };
    NodeLists behind;
    behind.begin.reserve(parted.size() + 1);
    behind.values.reserve(component.behind.values.size() + component.behind.values.size() / 8);
    behind.begin.push_back(0);
    const auto add = [&](std::uint32_t part, std::uint32_t other, std::vector<std::uint32_t>& list) {
      const int halves = is_cut(other) ? parts_.overlapping_halves(component.parts[other], part) : 1;
      if ((halves & 1) != 0) list.push_back(place[other]);
      if ((halves & 2) != 0) list.push_back(place[other] + 1);
    };
    std::vector<std::uint32_t> behind_second;
    for (std::uint32_t i = 0; i < component.parts.size(); ++i) {
      if (!is_cut(i)) {
        for (const std::uint32_t other : component.behind[i]) add(component.parts[i], other, behind.values);
      } else {
        behind_second.clear();
        for (const std::uint32_t other : component.behind[i]) {
          const int halves = parts_.overlapping_halves(component.parts[i], component.parts[other]);
          if ((halves & 1) != 0) add(parted[place[i]], other, behind.values);
          if ((halves & 2) != 0) add(parted[place[i] + 1], other, behind_second);
        }
        behind.begin.push_back(static_cast<std::uint32_t>(behind.values.size()));
        behind.values.insert(behind.values.end(), behind_second.begin(), behind_second.end());
      }
      behind.begin.push_back(static_cast<std::uint32_t>(behind.values.size()));
    }
    return behind;
  }

  // Adds the components of some parts to what is left to do, the first of them last.
  void order_components(const Component& all) {
    const NodeLists& components = component_finder_.find(all.behind);
    std::vector<std::uint32_t> position(all.parts.size());  // in the order
    for (std::uint32_t i = 0; i < position.size(); ++i) position[components.values[i]] = i;
    for (std::size_t end = components.count(); end > 0;) {
      // Those of one part each are in order together.
      std::size_t begin = end - 1;
      const bool single = components[begin].size() == 1;
      while (single && begin > 0 && components[begin - 1].size() == 1) --begin;
      const std::uint32_t first = components.begin[begin], last = components.begin[end];
      end = begin;
      Component& component = left_.emplace_back();
      component.parts.reserve(last - first);
      if (!single) {
        component.behind.begin.reserve(last - first + 1);
        component.behind.begin.push_back(0);
      }
      for (std::uint32_t k = first; k < last; ++k) {
        const std::uint32_t i = components.values[k];
        component.parts.push_back(all.parts[i]);
        for (const std::uint32_t other : all.behind[i]) {
          if (single || position[other] < first || position[other] >= last) {
            separated_.push_back({all.parts[other], all.parts[i]});
          } else {
            component.behind.values.push_back(position[other] - first);
          }
        }
        if (!single) component.behind.begin.push_back(static_cast<std::uint32_t>(component.behind.values.size()));
      }
    }
  }

  OrderedCycle result() {
    OrderedCycle result{parts_.take_points(), {}, {}, cuts_, false};
    for (const std::uint32_t part : order_) {
      if (parts_[part].parent == none) {
        result.order.push_back({part, true, 0});
        continue;
      }
      const std::uint32_t piece = static_cast<std::uint32_t>(result.pieces.parts.size());
      result.order.push_back({parts_[part].member, false, piece});
      result.pieces.add(parts_[part].facet, parts_.corners(part), parts_.cuts(part));
    }
    return result;
  }

  const std::size_t members_, most_cuts_;
  CycleParts parts_;
  ComponentFinder component_finder_;
  std::size_t cuts_ = 0;
  bool contradiction_ = false;
  std::vector<Component> left_;        // the next last
  std::vector<HidingPair> separated_;  // parts that hide each other, and are in one component no longer
  std::vector<std::uint32_t> order_;   // back to front
};

}  // namespace

OrderedCycle order_cycle(const Points& base, const Viewpoint& from, const std::vector<CycleMember>& members,
                         const std::vector<HidingPair>& pairs, std::size_t most_cuts) {
  return CycleCutter(base, from, members, most_cuts).run(pairs);
}

}  // namespace facetsort::exact_internal
