// Embree as an independent referee: rays through pixel centres, all hits along each.
#pragma once

#include <cstddef>
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
// Embree only proposes facets. Scene and eye are first scaled by a power of two so that the largest coordinate lies in
// [1, 2); Embree's own float32 depth and barycentric coordinates are not used. Depth along the ray is computed in
// double from the float32 corners. A hit so near an edge of its facet that float32 traversal could have decided either
// way makes the whole ray unjudged: its list is empty.
struct RayHits {
  FragmentLists lists;                     // hits of the judged rays
  std::vector<unsigned char> judged;       // one a pixel: 1 judged, 0 not
  std::size_t rays = 0;                    // with a hit, judged or not
  std::size_t unjudged_rays = 0;           // the sum of the reasons below
  std::size_t unjudged_edge = 0;           // a hit too near an edge or corner for its side to be certain
  std::size_t unjudged_grazing = 0;        // a facet seen so nearly edge-on that its depth has no certain digits
  std::size_t unjudged_near_plane = 0;     // a hit too near the near plane
};

// Owns an Embree scene over one mesh; cast() may be called for many views. The mesh's arrays must outlive it.
// cast() is parallel in the caller's task arena, and gives the same hits for any thread count.
class EmbreeReferee {
 public:
  // Fails with out_of_memory or bad_argument (with Embree's own words) where Embree refuses the mesh.
  static Result<EmbreeReferee> create(const MeshView& mesh);
  EmbreeReferee(EmbreeReferee&&) noexcept;
  EmbreeReferee& operator=(EmbreeReferee&&) noexcept;
  ~EmbreeReferee();

  Result<RayHits> cast(const View& view) const;

 private:
  struct State;
  explicit EmbreeReferee(State* state);
  State* state_;
};

}  // namespace facetsort
