#include "facetsort/plan/convex_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <tuple>

namespace facetsort {
namespace {

// Of a computed distance, angle or radius: many times what doubles lose in the few steps that lead to one.
constexpr double rounding = 1e-12;

Sphere sphere_of(const glm::dvec3& lowest, const glm::dvec3& highest) {
  const double size = glm::length(glm::max(glm::abs(lowest), glm::abs(highest)));
  return {(lowest + highest) / 2.0, glm::length(highest - lowest) / 2 + rounding * size};
}

// A sphere as it is seen from a point: half the angle of its cone, and how far off its direction may be.
struct Cone {
  double half_angle, error;
};

// `size`: of the coordinates that were subtracted. An eye in the sphere, or nearly, sees it all around.
Cone cone_of(double radius, double distance, double size) {
  constexpr double half_turn = 3.141592653589793;
  const double lost = rounding * size, farthest = radius + lost, nearest = distance - lost;
  if (!(farthest < nearest)) return {half_turn, 0};
  return {std::asin(farthest / nearest), lost / nearest};
}

class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), std::uint32_t{0}); }

  std::uint32_t root(std::uint32_t member) {
    while (parent_[member] != member) member = parent_[member] = parent_[parent_[member]];
    return member;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

// The first vertex used at each one's position.
std::vector<std::uint32_t> first_at_position(const MeshView& mesh) {
  const auto key = [&](std::uint32_t vertex) {
    const glm::vec3 p = mesh.positions[vertex] + glm::vec3(0);  // -0 becomes 0
    return std::make_tuple(p.x, p.y, p.z, vertex);
  };
  std::vector<std::uint32_t> used;
  used.reserve(3 * mesh.facet_count());
  for (const glm::uvec3& triangle : mesh.triangles) used.insert(used.end(), {triangle.x, triangle.y, triangle.z});
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::sort(used.begin(), used.end(), [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
  std::vector<std::uint32_t> first(mesh.vertex_count());
  for (std::size_t i = 0; i < used.size(); ++i) {
    const bool same = i > 0 && mesh.positions[used[i]] == mesh.positions[used[i - 1]];
    first[used[i]] = same ? first[used[i - 1]] : used[i];
  }
  return first;
}

}  // namespace

Sphere bounding_sphere(const MeshView& mesh) {
  glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest = -lowest;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 corner(mesh.positions[triangle[i]]);
      lowest = glm::min(lowest, corner);
      highest = glm::max(highest, corner);
    }
  }
  return sphere_of(lowest, highest);
}

bool are_apart(const Sphere& first, const Sphere& second, const glm::vec4& eye) {
  const glm::dvec3 from(eye);
  if (eye.w == 0) {
    const glm::dvec3 between = second.centre - first.centre;
    const double across = glm::length(glm::cross(between, from / glm::length(from)));
    const double size = glm::length(first.centre) + glm::length(second.centre);
    return across - rounding * size > first.radius + second.radius;
  }
  const glm::dvec3 a = first.centre - from, b = second.centre - from;
  const double size = glm::length(from);
  const Cone first_cone = cone_of(first.radius, glm::length(a), size + glm::length(first.centre));
  const Cone second_cone = cone_of(second.radius, glm::length(b), size + glm::length(second.centre));
  const double angle = std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
  const double error = first_cone.error + second_cone.error + rounding;
  return angle - error > first_cone.half_angle + second_cone.half_angle;
}

ConvexParts ConvexParts::find(const MeshView& mesh, const GeometryFacts& facts) {
  ConvexParts parts;
  const std::size_t count = facts.convex_closed_components;
  if (facts.convex_closed_facets != mesh.facet_count() || count == 0 || count > most_parts) return parts;
  const std::vector<std::uint32_t> first = first_at_position(mesh);
  Sets sets(mesh.vertex_count());
  for (const glm::uvec3& triangle : mesh.triangles) {
    sets.join(first[triangle.x], first[triangle.y]);
    sets.join(first[triangle.y], first[triangle.z]);
  }
  std::map<std::uint32_t, std::vector<glm::uvec3>> triangles;
  for (const glm::uvec3& triangle : mesh.triangles) triangles[sets.root(first[triangle.x])].push_back(triangle);
  if (triangles.size() != count) return parts;
  for (const auto& [root, of_part] : triangles) {
    MeshView part;
    part.positions = mesh.positions;
    part.triangles = of_part;
    parts.spheres_.push_back(bounding_sphere(part));
  }
  return parts;
}

bool ConvexParts::are_apart_from(const glm::vec4& eye) const {
  for (std::size_t i = 0; i < spheres_.size(); ++i) {
    for (std::size_t j = i + 1; j < spheres_.size(); ++j) {
      if (!are_apart(spheres_[i], spheres_[j], eye)) return false;
    }
  }
  return !spheres_.empty();
}

}  // namespace facetsort
