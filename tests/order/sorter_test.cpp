#include "facetsort/order/sorter.h"

#include <gtest/gtest.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>
#include <random>
#include <tuple>

#include "facetsort/report/allocations.h"
#include "shapes.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

constexpr double float_rounding = 0x1p-24;

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// One list of meshes for every test below: clean, dirty, and extreme.
const std::vector<NamedMesh>& meshes() {
  static const std::vector<NamedMesh> list = [] {
    std::vector<NamedMesh> made;
    for (const char* name : {"teapot_1k", "hand_2k", "spiralstair_15k"}) made.push_back({name, load(name)});
    made.push_back({"torus_knot", shapes::torus_knot(5000)});
    made.push_back({"soup", shapes::soup(3000, 7)});
    made.push_back({"nested_shells", shapes::nested_shells(3, 1e-3f, 2)});
    made.push_back({"many_scales", shapes::many_scales()});
    made.push_back({"sliver_fan", shapes::sliver_fan(64, 1e5f)});
    Mesh duplicates = shapes::box();
    for (int copy = 0; copy < 5; ++copy) {
      for (int facet = 0; facet < 12; ++facet) duplicates.triangles.push_back(duplicates.triangles[facet]);
    }
    duplicates.triangles.push_back({0, 0, 1});  // degenerate
    made.push_back({"duplicates", duplicates});
    return made;
  }();
  return list;
}

std::vector<SortView> near_and_far_views(const Mesh& mesh) {
  const Box box = facet_bounds(mesh.view());
  const glm::vec3 centre = box.centre();
  std::vector<SortView> views;
  for (const glm::vec3& direction : {glm::vec3(0.3f, 0.5f, 0.81f), glm::vec3(-0.9f, 0.1f, 0.42f), glm::vec3(0, 0, 1)}) {
    for (const float radii : {0.2f, 1.2f, 2.5f, 1e3f}) {
      views.push_back({glm::vec4(centre + radii * box.radius() * direction, 1), -direction});
    }
    views.push_back({glm::vec4(direction, 0), -direction});
  }
  return views;
}

SorterOptions whole_keys(Method method) { return {.method = method, .precision = Precision::whole}; }

FacetFrame frame_of(const Mesh& mesh) { return facet_frame(facet_bounds(mesh.view())); }

// The key in double, from the corners themselves, in units of the mesh's frame; larger is farther.
double true_key(const Mesh& mesh, const FacetFrame& frame, std::uint32_t facet, const SortView& view, Method method) {
  glm::dvec3 p[3];
  for (int i = 0; i < 3; ++i) p[i] = (glm::dvec3(mesh.view().corner(facet, i)) - frame.origin) * frame.scale;
  const glm::dvec3 centroid = (p[0] + p[1] + p[2]) / 3.0;
  const bool orthographic = view.eye.w == 0;
  const glm::dvec3 axis = glm::normalize(orthographic ? -glm::dvec3(view.eye) : glm::dvec3(view.forward));
  const auto along = [&](const glm::dvec3& q) { return glm::dot(q, axis); };
  switch (method) {
    case Method::centroid_distance:
      return orthographic ? along(centroid)
                          : glm::length(centroid - (glm::dvec3(view.eye) - frame.origin) * frame.scale);
    case Method::centroid_depth:
      return along(centroid);
    case Method::bounds_centre:
      return along((glm::min(glm::min(p[0], p[1]), p[2]) + glm::max(glm::max(p[0], p[1]), p[2])) / 2.0);
    case Method::first_vertex:
      return along(p[0]);
    case Method::nearest_vertex:
      return std::min({along(p[0]), along(p[1]), along(p[2])});
    case Method::farthest_vertex:
      return std::max({along(p[0]), along(p[1]), along(p[2])});
    case Method::exact:
    case Method::exact_tree:
    case Method::presorted:
      break;
  }
  return 0;
}

