// What each way to order a scene's blended objects costs in draw calls.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/order/sorter.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

struct DrawCost {
  std::string choice;              // "whole_objects", "facet_sort:METHOD" or "exact"
  std::size_t draws = 0;           // runs, triangles of an object brought together where that changes no pixel
  std::size_t draws_as_found = 0;  // runs of the order as it was found
  std::size_t triangles = 0;       // more than the facets where something was cut
  std::size_t groups = 0;          // of objects that have to be sorted together
  double order_ms = 0;             // wall clock, for this view, of a sorter that was prepared for another
};

// Of the scene's blended objects, for one view: each object as one draw (right only where no two interleave), the facet
// sort by centroid distance, and the exact order. Preconditions: validate(scene) is ok; those of SceneSorter::sort().
// Faults: those of SceneSorter::create().
Result<std::vector<DrawCost>> draw_costs(const Scene& scene, const SortView& view);

}  // namespace facetsort
