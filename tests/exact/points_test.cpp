// Points that cuts make, and the signs on them, against rational arithmetic.
#include "facetsort/exact/points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "exact/point_space.h"
#include "exact/rational.h"
#include "facetsort/exact/parts.h"
#include "shapes.h"

namespace facetsort::exact_internal {
namespace {

using rational::Number;
using Exact = rational::Point;

struct ExactPlane {
  Exact origin, normal;

  Number at(const Exact& p) const { return rational::dot(normal, p - origin); }
};

int sign_of(const Number& value) {
  return (value > 0) - (value < 0);
}

// The same points and planes in rational numbers.
class Oracle {
 public:
  explicit Oracle(const Points& points) : points_(points) {}

  ExactPlane plane(PlaneId id) const { return plane(points_.plane(id)); }
  ExactPlane plane(const CutPlane& defining) const {
    const Exact a = vertex(defining.first), b = vertex(defining.second);
    Exact c = vertex(defining.third);
    if (defining.is_join()) {
      const Exact end = vertex(defining.edge_end);
      const ExactPlane pierced = plane(defining.facet);
      c = c + (pierced.at(c) / (pierced.at(c) - pierced.at(end))) * (end - c);
    }
    return {a, rational::cross(b - a, c - a)};
  }

  Exact point(PointId id) const {
    if (points_.is_vertex(id)) return vertex(id);
    const PointDefinition& definition = points_.definition(id);
    if (definition.kind == PointDefinition::edge_and_plane) {
      const Exact from = vertex(definition.a), to = vertex(definition.b);
      const ExactPlane cut = plane(definition.c);
      return from + (cut.at(from) / (cut.at(from) - cut.at(to))) * (to - from);
    }
    // By Cramer's rule: the offsets, weighed by the cross products of the other normals.
    const ExactPlane p = plane(definition.a), q = plane(definition.b), r = plane(definition.c);
    const auto offset = [](const ExactPlane& plane) { return rational::dot(plane.normal, plane.origin); };
    const Exact qr = rational::cross(q.normal, r.normal);
    const Exact sum = offset(p) * qr + offset(q) * rational::cross(r.normal, p.normal) +
                      offset(r) * rational::cross(p.normal, q.normal);
    return (1 / rational::dot(p.normal, qr)) * sum;
  }

  int orientation(PointId a, PointId b, PointId c, PointId d) const {
    const Exact origin = point(a);
    return sign_of(rational::dot(rational::cross(point(b) - origin, point(c) - origin), point(d) - origin));
  }

  int turn(PointId a, PointId b, PointId c, const Eye& eye) const {
    const Exact origin = point(a), target{glm::dvec3(eye)};
    const Exact towards = eye.w == 0 ? target : target - origin;
    return sign_of(rational::dot(rational::cross(point(b) - origin, point(c) - origin), towards));
  }

  int side(PlaneId id, PointId p) const { return sign_of(plane(id).at(point(p))); }

 private:
  Exact vertex(PointId id) const { return Exact(glm::dvec3(points_.space().position(id))); }

