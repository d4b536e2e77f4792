#include "facetsort/check/verdict.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

// A fragment that the order draws. Its true depth lies in [lowest, highest].
struct DrawnFragment {
  double depth, lowest, highest;
  std::uint32_t rank, facet;
};

DrawnFragment drawn_fragment(const Fragment& fragment, std::uint32_t rank) {
  DrawnFragment drawn{fragment.depth, fragment.depth, fragment.depth, rank, fragment.facet};
  const double error = static_cast<double>(fragment.depth_error);
  if (error > 0) {  // rounded outwards: the interval must hold the true depth
    drawn.lowest = std::nextafter(fragment.depth - error, -infinity);
    drawn.highest = std::nextafter(fragment.depth + error, infinity);
  }
  return drawn;
}

bool is_beyond(const DrawnFragment& far, const DrawnFragment& near, double gap) {
  return far.depth - near.depth > gap && far.lowest > near.highest;
}

// How many of the ranks inserted so far are above a given one, in O(log n), for ranks 0 to n - 1 (Fenwick 1994, "A New
// Data Structure for Cumulative Frequency Tables").
class RankCounter {
 public:
  void reset(std::size_t ranks) {
    sums_.assign(ranks + 1, 0);
    inserted_ = 0;
  }
  void insert(std::uint32_t rank) {
    for (std::size_t i = std::size_t{rank} + 1; i < sums_.size(); i += i & (~i + 1)) ++sums_[i];
    ++inserted_;
  }
  std::size_t count_above(std::uint32_t rank) const {
    std::size_t not_above = 0;
    for (std::size_t i = std::size_t{rank} + 1; i > 0; i &= i - 1) not_above += sums_[i];
    return inserted_ - not_above;
  }

 private:
  std::vector<std::uint32_t> sums_;
  std::size_t inserted_ = 0;
};

// Judges one pixel after the other, keeping its scratch.
class PixelJudge {
 public:
  explicit PixelJudge(double gap) : gap_(gap) {}

  // rank_of(i) is the rank of pixel[i].
  template <typename RankOf>
  void judge(std::span<const Fragment> pixel, const RankOf& rank_of, std::size_t pixel_index, Verdict& verdict) {
    if (pixel.empty()) return;
    ++verdict.covered_pixels;
    fragments_.clear();
    for (std::size_t i = 0; i < pixel.size(); ++i) {
      const std::uint32_t rank = rank_of(i);
      if (rank != not_drawn) fragments_.push_back(drawn_fragment(pixel[i], rank));
    }
    verdict.uncovered_fragments += pixel.size() - fragments_.size();
    if (is_in_order()) return;

    const Pair worst = worst_pair();
    if (!(worst.backtrack > 0)) return;
    number_ranks();
    ++verdict.inverted_pixels;
    verdict.inverted_pairs += count_inverted_pairs();
    if (worst.backtrack > verdict.worst_backtrack) {
      verdict.worst_backtrack = worst.backtrack;
      verdict.worst_pixel = pixel_index;
      verdict.worst_far_facet = worst.far_facet;
      verdict.worst_near_facet = worst.near_facet;
    }
  }

 private:
  struct Pair {
    double backtrack = 0;
    std::uint32_t far_facet = 0, near_facet = 0;
  };

  bool is_in_order() const {
    return std::is_sorted(fragments_.begin(), fragments_.end(),
                          [](const DrawnFragment& a, const DrawnFragment& b) { return a.rank < b.rank; });
  }

  // The inverted pair that is farthest apart, of equal ones that with the smallest ids. For each near fragment the
  // farthest one with a larger rank is found by bisection, as the largest rank so far only grows along the list; it is
  // nearly always the answer, and where its error bound is too wide the search goes on towards the near fragment.
  Pair worst_pair() {
    largest_rank_.clear();
    for (const DrawnFragment& fragment : fragments_)
      largest_rank_.push_back(largest_rank_.empty() ? fragment.rank : std::max(largest_rank_.back(), fragment.rank));
    Pair worst;
    for (std::size_t near = 1; near < fragments_.size(); ++near) {
      const DrawnFragment& n = fragments_[near];
      const auto first = std::upper_bound(largest_rank_.begin(), largest_rank_.begin() + near, n.rank);
      for (auto far = static_cast<std::size_t>(first - largest_rank_.begin()); far < near; ++far) {
        const DrawnFragment& f = fragments_[far];
        const double backtrack = f.depth - n.depth;
        if (backtrack <= gap_ || backtrack < worst.backtrack) break;
        if (f.rank <= n.rank || !is_beyond(f, n, gap_)) continue;
        if (backtrack > worst.backtrack || std::pair(f.facet, n.facet) < std::pair(worst.far_facet, worst.near_facet))
          worst = {backtrack, f.facet, n.facet};
        break;
      }
    }
    return worst;
  }

