#include "shapes.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <span>
#include <utility>

namespace facetsort::shapes {
namespace {

constexpr double pi = std::numbers::pi;

// Appends `part`, its corners moved to position * scale + offset.
void append(Mesh& mesh, const Mesh& part, const glm::dvec3& scale, const glm::dvec3& offset) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec3& p : part.positions) mesh.positions.push_back(glm::vec3(glm::dvec3(p) * scale + offset));
  for (const glm::uvec3& t : part.triangles) mesh.triangles.push_back(t + first);
}

// A torus knot on the torus of radii 2/3 and 1/3, with the tangent and the torus's normal, which is perpendicular to it
// and comes back to itself after one round: a frame for a closed tube.
struct KnotPoint {
  glm::dvec3 position, tangent, normal;
  double speed;  // length of the derivative by the angle
};

KnotPoint knot_point(double angle, int p, int q) {
  const double cp = std::cos(p * angle), sp = std::sin(p * angle);
  const double cq = std::cos(q * angle), sq = std::sin(q * angle);
  const glm::dvec3 derivative(-q * sq * cp - p * (2 + cq) * sp, -q * sq * sp + p * (2 + cq) * cp, q * cq);
  const double speed = glm::length(derivative);
  return {glm::dvec3((2 + cq) * cp, (2 + cq) * sp, sq) / 3.0, derivative / speed, {cq * cp, cq * sp, sq}, speed / 3};
}

struct KnotMeasure {
  double length;
  double thickness;  // radius at which a round tube first touches itself or folds at a bend
};

// Thickness: the smallest circle through two points of the curve, tangent to it at one of them (Gonzalez and Maddocks
// 1999, "Global curvature, thickness, and the ideal shapes of knots").
KnotMeasure measure_knot(int p, int q) {
  constexpr int samples = 720;
  std::vector<KnotPoint> points;
  for (int i = 0; i < samples; ++i) points.push_back(knot_point(2 * pi * i / samples, p, q));
  KnotMeasure measure{0, std::numeric_limits<double>::infinity()};
  for (const KnotPoint& a : points) {
    measure.length += a.speed * 2 * pi / samples;
    for (const KnotPoint& b : points) {
      const glm::dvec3 chord = b.position - a.position;
      const double sine_times_chord = glm::length(glm::cross(chord, a.tangent));
      if (sine_times_chord == 0) continue;  // the point itself, or one straight ahead: a circle without bound
      measure.thickness = std::min(measure.thickness, glm::dot(chord, chord) / (2 * sine_times_chord));
    }
  }
  return measure;
}

// A regular polygon's corners and edges, along which the cycles lay their members: member k runs from before corner k
// to beyond corner k + 1 and climbs from -rise to +rise, so its end lies over the start of the next.
struct RingMember {
  glm::dvec3 start, end;
  glm::dvec3 side;  // unit, horizontal, to the left of the direction from start to end
  double edge;      // length of the polygon's edge, the scale of everything else
};

RingMember ring_member(int k, int n) {
  const auto corner = [n](int i) { return glm::dvec3(std::cos(2 * pi * i / n), std::sin(2 * pi * i / n), 0); };
  const double edge = 2 * std::sin(pi / n);
  const glm::dvec3 along = (corner(k + 1) - corner(k)) / edge;
  // A quarter of an edge beyond the corner: long enough to cross the neighbour, too short to meet the one after it.
  const glm::dvec3 overhang = 0.25 * edge * along, climb(0, 0, 0.25 * edge);
  return {corner(k) - overhang - climb, corner(k + 1) + overhang + climb, {-along.y, along.x, 0}, edge};
}

std::uint32_t midpoint(Mesh& mesh, std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t>& midpoints,
                       std::uint32_t a, std::uint32_t b) {
  const auto [entry, is_new] =
      midpoints.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.positions.size()));
  if (is_new) {
    mesh.positions.push_back(glm::vec3(glm::normalize(glm::dvec3(mesh.positions[a]) + glm::dvec3(mesh.positions[b]))));
  }
  return entry->second;
}

// Numbers in [0, 1). The standard leaves the distributions to each library: 24 of the generator's bits are the same
// everywhere.
class UniformNumbers {
 public:
  explicit UniformNumbers(std::uint32_t seed) : random_(seed) {}
  float next() { return static_cast<float>(random_() >> 8) * 0x1p-24f; }
  glm::vec3 next_point() {
    const float x = next(), y = next(), z = next();
    return {x, y, z};
  }

 private:
  std::mt19937 random_;
};

