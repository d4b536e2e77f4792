// An order of facets that breaks as few wishes as can be found. Internal to presort.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace facetsort::presort_internal {

// A facet should be drawn before another; it costs so much where it is not.
struct Wish {
  std::uint32_t first, then;
  std::int64_t weight;
};

// Changes `order`, a permutation of facet ids, so that what it costs is little. `wishes`: each pair of facets at most
// once.
void mend_order(std::span<const Wish> wishes, std::vector<std::uint32_t>& order);

}  // namespace facetsort::presort_internal
