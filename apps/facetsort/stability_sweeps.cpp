#include "stability_sweeps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "facetsort/facets/facets.h"
#include "shapes.h"

namespace facetsort {
namespace {

constexpr double degree = std::numbers::pi / 180;

// Unit vectors along which no shape below has a symmetry that could hide an error.
constexpr std::array<glm::dvec3, sweep_views> directions{{{0.36, 0.48, 0.8}, {-0.8, 0.36, 0.48}, {0.48, -0.8, -0.36}}};

constexpr std::string_view inside = "inside", on_vertex = "on a vertex", on_facet = "on a facet";

// ---- Stops -----------------------------------------------------------------------------------------------------

std::vector<SweepStop> stops(std::initializer_list<double> values) {
  std::vector<SweepStop> list;
  for (const double value : values) list.push_back({value});
  return list;
}

// 10^first, 10^(first + step), ... 10^last, each the double nearest to its decimal.
std::vector<SweepStop> powers_of_ten(double first, double last, double step) {
  std::vector<SweepStop> list;
  const auto count = static_cast<int>(std::lround((last - first) / step));
  for (int i = 0; i <= count; ++i) list.push_back({std::pow(10.0, first + i * step)});
  return list;
}

std::vector<SweepStop> eye_distances() {
  std::vector<SweepStop> list{{0, inside}, {0, on_vertex}, {0, on_facet}};
  const std::vector<SweepStop> numbers = powers_of_ten(-6, 6, 1);
  list.insert(list.end(), numbers.begin(), numbers.end());
  return list;
}

// ---- Meshes ----------------------------------------------------------------------------------------------------

// Four clean spheres inside each other: every depth key is right on them, or nearly, while nothing is extreme.
Mesh shells() {
  return shapes::nested_shells(4, 0.1f, 2);
}
constexpr double innermost_shell = 0.7;

void transform(Mesh& mesh, double scale, const glm::dvec3& offset) {
  for (glm::vec3& p : mesh.positions) p = glm::vec3(glm::dvec3(p) * scale + offset);
}

void append(Mesh& mesh, const Mesh& part) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), part.positions.begin(), part.positions.end());
  for (const glm::uvec3& t : part.triangles) mesh.triangles.push_back(t + first);
}

// A grid of cells, two triangles each, wound counter-clockwise from +z: columns x rows of `cell` from `corner` on.
// `slope`: how much z rises by x.
void append_sheet(Mesh& mesh, int columns, int rows, const glm::dvec2& cell, const glm::dvec3& corner, double slope) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (int j = 0; j <= rows; ++j) {
    for (int i = 0; i <= columns; ++i) {
      const double x = corner.x + i * cell.x;
      mesh.positions.push_back(glm::vec3(glm::dvec3(x, corner.y + j * cell.y, corner.z + slope * x)));
    }
  }
  const auto vertex = [&](int i, int j) { return first + static_cast<std::uint32_t>(j * (columns + 1) + i); };
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
      mesh.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
    }
  }
}

// Where layer k's cells begin, as a share of a cell: neighbouring layers never line up.
double stagger(int layer) {
  const double turns = layer * (std::numbers::phi - 1);
  return turns - std::floor(turns);
}

// ---- Views -----------------------------------------------------------------------------------------------------

View view_from(const glm::dvec3& eye, const glm::dvec3& at, double vertical_fov_degrees, double near, int size) {
  View view;
  view.eye = glm::vec3(eye);
  view.at = glm::vec3(at);
  view.vertical_fov_degrees = static_cast<float>(vertical_fov_degrees);
  view.near_distance = static_cast<float>(near);
  view.width = view.height = size;
  return view;
}

// Field of view in which a ball fills most of the picture.
double filling_fov(double radius, double distance) {
  return 2 * std::asin(radius / distance) / degree;
}

// A ball seen from outside, filling the picture from wherever it is seen.
std::vector<View> views_of_ball(const glm::dvec3& centre, double radius, double distance, int size) {
  std::vector<View> views;
  for (const glm::dvec3& direction : directions) {
    views.push_back(view_from(centre + distance * direction, centre, filling_fov(radius, distance),
                              1e-3 * (distance - radius), size));
  }
  return views;
}

