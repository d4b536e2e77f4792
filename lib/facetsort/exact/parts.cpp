#include "facetsort/exact/parts.h"

#include <algorithm>

namespace facetsort::exact_internal {

void PartList::add(FacetId facet, std::span<const PartCorner> loop, std::span<const Cut> part_cuts) {
  parts.push_back({facet, static_cast<std::uint32_t>(corners.size()), static_cast<std::uint32_t>(loop.size()),
                   static_cast<std::uint32_t>(cuts.size()), static_cast<std::uint32_t>(part_cuts.size())});
  corners.insert(corners.end(), loop.begin(), loop.end());
  cuts.insert(cuts.end(), part_cuts.begin(), part_cuts.end());
}

void keep_bounding_cuts(Polygon& polygon) {
  std::erase_if(polygon.cuts, [&](const Cut& cut) {
    return std::none_of(polygon.corners.begin(), polygon.corners.end(),
                        [&](const PartCorner& corner) { return corner.line == cut.plane; });
  });
}

std::pair<PointId, PointId> edge_vertices(const PointSpace& space, FacetId facet, Line line) {
  const int opposite = static_cast<int>(line & ~facet_edge);
  return std::minmax({space.corner(facet, (opposite + 1) % 3), space.corner(facet, (opposite + 2) % 3)});
}

Polygon whole_facet(const PointSpace& space, FacetId facet) {
  Polygon polygon;
  for (int i = 0; i < 3; ++i) {
    polygon.corners.push_back({space.corner(facet, i), facet_edge | static_cast<Line>((i + 2) % 3)});
  }
  return polygon;
}

PointId meeting_point(Points& points, FacetId facet, Line line, PlaneId plane) {
  if (is_facet_edge(line)) {
    const auto [p, q] = edge_vertices(points.space(), facet, line);
    return points.add({PointDefinition::edge_and_plane, p, q, plane});
  }
  return points.add(PointDefinition::of_planes(points.same_plane(facet), line, plane));
}

bool cut_in_two(Points& points, FacetId facet, const Polygon& polygon, PlaneId plane, Polygon& front, Polygon& back,
                std::vector<int>& sides) {
  const std::size_t count = polygon.corners.size();
  sides.resize(count);
  for (std::size_t i = 0; i < count; ++i) sides[i] = points.side(plane, polygon.corners[i].point);
  if (std::find(sides.begin(), sides.end(), 1) == sides.end()) return false;
  if (std::find(sides.begin(), sides.end(), -1) == sides.end()) return false;

  front.corners.clear();
  back.corners.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const PartCorner corner = polygon.corners[i];
    const int here = sides[i], next = sides[(i + 1) % count];
    if (here >= 0) front.corners.push_back({corner.point, here == 0 && next < 0 ? plane : corner.line});
    if (here <= 0) back.corners.push_back({corner.point, here == 0 && next > 0 ? plane : corner.line});
    if (here * next < 0) {
      const PointId meeting = meeting_point(points, facet, corner.line, plane);
      front.corners.push_back({meeting, here > 0 ? plane : corner.line});
      back.corners.push_back({meeting, here < 0 ? plane : corner.line});
    }
  }
  front.cuts = back.cuts = polygon.cuts;
  front.cuts.push_back({plane, 1});
  back.cuts.push_back({plane, -1});
  keep_bounding_cuts(front);
  keep_bounding_cuts(back);
  return true;
}

std::size_t count_new_corners(const Points& points, const PartList& parts, std::size_t first) {
  std::vector<PointDefinition> definitions;
  for (const PartCorner& corner : parts.corners) {
    if (corner.point >= first) definitions.push_back(points.definition(corner.point));
  }
  std::sort(definitions.begin(), definitions.end());
  return static_cast<std::size_t>(std::unique(definitions.begin(), definitions.end()) - definitions.begin());
}

}  // namespace facetsort::exact_internal
