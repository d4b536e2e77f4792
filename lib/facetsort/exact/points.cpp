#include "facetsort/exact/points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "facetsort/exact/integers.h"
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

Integer determinant(const IntegerVector& a, const IntegerVector& b, const IntegerVector& c, const IntegerVector& d) {
  return dot(cross(b - a, c - a), d - a);
}

ExactPoint with_positive_weight(IntegerVector p, Integer w) {
  if (w < 0) return {{-p.x, -p.y, -p.z}, -w};
  return {std::move(p), std::move(w)};
}

// The float32 coordinates that define a point: 1 (a vertex), 5 (an edge, then a plane) or 9 (three planes).
struct Coordinates {
  int count = 0;
  std::array<glm::vec3, 9> p;

  void add(const glm::vec3& point) { p[count++] = point; }
};

void add_plane(const Points& points, PlaneId plane, Coordinates& coordinates) {
  const glm::uvec3 vertices = points.plane_vertices(plane);
  for (int i = 0; i < 3; ++i) coordinates.add(points.space().position(vertices[i]));
}

Coordinates coordinates_of(const Points& points, const PointDefinition& definition) {
  Coordinates coordinates;
  if (definition.kind == PointDefinition::edge_and_plane) {
    coordinates.add(points.space().position(definition.a));
    coordinates.add(points.space().position(definition.b));
    add_plane(points, definition.c, coordinates);
  } else {
    for (const PlaneId plane : {definition.a, definition.b, definition.c}) add_plane(points, plane, coordinates);
  }
  return coordinates;
}

Coordinates coordinates_of(const Points& points, PointId point) {
  if (!points.is_vertex(point)) return coordinates_of(points, points.definition(point));
  Coordinates coordinates;
  coordinates.add(points.space().position(point));
  return coordinates;
}

int lowest_exponent(const Coordinates& coordinates) {
  int lowest = std::numeric_limits<int>::max();
  for (int i = 0; i < coordinates.count; ++i) {
    for (int k = 0; k < 3; ++k) lowest = std::min(lowest, Dyadic(coordinates.p[i][k]).exponent);
  }
  return lowest;
}

// 0 when all coordinates are zero.
template <std::size_t n>
int lowest_exponent(const std::array<Coordinates, n>& all) {
  int lowest = std::numeric_limits<int>::max();
  for (const Coordinates& coordinates : all) lowest = std::min(lowest, lowest_exponent(coordinates));
  return lowest == std::numeric_limits<int>::max() ? 0 : lowest;
}

