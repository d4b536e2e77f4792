#include "facetsort/exact/precedence.h"

#include <algorithm>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t leaves_per_task = 64;
constexpr std::size_t searches_per_task = 64;
constexpr std::size_t ranks_per_task = 4096;
constexpr std::uint32_t none = 0xffffffffu;

// In few batches too much is looked at that is pulled farther in the end; in many, the rounds get short.
constexpr std::size_t batches = 64;

}  // namespace

// Calls body(worker, i) for all i below `count`, on all threads, and takes over what they find.
template <typename Body>
void Precedence::work(std::size_t count, std::size_t count_per_task, const Body& body) {
  parallel_ranges(count, count_per_task, [&](std::size_t begin, std::size_t end) {
    Worker& worker = workers_.local();
    const unsigned long long fallbacks = exact_fallbacks();
    for (std::size_t i = begin; i < end; ++i) body(worker, i);
    worker.fallbacks += exact_fallbacks() - fallbacks;
  });
  for (Worker& worker : workers_) {
    edges_.insert(edges_.end(), worker.edges.begin(), worker.edges.end());
    worker.edges.clear();
    candidate_pairs_ += std::exchange(worker.candidates, 0);
    fallbacks_ += std::exchange(worker.fallbacks, 0);
  }
}

void Precedence::find_broken(const Relation& relation, const Screen& screen, const Elements& elements) {
  const Screenful screenful = screen.screenful(elements);
  work(screen.leaves(), leaves_per_task, [&](Worker& worker, std::size_t leaf) {
    worker.pairs.clear();
    worker.candidates += collect_pairs(screenful, leaf, worker.pairs);
    for (const ElementPair& pair : worker.pairs) {
      const std::uint32_t a = rank_of_[pair.a], b = rank_of_[pair.b];
      if (relation.is_behind(pair, b < a)) worker.edges.push_back({std::max(a, b), std::min(a, b)});
    }
  });
  broken_ = edges_.size();
}

// Lists the edges from `first_edge` on.
void Precedence::take_in(std::size_t first_edge) {
  next_.resize(edges_.size());
  for (std::size_t i = first_edge; i < edges_.size(); ++i) {
    next_[i] = std::exchange(first_[edges_[i].second], static_cast<std::uint32_t>(i));
  }
}

// Pulls what is behind those in stack_ to their places, and so on.
void Precedence::pull() {
  // From the farthest place on, so that none is pulled twice.
  std::sort(stack_.begin(), stack_.end(), [&](std::uint32_t a, std::uint32_t b) {
    return place_[a] > place_[b] || (place_[a] == place_[b] && a > b);
  });
  stack_.erase(std::unique(stack_.begin(), stack_.end()), stack_.end());
  pulled_.clear();
  while (!stack_.empty()) {
    const std::uint32_t before = stack_.back();
    stack_.pop_back();
    for (std::uint32_t i = first_[before]; i != none; i = next_[i]) {
      const std::uint32_t behind = edges_[i].first;
      if (place_[behind] <= place_[before]) continue;
      place_[behind] = place_[before];
      pulled_.push_back(behind);
      stack_.push_back(behind);
    }
  }
  std::sort(pulled_.begin(), pulled_.end());
  pulled_.erase(std::unique(pulled_.begin(), pulled_.end()), pulled_.end());
}

// Finds what is behind those that were pulled, among what they were pulled past.
void Precedence::search(const Relation& relation, const Screen& screen, const Elements& elements) {
  const Screenful screenful = screen.screenful(elements);
  work(pulled_.size(), searches_per_task, [&](Worker& worker, std::size_t i) {
    const std::uint32_t rank = pulled_[i], element = element_at_[rank];
    const PassedRanks passed{place_[rank], rank, searched_[rank], place_, rank_of_};
    ScreenBox box = screen.box(element);
    box.lowest[of_key] = screen.key(element);
    box.highest[of_key] = screen.key(element_at_[passed.begin]);
    worker.pairs.clear();
    collect_passed(screenful, element, box, passed, worker.pairs);
    for (const ElementPair& pair : worker.pairs) {
      if (relation.is_behind(pair, false)) worker.edges.push_back({rank_of_[pair.b], rank});
    }
    searched_[rank] = place_[rank];
  });
  searches_ += pulled_.size();
}

// All that is pulled to the places from `begin` to `end`; what is pulled to those before is known.
void Precedence::pull_to_places(const Relation& relation, const Screen& screen, const Elements& elements,
                                std::size_t begin, std::size_t end) {
  stack_.clear();
  for (std::size_t rank = begin; rank < end; ++rank) {
    if (place_[rank] == rank && first_[rank] != none) stack_.push_back(static_cast<std::uint32_t>(rank));
  }
  while (!stack_.empty()) {
    pull();
    const std::size_t taken = edges_.size();
    search(relation, screen, elements);
    take_in(taken);
    for (std::size_t i = taken; i < edges_.size(); ++i) {
      if (place_[edges_[i].first] > place_[edges_[i].second]) stack_.push_back(edges_[i].second);
    }
  }
}

void Precedence::find(const Relation& relation, const Screen& screen, const Elements& elements,
                      std::span<const std::uint32_t> ids) {
  const std::size_t count = elements.count();
  element_at_.clear();
  rank_of_.resize(count);
  for (const std::uint32_t id : ids) {
    const std::uint32_t element = elements.element_of_draw_id[id];
    if (element == no_element) continue;
    rank_of_[element] = static_cast<std::uint32_t>(element_at_.size());
    element_at_.push_back(element);
  }
  edges_.clear();
  candidate_pairs_ = searches_ = 0;
  fallbacks_ = 0;
  find_broken(relation, screen, elements);
  if (!edges_.empty()) {
    place_.resize(count);
    for (std::uint32_t rank = 0; rank < count; ++rank) place_[rank] = rank;
    searched_ = place_;
    first_.assign(count, none);
    take_in(0);
    const std::size_t batch = count / batches + 1;
    for (std::size_t begin = 0; begin < count; begin += batch) {
      pull_to_places(relation, screen, elements, begin, std::min(begin + batch, count));
    }
  }
  list_behind(count, edges_, behind_);
  parallel_ranges(count, ranks_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t rank = first; rank < last; ++rank) {
      std::sort(behind_.values.begin() + behind_.begin[rank], behind_.values.begin() + behind_.begin[rank + 1]);
    }
  });
}

std::size_t Precedence::memory_bytes() const {
  return behind_.memory_bytes() +
         bytes_of(element_at_, rank_of_, edges_, first_, next_, place_, searched_, pulled_, stack_);
}

}  // namespace facetsort::exact_internal
