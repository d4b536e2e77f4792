// Which of two facets hides the other: on pairs made by hand, and on random ones against rays.
#include "facetsort/exact/visibility.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>

#include "exact/point_space.h"
#include "facetsort/exact/facts.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/predicates.h"
#include "shapes.h"
#include "support/effort.h"

namespace facetsort::exact_internal {
namespace {

// A mesh and the points over it, every facet in a plane of its own unless said otherwise.
class Scene {
 public:
  explicit Scene(Mesh mesh) : mesh_(std::move(mesh)), space_(space_of(mesh_.view())), points_(space_) {}
  Scene(const Scene&) = delete;

  const Mesh& mesh() const { return mesh_; }
  void same_plane(FacetId facet, FacetId smaller) { space_.plane_of_facet[facet] = smaller; }

  Hiding hiding(FacetId a, FacetId b, const Eye& eye, bool surrounded) const {
    std::vector<PointId> loops[2];
    SeenPart parts[2];
    for (int k = 0; k < 2; ++k) {
      const FacetId facet = k == 0 ? a : b;
      for (int i = 0; i < 3; ++i) loops[k].push_back(space_.corner(facet, i));
      parts[k] = {facet, facing(facet, eye), loops[k]};
      EXPECT_NE(parts[k].facing, 0);
    }
    return exact_internal::hiding(points_, {eye, surrounded}, parts[0], parts[1]);
  }

  int facing(FacetId facet, const Eye& eye) const {
    return side_of_plane(mesh_.view().corner(facet, 0), mesh_.view().corner(facet, 1), mesh_.view().corner(facet, 2),
                         eye);
  }

