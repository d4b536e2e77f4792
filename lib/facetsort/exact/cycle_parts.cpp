#include "facetsort/exact/cycle_parts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace facetsort::exact_internal {
namespace {

constexpr double half_epsilon = std::numeric_limits<double>::epsilon() / 2;

}  // namespace

RoundedPlane CycleParts::plane_through_eye(const glm::dvec3& a, const glm::dvec3& b) const {
  if (from_.eye.w != 0) return {glm::cross(b, a), 0};
  const glm::dvec3 normal = glm::cross(glm::dvec3(from_.eye), b - a);
  return {normal, -glm::dot(normal, a)};
}

RoundedPlane CycleParts::plane_towards_eye(FacetId facet, int facing) const {
  const PointSpace& space = points_.space();
  const glm::uvec3 vertex = space.mesh.triangles[facet];
  const auto place = [&](PointId corner) { return glm::dvec3(space.position(corner)) - origin_; };
  const glm::dvec3 a = place(vertex.x), normal = glm::cross(place(vertex.y) - a, place(vertex.z) - a);
  const glm::dvec3 towards_eye = normal * (facing / glm::length(normal));
  return {towards_eye, -glm::dot(towards_eye, a)};
}

std::uint32_t CycleParts::add(FacetId facet, int facing, std::span<const PartCorner> corners,
                              std::span<const Cut> cuts, std::uint32_t member, std::uint32_t parent) {
  Part part{facet, facing, member, parent, none, static_cast<std::uint32_t>(corners_.size()),
            static_cast<std::uint32_t>(corners.size()), static_cast<std::uint32_t>(cuts_.size()),
            static_cast<std::uint32_t>(cuts.size()), 0, 0, 0};
  corners_.insert(corners_.end(), corners.begin(), corners.end());
  cuts_.insert(cuts_.end(), cuts.begin(), cuts.end());
  for (const PartCorner& corner : corners) {
    loops_.push_back(corner.point);
    places_.push_back(points_.position(corner.point) - origin_);
    const double reach = sum_of_magnitudes(places_.back());
    part.reach = std::max(part.reach, reach);
    part.error = std::max(part.error, points_.error(corner.point) + half_epsilon * reach);
  }
  for (std::uint32_t i = 0; i < part.corner_count; ++i) {
    const std::uint32_t next = i + 1 == part.corner_count ? 0 : i + 1;
    const RoundedPlane plane = plane_through_eye(places_[part.first_corner + i], places_[part.first_corner + next]);
    edge_planes_.push_back(facing > 0 ? plane : -plane);
  }
  parts_.push_back(part);
  return static_cast<std::uint32_t>(parts_.size() - 1);
}

bool CycleParts::halve(std::uint32_t number, FacetId facet, int facing) {
  const Part part = parts_[number];
  const PlaneId plane = points_.same_plane(facet);
  points_before_halve_ = points_.size();
  polygon_.corners.assign(corners(number).begin(), corners(number).end());
  polygon_.cuts.assign(cuts(number).begin(), cuts(number).end());
  if (!cut_in_two(points_, part.facet, polygon_, plane, front_, back_, sides_)) return false;
  const bool eye_in_front = (facing > 0) == (points_.space().faces_away[facet] == 0);
  parts_[number].first_half = static_cast<std::uint32_t>(parts_.size());
  for (const Polygon* half : {eye_in_front ? &back_ : &front_, eye_in_front ? &front_ : &back_}) {
    const std::uint32_t added = add(part.facet, part.facing, half->corners, half->cuts, part.member, number);
    const auto along_cut = std::find_if(half->corners.begin(), half->corners.end(),
                                        [&](const PartCorner& corner) { return corner.line == plane; });
    parts_[added].cut_edge = static_cast<std::uint32_t>(along_cut - half->corners.begin());
  }
  return true;
}

void CycleParts::undo_halve(std::uint32_t number) {
  const Part& first = parts_[parts_[number].first_half];
  points_.truncate(points_before_halve_);
  corners_.resize(first.first_corner);
  loops_.resize(first.first_corner);
  places_.resize(first.first_corner);
  edge_planes_.resize(first.first_corner);
  cuts_.resize(first.first_cut);
  parts_.resize(parts_[number].first_half);
  parts_[number].first_half = none;
}

