#include "facetsort/exact/triangulation.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

namespace facetsort::exact_internal {
namespace {

// A point on a line that several polygons share: an edge of the mesh (by its vertices), or the trace of a plane in a
// facet. `along` is its place on the line.
struct PointOnLine {
  std::uint32_t first, second;
  double along;
  PointId point;

  auto key() const { return std::tie(first, second); }
  bool operator<(const PointOnLine& other) const {
    return std::tie(first, second, along, point) < std::tie(other.first, other.second, other.along, other.point);
  }
  bool operator==(const PointOnLine& other) const { return key() == other.key() && point == other.point; }
};

// A corner of a polygon, and the side that the edge to the next corner lies on.
struct SideCorner {
  PointId point;
  Line side;
};

class Triangulator {
 public:
  Triangulator(const Points& points, const PartList& parts, std::span<const std::uint32_t> order)
      : points_(points), space_(points.space()), parts_(parts), order_(order) {
    for (const std::uint32_t id : order) {
      if (id < facet_count()) continue;
      const Part& part = parts.parts[id - facet_count()];
      const auto corners = parts.corners_of(part);
      for (std::size_t i = 0; i < corners.size(); ++i) {
        add_end(part.facet, corners[i].line, corners[i].point);
        add_end(part.facet, corners[i].line, corners[(i + 1) % corners.size()].point);
      }
    }
    for (std::vector<PointOnLine>* points_on_lines : {&on_edges_, &on_cuts_}) {
      std::sort(points_on_lines->begin(), points_on_lines->end());
      points_on_lines->erase(std::unique(points_on_lines->begin(), points_on_lines->end()), points_on_lines->end());
    }
  }

  std::size_t count() {
    std::size_t triangles = 0;
    for (const std::uint32_t id : order_) {
      load(id);
      triangles += polygon_.size() - 2;
    }
    return triangles;
  }

  TriangulatedParts run() {
    result_.counts.reserve(order_.size());
    for (const std::uint32_t id : order_) {
      load(id);
      result_.counts.push_back(static_cast<std::uint32_t>(polygon_.size() - 2));
      clip_ears(facet_of(id));
    }
    return std::move(result_);
  }

 private:
  std::size_t facet_count() const { return space_.mesh.facet_count(); }
  FacetId facet_of(std::uint32_t id) const { return id < facet_count() ? id : parts_.parts[id - facet_count()].facet; }

  double along_edge(PointId from, PointId to, PointId point) const {
    const glm::dvec3 edge = points_.position(to) - points_.position(from);
    return glm::dot(edge, points_.position(point) - points_.position(from));
  }

  void add_end(FacetId facet, Line line, PointId point) {
    if (points_.is_vertex(point)) return;
    if (is_facet_edge(line)) {
      const auto [from, to] = edge_vertices(space_, facet, line);
      on_edges_.push_back({from, to, along_edge(from, to, point), point});
    } else {
      on_cuts_.push_back({facet, line, 0, point});
    }
  }

  static std::span<const PointOnLine> on_line(const std::vector<PointOnLine>& points, std::uint32_t first,
                                              std::uint32_t second) {
    const auto range = std::equal_range(points.begin(), points.end(), PointOnLine{first, second, 0, 0},
                                        [](const PointOnLine& a, const PointOnLine& b) { return a.key() < b.key(); });
    return {range.first, range.second};
  }

  // The polygon of a draw id, with all vertices on its edges, to polygon_.
  void load(std::uint32_t id) {
    polygon_.clear();
    const FacetId facet = facet_of(id);
    if (id < facet_count()) {
      for (int i = 0; i < 3; ++i) {
        const Line line = facet_edge | static_cast<Line>((i + 2) % 3);
        add_side(facet, space_.corner(facet, i), space_.corner(facet, (i + 1) % 3), line);
      }
      return;
    }
    const auto corners = parts_.corners_of(parts_.parts[id - facet_count()]);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      add_side(facet, corners[i].point, corners[(i + 1) % corners.size()].point, corners[i].line);
    }
  }

  void add_side(FacetId facet, PointId from, PointId to, Line line) {
    polygon_.push_back({from, line});
    if (is_facet_edge(line)) {
      if (on_edges_.empty()) return;
      const auto [lower, upper] = edge_vertices(space_, facet, line);
      const auto points = on_line(on_edges_, lower, upper);
      if (points.empty()) return;
      const double start = along_edge(lower, upper, from), end = along_edge(lower, upper, to);
      for (std::size_t i = 0; i < points.size(); ++i) {
        const PointOnLine& p = start < end ? points[i] : points[points.size() - 1 - i];
        const bool between = std::min(start, end) <= p.along && p.along <= std::max(start, end);
        if (between && p.point != from && p.point != to) polygon_.push_back({p.point, line});
      }
      return;
    }
    between_.clear();
    const double length = along_edge(from, to, to);
    for (const PointOnLine& p : on_line(on_cuts_, facet, line)) {
      if (p.point == from || p.point == to) continue;
      const double along = along_edge(from, to, p.point);
      if (0 <= along && along <= length) between_.push_back({along, p.point});
    }
    std::sort(between_.begin(), between_.end());
    for (const auto& [along, point] : between_) polygon_.push_back({point, line});
  }