 private:
  Mesh mesh_;
  PointSpace space_;
  Points points_;
};

Mesh triangles(const std::vector<glm::vec3>& corners) {
  Mesh mesh;
  mesh.positions = corners;
  for (std::uint32_t i = 0; i < corners.size(); i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  return mesh;
}

constexpr Hiding none = Hiding::none, first = Hiding::first_behind_second, second = Hiding::second_behind_first;

Hiding reversed(Hiding hiding) {
  return hiding == first ? second : hiding == second ? first : none;
}

// Either way round, and wherever the answer must not depend on it, surrounded or not.
void expect_hiding(const Scene& scene, const Eye& eye, Hiding expected, bool both = true) {
  SCOPED_TRACE(testing::Message() << eye.x << ' ' << eye.y << ' ' << eye.z << ' ' << eye.w);
  for (const bool surrounded : {true, false}) {
    if (!surrounded && !both) continue;
    EXPECT_EQ(scene.hiding(0, 1, eye, surrounded), expected) << surrounded;
    EXPECT_EQ(scene.hiding(1, 0, eye, surrounded), reversed(expected)) << surrounded;
  }
}

TEST(Hiding, OfPanes) {
  const Scene scene(triangles({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {-1, -1, 1}, {1, -1, 1}, {0, 1, 1}}));
  expect_hiding(scene, {0, 0, 5, 1}, first);
  expect_hiding(scene, {0, 0, 1, 0}, first);
  expect_hiding(scene, {0, 0, -5, 1}, second);
  expect_hiding(scene, {0, 0, -1, 0}, second);
  expect_hiding(scene, {0, 0, 1e30f, 1}, first);
  expect_hiding(scene, {9, 0, 0.5f, 1}, none);
  expect_hiding(scene, {9, 0, 0.5f, 0}, none);
  expect_hiding(scene, {0, 0, 0.5f, 1}, none, false);  // on opposite sides of the eye
}

TEST(Hiding, BehindTheEyeIsSeenAllTheSame) {
  // Half-lines go every way: an eye at the origin, both panes at one side of it, whichever way it looks.
  const Scene scene(triangles({{-1, -1, -2}, {1, -1, -2}, {0, 1, -2}, {-1, -1, -1}, {1, -1, -1}, {0, 1, -1}}));
  expect_hiding(scene, {0, 0, 0, 1}, first, false);
  // Antipodes: one below, one above the eye, each other's mirror image.
  const Scene around(triangles({{-1, -1, -2}, {1, -1, -2}, {0, 1, -2}, {1, 1, 2}, {-1, 1, 2}, {0, -1, 2}}));
  expect_hiding(around, {0, 0, 0, 1}, none, false);
  expect_hiding(around, {0, 0, 1, 0}, first);
  expect_hiding(around, {0, 0, 4, 1}, first);
}

TEST(Hiding, OfFacetsThatShareAnEdge) {
  // A roof: from above each side is seen for itself, from beyond one eave the near side hides the far one.
  Mesh mesh;
  mesh.positions = {{0, -1, 1}, {0, 1, 1}, {-1, 0, 0}, {1, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  const Scene scene(mesh);
  expect_hiding(scene, {0, 0, 9, 1}, none);
  expect_hiding(scene, {0.3f, 0.2f, 1, 0}, none);
  expect_hiding(scene, {9, 0, 0.5f, 1}, first);
  expect_hiding(scene, {-9, 0, 0.5f, 1}, second);
  expect_hiding(scene, {1, 0, 0, 0}, first);
}

TEST(Hiding, OfFacetsThatShareAVertex) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, -1, 0}, {2, 1, 0}, {2, -1, 1}, {2, 1, 1}, {-2, 1, 0.5f}, {-2, -1, 0.5f}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}, {0, 5, 6}};
  const Scene scene(mesh);
  expect_hiding(scene, {1, 0, 9, 1}, first);
  expect_hiding(scene, {0, 0, 1, 0}, first);
  expect_hiding(scene, {1, 0, -9, 1}, second);
  EXPECT_EQ(scene.hiding(0, 2, {0, 0, 9, 1}, false), none);  // side by side, touching at the vertex
  EXPECT_EQ(scene.hiding(1, 2, {0.1f, 0, 9, 1}, true), none);
}

TEST(Hiding, OfSkewNeedlesThatStraddleEachOthersPlane) {
  for (const float height : {0.5f, -0.5f, 0x1p-20f, -0x1p-20f}) {
    SCOPED_TRACE(height);
    const Scene scene(triangles({{-10, -0.1f, -1},
                                 {10, 0, 1},
                                 {-10, 0.1f, -1},
                                 {-0.1f, -10, height - 1},
                                 {0, 10, height + 1},
                                 {0.1f, -10, height - 1}}));
    // Each has corners on both sides of the other's plane, and yet they do not touch.
    for (const auto& [plane, part] : {std::pair{0u, 1u}, std::pair{1u, 0u}}) {
      int sum = 0, magnitude = 0;
      for (int i = 0; i < 3; ++i) {
        const MeshView view = scene.mesh().view();
        const int side =
            orientation(view.corner(plane, 0), view.corner(plane, 1), view.corner(plane, 2), view.corner(part, i));
        sum += side;
        magnitude += std::abs(side);
      }
      ASSERT_LT(std::abs(sum), magnitude);
    }
    const Hiding expected = height > 0 ? first : second;
    expect_hiding(scene, {0, 0, 30, 1}, expected);
    expect_hiding(scene, {0, 0, 1, 0}, expected);
    expect_hiding(scene, {0, 0, -30, 1}, reversed(expected));
    expect_hiding(scene, {0, 0, -1, 0}, reversed(expected));
  }
}

TEST(Hiding, OfOneInsideTheOthersOutline) {
  const Scene scene(
      triangles({{-9, -9, -1}, {9, -9, 1}, {0, 9, 0}, {-0.5f, -0.2f, 0.4f}, {0.5f, 0, 0.9f}, {0, 0.5f, 0.8f}}));
  expect_hiding(scene, {0, 0, 20, 1}, first);
  expect_hiding(scene, {0, 0, -20, 1}, second);
}

TEST(Hiding, OfFacetsInOnePlaneIsNone) {
  Scene scene(triangles({{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {1, 0, 0}, {3, 0, 0}, {1, 2, 0}}));
  for (const bool known : {false, true}) {
    if (known) scene.same_plane(1, 0);
    expect_hiding(scene, {0, 0, 5, 1}, none);
    expect_hiding(scene, {1, 2, 3, 0}, none);
    expect_hiding(scene, {1, 1, -0.1f, 1}, none, false);
  }
}

// How far along direction d from the eye a facet is met clearly inside; nothing where it is not.
std::optional<double> met_at(const Mesh& mesh, FacetId facet, const glm::dvec3& eye, const glm::dvec3& d) {
  const glm::dvec3 a(mesh.view().corner(facet, 0)), b(mesh.view().corner(facet, 1)), c(mesh.view().corner(facet, 2));
  const glm::dvec3 normal = glm::cross(b - a, c - a);
  const double along = glm::dot(normal, d);
  if (std::abs(along) < 1e-9) return std::nullopt;
  const double t = glm::dot(normal, a - eye) / along;
  const glm::dvec3 p = eye + t * d;
  const double area = glm::dot(normal, normal);
  for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
    if (glm::dot(glm::cross(to - from, p - from), normal) < 1e-6 * area) return std::nullopt;
  }
  return t;
}

// Aims rays at points of facet a; where one meets b, that says which is behind.
Hiding seen_by_rays(const Mesh& mesh, FacetId a, FacetId b, const Eye& eye, std::mt19937& random) {
  const auto uniform = [&] { return static_cast<double>(random() >> 8) * 0x1p-24; };
  for (int i = 0; i < 200; ++i) {
    double v = uniform(), w = uniform();
    if (v + w > 1) v = 1 - v, w = 1 - w;
    const glm::dvec3 p = (1 - v - w) * glm::dvec3(mesh.view().corner(a, 0)) + v * glm::dvec3(mesh.view().corner(a, 1)) +
                         w * glm::dvec3(mesh.view().corner(a, 2));
    const glm::dvec3 target(eye);
    // Orthographic rays start beyond all of the mesh.
    const glm::dvec3 origin = eye.w == 0 ? p + 100.0 * target : target, direction = p - origin;
    const std::optional<double> own = met_at(mesh, a, origin, direction), other = met_at(mesh, b, origin, direction);
    if (!own || !other || *other < 1e-6 || std::abs(*own - *other) < 1e-6) continue;
    return *own > *other ? first : second;
  }
  return none;
}

TEST(Hiding, OfRandomPairsIsWhatRaysMeet) {
  std::mt19937 random(3);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  std::size_t compared = 0, surrounded_compared = 0, shared = 0;
  for (int i = 0; i < cases(6000); ++i) {
    Mesh mesh;
    for (int v = 0; v < 6; ++v) mesh.positions.push_back(glm::vec3{uniform(), uniform(), uniform()});
    const std::uint32_t vertices = 4 + i % 3;  // two, one or no vertex in common
    mesh.triangles = {{0, 1, 2}, {vertices - 3, vertices - 2, vertices - 1}};
    if (vertices == 6 && i % 2 == 0) {  // long and thin
      for (const int v : {1, 4}) mesh.positions[v] = mesh.positions[v - 1] + 0.05f * mesh.positions[v];
    }
    if (inspect_geometry(mesh.view()).intersecting_pairs > 0) continue;
    const Scene scene(mesh);
    const glm::vec3 inside{uniform(), uniform(), uniform()};
    const struct {
      Eye eye;
      bool surrounded;
    } eyes[] = {{Eye(inside, 1), true},
                {Eye(4.0f * inside - 1.5f, 1), true},
                {Eye(inside + glm::vec3(0, 0, 20), 1), false},
                {Eye(inside - 0.5f, 0), false}};
    for (const auto& [eye, surrounded] : eyes) {
      if (scene.facing(0, eye) == 0 || scene.facing(1, eye) == 0) continue;
      const Hiding found = scene.hiding(0, 1, eye, surrounded);
      ASSERT_EQ(scene.hiding(1, 0, eye, surrounded), reversed(found));
      if (!surrounded) {
        ASSERT_EQ(scene.hiding(0, 1, eye, true), found);
      }
      const Hiding expected = seen_by_rays(mesh, 0, 1, eye, random);
      if (expected == none) continue;  // apart, or overlapping less than rays tell
      ASSERT_EQ(found, expected) << i;
      ++compared;
      surrounded_compared += surrounded;
      shared += vertices < 6;
    }
  }
  EXPECT_GT(compared, static_cast<std::size_t>(cases(2000)));
  EXPECT_GT(surrounded_compared, static_cast<std::size_t>(cases(500)));
  EXPECT_GT(shared, static_cast<std::size_t>(cases(500)));
}

// What rays never meet is apart: facets that a plane through the eye parts.
TEST(Hiding, OfFacetsApartIsNone) {
  std::mt19937 random(4);
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-24f; };
  for (int i = 0; i < cases(2000); ++i) {
    Mesh mesh;
    const glm::vec3 eye{uniform(), uniform(), uniform()};
    for (int v = 0; v < 6; ++v) {
      glm::vec3 p{uniform(), uniform(), uniform()};
      // The first three on one side of the plane y = x + (eye.y - eye.x), the others on its other side or in it.
      const float off = (p.y - eye.y) - (p.x - eye.x);
      if ((off > 0) != (v < 3)) std::swap(p.x, p.y), p.x += eye.x - eye.y, p.y += eye.y - eye.x;
      mesh.positions.push_back(p);
    }
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    const auto side = [&](int v) { return (mesh.positions[v].y - eye.y) - (mesh.positions[v].x - eye.x); };
    if (!(side(0) > 0x1p-20f && side(1) > 0x1p-20f && side(2) > 0x1p-20f)) continue;
    if (!(side(3) < -0x1p-20f && side(4) < -0x1p-20f && side(5) < -0x1p-20f)) continue;
    const Scene scene(mesh);
    if (scene.facing(0, Eye(eye, 1)) == 0 || scene.facing(1, Eye(eye, 1)) == 0) continue;
    ASSERT_EQ(scene.hiding(0, 1, Eye(eye, 1), true), none) << i;
  }
}

}  // namespace
}  // namespace facetsort::exact_internal
