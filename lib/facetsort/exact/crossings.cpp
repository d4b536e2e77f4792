#include "facetsort/exact/crossings.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/facet_hierarchy.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t items_per_chunk = 1024;
constexpr std::size_t facets_per_task = 64;

// An end of the segment that two crossing facets share: a vertex, or where an edge of one pierces the other.
struct SegmentEnd {
  bool is_vertex;
  PointId vertex;
  PointDefinition definition;
  bool on_edge_of_first;
};

struct Segment {
  SegmentEnd ends[2];
};

// The corner of a facet that is alone on its side of a plane, from the sides of all three; nothing where the plane does
// not part the facet. Of the others, one may be in the plane.
std::optional<int> lone_corner(const std::array<int, 3>& sides) {
  const bool above = std::find(sides.begin(), sides.end(), 1) != sides.end();
  const bool below = std::find(sides.begin(), sides.end(), -1) != sides.end();
  if (!above || !below) return std::nullopt;
  for (int i = 0; i < 3; ++i) {
    if (sides[i] != 0 && sides[(i + 1) % 3] != sides[i] && sides[(i + 2) % 3] != sides[i]) return i;
  }
  return std::nullopt;
}

// Where the edge from corner i to corner j of a facet pierces the plane of another.
SegmentEnd pierce(const PointSpace& space, FacetId facet, int i, int j, const std::array<int, 3>& sides, FacetId plane,
                  bool on_edge_of_first) {
  if (sides[j] == 0) return {true, space.corner(facet, j), {}, on_edge_of_first};
  const auto [p, q] = std::minmax({space.corner(facet, i), space.corner(facet, j)});
  return {false, 0, {PointDefinition::edge_and_plane, p, q, space.plane_of_facet[plane]}, on_edge_of_first};
}

// The segment that facets f and g share when each has area on both sides of the other's plane; nothing where they are
// apart or meet in a point. Both meet the line of the two planes in an interval, each end of which is where an edge
// pierces the other's plane; orientations of pairs of edges order the ends along the line, as in Guigue and Devillers
// 2003, "Fast and Robust Triangle-Triangle Overlap Test Using Orientation Predicates".
std::optional<Segment> shared_segment(const Points& points, FacetId f, FacetId g) {
  const PointSpace& space = points.space();
  std::array<int, 3> f_sides, g_sides;
  for (int i = 0; i < 3; ++i) f_sides[i] = points.side(g, space.corner(f, i));
  const std::optional<int> f_lone = lone_corner(f_sides);
  if (!f_lone) return std::nullopt;
  for (int i = 0; i < 3; ++i) g_sides[i] = points.side(f, space.corner(g, i));
  const std::optional<int> g_lone = lone_corner(g_sides);
  if (!g_lone) return std::nullopt;

  const auto corner = [&](FacetId facet, int i) { return space.corner(facet, i % 3); };
  // Side of the line through corners `from` and `to` of g, an edge of g's winding, on which f's edge to corner m
  // pierces g's plane: +1 inside.
  const auto inside = [&](int m, int from, int to) {
    const PointId a = corner(f, *f_lone), b = corner(f, m), c = corner(g, from), d = corner(g, to);
    if (a == c || a == d || b == c || b == d) return 0;
    return -f_sides[*f_lone] * points.orientation(a, b, c, d);
  };
  const int f1 = (*f_lone + 1) % 3, f2 = (*f_lone + 2) % 3, g1 = (*g_lone + 1) % 3, g2 = (*g_lone + 2) % 3;
  // f's interval is [first, second], g's starts at its edge to g1 and ends at its edge to g2.
  const int first_after_start = inside(f1, *g_lone, g1), second_after_start = inside(f2, *g_lone, g1);
  if (first_after_start <= 0 && second_after_start <= 0) return std::nullopt;
  const int first_before_end = inside(f1, g2, *g_lone), second_before_end = inside(f2, g2, *g_lone);
  if (first_before_end <= 0 && second_before_end <= 0) return std::nullopt;

  Segment segment;
  int ends = 0;
  if (first_after_start > 0 && first_before_end > 0) {
    segment.ends[ends++] = pierce(space, f, *f_lone, f1, f_sides, g, true);
  }
  if (second_after_start > 0 && second_before_end > 0) {
    segment.ends[ends++] = pierce(space, f, *f_lone, f2, f_sides, g, true);
  }
  if (ends < 2 && (first_after_start <= 0 || second_after_start <= 0)) {
    segment.ends[ends++] = pierce(space, g, *g_lone, g1, g_sides, f, false);
  }
  if (ends < 2 && (first_before_end <= 0 || second_before_end <= 0)) {
    segment.ends[ends++] = pierce(space, g, *g_lone, g2, g_sides, f, false);
  }
  assert(ends == 2);
  return segment;
}

// A pair of facets, the smaller first, and the ends of the segment that they share.
struct Crossing {
  FacetId f, g;
  Segment segment;

  bool operator<(const Crossing& other) const { return std::tie(f, g) < std::tie(other.f, other.g); }
};

struct Crossings {
  std::vector<Crossing> found;  // sorted
  std::size_t not_kept = 0;
};

