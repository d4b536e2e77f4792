// Internal to exact: putting the halves of a part together where they lie apart in an order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/exact/elements.h"
#include "facetsort/exact/relation.h"
#include "facetsort/exact/row.h"
#include "facetsort/exact/screen.h"

namespace facetsort::exact_internal {

struct RejoiningCounts {
  std::size_t rejoined = 0, tried = 0;
  std::size_t candidate_pairs = 0;  // that the filters left to be decided
  unsigned long long fallbacks = 0;
};

// What one thread counts and works in.
struct RejoiningScratch {
  RejoiningCounts counts;
  std::vector<Candidate> candidates;
  std::vector<std::uint32_t> moved;
};

// In a row of elements none of which hides one that comes later, one half of a part can go to where the other is, past
// all that is between them but what it hides or is hidden by; that has to go with it, and so on, unless it comes upon
// the other half. (As in keeping a topological order of a graph that gets a new edge: Pearce and Kelly 2006, "A Dynamic
// Topological Sort Algorithm for Directed Acyclic Graphs".)
class Rejoining {
 public:
  // `moving`: of all elements, none; left so. Threads that share it and the row have to work on different elements.
  Rejoining(const Relation& relation, const Screen& screen, const Elements& elements, Row& row,
            std::vector<unsigned char>& moving, RejoiningScratch& scratch)
      : relation_(relation),
        screen_(screen),
        outlines_(screen.outlines(elements)),
        row_(row),
        moving_(moving),
        scratch_(scratch) {}

  // Puts `whole` into the row in place of its halves, where that can be. Does nothing where it can't, where too much
  // would have to move, or where a half is not in the row.
  bool rejoin(std::uint32_t whole, std::uint32_t first, std::uint32_t second);

 private:
  // The first half goes later, to the second, or the second earlier, to the first.
  enum class Way { later, earlier };

  bool can_move(Way way, std::uint32_t half, std::uint32_t target, std::size_t most_moved);
  bool take_along(Way way, std::uint32_t element, std::uint32_t target, std::size_t most_moved);
  bool take_if_passed(std::uint32_t element, const Candidate& other, std::uint32_t target, std::size_t most_moved);
  bool take_in_place(std::uint32_t element, std::uint32_t from, std::uint32_t to, std::uint32_t target,
                     std::size_t most_moved);
  void move(Way way, std::uint32_t whole, std::uint32_t target);

  const Relation& relation_;
  const Screen& screen_;
  const Outlines outlines_;
  Row& row_;
  std::vector<unsigned char>& moving_;
  RejoiningScratch& scratch_;
};

}  // namespace facetsort::exact_internal
