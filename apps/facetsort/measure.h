// One row of a comparison: what a strategy costs in a view, and how wrong it is there.
#pragma once

#include <cstddef>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/blend/view.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/report/row.h"
#include "input_mesh.h"
#include "prepared_strategy.h"

namespace facetsort {

// What both referees know of a view: found once, and every strategy is judged by it.
struct RefereedView {
  View view;
  PixelFormat format = PixelFormat::rgba32f;
  FragmentLists lists;
  Image reference;  // the lists, blended
  RayHits hits;
};

// Throws Failure where Embree refuses the view.
RefereedView referee_view(const InputMesh& input, const EmbreeReferee& referee, const View& view, PixelFormat format);

// Covered pixels that Embree can judge and whose ties can be told, and how its own picture of them compares with the
// reference.
struct Agreement {
  std::size_t judged = 0;
  std::size_t agreeing = 0;  // within a display step, layers that tie taken either way
};
Agreement compare_referees(const InputMesh& input, const RefereedView& refereed);

struct MeasuredStrategy {
  Row row;  // all but its `view`, the place in the view set
  Image picture;
};

// Draws `repeats` times, or as often as most_repeating_seconds allow, after an untimed first frame, whose allocations
// are counted. Makes the strategy ready unless that was done and took too long for its first allocations to show.
// Parallel in the caller's arena.
MeasuredStrategy measure_strategy(const InputMesh& input, const Strategy& strategy, const RefereedView& refereed,
                                  std::size_t repeats, PreparedStrategy& prepared);

}  // namespace facetsort