// For each facet the corner around which most facets lie, where these are so many that pairs of them need a search of
// their own; else no_group. All boxes of such facets overlap.
std::vector<std::uint32_t> find_hubs(const PointSpace& space, const std::vector<unsigned char>& degenerate) {
  constexpr std::uint32_t fewest_around = 64;
  std::vector<std::uint32_t> hubs(space.mesh.facet_count(), FacetHierarchy::no_group);
  for (FacetId f = 0; f < hubs.size(); ++f) {
    if (degenerate[f]) continue;
    std::uint32_t most = fewest_around;
    for (int i = 0; i < 3; ++i) {
      const PointId corner = space.corner(f, i);
      const std::uint32_t around = space.around_begin[corner + 1] - space.around_begin[corner];
      if (around < most || (around == most && corner >= hubs[f])) continue;
      most = around;
      hubs[f] = corner;
    }
  }
  return hubs;
}

class CrossingSearch {
 public:
  // Keeps all crossings but, where there are many more than `most`, some: the same ones for any thread count.
  CrossingSearch(const Points& points, const std::vector<unsigned char>& degenerate, std::size_t most)
      : points_(points), space_(points.space()), hubs_(find_hubs(space_, degenerate)), most_(most) {
    find_all_but_around_hubs(degenerate);
    find_around_hubs();
    tbb::parallel_sort(crossings_.found);
  }

  Crossings take() { return std::move(crossings_); }

 private:
  struct Chunk {
    std::vector<Crossing> found;
    std::size_t not_kept = 0;
  };

  // Calls search(item, chunk) for each of so many items, which adds what crosses it to the chunk.
  template <typename Search>
  void for_each_item(std::size_t items, const Search& search) {
    std::vector<Chunk> chunks((items + items_per_chunk - 1) / items_per_chunk);
    parallel_ranges(chunks.size(), 1, [&](std::size_t first, std::size_t last) {
      for (std::size_t c = first; c < last; ++c) {
        for (std::size_t i = c * items_per_chunk; i < std::min(items, (c + 1) * items_per_chunk); ++i) {
          search(i, chunks[c]);
        }
      }
    });
    for (const Chunk& chunk : chunks) {
      crossings_.found.insert(crossings_.found.end(), chunk.found.begin(), chunk.found.end());
      crossings_.not_kept += chunk.not_kept;
    }
  }

  void test(FacetId a, FacetId b, Chunk& chunk) const {
    const auto [f, g] = std::minmax(a, b);
    if (space_.plane_of_facet[f] == space_.plane_of_facet[g]) return;
    const std::optional<Segment> segment = shared_segment(points_, f, g);
    if (!segment) return;
    const std::size_t chunks = space_.mesh.facet_count() / items_per_chunk + 1;
    if (chunk.found.size() >= most_ / chunks + 64 * items_per_chunk) {
      ++chunk.not_kept;
      return;
    }
    chunk.found.push_back({f, g, *segment});
  }

  void find_all_but_around_hubs(const std::vector<unsigned char>& degenerate) {
    const FacetHierarchy hierarchy = hierarchy_of(space_.mesh, degenerate, hubs_);
    for_each_item(hierarchy.items().size(), [&](std::size_t i, Chunk& chunk) {
      const FacetId f = hierarchy.items()[i].facet;
      hierarchy.for_each_later_overlap(i, [&](FacetId g) { test(f, g, chunk); });
    });
  }

  // Facets with a corner in common that cross share a segment from there to the edge opposite to it, of one of them: so
  // the box of that edge overlaps the other's.
  void find_around_hubs() {
    std::vector<std::pair<PointId, FacetId>> around;
    for (FacetId f = 0; f < hubs_.size(); ++f) {
      if (hubs_[f] != FacetHierarchy::no_group) around.push_back({hubs_[f], f});
    }
    tbb::parallel_sort(around);
    for (std::size_t begin = 0, end; begin < around.size(); begin = end) {
      end = begin;
      std::vector<FacetHierarchy::Item> edges;
      for (; end < around.size() && around[end].first == around[begin].first; ++end) {
        edges.push_back({opposite_edge(around[end].second), around[end].second, FacetHierarchy::no_group});
      }
      const FacetHierarchy hierarchy(std::move(edges));
      for_each_item(hierarchy.items().size(), [&](std::size_t i, Chunk& chunk) {
        const Bounds& edge = hierarchy.items()[i].bounds;
        const FacetId f = hierarchy.items()[i].facet;
        const Bounds bounds = facet_bounds_of(f);
        hierarchy.for_each_overlap(bounds, [&](FacetId g) {
          // Where either edge overlaps the other facet, the pair is met twice.
          if (g == f || (g < f && edge.overlaps(facet_bounds_of(g)))) return;
          test(f, g, chunk);
        });
      });
    }
  }

  Bounds facet_bounds_of(FacetId facet) const {
    Bounds bounds = opposite_edge(facet);
    bounds.include({space_.position(hubs_[facet]), space_.position(hubs_[facet])});
    return bounds;
  }

  Bounds opposite_edge(FacetId facet) const {
    int at = 0;
    while (space_.corner(facet, at) != hubs_[facet]) ++at;
    const glm::vec3 a = space_.position(space_.corner(facet, (at + 1) % 3));
    const glm::vec3 b = space_.position(space_.corner(facet, (at + 2) % 3));
    return {glm::min(a, b), glm::max(a, b)};
  }

  const Points& points_;
  const PointSpace& space_;
  const std::vector<PointId> hubs_;
  const std::size_t most_;
  Crossings crossings_;
};

// Facet `facet` is to be cut along the plane of `by`.
struct Task {
  FacetId facet, by;

  auto operator<=>(const Task&) const = default;
};