  // Makes the ranks 0 to n - 1, in the same order.
  void number_ranks() {
    by_rank_.resize(fragments_.size());
    std::iota(by_rank_.begin(), by_rank_.end(), 0u);
    std::sort(by_rank_.begin(), by_rank_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return fragments_[a].rank < fragments_[b].rank; });
    for (std::uint32_t i = 0; i < by_rank_.size(); ++i) fragments_[by_rank_[i]].rank = i;
  }

  // Exact, in O(n log n) and the number of pairs within the gap: a sweep counts the pairs whose depth intervals are
  // apart, then those of them that the gap leaves unjudged are taken away.
  std::size_t count_inverted_pairs() {
    far_order_ = fragments_;
    near_order_ = fragments_;
    std::sort(far_order_.begin(), far_order_.end(),
              [](const DrawnFragment& a, const DrawnFragment& b) { return a.lowest > b.lowest; });
    std::sort(near_order_.begin(), near_order_.end(),
              [](const DrawnFragment& a, const DrawnFragment& b) { return a.highest > b.highest; });
    counter_.reset(fragments_.size());
    std::size_t pairs = 0;
    std::size_t far = 0;
    for (const DrawnFragment& near : near_order_) {
      while (far < far_order_.size() && far_order_[far].lowest > near.highest) counter_.insert(far_order_[far++].rank);
      pairs += counter_.count_above(near.rank);
    }

    for (std::size_t near = 1; near < fragments_.size(); ++near) {
      const DrawnFragment& n = fragments_[near];
      for (std::size_t i = near; i > 0 && fragments_[i - 1].depth - n.depth <= gap_; --i) {
        const DrawnFragment& f = fragments_[i - 1];
        pairs -= f.rank > n.rank && f.lowest > n.highest;
      }
    }
    return pairs;
  }

  double gap_;
  std::vector<DrawnFragment> fragments_, far_order_, near_order_;
  std::vector<std::uint32_t> largest_rank_, by_rank_;
  RankCounter counter_;
};

// rank_of(i) is the rank of lists.fragments[i].
template <typename RankOf>
Verdict judge_ranks(const FragmentLists& lists, const RankOf& rank_of, const JudgeOptions& options) {
  assert(options.bounding_radius > 0 && options.gap_radii >= 0);
  const auto width = static_cast<std::size_t>(lists.width);
  std::vector<Verdict> rows(static_cast<std::size_t>(lists.height));
  parallel_ranges(rows.size(), 4, [&](std::size_t begin, std::size_t end) {
    PixelJudge judge(options.gap_radii * options.bounding_radius);
    for (std::size_t y = begin; y < end; ++y) {
      for (std::size_t p = y * width; p < (y + 1) * width; ++p) {
        judge.judge(lists.pixel(p), [&](std::size_t i) { return rank_of(lists.offsets[p] + i); }, p, rows[y]);
      }
    }
  });

  Verdict total;
  for (const Verdict& row : rows) {
    total.covered_pixels += row.covered_pixels;
    total.inverted_pixels += row.inverted_pixels;
    total.inverted_pairs += row.inverted_pairs;
    total.uncovered_fragments += row.uncovered_fragments;
    if (row.worst_backtrack > total.worst_backtrack) {
      total.worst_backtrack = row.worst_backtrack;
      total.worst_pixel = row.worst_pixel;
      total.worst_far_facet = row.worst_far_facet;
      total.worst_near_facet = row.worst_near_facet;
    }
  }
  total.worst_backtrack /= options.bounding_radius;
  return total;
}

}  // namespace

Verdict judge_order(const FragmentLists& lists, std::span<const std::uint32_t> rank, const JudgeOptions& options) {
  return judge_ranks(
      lists,
      [&](std::size_t fragment) {
        assert(lists.fragments[fragment].facet < rank.size());
        return rank[lists.fragments[fragment].facet];
      },
      options);
}

Verdict judge_drawing(const FragmentLists& lists, std::span<const std::uint32_t> fragment_rank,
                      const JudgeOptions& options) {
  assert(fragment_rank.size() == lists.fragments.size());
  return judge_ranks(lists, [&](std::size_t fragment) { return fragment_rank[fragment]; }, options);
}

}  // namespace facetsort
