// Internal to blend: a mesh's vertices in homogeneous pixels and on the grid. One vertex a lane.
#if defined(FACETSORT_BLEND_PROJECT_VERTICES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef FACETSORT_BLEND_PROJECT_VERTICES_INL_H
#undef FACETSORT_BLEND_PROJECT_VERTICES_INL_H
#else
#define FACETSORT_BLEND_PROJECT_VERTICES_INL_H
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "facetsort/blend/coverage.h"
#include "facetsort/blend/facet_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using VertexTag = hn::CappedTag<double, 8>;
using VertexDoubles = hn::VFromD<VertexTag>;
using VertexFloatTag = hn::Rebind<float, VertexTag>;
using VertexGridTag = hn::Rebind<std::int32_t, VertexTag>;
constexpr std::size_t most_vertices = 8;

struct ProjectedVertices {
  VertexDoubles x, y, w, reach;
};

HWY_INLINE ProjectedVertices project_positions(const Camera& camera, const ViewBounds& bounds, const float* positions) {
  const VertexTag d;
  hn::VFromD<VertexFloatTag> px, py, pz;
  hn::LoadInterleaved3(VertexFloatTag(), positions, px, py, pz);
  const VertexDoubles qx = hn::Sub(hn::PromoteTo(d, px), hn::Set(d, camera.eye.x));
  const VertexDoubles qy = hn::Sub(hn::PromoteTo(d, py), hn::Set(d, camera.eye.y));
  const VertexDoubles qz = hn::Sub(hn::PromoteTo(d, pz), hn::Set(d, camera.eye.z));
  const auto along = [&](const glm::dvec3& row, double offset) HWY_ATTR {
    const VertexDoubles sum = hn::Add(hn::Mul(hn::Set(d, row.x), qx), hn::Mul(hn::Set(d, row.y), qy));
    return hn::Add(hn::Add(sum, hn::Mul(hn::Set(d, row.z), qz)), hn::Set(d, offset));
  };
  const VertexDoubles terms = hn::Add(hn::Add(hn::Abs(qx), hn::Abs(qy)), hn::Abs(qz));
  return {along(camera.row_x, camera.offset.x), along(camera.row_y, camera.offset.y),
          along(camera.row_w, camera.offset.z), hn::Add(terms, hn::Set(d, bounds.offset_reach))};
}

// `points`: as many x and y in turns as a vector has lanes.
HWY_INLINE void store_grid_points(const ProjectedVertices& vertices, const ViewBounds& bounds, double near_distance,
                                  std::int32_t* points) {
  // Below this a difference of two coordinates is an int32.
  constexpr double grid_reach = 0x1p30 - 1;
  const VertexTag d;
  const VertexDoubles units_per_pixel = hn::Set(d, 1 << grid_bits);
  const VertexDoubles inverse = hn::Div(hn::Set(d, 1.0), vertices.w);
  const VertexDoubles x = hn::Mul(vertices.x, inverse), y = hn::Mul(vertices.y, inverse);
  const VertexDoubles abs_x = hn::Abs(x), abs_y = hn::Abs(y);
  const VertexDoubles terms =
      hn::Add(hn::Set(d, bounds.x + bounds.y), hn::Mul(hn::Add(abs_x, abs_y), hn::Set(d, bounds.w)));
  const VertexDoubles error =
      hn::Mul(hn::Mul(hn::Set(d, 4 * projection_roundings), terms), hn::Mul(vertices.reach, inverse));
  // A quarter of a unit for this error, a half for rounding to the grid. No number compares, so it is off the grid.
  const auto is_far_enough = hn::Ge(vertices.w, hn::Set(d, near_distance));
  const auto is_close = hn::Lt(hn::Mul(hn::Max(abs_x, abs_y), units_per_pixel), hn::Set(d, grid_reach));
  const auto is_certain = hn::Lt(hn::Mul(error, units_per_pixel), hn::Set(d, 0.25));
  const auto is_on_grid = hn::And(is_far_enough, hn::And(is_close, is_certain));
  const auto on_grid = [&](VertexDoubles pixels) HWY_ATTR {
    const VertexDoubles units = hn::Floor(hn::Add(hn::Mul(pixels, units_per_pixel), hn::Set(d, 0.5)));
    return hn::DemoteTo(VertexGridTag(), hn::IfThenElse(is_on_grid, units, hn::Set(d, double{off_grid})));
  };
  hn::StoreInterleaved2(on_grid(x), on_grid(y), VertexGridTag(), points);
}

void ProjectVertices(ProjectedMesh& projected, std::size_t begin, std::size_t end) {
  const VertexTag d;
  const std::size_t lanes = hn::Lanes(d);
  const std::span<const glm::vec3> positions = projected.mesh.positions;
  // The last vertices, where they are fewer than a vector has lanes.
  glm::vec3 positions_copy[most_vertices] = {};
  ProjectedVertex vertices_copy[most_vertices];
  GridPoint points_copy[most_vertices];
  for (std::size_t first = begin; first < end; first += lanes) {
    const std::size_t count = std::min(lanes, end - first);
    const bool is_whole = count == lanes;
    if (!is_whole) std::copy_n(positions.begin() + static_cast<std::ptrdiff_t>(first), count, positions_copy);
    const glm::vec3* from = is_whole ? &positions[first] : positions_copy;
    ProjectedVertex* vertices = is_whole ? &projected.vertices[first] : vertices_copy;
    GridPoint* points = is_whole ? &projected.grid_points[first] : points_copy;

    const ProjectedVertices found = project_positions(projected.camera, projected.bounds, &from->x);
    hn::StoreInterleaved4(found.x, found.y, found.w, found.reach, d, &vertices->x);
    store_grid_points(found, projected.bounds, projected.camera.near_distance, &points->x);
    if (is_whole) continue;
    std::copy_n(vertices_copy, count, &projected.vertices[first]);
    std::copy_n(points_copy, count, &projected.grid_points[first]);
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per target
