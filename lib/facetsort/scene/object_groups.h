// Internal to scene: which objects have to be sorted together, and which can be drawn one after the other.
//
// Where a plane parts two objects, the eye's side of it is in front: no ray comes from there to the other side and back
// (Fuchs, Kedem and Naylor, "On Visible Surface Generation by a Priori Tree Structures", 1980). Boxes that don't overlap
// are parted by a plane across an axis.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/facets/facets.h"

namespace facetsort::scene_internal {

enum class Sequence {
  any,           // no ray meets both
  first_before,  // what shows of both is right when the first is drawn before the second
  second_before,
  interleaved,   // their facets may hide each other either way
};

// Of what the boxes hold, for an eye as SortView has it.
Sequence sequence_of(const Box& first, const Box& second, const glm::vec4& eye);

class ObjectGroups {
 public:
  // Call when boxes changed: finds which objects are linked by boxes that overlap.
  void set_boxes(std::span<const Box> boxes);

  // Groups of objects, in the order to draw them; the numbers in each ascend. Objects that are linked, or before each
  // other in a cycle, share a group. Valid until the next call.
  std::span<const std::vector<std::uint32_t>> find(const glm::vec4& eye);

 private:
  void find_edges(const glm::vec4& eye);

  std::vector<Box> boxes_;
  std::vector<std::vector<std::uint32_t>> clusters_;  // of objects linked by overlapping boxes
  std::vector<std::vector<std::uint32_t>> later_;     // of each cluster, those that must be drawn after it
  std::vector<std::vector<std::uint32_t>> groups_;
};

}  // namespace facetsort::scene_internal