// By how much a float key may be off, in the same unit: a handful of roundings of products of a point (at most
// sqrt(12) from the frame's origin) and of the direction to the eye.
double key_error(const Mesh& mesh, const SortView& view, Method method) {
  constexpr double reach = 3.5, roundings = 16;
  if (method != Method::centroid_distance || view.eye.w == 0) return roundings * float_rounding * reach;
  const FacetFrame frame = frame_of(mesh);
  const double eye = glm::length((glm::dvec3(view.eye) - frame.origin) * frame.scale);
  // |q + f|^2 is off by roundings of |q| (|q| + 2 |f|); the distance by that over 2 |q + f|, and a facet whose distance
  // is below the square root of it may be anywhere there.
  const double squared = roundings * float_rounding * reach * (reach + 2 * eye);
  return eye > 2 * reach ? squared / (2 * (eye - reach)) : std::sqrt(squared);
}

void expect_permutation(std::span<const std::uint32_t> order, std::size_t count) {
  std::vector<std::uint32_t> sorted(order.begin(), order.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<std::uint32_t> all(count);
  std::iota(all.begin(), all.end(), 0u);
  ASSERT_EQ(sorted, all);
}

// No facet is drawn after one that is nearer by more than the key's error.
void expect_back_to_front(const Mesh& mesh, std::span<const std::uint32_t> order, const SortView& view, Method method,
                          double allowance) {
  const FacetFrame frame = frame_of(mesh);
  double nearest = INFINITY;
  for (const std::uint32_t facet : order) {
    const double key = true_key(mesh, frame, facet, view, method);
    ASSERT_LE(key, nearest + allowance);
    nearest = std::min(nearest, key);
  }
}

class EveryMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Sorter, EveryMethod, testing::ValuesIn(depth_key_methods().begin(), depth_key_methods().end()),
                         [](const auto& method) { return std::string(method_name(method.param)); });

TEST_P(EveryMethod, GivesAPermutationBackToFrontByItsKey) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    Sorter sorter(mesh.view(), whole_keys(GetParam()));
    for (const SortView& view : near_and_far_views(mesh)) {
      const auto order = sorter.sort(view);
      expect_permutation(order, mesh.triangles.size());
      expect_back_to_front(mesh, order, view, GetParam(), 2 * key_error(mesh, view, GetParam()));
      for (std::size_t k = 1; k < order.size(); ++k) {
        const float before = sorter.keys()[order[k - 1]], after = sorter.keys()[order[k]];
        ASSERT_TRUE(before > after || (before == after && order[k - 1] < order[k])) << "ties go to the smaller id";
      }
    }
  }
}

class EveryMethodAndPrecision : public testing::TestWithParam<std::tuple<Method, Precision>> {};
INSTANTIATE_TEST_SUITE_P(Sorter, EveryMethodAndPrecision,
                         testing::Combine(testing::ValuesIn(depth_key_methods().begin(), depth_key_methods().end()),
                                          testing::Values(Precision::quantised, Precision::whole)),
                         [](const auto& both) {
                           return std::string(method_name(std::get<Method>(both.param))) +
                                  (std::get<Precision>(both.param) == Precision::whole ? "_whole" : "_quantised");
                         });

TEST_P(EveryMethodAndPrecision, MirroringMeshAndEyeChangesNothing) {
  const auto [method, precision] = GetParam();
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    Sorter sorter(mesh.view(), {.method = method, .precision = precision});
    for (const glm::vec3& mirror : {glm::vec3(-1, 1, 1), glm::vec3(1, -1, 1), glm::vec3(-1, -1, -1)}) {
      Mesh mirrored = mesh;
      for (glm::vec3& position : mirrored.positions) position *= mirror;
      Sorter other(mirrored.view(), {.method = method, .precision = precision});
      for (const SortView& view : near_and_far_views(mesh)) {
        const auto order = sorter.sort(view);
        const auto same = other.sort({view.eye * glm::vec4(mirror, 1), view.forward * mirror});
        ASSERT_TRUE(std::equal(order.begin(), order.end(), same.begin(), same.end()));
      }
    }
  }
}

