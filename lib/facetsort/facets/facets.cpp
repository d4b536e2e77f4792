#include "facetsort/facets/facets.h"

#include <algorithm>
#include <cmath>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t facets_per_task = 16384;

template <typename PointOfFacet>
PointArrays points_of_facets(const MeshView& mesh, const PointOfFacet& point) {
  PointArrays points;
  points.x.resize(mesh.facet_count());
  points.y.resize(mesh.facet_count());
  points.z.resize(mesh.facet_count());
  parallel_ranges(mesh.facet_count(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t facet = begin; facet < end; ++facet) {
      const glm::vec3 p(point(facet));
      points.x[facet] = p.x;
      points.y[facet] = p.y;
      points.z[facet] = p.z;
    }
  });
  return points;
}

}  // namespace

PointArrays facet_centroids(const MeshView& mesh, const FacetFrame& frame) {
  return points_of_facets(mesh, [&](std::size_t facet) {
    const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
    return ((a + b + c) / 3.0 - frame.origin) * frame.scale;
  });
}

PointArrays facet_bounds_centres(const MeshView& mesh, const FacetFrame& frame) {
  return points_of_facets(mesh, [&](std::size_t facet) {
    const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
    return ((glm::min(glm::min(a, b), c) + glm::max(glm::max(a, b), c)) / 2.0 - frame.origin) * frame.scale;
  });
}

PointArrays facet_corners(const MeshView& mesh, int i, const FacetFrame& frame) {
  return points_of_facets(
      mesh, [&](std::size_t facet) { return (glm::dvec3(mesh.corner(facet, i)) - frame.origin) * frame.scale; });
}

FacetFrame facet_frame(const Box& box) {
  FacetFrame frame;
  frame.origin = (glm::dvec3(box.lowest) + glm::dvec3(box.highest)) / 2.0;
  const glm::dvec3 half = (glm::dvec3(box.highest) - glm::dvec3(box.lowest)) / 2.0;
  const double largest = std::max({half.x, half.y, half.z});
  // ilogb of a float32's half range is within +-150: its inverse is an exact double.
  frame.scale = largest > 0 ? std::ldexp(1.0, -std::ilogb(largest)) : 1.0;
  return frame;
}

Plane facet_plane(const MeshView& mesh, std::uint32_t facet) {
  const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  return {normal, glm::dot(normal, a)};
}

glm::vec3 Box::centre() const { return glm::vec3((glm::dvec3(lowest) + glm::dvec3(highest)) / 2.0); }

float Box::radius() const {
  return static_cast<float>(glm::length(glm::dvec3(highest) - glm::dvec3(lowest)) / 2.0);
}

Box facet_bounds(const MeshView& mesh) {
  if (mesh.triangles.empty()) return {};
  const glm::vec3 first = mesh.corner(0, 0);
  Box box{first, first};
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      box.lowest = glm::min(box.lowest, mesh.positions[triangle[i]]);
      box.highest = glm::max(box.highest, mesh.positions[triangle[i]]);
    }
  }
  return box;
}

}  // namespace facetsort