// Which facet of each pair is cut. Every new vertex costs two triangles, so few of them are wanted. A cut of f by g
// runs along the line of their planes from edge to edge of f: where the segment they share ends on f's edge, that
// vertex serves the cut of f's neighbour by g too; where it ends on g's edge, inside f, the cut has to be extended to
// some point that serves nothing else. So a curve along which two sheets cross wants all its cuts in one of the sheets.
class CutAssignment {
 public:
  explicit CutAssignment(const std::vector<Crossing>& crossings) : crossings_(crossings) {
    find_links();
    cut_first_.assign(crossings.size(), 0);
    follow_curves();
    improve();
  }

  std::vector<Task> tasks() const {
    std::vector<Task> tasks;
    tasks.reserve(crossings_.size());
    for (std::size_t i = 0; i < crossings_.size(); ++i) {
      const Crossing& crossing = crossings_[i];
      tasks.push_back(cut_first_[i] ? Task{crossing.f, crossing.g} : Task{crossing.g, crossing.f});
    }
    tbb::parallel_sort(tasks);
    return tasks;
  }

 private:
  // Pairs of which a segment ends where one edge pierces one facet: the next pairs along the curve.
  struct Link {
    PointDefinition where;
    std::uint32_t crossing;
    std::uint8_t end;

    auto operator<=>(const Link&) const = default;
  };

  // Cuts that end in a group's point: of facets whose edge it is on, and of the facet that it is inside of.
  struct Cuts {
    int at_edge = 0, inside = 0;
  };

  void find_links() {
    for (std::uint32_t i = 0; i < crossings_.size(); ++i) {
      for (std::uint8_t end = 0; end < 2; ++end) {
        const SegmentEnd& e = crossings_[i].segment.ends[end];
        if (!e.is_vertex) links_.push_back({e.definition, i, end});
      }
    }
    tbb::parallel_sort(links_);
    group_of_end_.assign(2 * crossings_.size(), no_group);
    for (std::size_t i = 0; i < links_.size(); ++i) {
      if (i == 0 || links_[i].where != links_[i - 1].where) group_begins_.push_back(i);
      group_of_end_[2 * links_[i].crossing + links_[i].end] = static_cast<std::uint32_t>(group_begins_.size() - 1);
    }
    group_begins_.push_back(links_.size());
    cuts_.assign(group_begins_.size() - 1, {});
  }

  bool on_cut_edge(std::size_t crossing, int end, bool cut_first) const {
    return crossings_[crossing].segment.ends[end].on_edge_of_first == cut_first;
  }

  // What a cut adds to those there already, in half vertices. All cuts that end where an edge of g pierces f share one
  // vertex if g and its neighbour are cut there; and one, a kink, if f is cut by both. The latter counts more: f can't
  // always be parted at a kink without further vertices.
  int cost(std::size_t crossing, bool cut_first) const {
    int half_vertices = 0;
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t group = group_of_end_[2 * crossing + end];
      if (group == no_group) continue;
      if (on_cut_edge(crossing, end, cut_first)) {
        half_vertices += cuts_[group].at_edge == 0 ? 2 : 0;
      } else {
        half_vertices += cuts_[group].inside == 0 ? 3 : 0;
      }
    }
    return half_vertices;
  }

  void count(std::size_t crossing, bool cut_first, int by) {
    for (int end = 0; end < 2; ++end) {
      const std::uint32_t group = group_of_end_[2 * crossing + end];
      if (group == no_group) continue;
      (on_cut_edge(crossing, end, cut_first) ? cuts_[group].at_edge : cuts_[group].inside) += by;
    }
  }

  // Takes each curve as a whole: its pairs know which of their facets is of the one sheet and which of the other, and
  // the sheet is cut in which that costs less.
  void follow_curves() {
    enum : unsigned char { unseen, first_in_sheet, second_in_sheet };
    std::vector<unsigned char> side(crossings_.size(), unseen);
    std::vector<std::uint32_t> curve;
    for (std::uint32_t start = 0; start < crossings_.size(); ++start) {
      if (side[start] != unseen) continue;
      side[start] = first_in_sheet;
      curve.assign(1, start);
      for (std::size_t next = 0; next < curve.size(); ++next) {
        const std::uint32_t crossing = curve[next];
        for (int end = 0; end < 2; ++end) {
          const std::uint32_t group = group_of_end_[2 * crossing + end];
          if (group == no_group) continue;
          const bool owner_is_first = crossings_[crossing].segment.ends[end].on_edge_of_first;
          const bool owner_in_sheet = owner_is_first == (side[crossing] == first_in_sheet);
          for (std::size_t i = group_begins_[group]; i < group_begins_[group + 1]; ++i) {
            const Link& link = links_[i];
            if (side[link.crossing] != unseen) continue;
            const bool other_is_first = crossings_[link.crossing].segment.ends[link.end].on_edge_of_first;
            side[link.crossing] = other_is_first == owner_in_sheet ? first_in_sheet : second_in_sheet;
            curve.push_back(link.crossing);
          }
        }
      }
      const auto cut_first_in = [&](std::uint32_t crossing, bool sheet) {
        return sheet == (side[crossing] == first_in_sheet);
      };
      int total[2] = {0, 0};
      for (const bool sheet : {true, false}) {
        for (const std::uint32_t crossing : curve) {
          total[sheet] += cost(crossing, cut_first_in(crossing, sheet));
          count(crossing, cut_first_in(crossing, sheet), 1);
        }
        for (const std::uint32_t crossing : curve) count(crossing, cut_first_in(crossing, sheet), -1);
      }
      const bool sheet = total[true] <= total[false];
      for (const std::uint32_t crossing : curve) {
        cut_first_[crossing] = cut_first_in(crossing, sheet);
        count(crossing, cut_first_[crossing], 1);
      }
    }
  }

  // Turns single pairs round while that costs less.
  void improve() {
    constexpr int most_rounds = 8;
    bool changed = true;
    for (int round = 0; round < most_rounds && changed; ++round) {
      changed = false;
      for (std::size_t i = 0; i < crossings_.size(); ++i) {
        const bool cut_first = cut_first_[i];
        count(i, cut_first, -1);
        const bool turned = cost(i, !cut_first) < cost(i, cut_first);
        cut_first_[i] = turned != cut_first;
        count(i, cut_first_[i], 1);
        changed = changed || turned;
      }
    }
  }

  static constexpr std::uint32_t no_group = 0xffffffffu;

  const std::vector<Crossing>& crossings_;
  std::vector<Link> links_;
  std::vector<std::size_t> group_begins_;
  std::vector<std::uint32_t> group_of_end_;
  std::vector<Cuts> cuts_;  // by group
  std::vector<unsigned char> cut_first_;
};

