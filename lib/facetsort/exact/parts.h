// Internal to exact: convex parts of facets, and cutting them in two.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/exact/points.h"
#include "facetsort/facets/pieces.h"

namespace facetsort::exact_internal {

// What an edge of a part lies on: an edge of its facet, by the corner opposite to it, or a plane.
using Line = std::uint32_t;
inline constexpr Line facet_edge = 0x80000000u;
inline bool is_facet_edge(Line line) { return (line & facet_edge) != 0; }

// A corner of a part, and the line of the edge from it to the next corner.
struct PartCorner {
  PointId point;
  Line line;
};

// A convex polygon in a facet's plane, wound as the facet is; the whole facet where it has no cuts.
struct Part {
  FacetId facet;
  std::uint32_t first_corner, corner_count;
  std::uint32_t first_cut, cut_count;  // the planes of its edges that are not the facet's
};

struct PartList {
  std::vector<Part> parts;
  std::vector<PartCorner> corners;
  std::vector<Cut> cuts;

  std::span<const PartCorner> corners_of(const Part& part) const {
    return std::span(corners).subspan(part.first_corner, part.corner_count);
  }
  std::span<const Cut> cuts_of(const Part& part) const {
    return std::span(cuts).subspan(part.first_cut, part.cut_count);
  }
  void add(FacetId facet, std::span<const PartCorner> loop, std::span<const Cut> part_cuts);
  // Forgets all but the first `count` parts.
  void truncate(std::size_t count) {
    if (count == parts.size()) return;
    corners.resize(parts[count].first_corner);
    cuts.resize(parts[count].first_cut);
    parts.resize(count);
  }
  std::size_t memory_bytes() const { return bytes_of(parts, corners, cuts); }
};

// A part on its own, while it is being cut.
struct Polygon {
  std::vector<PartCorner> corners;
  std::vector<Cut> cuts;
};

// Drops the cuts whose planes no longer bound the polygon.
void keep_bounding_cuts(Polygon& polygon);

// The vertices of the edge of the facet that `line` is, smaller first. Precondition: is_facet_edge(line).
std::pair<PointId, PointId> edge_vertices(const PointSpace& space, FacetId facet, Line line);

Polygon whole_facet(const PointSpace& space, FacetId facet);

// Adds the point where a plane meets the edge of a part of `facet` that lies on `line`, and parts that edge's ends.
PointId meeting_point(Points& points, FacetId facet, Line line, PlaneId plane);

// Cuts `polygon` of `facet` by a plane and returns true, or returns false where the plane does not part
// it; new points are added to `points`. `sides` is scratch.
bool cut_in_two(Points& points, FacetId facet, const Polygon& polygon, PlaneId plane, Polygon& front, Polygon& back,
                std::vector<int>& sides);

// Distinct points, by definition, that are corners of the parts and have ids from `first` on.
std::size_t count_new_corners(const Points& points, const PartList& parts, std::size_t first);

}  // namespace facetsort::exact_internal
