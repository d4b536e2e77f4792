// Intersections: a bounding-volume hierarchy proposes pairs of facets, and two triangles meet exactly when an edge of
// one meets the other, which orientation signs decide (the tests are those of Guigue and Devillers 2003, "Fast and
// Robust Triangle-Triangle Overlap Test Using Orientation Predicates", taken edge by edge).
//
// Convexity: a closed surface that nowhere crosses or touches itself and has no reflex edge bounds a convex body
// (Tietze 1928 and Nakajima 1928: a closed connected set that is convex near each of its points is convex). So the
// intersecting pairs, found anyway, save the comparison of every corner with every facet's plane.
#include "facetsort/exact/facts.h"

#include <tbb/parallel_reduce.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <functional>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/facet_hierarchy.h"
#include "facetsort/exact/positions.h"
#include "facetsort/exact/predicates.h"

namespace facetsort {
namespace {

using namespace exact_internal;
using FacetId = std::uint32_t;
constexpr std::size_t grain = 1024;  // facets a task: tens of microseconds of predicates

// A facet's corners, and an id for each that is the same wherever the position is the same.
struct Triangle {
  std::array<glm::vec3, 3> corner;
  std::array<std::uint32_t, 3> position;
};

Triangle triangle_of(const MeshView& mesh, const std::vector<std::uint32_t>& position, std::size_t facet) {
  const glm::uvec3 t = mesh.triangles[facet];
  return {{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]},
          {position[t.x], position[t.y], position[t.z]}};
}

// Precondition: the segment pq, p != q, lies in the triangle's plane. Both closed.
bool coplanar_segment_meets_triangle(const glm::vec3& p, const glm::vec3& q, const std::array<glm::vec3, 3>& t) {
  int axis = 0;
  while (normal_sign(t[0], t[1], t[2], axis) == 0) ++axis;  // the triangle has area, so one axis shows it
  const int winding = normal_sign(t[0], t[1], t[2], axis);
  // Convex sets in the plane are apart only if a line along an edge of one of them separates them.
  for (int i = 0; i < 3; ++i) {
    const glm::vec3 &a = t[i], &b = t[(i + 1) % 3];
    if (normal_sign(a, b, p, axis) == -winding && normal_sign(a, b, q, axis) == -winding) return false;
  }
  const int side = normal_sign(p, q, t[0], axis);
  return side == 0 || normal_sign(p, q, t[1], axis) != side || normal_sign(p, q, t[2], axis) != side;
}

// Whether the closed segment pq, p != q, meets the closed triangle; p_side and q_side are the sides of its plane that
// the ends are on.
bool segment_meets_triangle(const glm::vec3& p, int p_side, const glm::vec3& q, int q_side,
                            const std::array<glm::vec3, 3>& t) {
  if (p_side * q_side > 0) return false;
  if (p_side == 0 && q_side == 0) return coplanar_segment_meets_triangle(p, q, t);
  const int s0 = orientation(p, q, t[0], t[1]);
  const int s1 = orientation(p, q, t[1], t[2]);
  if (s0 * s1 < 0) return false;
  const int s2 = orientation(p, q, t[2], t[0]);
  return s0 * s2 >= 0 && s1 * s2 >= 0;
}

// Sides of the plane of `plane` that the corners of `t` are on. Corners that the two share are known to lie in it.
std::array<int, 3> corner_sides(const Triangle& plane, const Triangle& t, const std::array<bool, 3>& shared) {
  std::array<int, 3> sides{};
  for (int i = 0; i < 3; ++i) {
    if (!shared[i]) sides[i] = orientation(plane.corner[0], plane.corner[1], plane.corner[2], t.corner[i]);
  }
  return sides;
}

// Whether all corners that are not shared lie strictly on one side.
bool strictly_on_one_side(const std::array<int, 3>& sides, const std::array<bool, 3>& shared) {
  bool above = true, below = true;
  for (int i = 0; i < 3; ++i) {
    above = above && (shared[i] || sides[i] > 0);
    below = below && (shared[i] || sides[i] < 0);
  }
  return above || below;
}

// Whether an edge of `edges`, one without shared corners, meets `t`.
bool free_edge_meets_triangle(const Triangle& edges, const std::array<int, 3>& sides, const std::array<bool, 3>& shared,
                              const Triangle& t) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    if (shared[i] || shared[j]) continue;
    if (segment_meets_triangle(edges.corner[i], sides[i], edges.corner[j], sides[j], t.corner)) return true;
  }
  return false;
}

