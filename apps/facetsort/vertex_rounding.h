// What float32 does to the vertices that cuts make, and how much of what is drawn it explains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// How far from its place in the facet a vertex can lie whose coordinates were rounded to float32.
double vertex_rounding(const MeshView& mesh, std::uint32_t facet);

double distance_to_segment(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b);

// Pixels that the parts of a mesh's facets cover more or less often than the facets do.
struct PartCoverage {
  std::size_t miscovered_pixels = 0;
  // Not among them: the ray through the centre passes no farther from an edge of each facet concerned (or meets it no
  // farther from the near plane) than the rounding of vertices moves that.
  std::size_t excused_pixels = 0;
};

// A mesh whose facets are drawn as triangles, some with corners of their own.
class PartedMesh {
 public:
  // `sources[t]` is the facet that triangle t of `drawn` is, or is part of. The arrays must outlive it.
  PartedMesh(const MeshView& mesh, const MeshView& drawn, std::span<const std::uint32_t> sources);

  // Adds to the depth errors of fragments of `drawn` what the rounding of vertices may have moved them along the ray.
  void widen_depth_errors(const View& view, FragmentLists& drawn_lists) const;

  // Lists of the same view, of the mesh and of the triangles drawn.
  PartCoverage compare_coverage(const View& view, const FragmentLists& mesh_lists,
                                const FragmentLists& drawn_lists) const;

 private:
  bool is_corner_of_source(std::uint32_t triangle, int i) const;
  double depth_rounding(std::uint32_t facet, const Ray& ray) const;
  bool is_explained(std::uint32_t facet, const Camera& camera, const Ray& ray) const;

  MeshView mesh_, drawn_;
  std::span<const std::uint32_t> sources_;
  std::vector<unsigned char> corner_moves_;       // three a triangle: 1 where it is no corner of the facet
  std::vector<std::uint32_t> triangles_;          // of `drawn` that have such a corner, by facet
  std::vector<std::size_t> first_triangle_;       // of each facet, in triangles_
};

}  // namespace facetsort
