// Embree as an independent referee: rays through pixel centres, all hits along each.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/view.h"
#include "facetsort/check/verdict.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Every facet that the ray through each pixel's centre meets, found by Embree and measured by us.
//
// Two tests look at every facet whose box a ray meets: Embree's own, in float32, and one in double, from the float32
// corners, with a bound on its rounding. A ray is judged where both say the same of each of these facets and the one in
// double is certain; any other ray is unjudged and its list is empty. So a hit that float32 loses or invents beside an
// edge can't pass for the truth, and no tolerance had to be chosen. Depth along the ray comes from the double alone.
// Embree's scene is moved to the origin and scaled by a power of two so that its largest coordinate lies in [1, 2), and
// each ray starts just outside the mesh (or at an eye inside): far eyes and small or distant meshes cost no digits.
struct RayHits {
  FragmentLists lists;                     // hits of the judged rays
  std::vector<unsigned char> judged;       // one a pixel: 1 judged, 0 not
  std::size_t rays = 0;                    // with a hit, judged or not
  std::size_t unjudged_rays = 0;           // the sum of the reasons below
  std::size_t unjudged_edge = 0;           // too near an edge or corner of a facet: which side is in doubt
  std::size_t unjudged_grazing = 0;        // the same, for a facet seen within 2^-12 of edge-on
  std::size_t unjudged_near_plane = 0;     // a hit too near the near plane
};

// Owns an Embree scene over one mesh; cast() may be called for many views. The mesh's arrays must outlive it.
// cast() is parallel in the caller's task arena, gives the same hits for any thread count, and may be called from
// several threads at once.
class EmbreeReferee {
 public:
  // Fails with out_of_memory or bad_argument (with Embree's own words) where Embree refuses the mesh.
  static Result<EmbreeReferee> create(const MeshView& mesh);
  EmbreeReferee(EmbreeReferee&&) noexcept;
  EmbreeReferee& operator=(EmbreeReferee&&) noexcept;
  ~EmbreeReferee();

  // Fails with bad_argument where validate(view) does.
  Result<RayHits> cast(const View& view) const;

  struct State;  // of the implementation alone

 private:
  explicit EmbreeReferee(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace facetsort