// Whether two triangles with area that share the edge opposite to corner i of s and corner j of t are folded onto each
// other.
bool folded_along_edge(const Triangle& s, int i, const Triangle& t, int j) {
  const glm::vec3 &a = s.corner[(i + 1) % 3], &b = s.corner[(i + 2) % 3];
  if (orientation(a, b, s.corner[i], t.corner[j]) != 0) return false;
  for (int axis = 0; axis < 3; ++axis) {
    const int side = normal_sign(a, b, s.corner[i], axis);
    if (side != 0) return normal_sign(a, b, t.corner[j], axis) == side;
  }
  assert(false && "a triangle with area has a normal");
  return false;
}

// Whether two triangles with area meet anywhere but in the corner or the edge they share.
bool intersect_apart_from_shared(const Triangle& s, const Triangle& t) {
  std::array<bool, 3> s_shared{}, t_shared{};
  int shared_count = 0, s_free = 0, t_free = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      if (s.position[i] == t.position[j]) {
        s_shared[i] = t_shared[j] = true;
        ++shared_count;
      }
    }
  }
  if (shared_count == 3) return false;  // the whole triangle is shared
  if (shared_count == 2) {
    for (int i = 0; i < 3; ++i) {
      if (!s_shared[i]) s_free = i;
      if (!t_shared[i]) t_free = i;
    }
    return folded_along_edge(s, s_free, t, t_free);
  }
  const std::array<int, 3> t_sides = corner_sides(s, t, t_shared);
  if (strictly_on_one_side(t_sides, t_shared)) return false;
  const std::array<int, 3> s_sides = corner_sides(t, s, s_shared);
  if (strictly_on_one_side(s_sides, s_shared)) return false;
  // With one shared corner the common part is star-shaped around it, and each of its rays ends on an edge opposite to
  // that corner: the edges at the corner need no test.
  return free_edge_meets_triangle(s, s_sides, s_shared, t) || free_edge_meets_triangle(t, t_sides, t_shared, s);
}

// Facets connected through shared edges, by position; facets with fewer than three distinct positions are left out.
struct Components {
  static constexpr FacetId none = 0xffffffffu;

  std::vector<FacetId> of_facet;      // the smallest facet of its component, or none
  std::vector<unsigned char> convex;  // by that facet: closed, consistently wound and without a reflex edge
};

FacetId find_root(std::vector<FacetId>& parent, FacetId facet) {
  while (parent[facet] != facet) {
    parent[facet] = parent[parent[facet]];
    facet = parent[facet];
  }
  return facet;
}