  const Points& points_;
};

// Adds planes through an edge and the point where another edge pierces a facet's plane.
void add_joins(Points& points, int count) {
  const MeshView& mesh = points.space().mesh;
  const Oracle oracle(points);
  std::mt19937 random(2);
  const auto any_facet = [&] { return static_cast<FacetId>(random() % mesh.facet_count()); };
  while (count > 0) {
    const glm::uvec3 edge = mesh.triangles[any_facet()], other = mesh.triangles[any_facet()];
    const FacetId facet = any_facet();
    if (oracle.side(facet, other.x) * oracle.side(facet, other.y) >= 0) continue;
    const CutPlane plane{edge.x, edge.y, other.x, other.y, facet};
    if (rational::is_zero(oracle.plane(plane).normal)) continue;
    points.add_plane(plane);
    --count;
  }
}

// Every point that cuts of the mesh's facets by each other's planes and those added, and those again by a third, can
// make.
std::vector<PointId> make_points(Points& points, std::size_t most) {
  const PointSpace& space = points.space();
  const auto facets = static_cast<FacetId>(space.mesh.facet_count());
  std::vector<PointId> made;
  std::vector<int> sides;
  for (FacetId f = 0; f < facets && made.size() < most; ++f) {
    std::vector<Polygon> parts{whole_facet(space, f)};
    for (PlaneId plane = 0; plane < points.plane_count(); ++plane) {
      if (plane == f) continue;
      std::vector<Polygon> next;
      for (const Polygon& part : parts) {
        Polygon front, back;
        const std::size_t before = points.size();
        if (!cut_in_two(points, f, part, plane, front, back, sides)) {
          next.push_back(part);
          continue;
        }
        for (std::size_t p = before; p < points.size(); ++p) made.push_back(static_cast<PointId>(p));
        next.push_back(front);
        next.push_back(back);
      }
      parts = std::move(next);
    }
  }
  return made;
}

struct Source {
  const char* name;
  Mesh (*make)();
};

Mesh scaled(Mesh mesh, float scale) {
  for (glm::vec3& p : mesh.positions) p *= scale;
  return mesh;
}

Mesh lattice() {
  Mesh mesh = shapes::soup(14, 9);
  for (glm::vec3& p : mesh.positions) p = glm::round(p * 3.0f);
  return mesh;
}

Mesh thin() {
  Mesh mesh = shapes::soup(8, 4);
  for (glm::vec3& p : mesh.positions) p.z = 1 + p.z * 0x1p-20f;
  return mesh;
}

const Source sources[] = {{"Soup", [] { return shapes::soup(7, 3); }},
                          {"Tiny", [] { return scaled(shapes::soup(6, 5), 0x1p-110f); }},
                          {"Huge", [] { return scaled(shapes::soup(6, 6), 0x1p110f); }},
                          {"NearlyParallel", thin},
                          {"Lattice", lattice}};

class PointSigns : public testing::TestWithParam<Source> {};
INSTANTIATE_TEST_SUITE_P(Sources, PointSigns, testing::ValuesIn(sources),
                         [](const auto& source) { return source.param.name; });

// Facets without area have no plane.
Mesh with_area(const Mesh& mesh) {
  Mesh kept = mesh;
  std::erase_if(kept.triangles, [&](const glm::uvec3& t) {
    const Exact a{glm::dvec3(mesh.positions[t.x])};
    return rational::is_zero(
        rational::cross(Exact(glm::dvec3(mesh.positions[t.y])) - a, Exact(glm::dvec3(mesh.positions[t.z])) - a));
  });
  return kept;
}

// A source's facets with area, and what cuts of them make.
struct CutSource {
  explicit CutSource(const Source& source, int joins = 0)
      : mesh(with_area(source.make())), space(space_of(mesh.view())), points(space) {
    add_joins(points, joins);
    ids = make_points(points, 150);
  }
  CutSource(const CutSource&) = delete;

