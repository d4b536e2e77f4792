#include "vertex_rounding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t pixels_per_task = 4096;

// Half a unit in the last place of each of three coordinates is sqrt(3) / 2 units of the largest; the rest is room for
// what is computed in double.
constexpr double relative_rounding = 0x1p-23;
// The same for coordinates below the smallest normal float.
constexpr double smallest_rounding = 0x1p-148;
// Rounding in double of a ray, over the distance that it has come.
constexpr double ray_rounding = 0x1p-48;

glm::dvec3 unit_normal(const MeshView& mesh, std::uint32_t facet) {
  const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : glm::dvec3(0);
}

double distance_to_ray(const Ray& ray, const glm::dvec3& a, const glm::dvec3& b) {
  const auto across = [&](const glm::dvec3& p) {
    return p - ray.origin - glm::dot(p - ray.origin, ray.direction) * ray.direction;
  };
  return distance_to_segment(glm::dvec3(0), across(a), across(b));
}

// The smallest float that is no less.
float rounded_up(double value) {
  const auto nearest = static_cast<float>(value);
  return static_cast<double>(nearest) < value ? std::nextafter(nearest, std::numeric_limits<float>::infinity())
                                              : nearest;
}

}  // namespace

double vertex_rounding(const MeshView& mesh, std::uint32_t facet) {
  float largest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(mesh.corner(facet, i)[axis]));
  }
  return std::max(relative_rounding * static_cast<double>(largest), smallest_rounding);
}

double distance_to_segment(const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 edge = b - a;
  const double squared_length = glm::dot(edge, edge);
  const double along = squared_length > 0 ? std::clamp(glm::dot(point - a, edge) / squared_length, 0.0, 1.0) : 0.0;
  return glm::length(point - (a + along * edge));
}

PartedMesh::PartedMesh(const MeshView& mesh, const MeshView& drawn, std::span<const std::uint32_t> sources)
    : mesh_(mesh),
      drawn_(drawn),
      sources_(sources),
      corner_moves_(3 * drawn.facet_count()),
      first_triangle_(mesh.facet_count() + 1, 0) {
  for (std::uint32_t triangle = 0; triangle < drawn.facet_count(); ++triangle) {
    bool moves = false;
    for (int i = 0; i < 3; ++i) {
      corner_moves_[3 * triangle + static_cast<std::size_t>(i)] = !is_corner_of_source(triangle, i);
      moves |= !is_corner_of_source(triangle, i);
    }
    if (!moves) continue;
    triangles_.push_back(triangle);
    ++first_triangle_[sources[triangle] + 1];
  }
  std::partial_sum(first_triangle_.begin(), first_triangle_.end(), first_triangle_.begin());
  std::stable_sort(triangles_.begin(), triangles_.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return sources[a] < sources[b]; });
}

bool PartedMesh::is_corner_of_source(std::uint32_t triangle, int i) const {
  const std::uint32_t facet = sources_[triangle];
  const glm::vec3 corner = drawn_.corner(triangle, i);
  return corner == mesh_.corner(facet, 0) || corner == mesh_.corner(facet, 1) || corner == mesh_.corner(facet, 2);
}

// A triangle's points lie no farther from the facet's plane than its corners; along the ray that is more.
double PartedMesh::depth_rounding(std::uint32_t facet, const Ray& ray) const {
  return vertex_rounding(mesh_, facet) / std::abs(glm::dot(unit_normal(mesh_, facet), ray.direction));
}

void PartedMesh::widen_depth_errors(const View& view, FragmentLists& drawn_lists) const {
  const Camera camera(view);
  parallel_ranges(drawn_lists.offsets.size() - 1, pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      const Ray ray = camera.pixel_ray(static_cast<int>(pixel) % drawn_lists.width,
                                       static_cast<int>(pixel) / drawn_lists.width);
      for (std::size_t i = drawn_lists.offsets[pixel]; i < drawn_lists.offsets[pixel + 1]; ++i) {
        Fragment& fragment = drawn_lists.fragments[i];
        const unsigned char* const moves = &corner_moves_[3 * std::size_t{fragment.facet}];
        if (!moves[0] && !moves[1] && !moves[2]) continue;
        fragment.depth_error = rounded_up(static_cast<double>(fragment.depth_error) +
                                          depth_rounding(sources_[fragment.facet], ray));
      }
    }
  });
}

bool PartedMesh::is_explained(std::uint32_t facet, const Camera& camera, const Ray& ray) const {
  const double rounding = vertex_rounding(mesh_, facet);
  for (std::size_t t = first_triangle_[facet]; t < first_triangle_[facet + 1]; ++t) {
    const std::uint32_t triangle = triangles_[t];
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t next = (i + 1) % 3;
      if (!corner_moves_[3 * triangle + i] && !corner_moves_[3 * triangle + next]) continue;
      const glm::dvec3 a(drawn_.corner(triangle, static_cast<int>(i)));
      const glm::dvec3 b(drawn_.corner(triangle, static_cast<int>(next)));
      const double slack = ray_rounding * std::max(glm::length(a - ray.origin), glm::length(b - ray.origin));
      if (distance_to_ray(ray, a, b) <= rounding + slack) return true;
    }
  }
  if (!camera.perspective || first_triangle_[facet] == first_triangle_[facet + 1]) return false;
  const glm::dvec3 normal = unit_normal(mesh_, facet);
  const double depth = glm::dot(normal, glm::dvec3(mesh_.corner(facet, 0)) - ray.origin) /
                       glm::dot(normal, ray.direction);
  return std::abs(depth * glm::dot(ray.direction, camera.forward) - camera.near_distance) <= depth_rounding(facet, ray);
}

PartCoverage PartedMesh::compare_coverage(const View& view, const FragmentLists& mesh_lists,
                                          const FragmentLists& drawn_lists) const {
  const Camera camera(view);
  PartCoverage coverage;
  std::vector<std::uint32_t> facets, drawn, differing;
  for (std::size_t pixel = 0; pixel + 1 < mesh_lists.offsets.size(); ++pixel) {
    if (mesh_lists.pixel(pixel).size() == drawn_lists.pixel(pixel).size()) continue;
    facets.clear();
    drawn.clear();
    differing.clear();
    for (const Fragment& fragment : mesh_lists.pixel(pixel)) facets.push_back(fragment.facet);
    for (const Fragment& fragment : drawn_lists.pixel(pixel)) drawn.push_back(sources_[fragment.facet]);
    std::sort(facets.begin(), facets.end());
    std::sort(drawn.begin(), drawn.end());
    std::set_symmetric_difference(facets.begin(), facets.end(), drawn.begin(), drawn.end(),
                                  std::back_inserter(differing));
    const Ray ray =
        camera.pixel_ray(static_cast<int>(pixel) % mesh_lists.width, static_cast<int>(pixel) / mesh_lists.width);
    const bool explained = std::all_of(differing.begin(), differing.end(),
                                       [&](std::uint32_t facet) { return is_explained(facet, camera, ray); });
    ++(explained ? coverage.excused_pixels : coverage.miscovered_pixels);
  }
  return coverage;
}

}  // namespace facetsort