Components find_components(const MeshView& mesh, const std::vector<std::uint32_t>& position,
                           const std::vector<unsigned char>& degenerate) {
  struct HalfEdge {
    std::uint32_t lower, upper;  // positions
    FacetId facet;
    std::uint8_t opposite;  // corner of the facet
    bool upwards;           // the facet runs from lower to upper

    auto operator<=>(const HalfEdge&) const = default;
  };
  const std::size_t facets = mesh.facet_count();
  std::vector<FacetId> parent(facets);
  std::iota(parent.begin(), parent.end(), FacetId{0});
  std::vector<HalfEdge> half_edges;
  half_edges.reserve(3 * facets);
  Components components{std::vector<FacetId>(facets, Components::none), std::vector<unsigned char>(facets, 1)};
  for (std::size_t f = 0; f < facets; ++f) {
    const std::array<std::uint32_t, 3> p = triangle_of(mesh, position, f).position;
    if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0]) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = p[(i + 1) % 3], to = p[(i + 2) % 3];
      half_edges.push_back(
          {std::min(from, to), std::max(from, to), static_cast<FacetId>(f), static_cast<std::uint8_t>(i), from < to});
    }
  }
  tbb::parallel_sort(half_edges);

  const auto for_each_edge = [&](const auto& visit) {
    for (std::size_t begin = 0, end = 0; begin < half_edges.size(); begin = end) {
      while (end < half_edges.size() && half_edges[end].lower == half_edges[begin].lower &&
             half_edges[end].upper == half_edges[begin].upper) {
        ++end;
      }
      visit(begin, end);
    }
  };
  for_each_edge([&](std::size_t begin, std::size_t end) {
    for (const HalfEdge& half_edge : std::span(half_edges).subspan(begin + 1, end - begin - 1)) {
      const FacetId a = find_root(parent, half_edges[begin].facet), b = find_root(parent, half_edge.facet);
      parent[std::max(a, b)] = std::min(a, b);
    }
  });
  for (const HalfEdge& half_edge : half_edges) {
    components.of_facet[half_edge.facet] = find_root(parent, half_edge.facet);
  }
  for (std::size_t f = 0; f < facets; ++f) {
    // A facet without area has no plane to be in front of.
    if (components.of_facet[f] != Components::none && degenerate[f]) components.convex[components.of_facet[f]] = 0;
  }
  for_each_edge([&](std::size_t begin, std::size_t end) {
    const HalfEdge& first = half_edges[begin];
    unsigned char& convex = components.convex[components.of_facet[first.facet]];
    if (!convex) return;
    const HalfEdge& second = half_edges[end - 1];
    if (end - begin != 2 || first.upwards == second.upwards) {
      convex = 0;
      return;
    }
    const Triangle s = triangle_of(mesh, position, first.facet), t = triangle_of(mesh, position, second.facet);
    const bool same_triangle = s.position[first.opposite] == t.position[second.opposite];
    const bool reflex = orientation(s.corner[0], s.corner[1], s.corner[2], t.corner[second.opposite]) > 0;
    if (same_triangle || reflex) convex = 0;
  });
  return components;
}

struct PairCount {
  std::size_t pairs = 0;
  std::pair<FacetId, FacetId> first{0xffffffffu, 0xffffffffu};
};

// Counts intersecting pairs, and takes from `convex` the components that intersect themselves.
PairCount count_intersections(const MeshView& mesh, const std::vector<std::uint32_t>& position,
                              const FacetHierarchy& hierarchy, Components& components) {
  const std::size_t count = hierarchy.items().size();
  const auto add = [](const PairCount& a, const PairCount& b) {
    return PairCount{a.pairs + b.pairs, std::min(a.first, b.first)};
  };
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, grain), PairCount{},
      [&](const tbb::blocked_range<std::size_t>& range, PairCount sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          const FacetId f = hierarchy.items()[i].facet;
          const Triangle s = triangle_of(mesh, position, f);
          hierarchy.for_each_later_overlap(i, [&](FacetId g) {
            if (!intersect_apart_from_shared(s, triangle_of(mesh, position, g))) return;
            sum = add(sum, {1, std::minmax(f, g)});
            const FacetId component = components.of_facet[f];
            if (component != components.of_facet[g]) return;
            std::atomic_ref<unsigned char>(components.convex[component]).store(0, std::memory_order_relaxed);
          });
        }
        return sum;
      },
      add);
}

}  // namespace

GeometryFacts inspect_geometry(const MeshView& mesh) {
  const std::size_t facets = mesh.facet_count();
  GeometryFacts facts;
  const std::vector<unsigned char> degenerate = find_degenerate_facets(mesh);
  facts.degenerate_facets = static_cast<std::size_t>(std::count(degenerate.begin(), degenerate.end(), 1));

  const std::vector<std::uint32_t> position = identify_positions(mesh);
  Components components = find_components(mesh, position, degenerate);
  const PairCount intersections = count_intersections(mesh, position, hierarchy_of(mesh, degenerate), components);
  facts.intersecting_pairs = intersections.pairs;
  if (intersections.pairs > 0) {
    facts.first_intersecting[0] = intersections.first.first;
    facts.first_intersecting[1] = intersections.first.second;
  }

  for (std::size_t f = 0; f < facets; ++f) {
    const FacetId component = components.of_facet[f];
    if (component == Components::none || !components.convex[component]) continue;
    facts.convex_closed_components += component == f;
    ++facts.convex_closed_facets;
  }
  return facts;
}

}  // namespace facetsort
