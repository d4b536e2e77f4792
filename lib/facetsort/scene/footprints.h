// Internal to scene: which parts of an eye's screen a triangle may cover, rounded outwards.
//
// An eye well outside of what it looks at has one chart, a plane across the view; any other has six, the faces of a
// cube around it, so that it may look everywhere at once. Two triangles that cover a common point of the screen have
// footprints that overlap in a chart.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/facets/facets.h"

namespace facetsort::scene_internal {

// A box in one chart, whose coordinates run from -1 to 1.
struct Footprint {
  glm::vec2 lowest, highest;
  std::uint32_t chart;
};

using Corners = std::array<glm::vec3, 3>;

class Charts {
 public:
  static constexpr std::uint32_t most = 6;

  // `bounds` has all that is to be looked at. Preconditions: finite; the eye's first three are not all 0 where w is 0.
  Charts(const glm::vec4& eye, const Box& bounds);

  std::uint32_t count() const { return single_ ? 1 : most; }
  // Of a triangle that lies in one chart; false where it may cover parts of several.
  bool find_one(const Corners& corners, Footprint& footprint) const;
  // Of any triangle, appended to `footprints`.
  void find_all(const Corners& corners, std::vector<Footprint>& footprints) const;

 private:
  glm::dvec3 in_view(const glm::vec3& point) const;

  bool single_, orthographic_;
  glm::dvec3 origin_;  // the eye or, orthographic, the centre
  glm::dvec3 right_, down_, forward_;
  double reach_ = 1;  // of what is looked at, in units of the chart
  float margin_;      // beyond all rounding
};

}  // namespace facetsort::scene_internal
