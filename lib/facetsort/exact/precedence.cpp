#include "facetsort/exact/precedence.h"

#include <tbb/parallel_for.h>

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

// Takes over what the threads found.
void Precedence::gather() {
  for (Worker& worker : workers_) {
    edges_.insert(edges_.end(), worker.edges.begin(), worker.edges.end());
    worker.edges.clear();
    candidate_pairs_ += std::exchange(worker.candidates, 0);
    fallbacks_ += std::exchange(worker.fallbacks, 0);
  }
}

void Precedence::find_broken(const Relation& relation, const Screen& screen, const Elements& elements) {
  const Screenful screenful = screen.screenful(elements);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, screen.leaves(), leaves_per_task),
                    [&](const tbb::blocked_range<std::size_t>& range) {
    Worker& worker = workers_.local();
    const unsigned long long fallbacks = exact_fallbacks();
    for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
      worker.pairs.clear();
      worker.candidates += collect_pairs(screenful, leaf, worker.pairs);
      for (const ElementPair& pair : worker.pairs) {
        const std::uint32_t a = rank_of_[pair.a], b = rank_of_[pair.b];
        if (relation.is_behind(pair, b < a)) worker.edges.push_back({std::min(a, b), std::max(a, b)});
      }
    }
    worker.fallbacks += exact_fallbacks() - fallbacks;
  });
  gather();
  broken_ = edges_.size();
}

// Lists the edges from `first_edge` on.
void Precedence::take_in(std::size_t first_edge) {
  next_.resize(edges_.size());
  for (std::size_t i = first_edge; i < edges_.size(); ++i) {
    next_[i] = std::exchange(first_[edges_[i].before], static_cast<std::uint32_t>(i));
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
      const std::uint32_t behind = edges_[i].behind;
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
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pulled_.size(), searches_per_task),
                    [&](const tbb::blocked_range<std::size_t>& range) {
    Worker& worker = workers_.local();
    const unsigned long long fallbacks = exact_fallbacks();
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const std::uint32_t rank = pulled_[i], element = element_at_[rank];
      const PassedRanks passed{place_[rank], rank, searched_[rank], place_, rank_of_};
      worker.pairs.clear();
      ScreenBox box = screen.box(element);
      box.lowest[of_key] = screen.key(element);
      box.highest[of_key] = screen.key(element_at_[passed.begin]);
      collect_passed(screenful, element, box, passed, worker.pairs);
      for (const ElementPair& pair : worker.pairs) {
        if (relation.is_behind(pair, false)) worker.edges.push_back({rank, rank_of_[pair.b]});
      }
      searched_[rank] = place_[rank];
    }
    worker.fallbacks += exact_fallbacks() - fallbacks;
  });
  searches_ += pulled_.size();
  gather();
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
      if (place_[edges_[i].behind] > place_[edges_[i].before]) stack_.push_back(edges_[i].before);
    }
  }
}

void Precedence::group_edges() {
  const std::size_t count = element_at_.size();
  begin_.assign(count + 1, 0);
  behind_.resize(edges_.size());
  if (edges_.empty()) return;
  for (const Edge& edge : edges_) ++begin_[edge.before + 1];
  for (std::size_t rank = 0; rank < count; ++rank) begin_[rank + 1] += begin_[rank];
  for (const Edge& edge : edges_) behind_[begin_[edge.before]++] = edge.behind;
  for (std::size_t rank = count; rank > 0; --rank) begin_[rank] = begin_[rank - 1];
  begin_[0] = 0;
  parallel_ranges(count, ranks_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t rank = first; rank < last; ++rank) {
      std::sort(behind_.begin() + begin_[rank], behind_.begin() + begin_[rank + 1]);
    }
  });
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
  group_edges();
}

std::size_t Precedence::memory_bytes() const {
  return bytes_of(element_at_, rank_of_, edges_, first_, next_, place_, searched_, pulled_, stack_, begin_, behind_);
}

}  // namespace facetsort::exact_internal
