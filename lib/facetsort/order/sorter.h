// The per-frame sort: a mesh and an eye go in, facet ids or a reordered index buffer come out, farthest facet first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/key_sort.h"
#include "facetsort/order/method.h"

namespace facetsort {

// Where the picture is seen from, in the mesh's space.
struct SortView {
  // (x, y, z, 1): a point, perspective. (x, y, z, 0): the direction towards the viewer, orthographic (any length > 0).
  glm::vec4 eye{0, 0, 1, 0};
  // Direction in which the camera looks (any length > 0); used by the keys along the camera axis in perspective, and
  // ignored for an orthographic eye.
  glm::vec3 forward{0, 0, -1};
};

// Sorts one mesh for many views. Construction computes what does not depend on the view; sort() allocates nothing
// after its first call. Keys are float32, compared to the last bit: facets with equal keys come out by smaller id
// first. They are taken relative to the mesh's centre, so a mesh far from the origin, or an eye far from the mesh,
// costs no digits. The order depends on neither thread count nor instruction set. Mirroring mesh and eye, or scaling
// both by a power of two, changes no key comparison.
//
// A Sorter serves one thread at a time; different Sorters may be used at once. It keeps no reference to the mesh.
class Sorter {
 public:
  // Preconditions: validate(mesh) is ok; `method` is one of depth_key_methods().
  explicit Sorter(const MeshView& mesh, Method method = Method::centroid_distance);

  // Facet ids, back to front. The span is valid until the next call on this Sorter.
  // Precondition: view.eye and view.forward are finite and not a zero direction.
  std::span<const std::uint32_t> sort(const SortView& view);

  // The same order written as an index buffer: `indices[3 k .. 3 k + 2]` are the corners of the k-th facet drawn.
  // `indices` is written once, front to back, and never read: it may be a mapped GPU buffer.
  // Preconditions: `triangles` are those of the constructor's mesh; indices.size() == 3 * triangles.size(); for 16
  // bits, every index is below 65536.
  void sort_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<std::uint32_t> indices);
  void sort_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<std::uint16_t> indices);

  // The key of each facet for the last view sorted, by facet id: larger is farther. Comparable within one view only.
  std::span<const float> keys() const { return keys_; }
  Method method() const { return method_; }
  // Bytes that this Sorter holds: what construction made, and with the scratch of sort().
  std::size_t prepared_bytes() const;
  std::size_t memory_bytes() const;

 private:
  void compute_keys(const SortView& view);
  template <typename Index>
  void write_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<Index> indices);

  Method method_;
  FacetFrame frame_;
  PointArrays points_[3];  // one set for the keys of one point a facet; three corners for nearest and farthest
  std::vector<float> keys_;
  KeySort key_sort_;
};

// One use: the order of one mesh for one view, by a depth key.
std::vector<std::uint32_t> sort_facets(const MeshView& mesh, const SortView& view,
                                       Method method = Method::centroid_distance);

}  // namespace facetsort
