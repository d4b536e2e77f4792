// Judging an order by per-pixel lists, whoever found them (the rasteriser or Embree).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "facetsort/blend/fragment_lists.h"

namespace facetsort {

struct JudgeOptions {
  double bounding_radius = 1;  // R, in the mesh's units
  // Two fragments are judged when their depths differ by more than the larger of gap_radii * R and the sum of their
  // depth_errors. 0 leaves the computation's own error bound alone.
  double gap_radii = 1e-6;
};

// What one order does to the fragments of one view.
struct Verdict {
  std::size_t covered_pixels = 0;    // pixels with a fragment
  std::size_t inverted_pixels = 0;   // pixels in which some fragment is drawn after a nearer one
  std::size_t inverted_pairs = 0;    // pairs of fragments, over all pixels, in which the farther is drawn later
  std::size_t uncovered_fragments = 0;  // fragments that the order does not draw
  double worst_backtrack = 0;        // largest depth, over R, by which a farther fragment was drawn over a nearer one
  // The pair behind worst_backtrack; meaningless where nothing is inverted.
  std::size_t worst_pixel = 0;
  std::uint32_t worst_far_facet = 0, worst_near_facet = 0;
};

// An order of whole facets: `rank[f]` is the position of facet f in it, or `not_drawn` (fragment_lists.h).
Verdict judge_order(const FragmentLists& lists, std::span<const std::uint32_t> rank, const JudgeOptions& options);
// Any order, pieces of facets included: `fragment_rank[i]` is that of lists.fragments[i], as fragment_ranks() finds it.
Verdict judge_drawing(const FragmentLists& lists, std::span<const std::uint32_t> fragment_rank,
                      const JudgeOptions& options);

}  // namespace facetsort