// Cuts one facet along segments in it: along whole chains of them, each from the facet's boundary to its boundary, so
// that a kink between two segments is but a corner of the faces on both sides; a face that is reflex there is then cut
// from the kink to another of its corners. Where segments do not make such chains, the step is that of a BSP: the
// polygon is cut in two along one segment's line, and each half goes on by itself.
class FacetCutter {
 public:
  // Gives up, and leaves the facet in some of its pieces, where it takes more than `most_cuts`.
  FacetCutter(Points& points, FacetId facet, PartList& pieces, std::size_t most_cuts)
      : points_(points), facet_(facet), pieces_(pieces), most_cuts_(most_cuts), ends_(points) {
    const MeshView& mesh = points.space().mesh;
    for (int axis = 0; turn_sign_ == 0; ++axis) {
      along_normal_ = Eye(0);
      along_normal_[axis] = 1;
      turn_sign_ = normal_sign(mesh.corner(facet, 0), mesh.corner(facet, 1), mesh.corner(facet, 2), axis);
    }
  }

  std::size_t cuts() const { return cuts_; }
  bool gave_up() const { return cuts_ > most_cuts_; }

  void add_segment(PlaneId plane, const SegmentEnd (&ends)[2]) {
    segments_.push_back({plane, {point_of(ends[0]), point_of(ends[1])}});
  }

  void cut() { cut(whole_facet(points_.space(), facet_), std::move(segments_)); }

 private:
  struct CutSegment {
    PlaneId plane;
    PointId ends[2];
  };
  using Segments = std::vector<CutSegment>;

  // A face of the subdivision that the segments make of a polygon; not always convex.
  using Loop = std::vector<PartCorner>;

  // A cut between two corners of a face, the first a kink.
  struct Join {
    PointId kink, to;
  };

  // Where a point in the polygon lies on its boundary: on the edge after a corner, or at that corner, which may be the
  // same point under another id.
  struct Place {
    std::size_t edge;
    PointId point;
  };

  // Segments end to end, from one place on the polygon's boundary to another.
  struct Chain {
    Place ends[2];
    std::vector<std::size_t> segments;
    std::vector<PlaneId> planes;  // of the segments
    std::vector<PointId> kinks;   // between them
  };

  PointId point_of(const SegmentEnd& end) { return end.is_vertex ? end.vertex : ends_.id_of(end.definition); }

  void cut(const Polygon& polygon, Segments segments) {
    while (!segments.empty()) {
      if (gave_up()) return;
      if (segments.size() > 1 && cut_along_chains(polygon, segments)) return;
      const std::size_t chosen = cheapest(segments);
      const PlaneId plane = segments[chosen].plane;
      Polygon front, back;
      if (!cut_in_two(points_, facet_, polygon, plane, front, back, sides_)) {
        segments.erase(segments.begin() + static_cast<std::ptrdiff_t>(chosen));  // it runs along the polygon's edge
        continue;
      }
      ++cuts_;
      Segments front_segments, back_segments;
      for (const CutSegment& segment : segments) distribute(segment, plane, front_segments, back_segments);
      cut(front, std::move(front_segments));
      cut(back, std::move(back_segments));
      return;
    }
    pieces_.add(facet_, polygon.corners, polygon.cuts);
  }

  void distribute(const CutSegment& segment, PlaneId plane, Segments& front, Segments& back) {
    const int first = points_.side(plane, segment.ends[0]), second = points_.side(plane, segment.ends[1]);
    if (first == 0 && second == 0) return;
    if (first * second >= 0) {
      (first + second > 0 ? front : back).push_back(segment);
      return;
    }
    const PointId meeting = points_.add(PointDefinition::of_planes(points_.same_plane(facet_), segment.plane, plane));
    front.push_back({segment.plane, {first > 0 ? segment.ends[0] : segment.ends[1], meeting}});
    back.push_back({segment.plane, {first < 0 ? segment.ends[0] : segment.ends[1], meeting}});
  }

  static bool is_shared(PointId end, const Segments& segments) {
    return std::count_if(segments.begin(), segments.end(), [&](const CutSegment& segment) {
             return segment.ends[0] == end || segment.ends[1] == end;
           }) > 1;
  }

