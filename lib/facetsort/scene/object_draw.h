// One draw of a whole object, as the engines' draw-order rules give it.
#pragma once

#include <cstdint>

namespace facetsort {

// Which faces a draw lets through.
enum class Faces { all, back, front };

// A place in a draw sequence and the state that the engine sets for it. Whatever an engine sorts and draws as one is an
// item: an object, or a part of it with a material of its own.
struct ObjectDraw {
  std::uint32_t item = 0;  // its index in what was given
  Faces faces = Faces::all;
  bool colour_write = true;  // off in a depth pre-pass
  bool depth_test = true;
  bool depth_write = true;
  bool clear_depth = false;        // the depth buffer is cleared just before
  bool transmission_pass = false;  // into the texture that transmissive materials read, not into the picture
  double alpha_cutoff = 0;         // fragments with less alpha are discarded; 0: none are

  bool operator==(const ObjectDraw&) const = default;
};

}  // namespace facetsort
