// Internal to exact: points that facets and cuts define, and signs on them that are never wrong.
//
// A point is a vertex of the mesh, or where a cut's plane meets an edge of the mesh, or where the planes of three
// facets meet. Such a point is rational in the float32 input and is never rounded in a decision: a double stands for
// it, with a bound on its error, in a filter, and integers where the filter is undecided.
#pragma once

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::exact_internal {

inline double sum_of_magnitudes(const glm::dvec3& v) {
  return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

using FacetId = std::uint32_t;
using PointId = std::uint32_t;
using PlaneId = std::uint32_t;

// How a point is defined. Vertices stand for all vertices at their position (identify_positions).
struct PointDefinition {
  enum Kind : std::uint32_t { edge_and_plane, three_planes } kind;
  // edge_and_plane: two vertices, smaller first, and a plane that parts them strictly.
  // three_planes: three planes, smallest first, that meet in one point.
  std::uint32_t a, b, c;

  // Where three planes meet, in any order.
  static PointDefinition of_planes(PlaneId a, PlaneId b, PlaneId c);

  auto operator<=>(const PointDefinition&) const = default;
};

// Where the picture is seen from: a point (w = 1) or a direction (w = 0).
using Eye = glm::vec4;

// The mesh that points belong to, with what is shared by all of them.
struct PointSpace {
  MeshView mesh;
  std::vector<PointId> position_of_vertex;  // the smallest vertex at the same position
  std::vector<FacetId> plane_of_facet;      // the smallest facet known to lie in the same plane
  std::vector<unsigned char> faces_away;    // whether its normal is opposite to that facet's
  std::vector<std::uint32_t> around_begin;  // vertex: its facets in `around`, by position
  std::vector<FacetId> around;

  void find_facets_around();

  glm::vec3 position(PointId vertex) const { return mesh.positions[vertex]; }
  // By position; of a vertex that stands for it.
  std::span<const FacetId> facets_around(PointId vertex) const {
    return std::span(around).subspan(around_begin[vertex], around_begin[vertex + 1] - around_begin[vertex]);
  }
  // Whether visit(facet) returns true for some facet with an edge of two vertices; calls it until it does. Such facets
  // are around both ends, of which one may have very many.
  template <typename Visit>
  bool any_facet_with_edge(PointId a, PointId b, const Visit& visit) const {
    if (facets_around(a).size() > facets_around(b).size()) std::swap(a, b);
    const std::span<const FacetId> facets = facets_around(a);
    return std::any_of(facets.begin(), facets.end(), [&](FacetId facet) {
      return (corner(facet, 0) == b || corner(facet, 1) == b || corner(facet, 2) == b) && visit(facet);
    });
  }
  PointId corner(FacetId facet, int i) const { return position_of_vertex[mesh.triangles[facet][i]]; }
};

// Points and planes by id. Points below the mesh's vertex count are vertices, planes below its facet count are those of
// facets; the rest are added. They may stand on those of a base, whose ids they share and which must not grow
// meanwhile. Reading is thread-safe.
class Points {
 public:
  explicit Points(const PointSpace& space)
      : space_(&space), first_(space.mesh.vertex_count()), first_plane_(space.mesh.facet_count()) {}
  explicit Points(const Points* base)
      : space_(base->space_), base_(base), first_(base->size()), first_plane_(base->plane_count()) {}

  PointId add(const PointDefinition& definition);
  PlaneId add_plane(const CutPlane& plane);
  // Forgets the points added after the first `size`.
  void truncate(std::size_t size) { made_.resize(size - first_); }
  // And the planes added after the first `planes`.
  void truncate(std::size_t size, std::size_t planes) {
    truncate(size);
    planes_.resize(planes - first_plane_);
    third_points_.resize(planes - first_plane_);
  }

  std::size_t size() const { return first_ + made_.size(); }
  std::size_t plane_count() const { return first_plane_ + planes_.size(); }
  std::span<const CutPlane> added_planes() const { return planes_; }
  std::size_t memory_bytes() const { return bytes_of(made_, planes_, third_points_); }
  const PointSpace& space() const { return *space_; }
  bool is_vertex(PointId point) const { return point < space_->mesh.vertex_count(); }
  // Precondition: not a vertex.
  const PointDefinition& definition(PointId point) const { return made(point).definition; }

  // Nearest doubles, up to `error` in each coordinate (0 for vertices).
  glm::dvec3 position(PointId point) const {
    return is_vertex(point) ? glm::dvec3(space_->position(point)) : made(point).position;
  }
  double error(PointId point) const { return is_vertex(point) ? 0.0 : made(point).error; }
  // The point rounded to float32: the same bits wherever the point is the same, however it is defined.
  glm::vec3 rounded(PointId point) const;

  // Whether two are the same point, exactly: cuts of several facets may define one in several ways.
  bool coincide(PointId a, PointId b) const;
  // Sign of det[b - a, c - a, d - a], exactly.
  int orientation(PointId a, PointId b, PointId c, PointId d) const;
  // The same with the eye for d: which way round a, b, c are seen, +1 for counter-clockwise.
  int turn(PointId a, PointId b, PointId c, const Eye& eye) const;
  // The side of the plane that the point is on, +1 for that of its normal.
  int side(PlaneId plane, PointId point) const;

  // What defines a plane.
  CutPlane plane(PlaneId id) const {
    if (id >= first_plane_) return planes_[id - first_plane_];
    if (id >= space_->mesh.facet_count()) return base_->plane(id);
    const glm::uvec3& facet = space_->mesh.triangles[id];
    return {facet.x, facet.y, facet.z};
  }
  // Three points of a plane in double; the third up to `error` in each coordinate.
  struct PlaneCorners {
    glm::dvec3 a, b, c;
    double error;
  };
  PlaneCorners corners(PlaneId plane) const {
    if (plane >= space_->mesh.facet_count()) return corners_of_added(plane);
    const glm::uvec3& facet = space_->mesh.triangles[plane];
    return {glm::dvec3(space_->position(facet.x)), glm::dvec3(space_->position(facet.y)),
            glm::dvec3(space_->position(facet.z)), 0};
  }
  // One id for the planes of facets known to lie in the same.
  PlaneId same_plane(PlaneId plane) const {
    return plane < space_->mesh.facet_count() ? space_->plane_of_facet[plane] : plane;
  }

 private:
  struct Made {
    PointDefinition definition;
    glm::dvec3 position;
    double error;
  };

  // The third point of an added plane in double.
  struct ThirdPoint {
    glm::dvec3 position;
    double error;
  };

  const Made& made(PointId point) const { return point < first_ ? base_->made(point) : made_[point - first_]; }
  PlaneCorners corners_of_added(PlaneId plane) const;
  bool known_vertex_in_plane(PointId vertex, PlaneId plane) const;
  bool known_in_plane(PointId point, PlaneId plane) const;
  bool known_collinear(PointId a, PointId b, PointId c) const;

  const PointSpace* space_;
  const Points* base_ = nullptr;
  std::size_t first_;        // id of made_[0]
  std::size_t first_plane_;  // id of planes_[0]
  std::vector<Made> made_;
  std::vector<CutPlane> planes_;
  std::vector<ThirdPoint> third_points_;  // of each
};

// Adds points, each definition once.
class DistinctPoints {
 public:
  explicit DistinctPoints(Points& points) : points_(points) {}

  // Takes the points that there are for added ones.
  void know_all() {
    for (auto i = static_cast<PointId>(points_.space().mesh.vertex_count()); i < points_.size(); ++i) {
      ids_.try_emplace(points_.definition(i), i);
    }
  }

  PointId id_of(const PointDefinition& definition) {
    const auto [place, is_new] = ids_.try_emplace(definition, 0);
    if (is_new) place->second = points_.add(definition);
    return place->second;
  }

 private:
  Points& points_;
  std::map<PointDefinition, PointId> ids_;
};

}  // namespace facetsort::exact_internal