  // The segment a cut along which takes the fewest points but the segments' ends, where it parts others or runs on
  // beyond a kink; of those, the one that parts them most evenly.
  std::size_t cheapest(const Segments& segments) const {
    constexpr std::size_t most_tried = 24;
    if (segments.size() == 1) return 0;
    const std::size_t step = (segments.size() + most_tried - 1) / most_tried;
    std::size_t best = 0;
    std::pair<std::size_t, std::size_t> best_cost{std::numeric_limits<std::size_t>::max(), 0};
    for (std::size_t i = 0; i < segments.size(); i += step) {
      std::size_t points = 0, front = 0, back = 0;
      for (const PointId end : segments[i].ends) points += is_shared(end, segments);
      for (const CutSegment& segment : segments) {
        const int first = points_.side(segments[i].plane, segment.ends[0]);
        const int second = points_.side(segments[i].plane, segment.ends[1]);
        points += first * second < 0;
        front += first + second > 0;
        back += first + second < 0;
      }
      const std::pair<std::size_t, std::size_t> cost{points, std::max(front, back)};
      if (cost < best_cost) {
        best_cost = cost;
        best = i;
      }
    }
    return best;
  }

  bool is_on_line(PointId point, Line line) const {
    if (!is_facet_edge(line)) return points_.side(line, point) == 0;
    const auto [p, q] = edge_vertices(points_.space(), facet_, line);
    if (points_.is_vertex(point)) return point == p || point == q;
    const PointDefinition& definition = points_.definition(point);
    return definition.kind == PointDefinition::edge_and_plane && definition.a == p && definition.b == q;
  }

  // Nothing where the point is inside.
  std::optional<Place> place_on_boundary(const Polygon& polygon, PointId point) const {
    const std::size_t count = polygon.corners.size();
    std::optional<Place> place;
    bool on_last_edge = is_on_line(point, polygon.corners[count - 1].line);
    for (std::size_t i = 0; i < count; ++i) {
      const bool on_edge = is_on_line(point, polygon.corners[i].line);
      if (polygon.corners[i].point == point || (on_edge && on_last_edge)) return Place{i, polygon.corners[i].point};
      if (on_edge) place = Place{i, point};
      on_last_edge = on_edge;
    }
    return place;
  }

