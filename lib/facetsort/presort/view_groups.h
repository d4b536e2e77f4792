// Groups of views that one order can serve. Internal to presort.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/presort/facet_pairs.h"

namespace facetsort::presort_internal {

// What some views see: their pairs, and the direction from the mesh's centre to each eye.
struct SeenViews {
  std::vector<glm::vec3> directions;  // unit
  std::vector<std::vector<SeenPair>> pairs;
  std::size_t pair_count;  // of all that there are

  std::size_t count() const { return directions.size(); }
};

// By how much area more the second of a pair is behind.
struct Vote {
  std::uint32_t pair;
  std::int64_t area;
};
using Votes = std::vector<Vote>;  // ascending by pair

// Finds groups of views such that little area is asked for both ways round within one: of that one half or the other is
// drawn wrongly, whatever the order; nearly all else can be drawn rightly.
class ViewGrouper {
 public:
  explicit ViewGrouper(const SeenViews& views);

  // The group of each view, 0 to count - 1; some may have none. Parallel in the caller's task arena.
  std::vector<std::uint32_t> groups(std::size_t count) const;

 private:
  struct Join {
    std::uint32_t kept, gone;
  };
  void join_cells(std::vector<Votes> votes);
  std::vector<std::uint32_t> joined_groups(std::size_t count) const;

  SeenViews views_;                     // with the pairs that may be asked for both ways round, numbered anew
  SeenViews cells_;                     // what neighbouring views see together
  std::vector<std::uint32_t> cell_of_;  // of each view
  std::vector<Join> joins_;             // of cells
};

// For each pair, by how much area more the views of a group ask for the second to be behind.
std::vector<std::int64_t> group_votes(const SeenViews& views, std::span<const std::uint32_t> groups,
                                      std::uint32_t group);

}  // namespace facetsort::presort_internal
