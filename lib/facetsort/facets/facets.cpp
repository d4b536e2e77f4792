#include "facetsort/facets/facets.h"

#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t facets_per_task = 16384;

// Not a lambda a point: one loop, in which the compiler sees the kind of point as a constant.
template <FacetPoint kind>
glm::dvec3 point_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  switch (kind) {
    case FacetPoint::centroid:
      return (a + b + c) / 3.0;
    case FacetPoint::bounds_centre:
      return (glm::min(glm::min(a, b), c) + glm::max(glm::max(a, b), c)) / 2.0;
    case FacetPoint::corner_0:
      return a;
    case FacetPoint::corner_1:
      return b;
    case FacetPoint::corner_2:
      return c;
  }
  return a;
}

template <FacetPoint kind>
void compute_points(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const FacetFrame& frame,
                    std::size_t begin, std::size_t end, PointArrays& points) {
  parallel_ranges(end - begin, facets_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t facet = begin + first; facet < begin + last; ++facet) {
      const glm::uvec3& t = triangles[facet];
      const glm::dvec3 point =
          point_of<kind>(glm::dvec3(positions[t.x]), glm::dvec3(positions[t.y]), glm::dvec3(positions[t.z]));
      const glm::vec3 p((point - frame.origin) * frame.scale);
      points.x[facet] = p.x;
      points.y[facet] = p.y;
      points.z[facet] = p.z;
    }
  });
}

PointArrays points_of(const MeshView& mesh, FacetPoint point, const FacetFrame& frame) {
  PointArrays points;
  compute_facet_points(mesh.triangles, mesh.positions, point, frame, points);
  return points;
}

Box box_of(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  const glm::vec3 first = positions[triangles[0].x];
  Box box{first, first};
  for (const glm::uvec3& triangle : triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::vec3 position = positions[triangle[i]];
      box.lowest = glm::min(box.lowest, position);
      box.highest = glm::max(box.highest, position);
    }
  }
  return box;
}

}  // namespace

void compute_facet_points(std::span<const glm::uvec3> triangles, const StridedPositions& positions, FacetPoint point,
                          const FacetFrame& frame, PointArrays& points) {
  points.x.resize(triangles.size());
  points.y.resize(triangles.size());
  points.z.resize(triangles.size());
  compute_facet_points(triangles, positions, point, frame, 0, triangles.size(), points);
}

void compute_facet_points(std::span<const glm::uvec3> triangles, const StridedPositions& positions, FacetPoint point,
                          const FacetFrame& frame, std::size_t begin, std::size_t end, PointArrays& points) {
  switch (point) {
    case FacetPoint::centroid:
      return compute_points<FacetPoint::centroid>(triangles, positions, frame, begin, end, points);
    case FacetPoint::bounds_centre:
      return compute_points<FacetPoint::bounds_centre>(triangles, positions, frame, begin, end, points);
    case FacetPoint::corner_0:
      return compute_points<FacetPoint::corner_0>(triangles, positions, frame, begin, end, points);
    case FacetPoint::corner_1:
      return compute_points<FacetPoint::corner_1>(triangles, positions, frame, begin, end, points);
    case FacetPoint::corner_2:
      return compute_points<FacetPoint::corner_2>(triangles, positions, frame, begin, end, points);
  }
}

PointArrays facet_centroids(const MeshView& mesh, const FacetFrame& frame) {
  return points_of(mesh, FacetPoint::centroid, frame);
}

PointArrays facet_bounds_centres(const MeshView& mesh, const FacetFrame& frame) {
  return points_of(mesh, FacetPoint::bounds_centre, frame);
}

PointArrays facet_corners(const MeshView& mesh, int i, const FacetFrame& frame) {
  constexpr FacetPoint corners[3] = {FacetPoint::corner_0, FacetPoint::corner_1, FacetPoint::corner_2};
  return points_of(mesh, corners[i], frame);
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

glm::vec3 Box::centre() const {
  return glm::vec3((glm::dvec3(lowest) + glm::dvec3(highest)) / 2.0);
}

float Box::radius() const {
  return static_cast<float>(glm::length(glm::dvec3(highest) - glm::dvec3(lowest)) / 2.0);
}

Box facet_bounds(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  if (triangles.empty()) return {};
  const auto box_of_range = [&](const tbb::blocked_range<std::size_t>& range, const Box& box) {
    const Box here = box_of(triangles.subspan(range.begin(), range.size()), positions);
    return Box{glm::min(box.lowest, here.lowest), glm::max(box.highest, here.highest)};
  };
  const auto both = [](const Box& a, const Box& b) {
    return Box{glm::min(a.lowest, b.lowest), glm::max(a.highest, b.highest)};
  };
  const Box first{positions[triangles[0].x], positions[triangles[0].x]};
  const tbb::blocked_range<std::size_t> all(0, triangles.size(), facets_per_task);
  return triangles.size() <= facets_per_task ? box_of_range(all, first)
                                             : tbb::parallel_reduce(all, first, box_of_range, both);
}

Box facet_bounds(const MeshView& mesh) {
  return facet_bounds(mesh.triangles, mesh.positions);
}

}  // namespace facetsort
