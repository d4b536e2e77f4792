// Internal to exact: which of two elements hides the other in the view at hand, by filters first.
#pragma once

#include <cstdint>

#include "facetsort/exact/elements.h"
#include "facetsort/exact/pair_kernels.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/screen.h"

namespace facetsort::exact_internal {

// Refers to what it is made of. Any number of threads may ask at once.
class Relation {
 public:
  Relation(const Points& points, const PartList& parts, const Elements& elements, const Screen& screen)
      : points_(points), parts_(parts), elements_(elements), screen_(screen) {}

  // Whether the first (or else the second) of a pair is behind the other. Exact; the filters decide nearly all.
  bool is_behind(const ElementPair& pair, bool first) const;
  // Whether two are in different planes and overlap as seen from the eye: one of them hides the other. Exact.
  bool overlap(std::uint32_t element, const Candidate& other) const;

 private:
  SeenPart seen_part(std::uint32_t element) const;
  int behind_by_cut(std::uint32_t element, std::uint32_t other) const;

  const Points& points_;
  const PartList& parts_;
  const Elements& elements_;
  const Screen& screen_;
};

}  // namespace facetsort::exact_internal
