// Internal to exact: cuts of a cycle that other cuts have made needless.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/exact/cycle_parts.h"
#include "facetsort/exact/hiding_graph.h"

namespace facetsort::exact_internal {

// `order` has the members of a cycle or what they were cut into, back to front; `pairs` are all of these that hide each
// other, or else the parts that they are halves of. Puts halves together again where nothing has to come between them,
// which moves others in the order (as in Pearce and Kelly 2006, "A Dynamic Topological Sort Algorithm for Directed
// Acyclic Graphs"), and returns the new order.
std::vector<std::uint32_t> undo_needless_cuts(const CycleParts& parts, std::span<const HidingPair> pairs,
                                              const std::vector<std::uint32_t>& order);

}  // namespace facetsort::exact_internal
