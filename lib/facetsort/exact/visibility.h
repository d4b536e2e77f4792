// Internal to exact: which of two parts hides the other.
#pragma once

#include <span>

#include "facetsort/exact/points.h"

namespace facetsort::exact_internal {

// A convex part of a facet as an eye sees it. `facing` is the side of the facet's plane that the eye is on, not 0.
struct SeenPart {
  FacetId facet;
  int facing;
  std::span<const PointId> corners;  // wound as the facet is
};

struct Viewpoint {
  Eye eye;
  // Whether parts may lie on opposite sides of the eye, so that no plane has all of them in front.
  bool surrounded;
};

enum class Hiding { none, first_behind_second, second_behind_first };

// Exact, for parts that do not cross: none where no half-line from the eye meets the inside of both, or where both lie
// in one plane. Orthographic eyes see whole lines. For parts that cross, which cutting has to prevent, any answer may
// come.
Hiding hiding(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b);

// Whether some half-line from the eye meets the inside of both; exact, for any parts.
bool overlap(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b);

// hiding() of parts that are known to overlap as seen from the eye.
Hiding hiding_of_overlapping(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b);

}  // namespace facetsort::exact_internal