  // Cuts the polygon along chains of segments that run from boundary to boundary without meeting, and joins kinks to
  // corners where what is left is not convex: this takes no points but the segments' ends. Returns false, and does
  // nothing, where the segments are no such chains, or a kink can't be joined.
  bool cut_along_chains(const Polygon& polygon, Segments segments) {
    constexpr std::size_t most_segments = 32;
    if (segments.size() > most_segments || !run_on_to_boundary(polygon, segments)) return false;
    if (meet_elsewhere_than_at_ends(segments)) return false;
    const std::optional<std::vector<Chain>> chains = find_chains(polygon, segments);
    if (!chains) return false;
    std::vector<Loop> faces(1);
    for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
      faces[0].push_back(polygon.corners[i]);
      if (!insert_ends(polygon, i, *chains, segments, faces[0])) return false;
    }
    for (const Chain& chain : *chains) {
      if (!split(chain.ends[0].point, chain.ends[1].point, chain.planes, chain.kinks, faces)) return false;
    }
    loops_searched_ = 0;
    std::vector<std::vector<Join>> joins;  // by face
    for (const Loop& face : faces) {
      std::vector<PointId> points;
      for (const PartCorner& corner : face) points.push_back(corner.point);
      std::optional<std::vector<Join>> found = fewest_joins(points, points.size());
      if (!found) return false;
      joins.push_back(std::move(*found));
    }
    cuts_ += chains->size();
    for (std::size_t i = 0; i < faces.size(); ++i) {
      std::vector<Loop> convex{std::move(faces[i])};
      for (const Join& join : joins[i]) {
        [[maybe_unused]] const bool joined = split(join.kink, join.to, {join_plane(join.kink, join.to)}, {}, convex);
        assert(joined);
      }
      cuts_ += joins[i].size();
      for (Loop& loop : convex) add_piece(std::move(loop));
    }
    return true;
  }

  // Moves ends inside the polygon that no other segment shares along their segments to the boundary: a cut has to end
  // somewhere, and a point there costs no more than one inside. Returns false where that is a corner.
  bool run_on_to_boundary(const Polygon& polygon, Segments& segments) {
    const std::size_t count = polygon.corners.size();
    for (CutSegment& segment : segments) {
      for (int end = 0; end < 2; ++end) {
        if (is_shared(segment.ends[end], segments) || place_on_boundary(polygon, segment.ends[end])) continue;
        // It leaves across the edge that runs from its right to its left.
        std::size_t edge = count;
        for (std::size_t i = 0; i < count && edge == count; ++i) {
          const PointId from = polygon.corners[i].point, to = polygon.corners[(i + 1) % count].point;
          const auto side = [&](PointId point) { return turn(segment.ends[1 - end], segment.ends[end], point); };
          if (side(from) < 0 && side(to) > 0) edge = i;
        }
        if (edge == count) return false;
        segment.ends[end] = meeting_point(points_, facet_, polygon.corners[edge].line, segment.plane);
      }
    }
    return true;
  }

  // Whether two segments cross, touch or overlap, but for a common end.
  bool meet_elsewhere_than_at_ends(const Segments& segments) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const CutSegment &a = segments[i], &b = segments[j];
        const int a0 = points_.side(b.plane, a.ends[0]), a1 = points_.side(b.plane, a.ends[1]);
        const bool common =
            a.ends[0] == b.ends[0] || a.ends[0] == b.ends[1] || a.ends[1] == b.ends[0] || a.ends[1] == b.ends[1];
        if (common) {
          if (a0 == 0 && a1 == 0) return true;
          continue;
        }
        if (a0 * a1 > 0) continue;
        if (points_.side(a.plane, b.ends[0]) * points_.side(a.plane, b.ends[1]) <= 0) return true;
      }
    }
    return false;
  }

  bool parts(const Polygon& polygon, PlaneId plane) const {
    const auto has_corner_on = [&](int side) {
      return std::any_of(polygon.corners.begin(), polygon.corners.end(),
                         [&](const PartCorner& corner) { return points_.side(plane, corner.point) == side; });
    };
    return has_corner_on(1) && has_corner_on(-1);
  }

  std::optional<std::vector<Chain>> find_chains(const Polygon& polygon, const Segments& segments) const {
    std::map<PointId, std::vector<std::size_t>> segments_at;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (const PointId end : segments[i].ends) segments_at[end].push_back(i);
    }
    std::map<PointId, Place> places;
    for (const auto& [point, met] : segments_at) {
      const std::optional<Place> place = place_on_boundary(polygon, point);
      if (met.size() > 2 || place.has_value() != (met.size() == 1)) return std::nullopt;
      if (place) places.emplace(point, *place);
    }
    std::vector<Chain> chains;
    std::vector<unsigned char> taken(segments.size());
    for (const auto& [start, place] : places) {
      std::size_t segment = segments_at[start].front();
      if (taken[segment]) continue;
      Chain chain;
      chain.ends[0] = place;
      for (PointId at = start;;) {
        taken[segment] = true;
        chain.segments.push_back(segment);
        at = segments[segment].ends[segments[segment].ends[0] == at];
        const std::vector<std::size_t>& met = segments_at[at];
        if (met.size() == 1) {
          chain.ends[1] = places.at(at);
          break;
        }
        chain.kinks.push_back(at);
        segment = met[met[0] == segment];
      }
      for (const std::size_t i : chain.segments) chain.planes.push_back(segments[i].plane);
      if (chain.kinks.empty() && !parts(polygon, chain.planes[0])) return std::nullopt;  // along an edge
      chains.push_back(std::move(chain));
    }
    if (std::find(taken.begin(), taken.end(), 0) != taken.end()) return std::nullopt;  // a closed chain
    return chains;
  }

  // Adds the ends of chains that lie on the edge after corner i, in their order along it.
  bool insert_ends(const Polygon& polygon, std::size_t i, const std::vector<Chain>& chains, const Segments& segments,
                   Loop& loop) const {
    const PartCorner corner = polygon.corners[i];
    struct End {
      PointId point;
      PlaneId plane;
    };
    std::vector<End> ends;
    for (const Chain& chain : chains) {
      for (int end = 0; end < 2; ++end) {
        const Place& place = chain.ends[end];
        if (place.edge != i || place.point == corner.point) continue;
        ends.push_back({place.point, segments[end == 0 ? chain.segments.front() : chain.segments.back()].plane});
      }
    }
    for (std::size_t k = 1; k < ends.size(); ++k) {
      for (std::size_t m = k; m > 0; --m) {
        const int corner_side = points_.side(ends[m - 1].plane, corner.point);
        const int side = points_.side(ends[m - 1].plane, ends[m].point);
        if (corner_side * side == 0) return false;  // two names of one point
        if (corner_side != side) break;
        std::swap(ends[m - 1], ends[m]);
      }
    }
    for (const End& end : ends) loop.push_back({end.point, corner.line});
    return true;
  }

  // Splits the one face that has both points along segments in these planes, between which there are kinks; returns
  // false where it is not one.
  static bool split(PointId start, PointId end, const std::vector<PlaneId>& planes, const std::vector<PointId>& kinks,
                    std::vector<Loop>& faces) {
    const auto find = [](const Loop& face, PointId point) {
      return static_cast<std::size_t>(
          std::find_if(face.begin(), face.end(), [&](const PartCorner& corner) { return corner.point == point; }) -
          face.begin());
    };
    const auto has_both = [&](const Loop& face) {
      return find(face, start) < face.size() && find(face, end) < face.size();
    };
    const auto face = std::find_if(faces.begin(), faces.end(), has_both);
    if (start == end || face == faces.end() || std::any_of(face + 1, faces.end(), has_both)) return false;
    const std::size_t from = find(*face, start), to = find(*face, end), count = face->size();
    Loop right, left;  // of the segments
    for (std::size_t i = from; i != to; i = (i + 1) % count) right.push_back((*face)[i]);
    right.push_back({end, planes.back()});
    for (std::size_t k = kinks.size(); k-- > 0;) right.push_back({kinks[k], planes[k]});
    for (std::size_t i = to; i != from; i = (i + 1) % count) left.push_back((*face)[i]);
    left.push_back({start, planes.front()});
    for (std::size_t k = 0; k < kinks.size(); ++k) left.push_back({kinks[k], planes[k + 1]});
    *face = std::move(right);
    faces.push_back(std::move(left));
    return true;
  }

  // Which way round three points of the facet are, +1 for as its corners are.
  int turn(PointId a, PointId b, PointId c) const { return turn_sign_ * points_.turn(a, b, c, along_normal_); }

  // Whether corners i and k of a loop can be joined within it.
  bool sees(const std::vector<PointId>& loop, std::size_t i, std::size_t k) const {
    const std::size_t count = loop.size();
    const auto point = [&](std::size_t at) { return loop[at % count]; };
    const auto opens_to = [&](std::size_t at, PointId other) {
      const PointId before = point(at + count - 1), here = point(at), after = point(at + 1);
      const int from_before = turn(before, here, other), from_after = turn(here, after, other);
      if (from_before == 0 || from_after == 0) return false;
      return turn(before, here, after) >= 0 ? from_before > 0 && from_after > 0 : from_before > 0 || from_after > 0;
    };
    if (!opens_to(i, point(k)) || !opens_to(k, point(i))) return false;
    for (std::size_t e = 0; e < count; ++e) {
      const std::size_t next = (e + 1) % count;
      if (e == i || e == k || next == i || next == k) continue;
      if (turn(point(i), point(k), point(e)) * turn(point(i), point(k), point(next)) > 0) continue;
      if (turn(point(e), point(next), point(i)) * turn(point(e), point(next), point(k)) <= 0) return false;
    }
    return true;
  }

  // The fewest joins, at most `most`, that part a face into convex ones; not always the fewest where that takes long to
  // find; nothing where there are none.
  std::optional<std::vector<Join>> fewest_joins(const std::vector<PointId>& loop, std::size_t most) {
    const std::size_t count = loop.size();
    const auto is_reflex = [&](std::size_t before, std::size_t at, std::size_t after) {
      return turn(loop[before % count], loop[at % count], loop[after % count]) < 0;
    };
    std::size_t reflex_corners = 0, from = 0;
    for (std::size_t i = count; i-- > 0;) {
      if (!is_reflex(i + count - 1, i, i + 1)) continue;
      ++reflex_corners;
      from = i;
    }
    if (reflex_corners == 0) return std::vector<Join>{};
    const std::size_t fewest = (reflex_corners + 1) / 2;  // a join ends in two corners
    if (fewest > most || ++loops_searched_ > most_loops_searched) return std::nullopt;

    // Some join has to end in the first reflex corner. Those come first that leave the fewest reflex corners.
    std::vector<std::pair<int, std::size_t>> candidates;
    for (std::size_t to = 0; to < count; ++to) {
      if (to == from || (to + 1) % count == from || (from + 1) % count == to) continue;
      if (!can_join(loop[from], loop[to]) || !sees(loop, from, to)) continue;
      const int left = is_reflex(from + count - 1, from, to) + is_reflex(to, from, from + 1) +
                       is_reflex(to + count - 1, to, from) + is_reflex(from, to, to + 1);
      candidates.push_back({left - is_reflex(to + count - 1, to, to + 1), to});
    }
    std::sort(candidates.begin(), candidates.end());
    std::optional<std::vector<Join>> best;
    for (const auto& [left, to] : candidates) {
      std::vector<PointId> one, other;
      for (std::size_t i = from; i != to; i = (i + 1) % count) one.push_back(loop[i]);
      one.push_back(loop[to]);
      for (std::size_t i = to; i != from; i = (i + 1) % count) other.push_back(loop[i]);
      other.push_back(loop[from]);
      const std::size_t allowed = best ? best->size() - 1 : most;
      if (allowed < fewest) break;
      std::optional<std::vector<Join>> joins = fewest_joins(one, allowed - 1);
      if (!joins) continue;
      const std::optional<std::vector<Join>> rest = fewest_joins(other, allowed - 1 - joins->size());
      if (!rest) continue;
      joins->insert(joins->end(), rest->begin(), rest->end());
      joins->insert(joins->begin(), Join{loop[from], loop[to]});
      best = std::move(joins);
    }
    return best;
  }

  // Whether there is a plane through a kink and another point that can be told by vertices and facets alone.
  bool can_join(PointId kink, PointId other) const {
    return !points_.is_vertex(kink) && is_pierced_edge(kink) && (points_.is_vertex(other) || is_pierced_edge(other));
  }
  bool is_pierced_edge(PointId point) const {
    const PointDefinition& definition = points_.definition(point);
    return definition.kind == PointDefinition::edge_and_plane && definition.c < points_.space().mesh.facet_count();
  }

  // The plane through the edge that pierces the facet in the kink, and the other point.
  PlaneId join_plane(PointId kink, PointId other) {
    const PointDefinition edge = points_.definition(kink);
    if (points_.is_vertex(other)) return points_.add_plane({edge.a, edge.b, other});
    const PointDefinition to = points_.definition(other);
    if (to.a == edge.a || to.a == edge.b) return points_.add_plane({edge.a, edge.b, to.b});
    if (to.b == edge.a || to.b == edge.b) return points_.add_plane({edge.a, edge.b, to.a});
    return points_.add_plane({edge.a, edge.b, to.a, to.b, to.c});
  }

  void add_piece(Loop loop) {
    Polygon piece{std::move(loop), {}};
    for (const PartCorner& corner : piece.corners) {
      const Line line = corner.line;
      const auto is_same = [&](const Cut& cut) { return cut.plane == line; };
      if (is_facet_edge(line) || std::any_of(piece.cuts.begin(), piece.cuts.end(), is_same)) continue;
      int side = 0;
      for (std::size_t i = 0; side == 0 && i < piece.corners.size(); ++i) {
        side = points_.side(line, piece.corners[i].point);
      }
      piece.cuts.push_back({line, side});
    }
    pieces_.add(facet_, piece.corners, piece.cuts);
  }

  static constexpr std::size_t most_loops_searched = 4000;

  Points& points_;
  FacetId facet_;
  PartList& pieces_;
  const std::size_t most_cuts_;
  Segments segments_;
  DistinctPoints ends_;
  std::vector<int> sides_;
  std::size_t cuts_ = 0;
  Eye along_normal_;  // along an axis that is not in the facet's plane
  int turn_sign_ = 0;
  std::size_t loops_searched_ = 0;
};

