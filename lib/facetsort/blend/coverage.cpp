#include "facetsort/blend/coverage.h"

#include <algorithm>
#include <cmath>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::blend_internal {
namespace {

constexpr std::size_t vertices_per_task = 16384;

// What one rounding to double costs, relatively. The factors in front of it below count roundings along the longest
// path and are rounded up; second-order terms are far below what the rounding up leaves.
constexpr double rounding = 0x1p-53;
// Of X, Y and W against the magnitude of their terms: difference, product, three sums, and the rounding of the input.
constexpr double projection_roundings = 8 * rounding;
// Of an edge function against the product of its corners' magnitudes: product, difference, and evaluation at a pixel.
constexpr double edge_roundings = 8 * rounding;

double largest_component(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// A corner relative to an origin on the screen, its magnitude over the extent, and the rounding of that.
struct RelativeVertex {
  double x, y, w, magnitude, error;
};

// How RelativeVertex::error follows from `reach`.
double relative_error_factor(const ViewBounds& bounds, const glm::dvec2& origin, double extent) {
  return projection_roundings *
         (bounds.x + bounds.y + (std::abs(origin.x) + std::abs(origin.y) + extent) * bounds.w);
}

RelativeVertex relative_vertex(const ProjectedVertex& vertex, const glm::dvec2& origin, double extent,
                               double error_factor) {
  const double x = vertex.x - origin.x * vertex.w;
  const double y = vertex.y - origin.y * vertex.w;
  return {x, y, vertex.w, std::abs(x) + std::abs(y) + extent * std::abs(vertex.w), error_factor * vertex.reach};
}

// Every term of E is a product of one component of each corner, so the products of magnitudes bound it.
double edge_error(const RelativeVertex& p, const RelativeVertex& q) {
  return p.error * q.magnitude + p.magnitude * q.error + edge_roundings * p.magnitude * q.magnitude;
}

// E_i at one pixel centre, and its error.
struct EdgeValues {
  double value[3], error[3];
};

EdgeValues edges_at_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y) {
  const glm::dvec2 centre(x + 0.5, y + 0.5);
  const double factor = relative_error_factor(projected.bounds, centre, 0);
  RelativeVertex corner[3];
  for (int i = 0; i < 3; ++i) {
    corner[i] = relative_vertex(projected.vertices[projected.mesh.triangles[facet][i]], centre, 0, factor);
  }
  EdgeValues edges;
  for (int i = 0; i < 3; ++i) {
    const RelativeVertex& p = corner[(i + 1) % 3];
    const RelativeVertex& q = corner[(i + 2) % 3];
    edges.value[i] = -facing * (p.x * q.y - p.y * q.x);
    edges.error[i] = edge_error(p, q);
  }
  return edges;
}

glm::dmat3 camera_rows(const Camera& camera) { return {camera.row_x, camera.row_y, camera.row_w}; }

int clamp_pixel(double value, int highest) {
  return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(highest) + 1.0));
}

}  // namespace

void ProjectedMesh::project(const MeshView& mesh_in, const View& view_in) {
  mesh = mesh_in;
  view = view_in;
  camera = Camera(view);
  bounds.offset_reach = std::max(std::abs(camera.offset.x), std::abs(camera.offset.y)) /
                        std::max(largest_component(camera.row_x), largest_component(camera.row_y));
  const auto bound = [&](const glm::dvec3& row, double offset) {
    const double from_offset = bounds.offset_reach > 0 ? std::abs(offset) / bounds.offset_reach : 0.0;
    return std::max(largest_component(row), from_offset);
  };
  bounds.x = bound(camera.row_x, camera.offset.x);
  bounds.y = bound(camera.row_y, camera.offset.y);
  bounds.w = bound(camera.row_w, camera.offset.z);

  vertices.resize(mesh.vertex_count());
  parallel_ranges(vertices.size(), vertices_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const glm::dvec3 q = glm::dvec3(mesh.positions[i]) - camera.eye;
      const double reach = std::abs(q.x) + std::abs(q.y) + std::abs(q.z) + bounds.offset_reach;
      vertices[i] = {glm::dot(camera.row_x, q) + camera.offset.x, glm::dot(camera.row_y, q) + camera.offset.y,
                     glm::dot(camera.row_w, q) + camera.offset.z, reach};
    }
  });
}

int facet_facing(const ProjectedMesh& projected, std::uint32_t facet) {
  const glm::vec3 a = projected.mesh.corner(facet, 0);
  const glm::vec3 b = projected.mesh.corner(facet, 1);
  const glm::vec3 c = projected.mesh.corner(facet, 2);
  // det[h0 h1 h2] is the determinant of the camera's rows times that of the corners relative to the eye.
  if (projected.camera.perspective) return side_of_plane(a, b, c, glm::vec4(projected.view.eye, 1.0f));

  // Orthographic: W is 1, and the determinant is that of the two edges from corner a, on the screen.
  const Camera& camera = projected.camera;
  const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a), ac = glm::dvec3(c) - glm::dvec3(a);
  const double determinant = glm::dot(camera.row_x, ab) * glm::dot(camera.row_y, ac) -
                             glm::dot(camera.row_y, ab) * glm::dot(camera.row_x, ac);
  const double magnitude = 2 * largest_component(camera.row_x) * largest_component(camera.row_y) *
                           (std::abs(ab.x) + std::abs(ab.y) + std::abs(ab.z)) *
                           (std::abs(ac.x) + std::abs(ac.y) + std::abs(ac.z));
  if (std::abs(determinant) > 2 * projection_roundings * magnitude) return determinant < 0 ? 1 : -1;
  return -exact_facing(a, b, c, projected.view.eye, camera_rows(camera), camera.offset);
}