TEST_P(EveryMethodAndPrecision, ScalingByPowersOfTwoChangesNothing) {
  const auto [method, precision] = GetParam();
  for (const auto& [name, mesh] : meshes()) {
    if (name == "many_scales") continue;  // its smallest facets would leave the range of floats
    SCOPED_TRACE(name);
    Sorter sorter(mesh.view(), {.method = method, .precision = precision});
    for (const int exponent : {-80, -20, 20, 80}) {
      const float scale = std::ldexp(1.0f, exponent);
      Mesh scaled = mesh;
      for (glm::vec3& position : scaled.positions) position *= scale;
      Sorter other(scaled.view(), {.method = method, .precision = precision});
      for (const SortView& view : near_and_far_views(mesh)) {
        const auto order = sorter.sort(view);
        const glm::vec4 eye = view.eye.w == 0 ? view.eye : glm::vec4(glm::vec3(view.eye) * scale, 1);
        const auto same = other.sort({eye, view.forward * scale});
        ASSERT_TRUE(std::equal(order.begin(), order.end(), same.begin(), same.end())) << "2^" << exponent;
      }
    }
  }
}

// All but bounds_centre: a facet's axis-aligned box does not turn with it.
class RotatingMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Sorter, RotatingMethod,
                         testing::Values(Method::centroid_distance, Method::centroid_depth, Method::first_vertex,
                                         Method::nearest_vertex, Method::farthest_vertex),
                         [](const auto& method) { return std::string(method_name(method.param)); });

TEST_P(RotatingMethod, RotatingMeshAndEyeSwapsNothingBeyondTheKeysError) {
  const glm::mat3 rotation(glm::rotate(glm::mat4(1), 0.7f, glm::vec3(0.3f, -0.5f, 0.8f)));
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    Mesh rotated = mesh;
    for (glm::vec3& position : rotated.positions) position = rotation * position;
    Sorter other(rotated.view(), whole_keys(GetParam()));
    for (const SortView& view : near_and_far_views(mesh)) {
      const SortView turned{glm::vec4(rotation * glm::vec3(view.eye), view.eye.w), rotation * view.forward};
      // The rotation rounds positions, and so the eye: as if each point were off by a few roundings of its distance.
      const FacetFrame frame = frame_of(mesh);
      const double eye = view.eye.w == 0 ? 0 : glm::length(glm::dvec3(view.eye)) * frame.scale;
      const double rounding = 32 * float_rounding * (3.5 + glm::length(frame.origin) * frame.scale + eye);
      expect_back_to_front(mesh, other.sort(turned), view, GetParam(),
                           2 * key_error(mesh, view, GetParam()) + 2 * rounding);
    }
  }
}

TEST_P(EveryMethod, PermutingFacetsKeepsTheSequenceOfKeys) {
  std::mt19937 random(3);
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    Mesh shuffled = mesh;
    std::shuffle(shuffled.triangles.begin(), shuffled.triangles.end(), random);
    Sorter sorter(mesh.view(), whole_keys(GetParam())), other(shuffled.view(), whole_keys(GetParam()));
    for (const SortView& view : near_and_far_views(mesh)) {
      const auto order = sorter.sort(view);
      const auto other_order = other.sort(view);
      for (std::size_t k = 0; k < order.size(); ++k) {
        ASSERT_EQ(sorter.keys()[order[k]], other.keys()[other_order[k]]);
      }
    }
  }
}

TEST_P(EveryMethodAndPrecision, SameOrderForAnyThreadCount) {
  const auto [method, precision] = GetParam();
  const SorterOptions options{.method = method, .precision = precision};
  const Mesh mesh = shapes::torus_knot(150000);
  const SortView view = near_and_far_views(mesh)[1];
  const auto order_of = [&] {
    Sorter sorter(mesh.view(), options);
    const std::span<const std::uint32_t> order = sorter.sort(view);
    return std::vector<std::uint32_t>(order.begin(), order.end());
  };
  const std::vector<std::uint32_t> expected = with_threads(1, order_of);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(with_threads(threads, order_of), expected) << threads << " threads";
}

TEST_P(EveryMethodAndPrecision, AllocatesNothingAfterTheFirstSort) {
  const auto [method, precision] = GetParam();
  const Mesh mesh = load("hand_2k");
  Sorter sorter(mesh.view(), {.method = method, .precision = precision});
  const std::vector<SortView> views = near_and_far_views(mesh);
  std::vector<std::uint32_t> indices(3 * mesh.triangles.size());
  sorter.sort_indices(views[0], mesh.triangles, std::span(indices));
  const AllocationScope scope;
  for (const SortView& view : views) {
    sorter.sort(view);
    sorter.sort_indices(view, mesh.triangles, std::span(indices));
  }
  EXPECT_EQ(scope.count().calls, 0u);
}