// ---- Scenes ----------------------------------------------------------------------------------------------------

SweepScene far_from_origin(const SweepStop& stop, int size) {
  SweepScene scene{shells(), {}};
  const double radius = static_cast<double>(facet_bounds(scene.mesh.view()).radius());
  const glm::dvec3 centre = stop.value * radius * directions[0];
  transform(scene.mesh, 1, centre);
  scene.views = views_of_ball(centre, 1, 2.5 * radius, size);
  return scene;
}

SweepScene scaled(const SweepStop& stop, int size) {
  SweepScene scene{shells(), {}};
  const double radius = static_cast<double>(facet_bounds(scene.mesh.view()).radius());
  transform(scene.mesh, stop.value, glm::dvec3(0));
  scene.views = views_of_ball(glm::dvec3(0), stop.value, 2.5 * radius * stop.value, size);
  return scene;
}

SweepScene contrasted(const SweepStop& stop, int size) {
  const double detail = 0.3 / stop.value;
  SweepScene scene{shapes::nested_shells(3, 0.2f, 1), {}};
  transform(scene.mesh, detail, glm::dvec3(0));
  Mesh around = shapes::icosphere(2);
  transform(around, 1, {0.4, 0.2, 0.3});  // still around the detail, with room to see it from
  append(scene.mesh, around);
  scene.views = views_of_ball(glm::dvec3(0), 1.5 * detail, 3 * detail, size / 2);
  return scene;
}

// This and the other scenes of sheets list them front to back: where a key can't tell two apart, ids are no help.
SweepScene stretched(const SweepStop& stop, int size) {
  constexpr int layers = 5, rows = 24;
  constexpr double spacing = 0.25, breadth = 0.1;
  const double length = breadth * stop.value;
  const int columns = static_cast<int>(std::ceil(2.4 / length)) + 1;  // covers 2.4 wherever the first cell begins
  SweepScene scene;
  for (int k = 0; k < layers; ++k) {
    const glm::dvec3 corner(-1.2 - stagger(k) * length, -1.2 - stagger(k + 1) * breadth, (k - 0.5 * layers) * spacing);
    append_sheet(scene.mesh, columns, rows + 1, {length, breadth}, corner, 0);
  }
  for (const glm::dvec3& eye : {glm::dvec3(0.9, 0.4, 3), glm::dvec3(-0.7, 0.8, 3), glm::dvec3(0.3, -1, 3)}) {
    scene.views.push_back(view_from(eye, glm::dvec3(0), 30, 1e-3, size / 2));
  }
  return scene;
}

SweepScene layered_closely(const SweepStop& stop, int size) {
  constexpr int layers = 5, cells = 16;
  constexpr double cell = 2.0 / cells;
  const double gap = stop.value * std::numbers::sqrt2;  // of the sheets' bounding radius
  SweepScene scene;
  for (int k = 0; k < layers; ++k) {
    append_sheet(scene.mesh, cells, cells, {cell, cell},
                 {-1 - stagger(k) * cell, -1 - stagger(k + 1) * cell, (0.5 * (layers - 1) - k) * gap}, 0);
  }
  for (const glm::dvec3& eye : {glm::dvec3(0.6, 0.3, 3.5), glm::dvec3(-0.5, 0.7, 3.5), glm::dvec3(0.2, -0.8, 3.5)}) {
    scene.views.push_back(view_from(eye, glm::dvec3(0), 28, 1e-3, size));
  }
  return scene;
}

SweepScene seen_at_an_angle(const SweepStop& stop, int size) {
  SweepScene scene{shells(), {}};
  const glm::dvec3 eye(0.2, -0.1, 0.15);
  for (const glm::dvec3& direction : directions) {
    scene.views.push_back(view_from(eye, eye + direction, stop.value, 1e-3, size));
  }
  return scene;
}

