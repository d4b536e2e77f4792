// The stability sweeps as data: which condition each changes, the values it takes, and the scene at each value.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

// Where a sweep's condition stands: at a value, or at a place that no number on the axis describes.
struct SweepStop {
  double value = 0;
  std::string_view place = {};  // empty for a value
};

// The mesh as rounded to float32: what every method and referee is given.
struct SweepScene {
  Mesh mesh;
  std::vector<View> views;  // sweep_views of them
};
inline constexpr std::size_t sweep_views = 3;

struct Sweep {
  std::string_view name, title, unit;
  std::string_view description;  // whole sentences: what changes, what stays, what rounding to float32 does
  std::vector<SweepStop> stops;
  std::size_t mildest;  // the stop from which conditions get worse, in both directions
  // `size`: width and height of the pictures, which sweeps of many layers divide.
  SweepScene (*scene)(const SweepStop& stop, int size);
};

std::span<const Sweep> all_sweeps();

}  // namespace facetsort