TEST_P(EveryMethodAndPrecision, IndexBuffersHoldTheCornersInTheOrder) {
  const auto [method, precision] = GetParam();
  const Mesh mesh = load("hand_2k");
  Sorter sorter(mesh.view(), {.method = method, .precision = precision});
  const SortView view = near_and_far_views(mesh)[2];
  const auto span = sorter.sort(view);
  const std::vector<std::uint32_t> order(span.begin(), span.end());
  std::vector<std::uint32_t> wide(3 * order.size());
  std::vector<std::uint16_t> narrow(3 * order.size());
  sorter.sort_indices(view, mesh.triangles, std::span(wide));
  sorter.sort_indices(view, mesh.triangles, std::span(narrow));
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (int i = 0; i < 3; ++i) {
      ASSERT_EQ(wide[3 * k + i], mesh.triangles[order[k]][i]);
      ASSERT_EQ(narrow[3 * k + i], mesh.triangles[order[k]][i]);
    }
  }
}

TEST(Sorter, AFarEyeAndAFarMeshCostNoDigits) {
  // Layers 1e-5 apart, seen from a million radii away: distances in float32 would all be equal.
  Mesh mesh;
  const int layers = 100;
  for (int layer = 0; layer < layers; ++layer) {
    const float z = 1e-5f * static_cast<float>(layer * 37 % layers);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(0, 1)}) {
      mesh.positions.emplace_back(corner, z);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  const auto order = sort_facets(mesh.view(), {glm::vec4(0, 0, 1e6f, 1), glm::vec3(0, 0, -1)});
  for (int k = 1; k < layers; ++k) {
    EXPECT_LT(mesh.view().corner(order[k - 1], 0).z, mesh.view().corner(order[k], 0).z);
  }
}

TEST(Sorter, KeysStayFiniteAtTheEndsOfTheFloatRange) {
  Mesh mesh = shapes::icosphere(1);
  for (glm::vec3& position : mesh.positions) position *= 1e-30f;
  for (const Method method : depth_key_methods()) {
    Sorter sorter(mesh.view(), method);
    expect_permutation(sorter.sort({glm::vec4(1e38f, 1e38f, -1e38f, 1), glm::vec3(1e-38f, 0, 1e38f)}), 80);
    for (const float key : sorter.keys()) EXPECT_TRUE(std::isfinite(key));
  }
}

TEST(Sorter, OneFacet) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(sort_facets(mesh.view(), {}), std::vector<std::uint32_t>{0});
}

TEST(Sorter, EyeAtACentroidAndFacetsAllAlike) {
  Mesh mesh = shapes::box();
  mesh.triangles.assign(100, mesh.triangles[0]);
  const FacetFrame identity;
  const PointArrays centroids = facet_centroids(mesh.view(), identity);
  const auto order =
      sort_facets(mesh.view(), {glm::vec4(centroids.x[0], centroids.y[0], centroids.z[0], 1), glm::vec3(0, 0, -1)});
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end())) << "equal keys come out by id";
}

TEST(Sorter, DifferentSortersServeDifferentThreadsAtOnce) {
  const Mesh mesh = shapes::torus_knot(20000);
  const std::vector<SortView> views = near_and_far_views(mesh);
  std::vector<std::vector<std::uint32_t>> expected;
  for (const SortView& view : views) expected.push_back(sort_facets(mesh.view(), view));
  std::vector<std::vector<std::uint32_t>> found(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t i) { found[i] = sort_facets(mesh.view(), views[i]); });
  EXPECT_EQ(found, expected);
}

TEST(Sorter, HoldsAtMost40BytesAFacetForOnePointKeys) {
  const Mesh mesh = shapes::torus_knot(20000);
  Sorter sorter(mesh.view());
  sorter.sort(near_and_far_views(mesh)[0]);
  EXPECT_LE(sorter.memory_bytes(), 40 * mesh.triangles.size());
}

}  // namespace
}  // namespace facetsort
