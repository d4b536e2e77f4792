#include "facetsort/scene/footprints.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace facetsort::scene_internal {
namespace {

// Chart coordinates are rounded by far less than this where the chart is as wide as the view.
constexpr double least_margin = 1e-6;

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// Some unit vector across a unit vector.
glm::dvec3 across(const glm::dvec3& direction) {
  const glm::dvec3 axis = std::abs(direction.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  return glm::normalize(glm::cross(direction, axis));
}

// Coordinates of a point of the view as the cube's face sees it: z from the eye to the face.
glm::dvec3 on_face(const glm::dvec3& p, std::uint32_t face) {
  const int axis = static_cast<int>(face / 2);
  return {p[(axis + 1) % 3], p[(axis + 2) % 3], face % 2 == 0 ? p[axis] : -p[axis]};
}

// The face through which the eye sees a point.
std::uint32_t face_of(const glm::dvec3& p) {
  int axis = 0;
  for (int i = 1; i < 3; ++i) {
    if (std::abs(p[i]) > std::abs(p[axis])) axis = i;
  }
  return static_cast<std::uint32_t>(2 * axis + (p[axis] < 0 ? 1 : 0));
}

// The part of a convex polygon where dot(normal, p) >= 0 (Sutherland and Hodgman, "Reentrant Polygon Clipping", 1974).
struct Polygon {
  std::array<glm::dvec3, 8> points;
  std::size_t size = 0;

  void add(const glm::dvec3& point) { points[size++] = point; }
};

Polygon clipped(const Polygon& polygon, const glm::dvec3& normal) {
  Polygon inside;
  for (std::size_t i = 0; i < polygon.size; ++i) {
    const glm::dvec3 &from = polygon.points[i], &to = polygon.points[(i + 1) % polygon.size];
    const double from_side = glm::dot(normal, from), to_side = glm::dot(normal, to);
    if (from_side >= 0) inside.add(from);
    if ((from_side < 0) != (to_side < 0)) inside.add(from + (to - from) * (from_side / (from_side - to_side)));
  }
  return inside;
}

// What a face shows of a triangle.
Polygon seen_through(const std::array<glm::dvec3, 3>& triangle, std::uint32_t face) {
  constexpr double wider = 1 + 1e-9;
  Polygon polygon;
  for (const glm::dvec3& corner : triangle) polygon.add(on_face(corner, face));
  for (const glm::dvec3& normal :
       {glm::dvec3(-1, 0, wider), glm::dvec3(1, 0, wider), glm::dvec3(0, -1, wider), glm::dvec3(0, 1, wider)}) {
    if (polygon.size > 0) polygon = clipped(polygon, normal);
  }
  return polygon;
}

// Whether rounding could matter: the triangle's plane passes by the eye at a small part of the way to its corners.
bool is_near_edge_on(const std::array<glm::dvec3, 3>& triangle) {
  const glm::dvec3 normal = glm::cross(triangle[1] - triangle[0], triangle[2] - triangle[0]);
  const double reach = std::max({largest(triangle[0]), largest(triangle[1]), largest(triangle[2])});
  return !(std::abs(glm::dot(normal, triangle[0])) > 1e-6 * glm::length(normal) * reach);
}

void include(Footprint& footprint, const glm::vec2& point) {
  footprint.lowest = glm::min(footprint.lowest, point);
  footprint.highest = glm::max(footprint.highest, point);
}

Footprint nothing(std::uint32_t chart) {
  return {glm::vec2(2), glm::vec2(-2), chart};
}

}  // namespace

Charts::Charts(const glm::vec4& eye, const Box& bounds) : orthographic_(eye.w == 0.0f) {
  const glm::dvec3 lowest(bounds.lowest), highest(bounds.highest), centre = 0.5 * lowest + 0.5 * highest;
  const double radius = glm::length(0.5 * highest - 0.5 * lowest);
  if (orthographic_) {
    single_ = true;
    origin_ = centre;
    const glm::dvec3 towards(eye);
    forward_ = -glm::normalize(towards / largest(towards));
    reach_ = radius > 0 ? radius : 1;
  } else {
    origin_ = glm::dvec3(eye);
    const glm::dvec3 to_centre = centre - origin_;
    const double distance = glm::length(to_centre);
    single_ = distance > 0 && distance >= 2 * radius;
    if (single_) {
      forward_ = to_centre / distance;
      const double sine = radius / distance;
      reach_ = radius > 0 ? sine / std::sqrt(1 - sine * sine) : 1;
    }
  }
  if (single_) {
    right_ = across(forward_);
    down_ = glm::cross(forward_, right_);
  }
  // Coordinates are ratios, rounded by a few 2^-53; a narrow chart makes more of that.
  const double rounding = orthographic_ ? largest(origin_) / reach_ : 1 / reach_;
  margin_ = static_cast<float>(std::min(4.0, least_margin + 1e-14 * rounding));
}

glm::dvec3 Charts::in_view(const glm::vec3& point) const {
  const glm::dvec3 p = glm::dvec3(point) - origin_;
  return {glm::dot(right_, p), glm::dot(down_, p), glm::dot(forward_, p)};
}

bool Charts::find_one(const Corners& corners, Footprint& footprint) const {
  footprint = nothing(0);
  if (single_) {
    for (const glm::vec3& corner : corners) {
      const glm::dvec3 p = in_view(corner);
      const double scale = 1 / (orthographic_ ? reach_ : reach_ * p.z);
      include(footprint, glm::vec2(glm::dvec2(p) * scale));
    }
  } else {
    const glm::dvec3 first = glm::dvec3(corners[0]) - origin_;
    footprint.chart = face_of(first);
    for (const glm::vec3& corner : corners) {
      const glm::dvec3 p = glm::dvec3(corner) - origin_;
      const glm::dvec3 q = on_face(p, footprint.chart);
      if (face_of(p) != footprint.chart || !(q.z > 0)) return false;
      include(footprint, glm::vec2(glm::dvec2(q) / q.z));
    }
  }
  footprint.lowest -= margin_;
  footprint.highest += margin_;
  return true;
}

void Charts::find_all(const Corners& corners, std::vector<Footprint>& footprints) const {
  Footprint footprint;
  if (find_one(corners, footprint)) return footprints.push_back(footprint);
  std::array<glm::dvec3, 3> triangle;
  for (int i = 0; i < 3; ++i) triangle[i] = glm::dvec3(corners[i]) - origin_;
  const bool covers_all = is_near_edge_on(triangle);
  for (std::uint32_t face = 0; face < most; ++face) {
    if (covers_all) {
      footprints.push_back({glm::vec2(-2), glm::vec2(2), face});
      continue;
    }
    const Polygon polygon = seen_through(triangle, face);
    if (polygon.size == 0) continue;
    footprint = nothing(face);
    for (std::size_t i = 0; i < polygon.size; ++i) {
      include(footprint, glm::vec2(glm::dvec2(polygon.points[i]) / polygon.points[i].z));
    }
    footprint.lowest -= margin_;
    footprint.highest += margin_;
    footprints.push_back(footprint);
  }
}

}  // namespace facetsort::scene_internal