void append_triangle(Mesh& mesh, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// Quads between successive pairs of vertices, two a step, from `first` on.
void append_ribbon(Mesh& mesh, std::uint32_t first, int quads) {
  for (int i = 0; i < quads; ++i) {
    const std::uint32_t right = first + 2 * static_cast<std::uint32_t>(i), left = right + 1;
    mesh.triangles.push_back({right, right + 2, left + 2});
    mesh.triangles.push_back({right, left + 2, left});
  }
}

}  // namespace

Mesh torus_knot(std::size_t facets, int p, int q) {
  assert(facets >= fewest_knot_facets && p >= 1 && p <= 8 && q >= 1 && q <= 8 && std::gcd(p, q) == 1);
  const KnotMeasure measure = measure_knot(p, q);
  const double radius = measure.thickness / 2;
  const double quads = static_cast<double>(facets) / 2;
  const int sides = std::max(5, static_cast<int>(std::lround(std::sqrt(quads * 2 * pi * radius / measure.length))));
  const int rings = static_cast<int>(std::lround(quads / sides));

  Mesh mesh;
  for (int i = 0; i < rings; ++i) {
    const KnotPoint centre = knot_point(2 * pi * i / rings, p, q);
    const glm::dvec3 binormal = glm::cross(centre.tangent, centre.normal);
    for (int j = 0; j < sides; ++j) {
      const double angle = 2 * pi * j / sides;
      mesh.positions.push_back(
          glm::vec3(centre.position + radius * (std::cos(angle) * centre.normal + std::sin(angle) * binormal)));
    }
  }
  for (int i = 0; i < rings; ++i) {
    const auto vertex = [&](int ring, int side) {
      return static_cast<std::uint32_t>((ring % rings) * sides + side % sides);
    };
    for (int j = 0; j < sides; ++j) {
      const std::uint32_t a = vertex(i, j), b = vertex(i, j + 1), c = vertex(i + 1, j + 1), d = vertex(i + 1, j);
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  return mesh;
}

Mesh nested_shells(int layers, float gap, int subdivisions) {
  assert(layers >= 1 && gap >= 1e-5f && (layers - 1) * double{gap} < 1);
  const Mesh sphere = icosphere(subdivisions);
  Mesh mesh;
  for (int i = 0; i < layers; ++i) append(mesh, sphere, glm::dvec3(1 - i * double{gap}), glm::dvec3(0));
  return mesh;
}

Mesh slab_cycle(int n) {
  assert(n >= 3);
  const Mesh cube = box();
  Mesh mesh;
  for (int k = 0; k < n; ++k) {
    const RingMember member = ring_member(k, n);
    const glm::dvec3 half_length = (member.end - member.start) / 2.0;
    const glm::dvec3 half_width = 0.1 * member.edge * member.side;
    const glm::dvec3 half_height = 0.02 * member.edge * glm::normalize(glm::cross(half_length, half_width));
    const glm::dvec3 centre = (member.start + member.end) / 2.0;
    Mesh slab = cube;
    for (glm::vec3& p : slab.positions) {
      p = glm::vec3(centre + double{p.x} * half_length + double{p.y} * half_width + double{p.z} * half_height);
    }
    append(mesh, slab, glm::dvec3(1), glm::dvec3(0));
  }
  return mesh;
}

Mesh triangle_cycle(int n) {
  assert(n >= 3);
  Mesh mesh;
  for (int k = 0; k < n; ++k) {
    const RingMember member = ring_member(k, n);
    const glm::dvec3 half_width = 0.1 * member.edge * member.side;
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::dvec3& corner : {member.start - half_width, member.end, member.start + half_width}) {
      mesh.positions.push_back(glm::vec3(corner));
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

Mesh interpenetrating(int subdivisions) {
  Mesh mesh = icosphere(subdivisions);
  // Off centre and with three different sides, so that no symmetry hides a wrong order.
  append(mesh, box(), {0.9, 0.75, 0.6}, {0.3, 0.2, 0.1});
  return mesh;
}

Mesh sliver_fan(int n, float aspect) {
  assert(n >= 1 && aspect >= 1 && aspect <= 1e6f && n <= 6 * double{aspect});
  constexpr double depth = 0.2;  // of the cone, over its radius
  const double width = std::hypot(1, depth) / double{aspect};
  const double angle = 2 * std::asin(width / 2);
  Mesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  for (int i = 0; i <= n; ++i) {
    mesh.positions.push_back(glm::vec3(glm::dvec3(std::cos(i * angle), std::sin(i * angle), -depth)));
  }
  for (std::uint32_t i = 1; i <= static_cast<std::uint32_t>(n); ++i) mesh.triangles.push_back({0, i, i + 1});
  return mesh;
}

Mesh many_scales() {
  const float unit = static_cast<float>(1 / std::sqrt(3.0));  // corners at distance 1
  const Mesh tetrahedron{{{unit, unit, unit}, {unit, -unit, -unit}, {-unit, unit, -unit}, {-unit, -unit, unit}},
                         {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {1, 3, 2}},
                         {},
                         {}};
  Mesh mesh;
  for (int power = -6; power <= 6; ++power) {
    const double size = std::pow(10.0, power);
    append(mesh, tetrahedron, glm::dvec3(size), glm::dvec3(0));
    // Clear of the first (its ball ends at 1, this one's begins at 1.2) and inside the next (whose faces are at 3.3).
    append(mesh, tetrahedron, glm::dvec3(size), glm::dvec3(2.2 * size, 0, 0));
  }
  return mesh;
}

Mesh soup(std::size_t n, std::uint32_t seed) {
  UniformNumbers uniform(seed);
  Mesh mesh;
  for (std::size_t i = 0; i < 3 * n; ++i) mesh.positions.push_back(uniform.next_point());
  for (std::uint32_t i = 0; i < n; ++i) mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  return mesh;
}

Mesh scattered(std::size_t n, float size, std::uint32_t seed) {
  assert(size > 0);
  UniformNumbers uniform(seed);
  Mesh mesh;
  for (std::size_t i = 0; i < n; ++i) {
    const glm::vec3 centre = uniform.next_point();
    glm::vec3 corner[3];
    for (glm::vec3& p : corner) p = centre + size * (uniform.next_point() - 0.5f);
    append_triangle(mesh, corner[0], corner[1], corner[2]);
  }
  return mesh;
}

Mesh woven_mat(int n) {
  assert(n >= 2);
  constexpr float half_width = 0.2f, height = 0.1f;  // where each passes over the other they are 0.12 apart and more
  Mesh mesh;
  for (const bool along_x : {true, false}) {
    for (int ribbon = 0; ribbon < n; ++ribbon) {
      const auto first = static_cast<std::uint32_t>(mesh.positions.size());
      for (int crossing = 0; crossing < n; ++crossing) {
        const bool over = ((ribbon + crossing) % 2 == 0) == along_x;
        for (const float side : {-half_width, half_width}) {
          const float along = static_cast<float>(crossing);
          const float across = static_cast<float>(ribbon) + (along_x ? side : -side);
          mesh.positions.emplace_back(along_x ? along : across, along_x ? across : along, over ? height : -height);
        }
      }
      append_ribbon(mesh, first, n - 1);
    }
  }
  return mesh;
}

Mesh comb(int n) {
  assert(n >= 1);
  Mesh mesh;
  // A tooth falls along z = 0.2 - y: over the first bar, at y = 0 and z = 0, and under the second, at z = -0.1.
  const double spacing = 1.0 / n, width = 0.4 * spacing;
  for (int i = 0; i < n; ++i) {
    const double x = (i + 0.5) * spacing;
    append_triangle(mesh, glm::dvec3(x - width / 2, -0.2, 0.4), glm::dvec3(x + width / 2, -0.2, 0.4),
                    glm::dvec3(x, 1.2, -1));
  }
  append_triangle(mesh, glm::vec3(-0.2f, -0.05f, 0), glm::vec3(3, 0, 0), glm::vec3(-0.2f, 0.05f, 0));
  // Over the teeth where y is above 0.4, then across the first bar, at x = 2.1.
  append_triangle(mesh, glm::vec3(-0.2f, 0.9f, -0.1f), glm::vec3(2.4f, -0.1f, -0.1f), glm::vec3(-0.2f, 1, -0.1f));
  return mesh;
}

Mesh scroll(int turns, int facets_per_turn) {
  assert(turns >= 1 && facets_per_turn >= 6 && facets_per_turn % 2 == 0);
  const int quads = turns * facets_per_turn / 2;
  Mesh mesh;
  for (int i = 0; i <= quads; ++i) {
    const double angle = 4 * pi * i / facets_per_turn;
    const double radius = (turns + angle / (2 * pi)) / (2 * turns);  // so that the sheet keeps clear of the axis
    for (const double z : {-1.0, 1.0}) {
      mesh.positions.push_back(glm::vec3(glm::dvec3(radius * std::cos(angle), radius * std::sin(angle), z)));
    }
  }
  append_ribbon(mesh, 0, quads);
  return mesh;
}

Mesh coplanar(std::size_t n, std::uint32_t seed) {
  UniformNumbers uniform(seed);
  const auto point = [&] {
    const float x = std::floor(uniform.next() * 0x1p10f) * 0x1p-10f,
                y = std::floor(uniform.next() * 0x1p10f) * 0x1p-10f;
    return glm::vec3(x, y, x / 2 + y / 4);  // few enough bits to be exact
  };
  Mesh mesh;
  while (mesh.triangles.size() < n) {
    const glm::vec3 a = point(), b = point(), c = point();
    const glm::vec3 u = b - a, v = c - a;
    if (u.x * v.y != u.y * v.x) append_triangle(mesh, a, b, c);  // exact: products of 11 bits
  }
  return mesh;
}

Mesh duplicated_grid(int n, int copies) {
  assert(n >= 1 && copies >= 1);
  Mesh mesh;
  const auto vertex = [n](int x, int y) { return static_cast<std::uint32_t>(y * (n + 1) + x); };
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) mesh.positions.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0f);
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      mesh.triangles.push_back({vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1)});
      mesh.triangles.push_back({vertex(x, y), vertex(x + 1, y + 1), vertex(x, y + 1)});
    }
  }
  const std::size_t facets = mesh.triangles.size();
  for (int copy = 1; copy < copies; ++copy) {
    for (std::size_t f = 0; f < facets; ++f) {
      const glm::uvec3 t = mesh.triangles[f];
      const int turn = copy % 3;
      const glm::uvec3 turned(t[turn], t[(turn + 1) % 3], t[(turn + 2) % 3]);
      mesh.triangles.push_back(copy % 2 == 0 ? turned : glm::uvec3(turned.x, turned.z, turned.y));
    }
  }
  return mesh;
}