  // Ears are cut off where two sides meet, so that no triangle is flat by construction, and not where all that is left
  // would be one side.
  void clip_ears(FacetId facet) {
    Line new_side = facet_edge | 3;  // unlike any line
    while (polygon_.size() > 3) {
      const std::size_t count = polygon_.size();
      std::size_t ear = count;
      for (std::size_t i = 0; i < count && ear == count; ++i) {
        const std::size_t before = (i + count - 1) % count;
        if (polygon_[before].side == polygon_[i].side) continue;
        const Line left = polygon_[(i + 1) % count].side;
        for (std::size_t k = 2; k + 1 < count; ++k) {
          if (polygon_[(i + k) % count].side != left) ear = i;
        }
      }
      if (ear == count) ear = 0;  // a polygon whose cuts coincide: any triangles will do
      const std::size_t before = (ear + count - 1) % count, after = (ear + 1) % count;
      emit(facet, polygon_[before].point, polygon_[ear].point, polygon_[after].point);
      polygon_[before].side = new_side++;
      polygon_.erase(polygon_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    emit(facet, polygon_[0].point, polygon_[1].point, polygon_[2].point);
  }

  void emit(FacetId facet, PointId a, PointId b, PointId c) {
    result_.triangles.triangles.push_back({index_of(facet, a), index_of(facet, b), index_of(facet, c)});
    result_.triangles.source.push_back(facet);
  }

  std::uint32_t index_of(FacetId facet, PointId point) {
    if (points_.is_vertex(point)) {
      for (int i = 0; i < 3; ++i) {
        if (space_.corner(facet, i) == point) return space_.mesh.triangles[facet][i];
      }
    }
    const auto next = static_cast<std::uint32_t>(space_.mesh.vertex_count() + result_.triangles.vertices.size());
    const auto [known, is_new] = vertex_of_.try_emplace(std::uint64_t{facet} << 32 | point, next);
    if (is_new) result_.triangles.vertices.push_back({points_.rounded(point), facet, barycentric(facet, point)});
    return known->second;
  }

  glm::vec3 barycentric(FacetId facet, PointId point) const {
    const PointDefinition& definition = points_.definition(point);
    const glm::dvec3 p = points_.position(point);
    glm::dvec3 corner[3];
    int on_edge = 0;
    for (int i = 0; i < 3; ++i) {
      corner[i] = points_.position(space_.corner(facet, i));
      const PointId id = space_.corner(facet, i);
      on_edge += definition.kind == PointDefinition::edge_and_plane && (id == definition.a || id == definition.b);
    }
    glm::dvec3 weight(0);
    if (on_edge >= 2) {  // 3 where two corners of a facet without area are one point
      for (int i = 0; i < 3 && weight == glm::dvec3(0); ++i) {
        const int j = (i + 1) % 3;
        const PointId from = space_.corner(facet, i), to = space_.corner(facet, j);
        if (std::minmax({from, to}) != std::pair(definition.a, definition.b)) continue;
        const double t = along_edge(from, to, point) / along_edge(from, to, to);
        weight[i] = 1 - t;
        weight[j] = t;
      }
      return glm::vec3(glm::clamp(weight, 0.0, 1.0));
    }
    const glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 &a = corner[(i + 1) % 3], &b = corner[(i + 2) % 3];
      weight[i] = std::max(0.0, glm::dot(glm::cross(b - a, p - a), normal));
    }
    return glm::vec3(weight / (weight.x + weight.y + weight.z));
  }

  const Points& points_;
  const PointSpace& space_;
  const PartList& parts_;
  const std::span<const std::uint32_t> order_;
  std::vector<PointOnLine> on_edges_, on_cuts_;  // sorted
  std::vector<SideCorner> polygon_;
  std::vector<std::pair<double, PointId>> between_;
  std::unordered_map<std::uint64_t, std::uint32_t> vertex_of_;  // by facet and point
  TriangulatedParts result_;
};

}  // namespace

TriangulatedParts triangulate_parts(const Points& points, const PartList& parts, std::span<const std::uint32_t> order) {
  return Triangulator(points, parts, order).run();
}

OrderedTriangles triangulate(const Points& points, const PartList& parts, std::span<const std::uint32_t> order) {
  return triangulate_parts(points, parts, order).triangles;
}

std::size_t count_triangles(const Points& points, const PartList& parts, std::span<const std::uint32_t> order) {
  return Triangulator(points, parts, order).count();
}

}  // namespace facetsort::exact_internal