// Bounds the error of an edge plane of a part at the corners of another.
double CycleParts::side_error(const Part& plane, const Part& of) const {
  if (from_.eye.w != 0) {
    return 32 * half_epsilon * plane.reach * plane.reach * of.reach +
           8 * plane.reach * (2 * plane.error * of.reach + of.error * plane.reach);
  }
  const double reach = plane.reach + of.reach;
  return sum_of_magnitudes(glm::dvec3(from_.eye)) *
         (32 * half_epsilon * plane.reach * reach + 8 * (2 * plane.error * reach + of.error * plane.reach));
}

// Whether the plane of some edge of `a` parts them, touching included.
CycleParts::Overlap CycleParts::overlap_by_edges(const Part& a, const Part& b) const {
  const double error = side_error(a, b);
  Overlap result = Overlap::yes;
  for (std::uint32_t i = a.first_corner; i < a.first_corner + a.corner_count; ++i) {
    double innermost = -std::numeric_limits<double>::infinity();
    for (std::uint32_t k = b.first_corner; k < b.first_corner + b.corner_count && innermost <= error; ++k) {
      innermost = std::max(innermost, edge_planes_[i](places_[k]));
    }
    if (innermost < -error) return Overlap::no;
    if (innermost <= error) result = Overlap::unknown;
  }
  return result;
}

// Whether `part` overlaps the inside of the cut that a half has, as the eye sees them.
CycleParts::Overlap CycleParts::overlap_of_cut(const Part& part, const Part& half) const {
  const std::uint32_t next = half.cut_edge + 1 == half.corner_count ? 0 : half.cut_edge + 1;
  const glm::dvec3 from = places_[half.first_corner + half.cut_edge], to = places_[half.first_corner + next];
  const double error = 2 * side_error(part, half);  // twice, for the rounding of what lies between the ends
  const std::uint32_t end = part.first_corner + part.corner_count;
  double enter = 0, leave = 1;
  for (std::uint32_t i = part.first_corner; i < end; ++i) {
    const double at_from = edge_planes_[i](from), at_to = edge_planes_[i](to);
    if (at_from < -error && at_to < -error) return Overlap::no;
    if (at_from < 0 && at_to > at_from) enter = std::max(enter, at_from / (at_from - at_to));
    if (at_to < 0 && at_from > at_to) leave = std::min(leave, at_from / (at_from - at_to));
  }
  if (!(enter < leave)) return Overlap::unknown;
  const glm::dvec3 middle = from + (0.5 * (enter + leave)) * (to - from);
  for (std::uint32_t i = part.first_corner; i < end; ++i) {
    if (!(edge_planes_[i](middle) > error)) return Overlap::unknown;
  }
  return Overlap::yes;
}

bool CycleParts::overlap(std::uint32_t a, std::uint32_t b) const {
  const Overlap by_a = overlap_by_edges(parts_[a], parts_[b]);
  if (by_a == Overlap::no) return false;
  const Overlap by_b = overlap_by_edges(parts_[b], parts_[a]);
  if (by_b == Overlap::no) return false;
  if (by_a == Overlap::yes && by_b == Overlap::yes && !from_.surrounded) return true;
  return hiding(points_, from_, seen(parts_[a]), seen(parts_[b])) != Hiding::none;
}

int CycleParts::overlapping_halves(std::uint32_t parent, std::uint32_t other) const {
  const std::uint32_t beyond = parts_[parent].first_half, before = beyond + 1;
  const RoundedPlane& cut = edge_planes_[parts_[before].first_corner + parts_[before].cut_edge];
  const double error = side_error(parts_[before], parts_[other]);
  bool may_be_beyond = false, may_be_before = false;
  for (const glm::dvec3& place : places(other)) {
    const double side = cut(place);
    may_be_beyond = may_be_beyond || side <= error;
    may_be_before = may_be_before || side >= -error;
  }
  if (!may_be_beyond) return 2;
  if (!may_be_before) return 1;
  switch (overlap_of_cut(parts_[other], parts_[before])) {
    case Overlap::yes: return 3;
    case Overlap::no: return overlap(beyond, other) ? 1 : 2;  // what they share is not parted
    case Overlap::unknown: break;
  }
  return (overlap(beyond, other) ? 1 : 0) + (overlap(before, other) ? 2 : 0);
}

}  // namespace facetsort::exact_internal