// The parts of one facet, with points of their own after those of the mesh.
struct CutFacet {
  std::optional<Points> points;
  PartList pieces;
  std::size_t cuts = 0;
  std::size_t new_corners = 0;
  bool gave_up = false;
};

CutFacet cut_facet(const Points& mesh_points, std::span<const Task> tasks, std::size_t most_cuts) {
  CutFacet result;
  result.points.emplace(&mesh_points);
  const FacetId facet = tasks.front().facet;
  FacetCutter cutter(*result.points, facet, result.pieces, most_cuts);
  for (const Task& task : tasks) {
    const std::optional<Segment> segment = shared_segment(mesh_points, facet, task.by);
    cutter.add_segment(mesh_points.same_plane(task.by), segment->ends);
  }
  cutter.cut();
  result.gave_up = cutter.gave_up();
  if (result.gave_up) return {std::nullopt, {}, 0, 0, true};
  result.cuts = cutter.cuts();
  result.new_corners = count_new_corners(*result.points, result.pieces, mesh_points.size());
  return result;
}

// Moves the parts of one facet to the whole mesh's, points that are there already included.
class Merger {
 public:
  Merger(Points& points, PartList& pieces) : points_(points), pieces_(pieces), merged_(points) {}

  void add(const CutFacet& facet) {
    std::vector<PartCorner> corners;
    std::vector<Cut> cuts;
    planes_.clear();
    for (const Part& part : facet.pieces.parts) {
      corners.clear();
      cuts.clear();
      for (const PartCorner& corner : facet.pieces.corners_of(part)) {
        const Line line = is_facet_edge(corner.line) ? corner.line : plane_of(facet, corner.line);
        corners.push_back({point_of(facet, corner.point), line});
      }
      for (const Cut& cut : facet.pieces.cuts_of(part)) cuts.push_back({plane_of(facet, cut.plane), cut.side});
      pieces_.add(part.facet, corners, cuts);
    }
  }