SweepScene near_to_far(const SweepStop& stop, int size) {
  constexpr int layers = 9, cells = 6;
  SweepScene scene;
  for (int k = 0; k < layers; ++k) {
    const double distance = std::pow(stop.value, static_cast<double>(k) / (layers - 1) - 1);
    const double cell = 1.5 * distance / cells;
    append_sheet(scene.mesh, cells + 1, cells + 1, {cell, cell},
                 {-0.75 * distance - stagger(k) * cell, -0.75 * distance - stagger(k + 1) * cell, -distance}, 0.05);
  }
  for (const glm::dvec3& at : {glm::dvec3(0.03, -0.02, -1), glm::dvec3(0.1, 0.05, -1), glm::dvec3(-0.12, 0.08, -1)}) {
    scene.views.push_back(view_from(glm::dvec3(0), at, 45, 1 / stop.value, size / 2));
  }
  return scene;
}

SweepScene seen_from_a_distance(const SweepStop& stop, int size) {
  SweepScene scene{shells(), {}};
  const MeshView mesh = scene.mesh.view();
  const double radius = static_cast<double>(facet_bounds(mesh).radius());
  const double distance = stop.value * radius;
  const double near = std::max(1e-3 * distance, 1e-9);
  for (std::size_t i = 0; i < sweep_views; ++i) {
    // A facet of the outermost shell, and the way out through its middle.
    const std::size_t facet = 40 + 90 * i;
    const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
    const glm::dvec3 centroid = (a + b + c) / 3.0;
    const glm::dvec3 outwards = glm::normalize(glm::cross(b - a, c - a));
    const glm::dvec3 ahead = 0.1 * directions[i];  // off the centre, which the eye is on the axis of
    if (stop.place == inside) {
      scene.views.push_back(view_from(0.5 * innermost_shell * directions[i], 2.0 * centroid, 60, 1e-3, size));
    } else if (stop.place == on_vertex) {
      scene.views.push_back(view_from(a, ahead, 60, near, size));
    } else {
      const glm::dvec3 eye = centroid + distance * outwards;
      const double to_centre = std::sqrt(glm::dot(eye, eye));
      const double fov = to_centre > 2 ? filling_fov(1, to_centre) : 60;
      scene.views.push_back(view_from(eye, ahead, fov, near, size));
    }
  }
  return scene;
}

SweepScene many_layers(const SweepStop& stop, int size) {
  constexpr int cells = 4;
  constexpr double cell = 0.5, spacing = 0.2;
  const int layers = static_cast<int>(stop.value);
  SweepScene scene;
  for (int k = 0; k < layers; ++k) {
    append_sheet(scene.mesh, cells + 1, cells + 1, {cell, cell},
                 {-1 - stagger(k) * cell, -1 - stagger(k + 1) * cell, (0.5 * (layers - 1) - k) * spacing}, 0);
  }
  for (const glm::dvec3& eye : {glm::dvec3(0.001, 0.0005, 1), glm::dvec3(-0.002, 0.001, 1), glm::dvec3(0, -0.003, 1)}) {
    View view = view_from((layers * spacing + 1) * eye, glm::dvec3(0), 45, 1e-3, size / 4);
    view.projection = Projection::orthographic;
    view.height_in_units = 2;
    scene.views.push_back(view);
  }
  return scene;
}

SweepScene in_a_cycle(const SweepStop& stop, int size) {
  const int members = static_cast<int>(stop.value);
  SweepScene scene{shapes::triangle_cycle(members), {}};
  const double edge = 2 * std::sin(std::numbers::pi / members);
  for (int i = 0; i < static_cast<int>(sweep_views); ++i) {
    const double angle = 2 * std::numbers::pi * (members * i / static_cast<int>(sweep_views)) / members;
    const glm::dvec3 corner(std::cos(angle), std::sin(angle), 0);
    scene.views.push_back(view_from(corner + glm::dvec3(0, 0, 3 * edge), corner, 24, 1e-3 * edge, size));
  }
  return scene;
}

SweepScene nested(const SweepStop& stop, int size) {
  const int depth = static_cast<int>(stop.value);
  return {shapes::nested_shells(depth, 0.9f / static_cast<float>(depth), 2),
          views_of_ball(glm::dvec3(0), 1, 4, size / 2)};
}

