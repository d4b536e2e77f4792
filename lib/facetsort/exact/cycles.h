// Internal to exact: parts that hide each other in cycles, cut until they do not.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/visibility.h"

namespace facetsort::exact_internal {

// Strongly connected components of a graph with edges from what is behind to what is in front, in an order in which no
// edge leads from a later component to an earlier one (Tarjan 1972, "Depth-First Search and Linear Graph Algorithms").
// Deterministic: among what may come next, the smallest index first. `behind[i]` are the nodes behind node i.
std::vector<std::vector<std::uint32_t>> ordered_components(std::span<const std::vector<std::uint32_t>> behind);

// A part in a cycle.
struct CycleMember {
  FacetId facet;
  int facing;
  std::vector<PartCorner> corners;
  std::vector<Cut> cuts;
};

// `first` is behind `second`.
struct HidingPair {
  std::uint32_t first, second;
};

struct OrderedPart {
  std::uint32_t member;  // the member that this is, or is a piece of
  bool is_whole;
  std::uint32_t piece;   // in OrderedCycle::pieces, where it is no whole member
};

struct OrderedCycle {
  Points points;               // those that the cuts made, after those of the mesh
  PartList pieces;
  std::vector<OrderedPart> order;  // back to front
  std::size_t cuts = 0;
  bool gave_up = false;  // more cuts are needed than are allowed: there is no order
};

// Orders the members of a cycle, cutting some: in a small cycle one, where that is enough; otherwise by a BSP of the
// members' own planes (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree Structures"), but
// the plane is the one that cuts the fewest, and what it leaves on either side is taken apart into components again, so
// that only cycles are ever cut. `members` come farthest first, `pairs` are all that hide each other.
OrderedCycle order_cycle(const Points& base, const Viewpoint& from, std::vector<CycleMember> members,
                         const std::vector<HidingPair>& pairs, std::size_t most_cuts);

}  // namespace facetsort::exact_internal
