// Internal to exact: the order by depth of a view, and what must be drawn earlier than it says.
//
// Of the constraints, those are found first that the order by depth breaks: a part is behind one that comes before it.
// Such a part is pulled ahead of its turn, to the place of what it is behind. It may have to come after parts that are
// deeper still, with which it was in order until then: those are searched for among the parts whose turn lies between,
// and are pulled along. How far each part is pulled is found in rounds, in each of which all searches are independent.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/exact/hiding_graph.h"
#include "facetsort/exact/relation.h"

namespace facetsort::exact_internal {

class Precedence {
 public:
  // `ids` are the draw ids in the order by depth. Parallel in the caller's task arena; the same for any thread count.
  // Keeps its storage.
  void find(const Relation& relation, const Screen& screen, const Elements& elements,
            std::span<const std::uint32_t> ids);

  // Elements in the order by depth: rank 0 is the farthest.
  std::span<const std::uint32_t> element_at() const { return element_at_; }
  // By rank, the ranks of what is behind and has to be drawn before, ascending; those left out come earlier in any
  // case.
  const NodeLists& behind() const { return behind_; }

  std::size_t candidate_pairs() const { return candidate_pairs_; }
  std::size_t broken() const { return broken_; }
  std::size_t searches() const { return searches_; }
  unsigned long long fallbacks() const { return fallbacks_; }
  std::size_t memory_bytes() const;

 private:
  // What one thread finds, and its scratch.
  struct Worker {
    std::vector<HidingPair> edges;
    std::size_t candidates = 0;
    unsigned long long fallbacks = 0;
    std::vector<ElementPair> pairs;
  };

  void find_broken(const Relation& relation, const Screen& screen, const Elements& elements);
  void take_in(std::size_t first_edge);
  void pull();
  void search(const Relation& relation, const Screen& screen, const Elements& elements);
  void pull_to_places(const Relation& relation, const Screen& screen, const Elements& elements, std::size_t begin,
                      std::size_t end);
  template <typename Body>
  void work(std::size_t count, std::size_t count_per_task, const Body& body);

  tbb::enumerable_thread_specific<Worker> workers_;
  std::vector<std::uint32_t> element_at_, rank_of_;
  std::vector<HidingPair> edges_;              // by rank: the first has to be drawn before the second
  std::vector<std::uint32_t> first_, next_;    // lists of edges by their second: by rank, by edge
  std::vector<std::uint32_t> place_;           // by rank: the rank that the element is pulled to, or its own
  std::vector<std::uint32_t> searched_;        // by rank: the smallest that was searched from
  std::vector<std::uint32_t> pulled_, stack_;  // in the round at hand
  NodeLists behind_;
  std::size_t candidate_pairs_ = 0, broken_ = 0, searches_ = 0;
  unsigned long long fallbacks_ = 0;
};

}  // namespace facetsort::exact_internal
