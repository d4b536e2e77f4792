#include "facetsort/exact/points.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

#include "facetsort/exact/integers.h"
#include "facetsort/exact/plane_normal.h"
#include "facetsort/exact/plane_points.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {
namespace {

constexpr double half_epsilon = std::numeric_limits<double>::epsilon() / 2;

// A homogeneous point in integers: (x, y, z) / w in units of a common power of two. w > 0, or 0 for a direction.
struct ExactPoint {
  IntegerVector p;
  Integer w;
};

IntegerVector operator*(const Integer& factor, const IntegerVector& v) {
  return {factor * v.x, factor * v.y, factor * v.z};
}

IntegerVector operator+(const IntegerVector& a, const IntegerVector& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

ExactPoint with_positive_weight(IntegerVector p, Integer w) {
  if (w < 0) return {{-p.x, -p.y, -p.z}, -w};
  return {std::move(p), std::move(w)};
}

// What defines a point in float32: a vertex; an edge, then a plane; or three planes.
struct Coordinates {
  int point_count = 0, plane_count = 0;
  std::array<glm::vec3, 2> point;
  std::array<PlanePoints, 3> plane;
};

Coordinates coordinates_of(const glm::vec3& point) {
  Coordinates coordinates;
  coordinates.point[coordinates.point_count++] = point;
  return coordinates;
}

void add_plane(const Points& points, PlaneId plane, Coordinates& coordinates) {
  coordinates.plane[coordinates.plane_count++] = points_of(points.space().mesh, points.plane(plane));
}

Coordinates coordinates_of(const Points& points, const PointDefinition& definition) {
  Coordinates coordinates;
  if (definition.kind == PointDefinition::edge_and_plane) {
    coordinates = coordinates_of(points.space().position(definition.a));
    coordinates.point[coordinates.point_count++] = points.space().position(definition.b);
    add_plane(points, definition.c, coordinates);
  } else {
    for (const PlaneId plane : {definition.a, definition.b, definition.c}) add_plane(points, plane, coordinates);
  }
  return coordinates;
}

Coordinates coordinates_of(const Points& points, PointId point) {
  if (points.is_vertex(point)) return coordinates_of(points.space().position(point));
  return coordinates_of(points, points.definition(point));
}

int lowest_exponent(const Coordinates& coordinates) {
  int lowest = std::numeric_limits<int>::max();
  for (int i = 0; i < coordinates.point_count; ++i) {
    lowest = std::min(lowest, common_exponent({glm::dvec3(coordinates.point[i])}));
  }
  for (int i = 0; i < coordinates.plane_count; ++i) lowest = std::min(lowest, plane_exponent(coordinates.plane[i]));
  return lowest;
}

template <std::size_t n>
int lowest_exponent(const std::array<Coordinates, n>& all) {
  int lowest = std::numeric_limits<int>::max();
  for (const Coordinates& coordinates : all) lowest = std::min(lowest, lowest_exponent(coordinates));
  return lowest;
}

// A plane in integers: the points x with dot(normal, x - origin) = 0.
struct ExactPlane {
  IntegerVector origin, normal;

  ExactPlane(const PlanePoints& plane, int exponent)
      : origin(scaled_integers(plane.points[0], exponent)), normal(plane_normal(plane, exponent)) {}

  Integer value_at(const IntegerVector& point) const { return dot(normal, point - origin); }
};

ExactPoint exact_point(const Coordinates& coordinates, int exponent) {
  const auto integers = [&](const glm::vec3& point) { return scaled_integers(glm::dvec3(point), exponent); };
  if (coordinates.plane_count == 0) return {integers(coordinates.point[0]), Integer(1)};
  if (coordinates.plane_count == 1) {
    const IntegerVector from = integers(coordinates.point[0]), to = integers(coordinates.point[1]);
    const ExactPlane plane(coordinates.plane[0], exponent);
    const Integer from_value = plane.value_at(from), to_value = plane.value_at(to);
    return with_positive_weight(to_value * from - from_value * to, to_value - from_value);
  }
  // On the first plane, a facet's, with the weights of its three vertices for coordinates, the other two planes are
  // lines; lines meet in their cross product.
  assert(!coordinates.plane[0].is_join);
  std::array<IntegerVector, 3> corner;
  for (int i = 0; i < 3; ++i) corner[i] = integers(coordinates.plane[0].points[i]);
  IntegerVector line[2];
  for (int k = 0; k < 2; ++k) {
    const ExactPlane plane(coordinates.plane[1 + k], exponent);
    line[k] = {plane.value_at(corner[0]), plane.value_at(corner[1]), plane.value_at(corner[2])};
  }
  const IntegerVector weight = cross(line[0], line[1]);
  return with_positive_weight(weight.x * corner[0] + weight.y * corner[1] + weight.z * corner[2],
                              weight.x + weight.y + weight.z);
}

// Sign of det[b - a, c - a, d - a] times the weights of all, which are not negative.
int exact_orientation(const ExactPoint& a, const ExactPoint& b, const ExactPoint& c, const ExactPoint& d) {
  const IntegerVector u = a.w * b.p - b.w * a.p, v = a.w * c.p - c.w * a.p, w = a.w * d.p - d.w * a.p;
  return sign(dot(cross(u, v), w));
}

// numerator / denominator * 2^exponent in double, within a relative 2^-52; a function of the value alone.
double quotient(const Integer& numerator, const Integer& denominator, int exponent) {
  if (numerator == 0) return 0;
  constexpr int digits = 80;
  const Integer magnitude = abs(numerator);
  int shift = digits + static_cast<int>(msb(denominator)) - static_cast<int>(msb(magnitude));
  const auto divided = [&] {
    return shift >= 0 ? Integer((magnitude << shift) / denominator) : Integer(magnitude / (denominator << -shift));
  };
  Integer result = divided();
  if (static_cast<int>(msb(result)) != digits - 1) {
    shift += digits - 1 - static_cast<int>(msb(result));
    result = divided();
  }
  const double value = std::ldexp(static_cast<double>(result), exponent - shift);
  return numerator < 0 ? -value : value;
}

glm::dvec3 exact_position(const Coordinates& coordinates) {
  ++fallback_count;
  const int exponent = lowest_exponent(coordinates);
  const ExactPoint point = exact_point(coordinates, exponent);
  return {quotient(point.p.x, point.w, exponent), quotient(point.p.y, point.w, exponent),
          quotient(point.p.z, point.w, exponent)};
}

// A value and a bound on its error.
struct Bounded {
  double value, error;
};

// det[u, v, w], where u, v and w have up to 2 ulp of rounding and the errors given.
Bounded bounded_determinant(const glm::dvec3& u, double u_error, const glm::dvec3& v, double v_error,
                            const glm::dvec3& w, double w_error) {
  const double uy_vz = u.y * v.z, uz_vy = u.z * v.y;
  const double uz_vx = u.z * v.x, ux_vz = u.x * v.z;
  const double ux_vy = u.x * v.y, uy_vx = u.y * v.x;
  const double value = w.x * (uy_vz - uz_vy) + w.y * (uz_vx - ux_vz) + w.z * (ux_vy - uy_vx);
  const double magnitude = std::abs(w.x) * (std::abs(uy_vz) + std::abs(uz_vy)) +
                           std::abs(w.y) * (std::abs(uz_vx) + std::abs(ux_vz)) +
                           std::abs(w.z) * (std::abs(ux_vy) + std::abs(uy_vx));
  const double largest_error = std::max({u_error, v_error, w_error});
  double error = 8 * half_epsilon * magnitude;
  if (largest_error > 0) {
    const double su = sum_of_magnitudes(u) + 3 * u_error, sv = sum_of_magnitudes(v) + 3 * v_error;
    const double sw = sum_of_magnitudes(w) + 3 * w_error;
    error = 1.0001 * error + 1.0001 * (sv * sw * u_error + su * sw * v_error + su * sv * w_error);
  }
  return {value, error};
}

Bounded bounded_side(const Points& points, PlaneId plane, const glm::dvec3& point, double point_error) {
  const auto [a, b, c, error] = points.corners(plane);
  return bounded_determinant(b - a, 0, c - a, error, point - a, point_error);
}

// The point in double and a bound on its error, not finite where double can't tell.
std::pair<glm::dvec3, double> approximate(const Points& points, const PointDefinition& definition) {
  if (definition.kind == PointDefinition::edge_and_plane) {
    const glm::dvec3 p(points.space().position(definition.a)), q(points.space().position(definition.b));
    const Bounded from = bounded_side(points, definition.c, p, 0);
    const Bounded to = bounded_side(points, definition.c, q, 0);
    const double difference = from.value - to.value, error = from.error + to.error;
    const double certain = std::abs(difference) - error;
    if (!(certain > 0)) return {{}, INFINITY};
    const double t = from.value / difference;
    const double t_error = 2 * error / certain + 4 * half_epsilon;
    return {p + t * (q - p), t_error * sum_of_magnitudes(q - p) + 4 * half_epsilon * sum_of_magnitudes(p)};
  }
  const Points::PlaneCorners facet = points.corners(definition.a);
  const std::array<glm::dvec3, 3> corner = {facet.a, facet.b, facet.c};
  glm::dvec3 line[2];
  double line_error[2];
  for (int k = 0; k < 2; ++k) {
    double largest = 0;
    line_error[k] = 0;
    for (int i = 0; i < 3; ++i) {
      const Bounded side = bounded_side(points, k == 0 ? definition.b : definition.c, corner[i], 0);
      line[k][i] = side.value;
      line_error[k] = std::max(line_error[k], side.error);
      largest = std::max(largest, std::abs(side.value));
    }
    if (!(largest > 0)) return {{}, INFINITY};
    line[k] /= largest;  // so that products of small coordinates stay within double
    line_error[k] = line_error[k] / largest + 2 * half_epsilon;
  }
  const glm::dvec3 weight = glm::cross(line[0], line[1]);
  const double weight_error = 2 * (line_error[0] + line_error[1] + line_error[0] * line_error[1]) + 8 * half_epsilon;
  const double sum = weight.x + weight.y + weight.z;
  const double certain = std::abs(sum) - 4 * weight_error;
  if (!(certain > 0)) return {{}, INFINITY};
  const glm::dvec3 ab = corner[1] - corner[0], ac = corner[2] - corner[0];
  const glm::dvec3 offset = (weight.y * ab + weight.z * ac) / sum;
  const double reach = sum_of_magnitudes(ab) + sum_of_magnitudes(ac);
  return {corner[0] + offset,
          reach * (8 * weight_error / certain + 8 * half_epsilon) + 4 * half_epsilon * sum_of_magnitudes(corner[0])};
}

// The point in double, and a bound on its error that leaves it of use in a filter.
std::pair<glm::dvec3, double> position_and_error(const Points& points, const PointDefinition& definition) {
  // A double in error by more than this, over its largest coordinate, is of none.
  constexpr double largest_error = 0x1p-44;
  auto [position, error] = approximate(points, definition);
  const auto magnitude = [](const glm::dvec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); };
  if (!(error <= largest_error * magnitude(position))) {
    position = exact_position(coordinates_of(points, definition));
    error = 4 * half_epsilon * magnitude(position);
  }
  return {position, error};
}

bool rounds_one_way(double value, double error) {
  return static_cast<float>(value - error) == static_cast<float>(value + error);
}

}  // namespace