 private:
  PlaneId plane_of(const CutFacet& facet, PlaneId plane) {
    if (plane < points_.space().mesh.facet_count()) return plane;
    const auto [place, is_new] = planes_.try_emplace(plane, 0);
    if (is_new) place->second = points_.add_plane(facet.points->plane(plane));
    return place->second;
  }

  PointId point_of(const CutFacet& facet, PointId point) {
    if (points_.is_vertex(point)) return point;
    PointDefinition definition = facet.points->definition(point);
    if (definition.kind == PointDefinition::edge_and_plane) {
      definition.c = plane_of(facet, definition.c);
    } else {
      definition = PointDefinition::of_planes(plane_of(facet, definition.a), plane_of(facet, definition.b),
                                              plane_of(facet, definition.c));
    }
    return merged_.id_of(definition);
  }

  Points& points_;
  PartList& pieces_;
  DistinctPoints merged_;
  std::map<PlaneId, PlaneId> planes_;  // of the facet being added
};

}  // namespace

PartedFacets part_crossing_facets(Points& points, const std::vector<unsigned char>& degenerate,
                                  std::size_t most_triangles) {
  PartedFacets result;
  const std::size_t facets = points.space().mesh.facet_count();
  const Crossings crossings = CrossingSearch(points, degenerate, most_triangles).take();
  result.crossing_pairs = crossings.found.size() + crossings.not_kept;
  result.uncut_pairs = crossings.not_kept;
  const std::vector<Task> tasks = CutAssignment(crossings.found).tasks();
  std::vector<std::size_t> begins;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    if (i == 0 || tasks[i].facet != tasks[i - 1].facet) begins.push_back(i);
  }
  begins.push_back(tasks.size());

  // In batches, and small ones at first, so that what is cut in vain beyond the limit stays small.
  constexpr std::size_t first_batch_size = 64, largest_batch_size = 4096;
  const Points base(points.space());
  Merger merger(points, result.pieces);
  std::size_t triangles = facets;
  std::vector<CutFacet> batch;
  std::size_t batch_size = first_batch_size;
  for (std::size_t begin = 0, end; begin + 1 < begins.size(); begin = end) {
    end = std::min(begins.size() - 1, begin + batch_size);
    batch_size = std::min(2 * batch_size, largest_batch_size);
    // Every cut makes a piece more, and so at least one triangle.
    const std::size_t most_cuts = most_triangles > triangles ? most_triangles - triangles : 0;
    batch.clear();
    batch.resize(end - begin);
    parallel_ranges(end - begin, facets_per_task, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const std::size_t from = begins[begin + i], to = begins[begin + i + 1];
        batch[i] = cut_facet(base, std::span(tasks).subspan(from, to - from), most_cuts);
      }
    });
    for (std::size_t i = 0; i < batch.size(); ++i) {
      // Each new corner adds at most two triangles: one on either side of an edge, or two in the facet.
      const std::size_t added = 2 * batch[i].new_corners;
      if (batch[i].gave_up || triangles + added > most_triangles) {
        result.uncut_pairs += begins[begin + i + 1] - begins[begin + i];
        continue;
      }
      triangles += added;
      result.cuts += batch[i].cuts;
      merger.add(batch[i]);
    }
  }
  return result;
}

}  // namespace facetsort::exact_internal
