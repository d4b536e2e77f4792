// Pairs of facets that may hide each other, and what is seen of them. Internal to presort.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::presort_internal {

// On which side of the plane of one the other lies: +1 the front, -1 the back, 0 both (or in it).
struct FacetPair {
  std::uint32_t first, second;
  std::int8_t second_from_first, first_from_second;
};

struct PairOptions {
  double gap;         // fragments nearer to each other, in the mesh's units, have no order
  bool with_culling;  // facets seen from behind are not drawn
};

// What is seen of a pair: which of the two is behind, and where both cover the picture.
struct SeenPair {
  std::uint32_t pair : 31;
  std::uint32_t second_is_behind : 1;
  std::uint32_t area;  // in areas_per_pixel to the pixel
};
inline constexpr double areas_per_pixel = 256;

// The facets that a view without back faces leaves: fragments of the others are taken out of `lists`.
FragmentLists without_back_faces(const MeshView& mesh, const View& view, const FragmentLists& lists);

// Finds the pairs that are next to each other at some pixel of some views, or share a corner, but for those so far
// apart that orders near to one by depth have them right. The mesh must outlive it.
class PairFinder {
 public:
  PairFinder(const MeshView& mesh, const PairOptions& options);

  // Parallel in the caller's task arena.
  void add(std::span<const View> views);
  // Each once, in ascending order. Precondition: called once, last.
  std::vector<FacetPair> pairs();

 private:
  MeshView mesh_;
  PairOptions options_;
  std::vector<double> sizes_;         // of facets
  std::vector<std::uint64_t> found_;  // the two ids in one number; ascending
};

// Those of `pairs` that overlap in a view, in the order of `pairs`.
// Precondition: all of the mesh is before the eye of `view`.
std::vector<SeenPair> seen_pairs(const MeshView& mesh, const View& view, std::span<const FacetPair> pairs,
                                 const PairOptions& options);

}  // namespace facetsort::presort_internal
