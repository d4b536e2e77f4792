// Internal to exact: the parts of a cycle and of what they are cut into, as the eye sees them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/visibility.h"

namespace facetsort::exact_internal {

// A plane in double: dot(normal, p) + offset tells the side of a place p.
struct RoundedPlane {
  glm::dvec3 normal;
  double offset;

  double operator()(const glm::dvec3& place) const { return glm::dot(normal, place) + offset; }
  RoundedPlane operator-() const { return {-normal, -offset}; }
};

// Members of a cycle and their halves, by number. Of every part there are its corners in double, relative to an origin,
// which has to be the eye where the eye is a point; and the planes through the eye and each of its edges. With them a
// filter nearly always tells whether two parts overlap on the screen.
class CycleParts {
 public:
  static constexpr std::uint32_t none = 0xffffffffu;

  struct Part {
    FacetId facet;
    int facing;
    std::uint32_t member;      // the one that this is, or is a piece of: the number of its part
    std::uint32_t parent;      // none: a member
    std::uint32_t first_half;  // of the two that it was cut into, the one beyond the cut; the other follows. Or none
    std::uint32_t first_corner, corner_count, first_cut, cut_count;
    std::uint32_t cut_edge;    // of a half: its edge along the cut
    double reach, error;       // largest sum of the magnitudes of a corner's coordinates, and error of each
  };

  CycleParts(const Points& base, const Viewpoint& from, const glm::dvec3& origin)
      : points_(&base), from_(from), origin_(origin) {}

  std::uint32_t add_member(FacetId facet, int facing, std::span<const PartCorner> corners, std::span<const Cut> cuts) {
    const std::uint32_t number = static_cast<std::uint32_t>(parts_.size());
    return add(facet, facing, corners, cuts, number, none);
  }

  std::size_t count() const { return parts_.size(); }
  const Part& operator[](std::uint32_t part) const { return parts_[part]; }
  const Points& points() const { return points_; }
  Points take_points() { return std::move(points_); }
  std::span<const PartCorner> corners(std::uint32_t part) const {
    return std::span(corners_).subspan(parts_[part].first_corner, parts_[part].corner_count);
  }
  std::span<const Cut> cuts(std::uint32_t part) const {
    return std::span(cuts_).subspan(parts_[part].first_cut, parts_[part].cut_count);
  }
  // Corners relative to the origin.
  std::span<const glm::dvec3> places(std::uint32_t part) const {
    return std::span(places_).subspan(parts_[part].first_corner, parts_[part].corner_count);
  }

  // Cuts a part along the plane of a facet, of which `facing` is the eye's side, or returns false where that does not
  // part it.
  bool halve(std::uint32_t part, FacetId plane, int facing);
  // Takes back the last halve(), which was of `part`.
  void undo_halve(std::uint32_t part);

  // Exact: whether two parts of different planes overlap as seen from the eye.
  bool overlap(std::uint32_t a, std::uint32_t b) const;
  // The same of both halves of `parent`, which overlaps `other`: 1 where the one beyond the cut does, plus 2 where the
  // one before it does.
  int overlapping_halves(std::uint32_t parent, std::uint32_t other) const;

  bool in_one_plane(FacetId a, FacetId b) const { return points_.same_plane(a) == points_.same_plane(b); }
  // The plane of a facet, of which `facing` is the eye's side, positive on that side. Not finite where the facet is too
  // thin for double.
  RoundedPlane plane_towards_eye(FacetId facet, int facing) const;
  // The plane through the eye and two places.
  RoundedPlane plane_through_eye(const glm::dvec3& a, const glm::dvec3& b) const;

 private:
  enum class Overlap { no, yes, unknown };

  std::uint32_t add(FacetId facet, int facing, std::span<const PartCorner> corners, std::span<const Cut> cuts,
                    std::uint32_t member, std::uint32_t parent);
  double side_error(const Part& plane, const Part& of) const;
  Overlap overlap_by_edges(const Part& a, const Part& b) const;
  Overlap overlap_of_cut(const Part& part, const Part& half) const;
  SeenPart seen(const Part& part) const {
    return {part.facet, part.facing, std::span(loops_).subspan(part.first_corner, part.corner_count)};
  }

  Points points_;
  Viewpoint from_;
  glm::dvec3 origin_;
  std::vector<Part> parts_;
  // By corner; its edge leads to the next.
  std::vector<PartCorner> corners_;
  std::vector<PointId> loops_;
  std::vector<glm::dvec3> places_;
  std::vector<RoundedPlane> edge_planes_;  // positive inside
  std::vector<Cut> cuts_;
  std::size_t points_before_halve_ = 0;
  // Scratch.
  Polygon polygon_, front_, back_;
  std::vector<int> sides_;
};

}  // namespace facetsort::exact_internal