std::vector<Sweep> make_sweeps() {
  return {
      {"origin_distance", "Distance from the origin", "radii",
       "Four nested spheres and their eyes, 2.5 radii away, are moved from the origin. Rounding to float32 itself "
       "moves "
       "every corner by up to 4e-8 of the distance: at 1e5 radii by four thousandths of a radius, so that the spheres "
       "are rough; at 2e6 by more than the space between two of them, so that facets lie in one another and collapse. "
       "What is judged is the order of the mesh so rounded.",
       stops({1, 10, 100, 1e3, 1e4, 1e5, 2e5, 3e5, 5e5, 7e5, 1e6, 2e6, 3e6, 1e7}), 0, far_from_origin},
      {"scale", "Overall scale", "units",
       "Four nested spheres of this radius, seen from 2.5 bounding radii. Float32 holds such coordinates to full "
       "precision; squares of them leave its range below 1e-22 and above 1e19.",
       stops({1e-30, 1e-26, 1e-24, 1e-22, 1e-20, 1e-15, 1e-10, 1e-5, 1, 1e5, 1e10, 1e15, 1e19, 1e20, 1e25, 1e30}), 8,
       scaled},
      {"scale_contrast", "Scale contrast in one mesh", "largest part over smallest",
       "A sphere of radius 1 around three nested ones of radius 0.3 over the contrast, which are looked at from close "
       "by. "
       "The small ones sit at the origin, where float32 has digits to spare, and the large one's centre does not: "
       "relative to the middle of the mesh, the small ones are far off.",
       powers_of_ten(0, 12, 1), 0, contrasted},
      {"aspect_ratio", "Aspect ratio of the facets", "length over breadth",
       "Five parallel sheets a quarter apart, cut into strips 0.1 broad and longer and longer, so that most of each "
       "facet lies outside the picture, and part of it behind the eye. A facet's centroid then says nothing of where "
       "it is seen.",
       powers_of_ten(0, 8, 0.5), 0, stretched},
      {"layer_gap", "Gap between parallel layers", "radii",
       "Five parallel sheets of 512 facets, the cells of each beginning elsewhere than those of the next, seen from "
       "about 15 degrees off their normal. Float32 holds the gap exactly enough: the sheets lie around z = 0.",
       powers_of_ten(-7, -1, 0.5), 12, layered_closely},
      {"field_of_view", "Field of view", "degrees",
       "Four nested spheres from inside all of them. The order asked for is the same throughout; what changes is which "
       "part of it is seen.",
       stops({0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 60, 90, 120, 150, 170, 175, 179}), 8, seen_at_an_angle},
      {"near_far_ratio", "Ratio of far to near", "farthest depth over near plane",
       "Nine sheets from the near plane, which cuts the first, to distance 1, each the same factor nearer than the one "
       "behind it. The eye is at the origin and the mesh's middle is not.",
       powers_of_ten(1, 9, 0.5), 0, near_to_far},
      {"eye_distance", "Distance of the eye from the surface", "radii",
       "Four nested spheres from inside all of them, from exactly a vertex, from a facet's centroid as rounded to "
       "float32, and from ever farther outside, with a field of view that the mesh fills. Up to 1e-6 radii the eye's "
       "own rounding, up to 3e-8, is part of the distance.",
       eye_distances(), 9, seen_from_a_distance},
      {"layers", "Number of layers", "layers",
       "Parallel sheets of 50 facets at a constant spacing, seen along their normal within 0.2 degrees, "
       "orthographically: "
       "nothing but their number changes.",
       stops({1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000}), 0, many_layers},
      {"cycle_length", "Length of a cycle", "facets",
       "A ring of triangles, each over the next and the last over the first, seen from above three of its corners. No "
       "order of whole facets is right.",
       stops({3, 4, 5, 6, 8, 10, 20, 30, 50, 100, 200, 300, 500, 1000}), 0, in_a_cycle},
      {"nesting", "Depth of nesting", "spheres in one another",
       "Closed spheres of 320 facets inside one another, dividing nine tenths of the outermost's radius evenly: the "
       "deeper, the thinner the space between two.",
       stops({1, 2, 3, 5, 8, 12, 20, 32, 50, 75, 100}), 0, nested},
  };
}

}  // namespace

std::span<const Sweep> all_sweeps() {
  static const std::vector<Sweep> sweeps = make_sweeps();
  return sweeps;
}

}  // namespace facetsort