PointDefinition PointDefinition::of_planes(PlaneId a, PlaneId b, PlaneId c) {
  std::array<PlaneId, 3> planes = {a, b, c};
  std::sort(planes.begin(), planes.end());
  return {three_planes, planes[0], planes[1], planes[2]};
}

void PointSpace::find_facets_around() {
  around_begin.assign(mesh.vertex_count() + 1, 0);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++around_begin[position_of_vertex[t[i]] + 1];
  }
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) around_begin[v + 1] += around_begin[v];
  around.resize(3 * mesh.facet_count());
  std::vector<std::uint32_t> next(around_begin.begin(), around_begin.end() - 1);
  for (FacetId f = 0; f < mesh.facet_count(); ++f) {
    for (int i = 0; i < 3; ++i) around[next[corner(f, i)]++] = f;
  }
}

PointId Points::add(const PointDefinition& definition) {
  const auto [position, error] = position_and_error(*this, definition);
  made_.push_back({definition, position, error});
  return static_cast<PointId>(size() - 1);
}

PlaneId Points::add_plane(const CutPlane& plane) {
  ThirdPoint third{glm::dvec3(space_->position(plane.third)), 0};
  if (plane.is_join()) {
    const auto [position, error] =
        position_and_error(*this, {PointDefinition::edge_and_plane, plane.third, plane.edge_end, plane.facet});
    third = {position, error};
  }
  planes_.push_back(plane);
  third_points_.push_back(third);
  return static_cast<PlaneId>(plane_count() - 1);
}

