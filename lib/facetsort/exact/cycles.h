// Internal to exact: parts that hide each other in cycles, cut until they do not.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/exact/hiding_graph.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/visibility.h"

namespace facetsort::exact_internal {

// A part in a cycle.
struct CycleMember {
  FacetId facet;
  int facing;
  std::vector<PartCorner> corners;
  std::vector<Cut> cuts;
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
  // There is no order: more cuts would be needed than are allowed, or members cross, and what they hide contradicts.
  bool gave_up = false;
};

// Orders the members of a cycle, cutting some: in a small cycle one, where that is enough. Otherwise the plane of a
// member takes it apart, as in a BSP (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree
// Structures"). But of the members that the plane parts only those are cut that can be drawn whole neither with what is
// beyond the plane nor with what is before it; and what is left is taken apart into components again, so that only
// cycles are ever cut. In the end, cuts that others have made needless are undone. `members` come farthest first;
// `pairs` are all that hide each other. Parallel in the caller's task arena; the same for any thread count.
OrderedCycle order_cycle(const Points& base, const Viewpoint& from, const std::vector<CycleMember>& members,
                         const std::vector<HidingPair>& pairs, std::size_t most_cuts);

}  // namespace facetsort::exact_internal