ExactPoint exact_point(const Coordinates& coordinates, int exponent) {
  const auto p = [&](int i) { return scaled_integers(glm::dvec3(coordinates.p[i]), exponent); };
  if (coordinates.count == 1) return {p(0), Integer(1)};
  if (coordinates.count == 5) {
    const IntegerVector from = p(0), to = p(1), a = p(2), b = p(3), c = p(4);
    const Integer side_from = determinant(a, b, c, from), side_to = determinant(a, b, c, to);
    return with_positive_weight(side_to * from - side_from * to, side_to - side_from);
  }
  // On the first plane, with the weights of its three vertices for coordinates, the other two planes are lines; lines
  // meet in their cross product.
  const std::array<IntegerVector, 3> corner = {p(0), p(1), p(2)};
  IntegerVector line[2];
  for (int k = 0; k < 2; ++k) {
    const IntegerVector a = p(3 + 3 * k), b = p(4 + 3 * k), c = p(5 + 3 * k);
    line[k] = {determinant(a, b, c, corner[0]), determinant(a, b, c, corner[1]), determinant(a, b, c, corner[2])};
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
  const int exponent = lowest_exponent(std::array{coordinates});
  const ExactPoint point = exact_point(coordinates, exponent);
  return {quotient(point.p.x, point.w, exponent), quotient(point.p.y, point.w, exponent),
          quotient(point.p.z, point.w, exponent)};
}

double sum_of_magnitudes(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

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

// The corners of a plane.
std::array<glm::vec3, 3> corners_of(const Points& points, PlaneId plane) {
  const glm::uvec3 v = points.plane_vertices(plane);
  return {points.space().position(v.x), points.space().position(v.y), points.space().position(v.z)};
}

Bounded bounded_side(const Points& points, PlaneId plane, const glm::dvec3& point) {
  const auto corner = corners_of(points, plane);
  const glm::dvec3 a(corner[0]), b(corner[1]), c(corner[2]);
  return bounded_determinant(b - a, 0, c - a, 0, point - a, 0);
}

// The point in double and a bound on its error, not finite where double can't tell.
std::pair<glm::dvec3, double> approximate(const Points& points, const PointDefinition& definition) {
  if (definition.kind == PointDefinition::edge_and_plane) {
    const glm::dvec3 p(points.space().position(definition.a)), q(points.space().position(definition.b));
    const Bounded from = bounded_side(points, definition.c, p), to = bounded_side(points, definition.c, q);
    const double difference = from.value - to.value, error = from.error + to.error;
    const double certain = std::abs(difference) - error;
    if (!(certain > 0)) return {{}, INFINITY};
    const double t = from.value / difference;
    const double t_error = 2 * error / certain + 4 * half_epsilon;
    return {p + t * (q - p), t_error * sum_of_magnitudes(q - p) + 4 * half_epsilon * sum_of_magnitudes(p)};
  }
  std::array<glm::dvec3, 3> corner;
  for (int i = 0; i < 3; ++i) corner[i] = corners_of(points, definition.a)[i];
  glm::dvec3 line[2];
  double line_error[2];
  for (int k = 0; k < 2; ++k) {
    double largest = 0;
    line_error[k] = 0;
    for (int i = 0; i < 3; ++i) {
      const Bounded side = bounded_side(points, k == 0 ? definition.b : definition.c, corner[i]);
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
  return {corner[0] + offset, reach * (8 * weight_error / certain + 8 * half_epsilon) +
                                  4 * half_epsilon * sum_of_magnitudes(corner[0])};
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
  // A double in error by more than this, over its largest coordinate, is no use in a filter.
  constexpr double largest_error = 0x1p-44;
  auto [position, error] = approximate(*this, definition);
  const auto magnitude = [](const glm::dvec3& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); };
  if (!(error <= largest_error * magnitude(position))) {
    position = exact_position(coordinates_of(*this, definition));
    error = 4 * half_epsilon * magnitude(position);
  }
  made_.push_back({definition, position, error});
  return static_cast<PointId>(size() - 1);
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

// A vertex of the plane, or of a facet in it.
bool Points::known_vertex_in_plane(PointId vertex, PlaneId plane) const {
  const glm::uvec3 v = plane_vertices(plane);
  const std::vector<PointId>& position = space_->position_of_vertex;
  if (position[v.x] == vertex || position[v.y] == vertex || position[v.z] == vertex) return true;
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
  if (d.kind == PointDefinition::edge_and_plane) return known_vertex_in_plane(d.a, plane) && known_vertex_in_plane(d.b, plane);
  return same_plane(d.a) == same_plane(plane) || same_plane(d.b) == same_plane(plane);
}

bool Points::known_collinear(PointId a, PointId b, PointId c) const {
  if (a == b || b == c || c == a) return true;
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
      continue;
    }
    for (const auto& [f, g] : {std::pair{d.a, d.b}, std::pair{d.b, d.c}, std::pair{d.a, d.c}}) {
      const auto on_line = [&, f = f, g = g](PointId p) { return known_in_plane(p, f) && known_in_plane(p, g); };
      if (on_line(a) && on_line(b) && on_line(c)) return true;
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
  const Bounded value =
      bounded_determinant(position(b) - origin, error(b) + origin_error, position(c) - origin,
                          error(c) + origin_error, position(d) - origin, error(d) + origin_error);
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_collinear(a, b, c) || known_collinear(a, b, d) || known_collinear(a, c, d) || known_collinear(b, c, d)) {
    return 0;
  }
  ++fallback_count;
  const std::array all = {coordinates_of(*this, a), coordinates_of(*this, b), coordinates_of(*this, c),
                          coordinates_of(*this, d)};
  const int exponent = lowest_exponent(all);
  return exact_orientation(exact_point(all[0], exponent), exact_point(all[1], exponent),
                           exact_point(all[2], exponent), exact_point(all[3], exponent));
}

int Points::turn(PointId a, PointId b, PointId c, const Eye& eye) const {
  if (is_vertex(a) && is_vertex(b) && is_vertex(c)) {
    return side_of_plane(space_->position(a), space_->position(b), space_->position(c), eye);
  }
  const glm::dvec3 origin = position(a), target(eye);
  const double origin_error = error(a);
  const Bounded value = bounded_determinant(position(b) - origin, error(b) + origin_error, position(c) - origin,
                                            error(c) + origin_error, eye.w == 0 ? target : target - origin,
                                            eye.w == 0 ? 0 : origin_error);
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_collinear(a, b, c)) return 0;
  ++fallback_count;
  Coordinates seen_from;
  seen_from.add(glm::vec3(eye));
  const std::array all = {coordinates_of(*this, a), coordinates_of(*this, b), coordinates_of(*this, c), seen_from};
  const int exponent = lowest_exponent(all);
  ExactPoint exact_eye = exact_point(seen_from, exponent);
  if (eye.w == 0) exact_eye.w = 0;
  return exact_orientation(exact_point(all[0], exponent), exact_point(all[1], exponent),
                           exact_point(all[2], exponent), exact_eye);
}

int Points::side(PlaneId plane, PointId point) const {
  const auto [a, b, c] = corners_of(*this, plane);
  const glm::dvec3 origin(a);
  const Bounded value = bounded_determinant(glm::dvec3(b) - origin, 0, glm::dvec3(c) - origin, 0,
                                            position(point) - origin, error(point));
  if (std::abs(value.value) > value.error) return sign(value.value);
  if (known_in_plane(point, plane)) return 0;
  const glm::uvec3 v = plane_vertices(plane);
  return orientation(v.x, v.y, v.z, point);
}

}  // namespace facetsort::exact_internal
