// Pixels without a right answer.
#pragma once

#include <vector>

#include "facetsort/blend/fragment_lists.h"

namespace facetsort {

// One a pixel: 1 where two of its fragments tie, that is where their depths differ by no more than `gap` (in the
// mesh's units) or by no more than their rounding. Parallel in the caller's task arena.
std::vector<unsigned char> tied_pixels(const FragmentLists& lists, double gap);

}  // namespace facetsort
