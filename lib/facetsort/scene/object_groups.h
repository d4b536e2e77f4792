// Internal to scene: which objects have to be sorted together, and which can be drawn one after the other.
//
// Where a plane parts two objects, the eye's side of it is in front: no ray comes from there to the other side and back
// (Fuchs, Kedem and Naylor, "On Visible Surface Generation by a Priori Tree Structures", 1980). Planes across thirteen
// directions are tried, those of the faces, edges and corners of a cube (Klosowski et al., "Efficient Collision
// Detection Using Bounding Volume Hierarchies of k-DOPs", 1998).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace facetsort::scene_internal {

enum class Sequence {
  any,           // no ray meets both
  first_before,  // what shows of both is right when the first is drawn before the second
  second_before,
  interleaved,  // their facets may hide each other either way
};

// Between which planes the corners of some facets lie, across each direction, rounded outwards.
struct Slabs {
  static constexpr std::size_t directions = 13;  // the first three are the axes

  std::array<double, directions> lowest, highest;
};
// Precondition: there is a facet.
Slabs slabs_of(std::span<const glm::uvec3> triangles, std::span<const glm::vec3> positions);

// Of what lies in the slabs, for an eye as SortView has it.
Sequence sequence_of(const Slabs& first, const Slabs& second, const glm::vec4& eye);

class ObjectGroups {
 public:
  // Call when some changed: finds which objects no plane parts.
  void set_slabs(std::span<const Slabs> slabs);

  // Groups of objects, in the order to draw them; the numbers in each ascend. Objects that no plane parts share a
  // group, and so do objects that are before each other in a cycle, from the first view on in which they are: the
  // groups soon are the same from view to view. Valid until the next call.
  std::span<const std::vector<std::uint32_t>> find(const glm::vec4& eye);

 private:
  void find_edges(const glm::vec4& eye);

  std::vector<Slabs> slabs_;
  std::vector<std::vector<std::uint32_t>> groups_;
  std::vector<std::vector<std::uint32_t>> later_;  // of each group, those that must be drawn after it
};

}  // namespace facetsort::scene_internal
