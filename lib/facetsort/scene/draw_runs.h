// Facets of several objects in one order, drawn by as few calls as may be.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

namespace facetsort {

// One draw call: indices [first_index, first_index + index_count) of a merged index buffer, all of one object.
struct DrawRun {
  std::uint32_t object;  // of MergedMesh::objects
  std::uint32_t first_index, index_count;

  bool operator==(const DrawRun&) const = default;
};

// The fewest runs that draw triangles in just this order: `objects` has the object of each, in the order drawn. Earlier
// content of `runs` is replaced.
void find_draw_runs(std::span<const std::uint32_t> objects, std::vector<DrawRun>& runs);
std::size_t count_draw_runs(std::span<const std::uint32_t> objects);

// Triangles in the order drawn, and the object of each.
struct DrawnTriangles {
  std::span<const glm::vec3> positions;
  std::span<const glm::uvec3> triangles;
  std::span<const std::uint32_t> objects;
};

// Finds another order of the same triangles that makes the same picture to the bit and falls into fewer runs. Triangles
// that have no tile of the screen in common may be drawn in either order, so those of one object are brought together
// as far as no other object's triangle on a common tile has to come between. Of all objects that could go on, the one
// with the most triangles ready does. The fewest runs are not promised, as to find them is as hard as the shortest
// common supersequence; but no run as a whole could have been drawn with an earlier one of its object.
//
// Keeps its scratch, and allocates nothing once it has seen as many triangles and objects. One thread at a time; works
// in parallel in the caller's task arena; the result is the same for any thread count.
class RunGrouper {
 public:
  RunGrouper();
  RunGrouper(RunGrouper&&) noexcept;
  RunGrouper& operator=(RunGrouper&&) noexcept;
  ~RunGrouper();

  // Places in the order given, in the new order; valid until the next call.
  // Preconditions: eye is that of SortView; positions of triangles are finite; every object is below object_count.
  std::span<const std::uint32_t> group(const glm::vec4& eye, const DrawnTriangles& drawn, std::size_t object_count);

  std::size_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace facetsort
