// Judging a picture by the per-pixel lists it should have been blended from.
#pragma once

#include <cstddef>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/view.h"
#include "facetsort/check/verdict.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

struct PictureVerdict {
  std::size_t covered_pixels = 0;
  // Covered pixels whose colour differs_visibly() from the reference's and from that of every other order of the
  // layers that tie: layers whose depths JudgeOptions can't tell apart may be drawn either way.
  std::size_t wrong_pixels = 0;
  std::size_t unjudged_pixels = 0;  // differ, and have more orders of tied layers than can be tried
  double rmse = 0, max_error = 0;   // against the reference, in linear RGB, over all covered pixels
};

// `reference` is blend_lists() of the same mesh, view, lists and format. Parallel in the caller's task arena.
PictureVerdict judge_picture(const MeshView& mesh, const View& view, const FragmentLists& lists,
                             const Image& reference, const Image& picture, const JudgeOptions& options);

}  // namespace facetsort