Points::PlaneCorners Points::corners_of_added(PlaneId plane) const {
  if (plane < first_plane_) return base_->corners(plane);
  const CutPlane& defining = planes_[plane - first_plane_];
  const ThirdPoint& third = third_points_[plane - first_plane_];
  return {glm::dvec3(space_->position(defining.first)), glm::dvec3(space_->position(defining.second)), third.position,
          third.error};
}

glm::vec3 Points::rounded(PointId point) const {
  if (is_vertex(point)) return space_->position(point);
  const Made& m = made(point);
  if (rounds_one_way(m.position.x, m.error) && rounds_one_way(m.position.y, m.error) &&
      rounds_one_way(m.position.z, m.error)) {
    return m.position;
  }
  return exact_position(coordinates_of(*this, point));
}

bool Points::coincide(PointId a, PointId b) const {
  if (a == b) return true;
  const glm::dvec3 difference = glm::abs(position(a) - position(b));
  const double bound = 1.0001 * (error(a) + error(b));  // and the difference's own rounding
  if (difference.x > bound || difference.y > bound || difference.z > bound) return false;
  ++fallback_count;
  const std::array both = {coordinates_of(*this, a), coordinates_of(*this, b)};
  const int exponent = lowest_exponent(both);
  const ExactPoint p = exact_point(both[0], exponent), q = exact_point(both[1], exponent);
  return q.w * p.p.x == p.w * q.p.x && q.w * p.p.y == p.w * q.p.y && q.w * p.p.z == p.w * q.p.z;
}