Mesh box() {
  Mesh mesh;
  for (int i = 0; i < 8; ++i) mesh.positions.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  constexpr std::array<std::array<std::uint32_t, 4>, 6> faces = {
      {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};
  for (const auto& [a, b, c, d] : faces) {
    mesh.triangles.push_back({a, b, c});
    mesh.triangles.push_back({a, c, d});
  }
  return mesh;
}

Mesh icosphere(int subdivisions) {
  assert(subdivisions >= 0 && subdivisions <= 10);
  Mesh mesh;
  // Three golden rectangles, one across each axis.
  for (int axis = 0; axis < 3; ++axis) {
    for (const double s : {-1.0, 1.0}) {
      for (const double t : {-1.0, 1.0}) {
        glm::dvec3 corner(0);
        corner[(axis + 1) % 3] = s;
        corner[(axis + 2) % 3] = t * std::numbers::phi;
        mesh.positions.push_back(glm::vec3(glm::normalize(corner)));
      }
    }
  }
  // The 20 faces are the triples of corners at mutual distance of an edge; wound by the side the centre is on.
  constexpr double edge_squared = 1.2;  // between an edge's 1.106 and the next distance's 2.894
  const auto adjacent = [&](std::uint32_t a, std::uint32_t b) {
    const glm::vec3 d = mesh.positions[a] - mesh.positions[b];
    return double{glm::dot(d, d)} < edge_squared;
  };
  for (std::uint32_t a = 0; a < 12; ++a) {
    for (std::uint32_t b = a + 1; b < 12; ++b) {
      for (std::uint32_t c = b + 1; c < 12; ++c) {
        if (!adjacent(a, b) || !adjacent(b, c) || !adjacent(c, a)) continue;
        const bool outwards = glm::dot(glm::cross(mesh.positions[a], mesh.positions[b]), mesh.positions[c]) > 0;
        mesh.triangles.push_back(outwards ? glm::uvec3(a, b, c) : glm::uvec3(a, c, b));
      }
    }
  }
  for (int i = 0; i < subdivisions; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> midpoints;
    std::vector<glm::uvec3> finer;
    for (const glm::uvec3 t : mesh.triangles) {
      const std::uint32_t ab = midpoint(mesh, midpoints, t.x, t.y);
      const std::uint32_t bc = midpoint(mesh, midpoints, t.y, t.z);
      const std::uint32_t ca = midpoint(mesh, midpoints, t.z, t.x);
      for (const glm::uvec3& quarter : {glm::uvec3(t.x, ab, ca), {ab, t.y, bc}, {ca, bc, t.z}, {ab, bc, ca}}) {
        finer.push_back(quarter);
      }
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

}  // namespace facetsort::shapes