  Mesh mesh;
  PointSpace space;
  Points points;
  std::vector<PointId> ids;
};

TEST_P(PointSigns, AreThoseOfRationalArithmetic) {
  const CutSource source(GetParam(), 4);
  const auto& [mesh, space, points, made] = source;
  std::vector<PointId> ids = made;
  ASSERT_GT(ids.size(), 20u);
  for (const glm::uvec3& t : mesh.triangles) ids.push_back(space.position_of_vertex[t.y]);
  const Oracle oracle(points);

  std::mt19937 random(1);
  const auto any = [&] { return ids[random() % ids.size()]; };
  std::size_t zeros = 0;
  for (int i = 0; i < 300; ++i) {
    const PointId a = any(), b = any(), c = any(), d = any();
    ASSERT_EQ(points.orientation(a, b, c, d), oracle.orientation(a, b, c, d));
    const glm::vec3 position = mesh.positions[random() % mesh.positions.size()];
    for (const Eye& eye : {Eye(position, 1), Eye(position, 0), Eye(position * 1000.0f, 1)}) {
      ASSERT_EQ(points.turn(a, b, c, eye), oracle.turn(a, b, c, eye));
    }
    const auto plane = static_cast<PlaneId>(random() % points.plane_count());
    const int side = oracle.side(plane, a);
    ASSERT_EQ(points.side(plane, a), side);
    zeros += side == 0;
  }
  EXPECT_GT(zeros, 0u);
  // Points that are made lie exactly in the planes that make them.
  for (const PointId id : ids) {
    if (points.is_vertex(id)) continue;
    const PointDefinition& definition = points.definition(id);
    EXPECT_EQ(points.side(definition.c, id), 0);
    if (definition.kind == PointDefinition::edge_and_plane) {
      EXPECT_EQ(points.orientation(definition.a, definition.b, id, any()), 0);
    } else {
      EXPECT_EQ(points.side(definition.a, id), 0);
      EXPECT_EQ(points.side(definition.b, id), 0);
    }
  }
}

TEST_P(PointSigns, PositionsAreWithinTheirErrors) {
  const CutSource source(GetParam());
  const auto& [mesh, space, points, ids] = source;
  const Oracle oracle(points);
  for (const PointId id : ids) {
    const Exact exact = oracle.point(id);
    const Exact off = Exact(points.position(id)) - exact;
    const Number error(points.error(id));
    for (const Number& coordinate : {off.x, off.y, off.z}) ASSERT_LE(abs(coordinate), error);
    // Rounded to nearest: no neighbour is nearer.
    const glm::vec3 rounded = points.rounded(id);
    const Number coordinates[] = {exact.x, exact.y, exact.z};
    for (int i = 0; i < 3; ++i) {
      const Number distance = abs(Number(static_cast<double>(rounded[i])) - coordinates[i]);
      for (const float limit : {-INFINITY, INFINITY}) {
        const Number neighbour(static_cast<double>(std::nextafter(rounded[i], limit)));
        // Twice rounded, once to double: half an ulp of a double may be lost.
        ASSERT_LE(distance, abs(neighbour - coordinates[i]) * (1 + Number(0x1p-20)));
      }
    }
  }
}

TEST_P(PointSigns, CoincideWhereRationalArithmeticSaysSo) {
  const CutSource source(GetParam());
  const auto& [mesh, space, points, ids] = source;
  const Oracle oracle(points);
  std::vector<Exact> exact;
  for (const PointId id : ids) exact.push_back(oracle.point(id));
  const std::vector<PointId> same = identify_points(points);
  std::size_t coincide = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const bool is_same = exact[i] == exact[j];
      ASSERT_EQ(points.coincide(ids[i], ids[j]), is_same);
      ASSERT_EQ(same[ids[i]] == same[ids[j]], is_same);
      coincide += is_same;
    }
  }
  // Parts that a plane leaves side by side are cut by the next one in the same points.
  EXPECT_GT(coincide, 0u);
}

// Two planes through one line meet an edge in the same point, and so does the edge with that line's facets.
TEST(Points, RoundToTheSameBitsHoweverDefined) {
  std::mt19937 random(7);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (int i = 0; i < 200; ++i) {
    // An edge of 0 and 1; facet (2, 3, 4) crosses it; the edge's point is where that plane meets the planes of two
    // facets that share the edge, (0, 1, 5) and (1, 0, 6).
    Mesh mesh;
    for (int v = 0; v < 7; ++v) mesh.positions.push_back(glm::vec3{uniform(), uniform(), uniform()});
    mesh.positions[0].z -= 2;
    mesh.positions[1].z += 2;
    mesh.triangles = {{2, 3, 4}, {0, 1, 5}, {1, 0, 6}, {3, 4, 2}};
    const PointSpace space = space_of(mesh.view());
    Points points(space);
    if (points.side(0, 0) * points.side(0, 1) >= 0) continue;
    const PointId on_edge = points.add({PointDefinition::edge_and_plane, 0, 1, 0});
    const PointId other_plane = points.add({PointDefinition::edge_and_plane, 0, 1, 3});
    const PointId of_planes = points.add({PointDefinition::three_planes, 0, 1, 2});
    EXPECT_EQ(points.rounded(on_edge), points.rounded(other_plane));
    EXPECT_EQ(points.rounded(on_edge), points.rounded(of_planes));
    EXPECT_TRUE(points.coincide(on_edge, other_plane) && points.coincide(of_planes, on_edge));
    const std::vector<PointId> same = identify_points(points);
    EXPECT_TRUE(same[other_plane] == on_edge && same[of_planes] == on_edge && same[on_edge] == on_edge);
    EXPECT_EQ(points.orientation(0, 1, of_planes, 5), 0);
    EXPECT_EQ(points.side(0, of_planes), 0);
  }
}