// A vertex of the plane, or of a facet in it.
bool Points::known_vertex_in_plane(PointId vertex, PlaneId plane) const {
  const CutPlane defining = this->plane(plane);
  const std::vector<PointId>& position = space_->position_of_vertex;
  if (position[defining.first] == vertex || position[defining.second] == vertex) return true;
  if (position[defining.third] == vertex && !defining.is_join()) return true;
  const PlaneId same = same_plane(plane);
  for (std::uint32_t i = space_->around_begin[vertex]; i < space_->around_begin[vertex + 1]; ++i) {
    if (space_->plane_of_facet[space_->around[i]] == same) return true;
  }
  return false;
}

bool Points::known_in_plane(PointId point, PlaneId plane) const {
  if (is_vertex(point)) return known_vertex_in_plane(point, plane);
  const PointDefinition& d = definition(point);
  if (same_plane(d.c) == same_plane(plane)) return true;
  if (d.kind == PointDefinition::edge_and_plane)
    return known_vertex_in_plane(d.a, plane) && known_vertex_in_plane(d.b, plane);
  return same_plane(d.a) == same_plane(plane) || same_plane(d.b) == same_plane(plane);
}

bool Points::known_collinear(PointId a, PointId b, PointId c) const {
  if (a == b || b == c || c == a) return true;
  const auto all_in_plane = [&](PlaneId plane) {
    return known_in_plane(a, plane) && known_in_plane(b, plane) && known_in_plane(c, plane);
  };
  for (const PointId made_point : {a, b, c}) {
    if (is_vertex(made_point)) continue;
    const PointDefinition& d = definition(made_point);
    if (d.kind == PointDefinition::edge_and_plane) {
      const auto on_edge = [&](PointId p) {
        if (is_vertex(p)) return p == d.a || p == d.b;
        const PointDefinition& other = definition(p);
        return other.kind == d.kind && other.a == d.a && other.b == d.b;
      };
      if (on_edge(a) && on_edge(b) && on_edge(c)) return true;
      if (all_in_plane(d.c) && space_->any_facet_with_edge(d.a, d.b, all_in_plane)) return true;
      continue;
    }
    for (const auto& [f, g] : {std::pair{d.a, d.b}, std::pair{d.b, d.c}, std::pair{d.a, d.c}}) {
      if (all_in_plane(f) && all_in_plane(g)) return true;
    }
  }
  return false;
}