FacetEdges facet_edges(const ProjectedMesh& projected, std::uint32_t facet, int facing, const glm::dvec2& origin,
                       double extent) {
  const double factor = relative_error_factor(projected.bounds, origin, extent);
  RelativeVertex corner[3];
  for (int i = 0; i < 3; ++i) {
    corner[i] = relative_vertex(projected.vertices[projected.mesh.triangles[facet][i]], origin, extent, factor);
  }
  FacetEdges edges;
  for (int i = 0; i < 3; ++i) {
    const RelativeVertex& p = corner[(i + 1) % 3];
    const RelativeVertex& q = corner[(i + 2) % 3];
    edges.a[i] = -facing * (p.y * q.w - p.w * q.y);
    edges.b[i] = -facing * (p.w * q.x - p.x * q.w);
    edges.c[i] = -facing * (p.x * q.y - p.y * q.x);
    edges.error[i] = edge_error(p, q);
  }
  return edges;
}

bool covers_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y) {
  const EdgeValues edges = edges_at_pixel(projected, facet, facing, x, y);
  for (int i = 0; i < 3; ++i) {
    if (edges.value[i] < -edges.error[i]) return false;
  }
  for (int i = 0; i < 3; ++i) {
    if (edges.value[i] > edges.error[i]) continue;
    const EdgeSigns signs =
        exact_edge_signs(projected.mesh.corner(facet, (i + 1) % 3), projected.mesh.corner(facet, (i + 2) % 3),
                         projected.view.eye, camera_rows(projected.camera), projected.camera.offset, x + 0.5, y + 0.5);
    const int side = signs.at_pixel != 0 ? signs.at_pixel : signs.x != 0 ? signs.x : signs.y;
    if (-facing * side < 0) return false;
  }
  return true;
}

PixelBox facet_pixels(const ProjectedMesh& projected, std::uint32_t facet) {
  const ViewBounds& bounds = projected.bounds;
  const double near_distance = projected.camera.near_distance;
  const ProjectedVertex* corner[3];
  int beyond_near = 0;
  for (int i = 0; i < 3; ++i) {
    corner[i] = &projected.vertices[projected.mesh.triangles[facet][i]];
    beyond_near += !projected.camera.perspective || corner[i]->w >= near_distance;
  }
  if (beyond_near == 0) return {};

  double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY, margin = 0;
  const auto include = [&](double x, double y, double w, double reach) {
    const double px = x / w, py = y / w;
    x0 = std::min(x0, px);
    x1 = std::max(x1, px);
    y0 = std::min(y0, py);
    y1 = std::max(y1, py);
    const double terms = bounds.x + bounds.y + (std::abs(px) + std::abs(py)) * bounds.w;
    margin = std::max(margin, 4 * projection_roundings * terms * reach / w);
  };
  for (int i = 0; i < 3; ++i) {
    const ProjectedVertex& p = *corner[i];
    const ProjectedVertex& q = *corner[(i + 1) % 3];
    const bool p_beyond = beyond_near == 3 || p.w >= near_distance;
    if (p_beyond) include(p.x, p.y, p.w, p.reach);
    if (beyond_near == 3 || p_beyond == (q.w >= near_distance)) continue;
    const double t = (near_distance - p.w) / (q.w - p.w);
    include(p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), near_distance, p.reach + q.reach);
  }
  const int width = projected.view.width, height = projected.view.height;
  PixelBox box;
  box.x0 = std::max(0, clamp_pixel(std::ceil(x0 - margin - 0.5), width));
  box.y0 = std::max(0, clamp_pixel(std::ceil(y0 - margin - 0.5), height));
  box.x1 = std::min(width - 1, clamp_pixel(std::floor(x1 + margin - 0.5), width));
  box.y1 = std::min(height - 1, clamp_pixel(std::floor(y1 + margin - 0.5), height));
  box.crosses_near = beyond_near != 3;
  return box;
}

PixelDepth depth_at_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y) {
  const EdgeValues edges = edges_at_pixel(projected, facet, facing, x, y);
  const Ray ray = projected.camera.pixel_ray(x, y);
  double weights = 0, error = 0, weighted_depth = 0, nearest = INFINITY, farthest = -INFINITY, reach = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 q = glm::dvec3(projected.mesh.corner(facet, i)) - ray.origin;
    const double depth = glm::dot(q, ray.direction);
    const double weight = std::max(edges.value[i], 0.0);
    weights += weight;
    weighted_depth += weight * depth;
    error += edges.error[i];
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
    reach = std::max(reach, std::abs(q.x) + std::abs(q.y) + std::abs(q.z));
  }
  // Wrong weights move the depth between the corners' depths; the corners' own depths carry a dot product's rounding.
  const double spread = farthest - nearest;
  const double of_corners = 2 * projection_roundings * reach;
  if (weights <= error) return {(nearest + farthest) / 2, spread + of_corners};
  return {weighted_depth / weights, spread * std::min(1.0, error / (weights - error)) + of_corners};
}

}  // namespace facetsort::blend_internal
