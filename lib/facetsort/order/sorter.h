// The per-frame sort: a mesh and an eye go in, facet ids or a reordered index buffer come out, farthest facet first.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/method.h"

namespace facetsort {

// Where the picture is seen from, in the mesh's space.
struct SortView {
  // (x, y, z, 1): a point, perspective. (x, y, z, 0): the direction towards the viewer, orthographic (any length > 0).
  glm::vec4 eye{0, 0, 1, 0};
  // Direction in which the camera looks (any length > 0); used by the keys along the camera axis in perspective, and
  // ignored for an orthographic eye.
  glm::vec3 forward{0, 0, -1};
  // Facets wholly on the negative side of one of these, dot(plane, (x, y, z, 1)) < 0, are left out; at most 8, normals
  // of any length > 0. Only with SorterOptions::cull_by_clip_planes. clip_planes_of() gives those of a frustum.
  std::span<const glm::vec4> clip_planes{};
};

// The six planes of the frustum of a matrix from mesh space to clip space with -w <= x, y, z <= w (OpenGL's; with
// Vulkan's or Direct3D's 0 <= z the near plane culls a little less).
std::array<glm::vec4, 6> clip_planes_of(const glm::mat4& clip_from_mesh);

enum class Direction { back_to_front, front_to_back };

// How finely depths are told apart.
enum class Precision {
  // Depth is cut into steps, one for two facets and at most 65,536, over the depths where nearly all facets lie; facets
  // on one step come out by smaller id. Facets beyond those depths, and on steps with more than their share, are sorted
  // by whole keys: no facet is more than 48 places, or 16 and 1/4096 of the facets, from where its whole key would put
  // it. Half the work of whole keys and less. Below 1,024 facets keys are whole.
  quantised,
  // Float32 keys, compared to the last bit: for layers nearer to each other than 1/65,536 of the depth that they lie in,
  // and for orders that are compared with others.
  whole,
};

// Bits of the keys that tell the depths of so many facets apart: 32 where they are whole.
int key_bits(Precision precision, std::size_t facets);

struct SorterOptions {
  Method method = Method::centroid_distance;  // one of depth_key_methods()
  Direction direction = Direction::back_to_front;
  Precision precision = Precision::quantised;
  // Leave out facets seen from behind. A facet seen from the front is never left out; a few of those behind whose
  // angle is within rounding of edge-on may stay. 6.6 bytes a facet, 18.6 for bounds_centre.
  bool cull_back_faces = false;
  // Leave out what SortView::clip_planes leave out. A facet that reaches inside is never left out. Half a byte a facet.
  bool cull_by_clip_planes = false;
};

// Facets [first, first + count) of the mesh: a material, a meshlet.
struct FacetRange {
  std::uint32_t first = 0, count = 0;
};

// Sorts one mesh for many views. Construction computes what does not depend on the view; the sorting functions allocate
// nothing after the first call of each, in an arena of no more threads. Facets with equal keys come out by smaller id
// first, in both directions. Keys are taken relative to the mesh's centre, so a mesh far from the origin, or an eye far
// from the mesh, costs no digits; nor does an eye near facets that are small against the mesh. The order depends on
// neither thread count nor instruction set. Mirroring mesh and eye, or scaling both by a power of two, changes nothing.
//
// Meshes whose facets lie in spatial order (spatial_order()) sort fastest. Large meshes are sorted in parallel in the
// caller's task arena. A Sorter serves one thread at a time; different Sorters may be used at once. It keeps no
// reference to the mesh.
class Sorter {
 public:
  // Preconditions: validate(mesh) is ok; `options.method` is one of depth_key_methods().
  explicit Sorter(const MeshView& mesh, Method method = Method::centroid_distance);
  Sorter(const MeshView& mesh, const SorterOptions& options);
  // The same without a copy of an interleaved vertex buffer. Preconditions: as validate() would have them.
  Sorter(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const SorterOptions& options = {});
  Sorter(Sorter&&) noexcept;
  Sorter& operator=(Sorter&&) noexcept;
  ~Sorter();

  // New positions of the same facets (skinning): as if constructed with them, without allocating.
  // Precondition: `triangles` are those of the constructor.
  void set_positions(std::span<const glm::uvec3> triangles, const StridedPositions& positions);
  // New positions of the facets of a range alone: of an object among others, say. What is known of the others stays,
  // unless the range has left the box that all facets had when last all were new: keys are relative to that box.
  // Preconditions: `triangles` are those of the constructor, the range is of them, and positions of others are the
  // same.
  void set_positions(std::span<const glm::uvec3> triangles, const StridedPositions& positions,
                     const FacetRange& changed);

  // Ids of the facets that are not culled, in order. The span is valid until the next call on this Sorter. Does nothing
  // where the last call was this one, and neither view nor positions changed since.
  // Precondition of this and all others that take a view: eye, forward and planes are finite and not a zero direction.
  std::span<const std::uint32_t> sort(const SortView& view);

  // The same order written as an index buffer, and the number of facets in it: `indices[3 k .. 3 k + 2]` are the
  // corners of the k-th facet drawn, and ids[k], where `ids` is not empty, is its id (for picking). Both are written
  // once, front to back or, by several threads, in a few runs front to back, and never read: they may be mapped GPU
  // buffers. What follows the last facet is left as it is.
  // Preconditions: `triangles` are those of the constructor; indices.size() >= 3 * triangles.size(); `ids` is empty or
  // has room for all; for 16 bits, every index is below 65536.
  std::size_t sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                           std::span<std::uint32_t> indices, std::span<std::uint32_t> ids = {});
  std::size_t sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                           std::span<std::uint16_t> indices, std::span<std::uint32_t> ids = {});

  // Sorts each range by itself. Range r is written from indices[3 * ranges[r].first] (and ids[ranges[r].first]) on, so
  // that draw calls stay as they are; counts[r] is the number of its facets that are not culled.
  // Preconditions: those of sort_indices(); ranges do not overlap; counts.size() == ranges.size().
  void sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles, std::span<const FacetRange> ranges,
                   std::span<std::uint32_t> indices, std::span<std::uint32_t> counts,
                   std::span<std::uint32_t> ids = {});
  void sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles, std::span<const FacetRange> ranges,
                   std::span<std::uint16_t> indices, std::span<std::uint32_t> counts,
                   std::span<std::uint32_t> ids = {});

  // Whether the last sort was of this view and these positions, so that another would give the same: a renderer that
  // still has that index buffer can leave it.
  bool is_sorted_for(const SortView& view) const;
  // Lets the next call do all of its work whatever its view, as a frame from a new eye does: for timing.
  void forget_view();

  // The key of each facet for the last view sorted, by facet id: larger is farther. Comparable within one view only.
  // Computed by the first call after a sort. Precondition: something was sorted, and the view not forgotten.
  std::span<const float> keys();
  Method method() const;
  // Bytes that this Sorter holds: what construction made, and with the scratch of the sorting functions.
  std::size_t prepared_bytes() const;
  std::size_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// One use: the order of one mesh for one view, by whole depth keys.
std::vector<std::uint32_t> sort_facets(const MeshView& mesh, const SortView& view,
                                       Method method = Method::centroid_distance);

}  // namespace facetsort