int Points::orientation(PointId a, PointId b, PointId c, PointId d) const {
  if (is_vertex(a) && is_vertex(b) && is_vertex(c) && is_vertex(d)) {
    return facetsort::orientation(space_->position(a), space_->position(b), space_->position(c), space_->position(d));
  }
  const glm::dvec3 origin = position(a);
  const double origin_error = error(a);
  const Bounded value = bounded_determinant(position(b) - origin, error(b) + origin_error, position(c) - origin,
                                            error(c) + origin_error, position(d) - origin, error(d) + origin_error);
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_collinear(a, b, c) || known_collinear(a, b, d) || known_collinear(a, c, d) || known_collinear(b, c, d)) {
    return 0;
  }
  ++fallback_count;
  const std::array all = {coordinates_of(*this, a), coordinates_of(*this, b), coordinates_of(*this, c),
                          coordinates_of(*this, d)};
  const int exponent = lowest_exponent(all);
  return exact_orientation(exact_point(all[0], exponent), exact_point(all[1], exponent), exact_point(all[2], exponent),
                           exact_point(all[3], exponent));
}

int Points::turn(PointId a, PointId b, PointId c, const Eye& eye) const {
  if (is_vertex(a) && is_vertex(b) && is_vertex(c)) {
    return side_of_plane(space_->position(a), space_->position(b), space_->position(c), eye);
  }
  const glm::dvec3 origin = position(a), target(eye);
  const double origin_error = error(a);
  const Bounded value =
      bounded_determinant(position(b) - origin, error(b) + origin_error, position(c) - origin, error(c) + origin_error,
                          eye.w == 0 ? target : target - origin, eye.w == 0 ? 0 : origin_error);
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_collinear(a, b, c)) return 0;
  ++fallback_count;
  const Coordinates seen_from = coordinates_of(glm::vec3(eye));
  const std::array all = {coordinates_of(*this, a), coordinates_of(*this, b), coordinates_of(*this, c), seen_from};
  const int exponent = lowest_exponent(all);
  ExactPoint exact_eye = exact_point(seen_from, exponent);
  if (eye.w == 0) exact_eye.w = 0;
  return exact_orientation(exact_point(all[0], exponent), exact_point(all[1], exponent), exact_point(all[2], exponent),
                           exact_eye);
}

int Points::side(PlaneId plane, PointId point) const {
  const Bounded value = bounded_side(*this, plane, position(point), error(point));
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_in_plane(point, plane)) return 0;
  const CutPlane defining = this->plane(plane);
  if (!defining.is_join()) return orientation(defining.first, defining.second, defining.third, point);
  ++fallback_count;
  const PlanePoints plane_points = points_of(space_->mesh, defining);
  const Coordinates coordinates = coordinates_of(*this, point);
  const int exponent = std::min(plane_exponent(plane_points), lowest_exponent(coordinates));
  const ExactPoint exact = exact_point(coordinates, exponent);
  const ExactPlane exact_plane(plane_points, exponent);
  return sign(dot(exact_plane.normal, exact.p - exact.w * exact_plane.origin));
}

}  // namespace facetsort::exact_internal