TEST(Points, OfABaseAreSharedAndTruncated) {
  const Mesh mesh = shapes::soup(4, 3);
  const PointSpace space = space_of(mesh.view());
  Points base(space);
  const std::vector<PointId> made = make_points(base, 100);
  ASSERT_GE(made.size(), 2u);
  Points above(&base);
  EXPECT_EQ(above.size(), base.size());
  const PointId again = above.add(base.definition(made[0]));
  EXPECT_EQ(again, base.size());
  EXPECT_EQ(above.definition(again), base.definition(made[0]));
  EXPECT_EQ(above.rounded(again), above.rounded(made[0]));
  const PlaneId plane = above.add_plane({0, 4, 8});
  EXPECT_EQ(plane, mesh.triangles.size());
  EXPECT_EQ(above.plane(plane), (CutPlane{0, 4, 8}));
  EXPECT_EQ(above.side(plane, 4), 0);
  above.truncate(base.size());
  EXPECT_EQ(above.size(), base.size());
}

TEST(CutInTwo, PartsAPolygonAndNamesItsEdges) {
  // A facet in z = 0 and three planes: through its middle, through a corner, beside it.
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0},  {1, 0, -1}, {1, 1, 1}, {1, -1, 1},
                    {0, 0, 5}, {1, 1, 5}, {-1, 0, 0}, {-1, 1, 0}, {-1, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {0, 6, 7}, {8, 9, 10}};
  const PointSpace space = space_of(mesh.view());
  Points points(space);
  const Polygon whole = whole_facet(space, 0);
  ASSERT_EQ(whole.corners.size(), 3u);
  EXPECT_TRUE(whole.cuts.empty());
  Polygon front, back;
  std::vector<int> sides;

  ASSERT_TRUE(cut_in_two(points, 0, whole, 1, front, back, sides));  // x = 1
  const Polygon &corner_side = front.corners.size() == 3 ? back : front,
                &triangle = front.corners.size() == 3 ? front : back;
  EXPECT_EQ(triangle.corners.size(), 3u);
  EXPECT_EQ(corner_side.corners.size(), 4u);
  EXPECT_EQ(points.size(), mesh.positions.size() + 2);
  for (const auto& [polygon, side] : {std::pair{&front, 1}, std::pair{&back, -1}}) {
    ASSERT_EQ(polygon->cuts.size(), 1u);
    EXPECT_EQ(polygon->cuts[0].plane, 1u);
    EXPECT_EQ(polygon->cuts[0].side, side);
    for (std::size_t i = 0; i < polygon->corners.size(); ++i) {
      const PartCorner& corner = polygon->corners[i];
      const PartCorner& next = polygon->corners[(i + 1) % polygon->corners.size()];
      EXPECT_GE(points.side(1, corner.point) * side, 0);
      const bool on_cut = points.side(1, corner.point) == 0 && points.side(1, next.point) == 0;
      EXPECT_EQ(!is_facet_edge(corner.line), on_cut);
    }
  }

  ASSERT_TRUE(cut_in_two(points, 0, whole, 2, front, back, sides));  // x = y, through corner 0
  EXPECT_EQ(front.corners.size(), 3u);
  EXPECT_EQ(back.corners.size(), 3u);
  const auto has_corner_0 = [](const Polygon& polygon) {
    return std::any_of(polygon.corners.begin(), polygon.corners.end(),
                       [](const PartCorner& c) { return c.point == 0; });
  };
  EXPECT_TRUE(has_corner_0(front) && has_corner_0(back));

  const std::size_t before = points.size();
  EXPECT_FALSE(cut_in_two(points, 0, whole, 3, front, back, sides));  // x = -1
  EXPECT_FALSE(cut_in_two(points, 0, whole, 0, front, back, sides));  // its own
  EXPECT_EQ(points.size(), before);
}

}  // namespace
}  // namespace facetsort::exact_internal
