// The run time of presorted meshes: an eye goes in, and an index buffer comes out whose order is right from that eye,
// wherever it is, in the mesh too. Nothing is sorted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>

#include "facetsort/order/presorted_data.h"

namespace facetsort {

struct PresortedReaderOptions {
  // Leave out facets seen from behind. A facet seen from the front is never left out, and of those behind only facets
  // without area stay: what side the eye is on is decided exactly.
  bool cull_back_faces = false;
};

// Reads one presorted mesh for many eyes. Construction arranges planes and counts for reading; the reading functions
// allocate nothing after the first call of each, in an arena of no more threads. An eye that has moved a little since
// the last call costs less than one that jumps: planes that it can't have crossed are not looked at again.
//
// The order depends on the eye alone: not on earlier eyes, nor on thread count or instruction set. Seen from a plane of
// the tree, neither side hides the other; it is read as from the front. Large meshes are read in parallel in the
// caller's task arena. A reader serves one thread at a time; different readers may be used at once, of one mesh too.
// The arrays of the view, which may be a mapped file's, must outlive it.
class PresortedReader {
 public:
  // Precondition: the view is sound: what it counts adds up to the lengths of its arrays, and indices are within them.
  explicit PresortedReader(const PresortedView& mesh, const PresortedReaderOptions& options = {});
  PresortedReader(PresortedReader&&) noexcept;
  PresortedReader& operator=(PresortedReader&&) noexcept;
  ~PresortedReader();

  // Writes the triangles that are drawn, back to front, as indices of the mesh's vertices and, after them, of the made
  // ones; ids[k], where `ids` is not empty, is the facet that the k-th is, or is part of. Returns how many there are.
  // Both are written front to back or, by several threads, in a few runs front to back, and never read: they may be
  // mapped GPU buffers. Up to four triangles at a time may be written twice; what follows the last is left as it is.
  // Eyes: (x, y, z, 1) a point, perspective; (x, y, z, 0) the direction towards the viewer, orthographic.
  // Preconditions: the eye is finite, and w = 1, or w = 0 and it is not zero; indices.size() >= 3 * triangles.size();
  // `ids` is empty or has room for all triangles.
  std::size_t read_indices(const glm::vec4& eye, std::span<std::uint32_t> indices, std::span<std::uint32_t> ids = {});

  // Draw ids of what is drawn, back to front (see Pieces): i for facet i as a whole; facet count + i for the i-th of
  // the pieces that have cuts. Returns how many there are. Precondition: `ids` has room for all pieces.
  std::size_t read_draw_ids(const glm::vec4& eye, std::span<std::uint32_t> ids);

  // Whether the last reading was for this eye, so that another would give the same: a renderer that still has what it
  // gave can leave it.
  bool is_read_for(const glm::vec4& eye) const;
  // Goes to an eye without reading: whether the order from there is the one that was last read. It is where no plane of
  // the tree lies between the two eyes; what it costs is what a reading spends on finding that out. Precondition: as of
  // the reading functions.
  bool keeps_order(const glm::vec4& eye);
  // Lets the next call do all of its work whatever its eye, as after a jump: for timing.
  void forget_eye();

  // Bytes that this reader holds beyond the view.
  std::size_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace facetsort
