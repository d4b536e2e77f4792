#include "facetsort/presort/index_buffers.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/order/sorter.h"
#include "shapes.h"
#include "support/mesh_files.h"
#include "support/random_views.h"
#include "support/threads.h"

namespace facetsort {
namespace {

constexpr std::uint32_t seed_of_views = 3;

// What holds whatever the mesh.
void expect_sound(const MeshView& mesh, const IndexBuffers& buffers, std::size_t most_buffers) {
  ASSERT_GE(buffers.buffer_count, 1u);
  EXPECT_LE(buffers.buffer_count, most_buffers);
  ASSERT_EQ(buffers.facets.size(), buffers.buffer_count * mesh.facet_count());
  std::vector<std::uint32_t> all(mesh.facet_count());
  std::iota(all.begin(), all.end(), 0u);
  for (std::size_t i = 0; i < buffers.buffer_count; ++i) {
    const auto buffer = std::span(buffers.facets).subspan(i * mesh.facet_count(), mesh.facet_count());
    std::vector<std::uint32_t> sorted(buffer.begin(), buffer.end());
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, all) << "buffer " << i;
    EXPECT_NE(std::count(buffers.buffer_of_direction.begin(), buffers.buffer_of_direction.end(), i), 0)
        << "buffer " << i << " is for no direction";
  }
  ASSERT_FALSE(buffers.directions.empty());
  ASSERT_EQ(buffers.buffer_of_direction.size(), buffers.directions.size());
  for (const glm::vec3& direction : buffers.directions) EXPECT_NEAR(glm::length(direction), 1, 1e-5);
  for (const std::uint32_t buffer : buffers.buffer_of_direction) EXPECT_LT(buffer, buffers.buffer_count);
  EXPECT_GE(buffers.mean_inverted_rate, 0);
  EXPECT_LE(buffers.mean_inverted_rate, buffers.worst_inverted_rate);
  EXPECT_LE(buffers.worst_inverted_rate, 1);
}

void expect_same(const IndexBuffers& a, const IndexBuffers& b) {
  EXPECT_EQ(a.buffer_count, b.buffer_count);
  EXPECT_EQ(a.facets, b.facets);
  EXPECT_EQ(a.directions, b.directions);
  EXPECT_EQ(a.buffer_of_direction, b.buffer_of_direction);
  EXPECT_EQ(a.mean_inverted_rate, b.mean_inverted_rate);
  EXPECT_EQ(a.worst_inverted_rate, b.worst_inverted_rate);
}

double mean_rate(const MeshView& mesh, const IndexBuffers& buffers, const std::vector<View>& views) {
  double sum = 0;
  for (const View& view : views) sum += inverted_rate(mesh, view, buffers);
  return sum / static_cast<double>(views.size());
}

// Orders by depth along directions spread over the sphere.
IndexBuffers depth_orders(const MeshView& mesh, int count) {
  IndexBuffers buffers;
  buffers.buffer_count = static_cast<std::size_t>(count);
  for (int i = 0; i < count; ++i) {
    const glm::vec3 direction(fibonacci_direction(i, count));
    const SortView view{.eye = glm::vec4(direction, 0), .forward = -direction};
    const std::vector<std::uint32_t> order = sort_facets(mesh, view, Method::centroid_depth);
    buffers.facets.insert(buffers.facets.end(), order.begin(), order.end());
    buffers.directions.push_back(direction);
    buffers.buffer_of_direction.push_back(static_cast<std::uint32_t>(i));
  }
  return buffers;
}

TEST(IndexBuffers, AreBetterThanAsManyOrdersByDepth) {
  for (const auto& [name, count] : {std::pair("teapot_1k", 4), std::pair("hand_2k", 10)}) {
    SCOPED_TRACE(testing::Message() << name << ", " << count << " buffers");
    const Mesh mesh = load(name);
    const std::vector<View> views = random_views(mesh.view(), 40, seed_of_views);
    const IndexBuffers made = make_index_buffers(mesh.view(), {.most_buffers = static_cast<std::size_t>(count)});
    expect_sound(mesh.view(), made, static_cast<std::size_t>(count));
    const double by_depth = mean_rate(mesh.view(), depth_orders(mesh.view(), count), views);
    EXPECT_LT(mean_rate(mesh.view(), made, views), by_depth / 1.5);
  }
}

TEST(IndexBuffers, MeasureWhatTheyErr) {
  const Mesh mesh = load("hand_2k");
  const IndexBuffers buffers = make_index_buffers(mesh.view(), {.most_buffers = 3});
  const double mean = mean_rate(mesh.view(), buffers, random_views(mesh.view(), 100, seed_of_views));
  EXPECT_GT(mean, 0);
  EXPECT_GT(buffers.mean_inverted_rate, mean / 2);
  EXPECT_LT(buffers.mean_inverted_rate, mean * 2);
}

TEST(IndexBuffers, AreTheSameForAnyThreadCount) {
  const Mesh mesh = shapes::torus_knot(600);
  const auto make = [&] { return make_index_buffers(mesh.view(), {.most_buffers = 5}); };
  const IndexBuffers one = with_threads(1, make);
  for (const int threads : {2, 3, 8}) {
    SCOPED_TRACE(threads);
    expect_same(with_threads(threads, make), one);
  }
}

TEST(IndexBuffers, OneIsEnoughForConvexMeshesWithCulling) {
  for (const Mesh& mesh : {shapes::box(), shapes::icosphere(2)}) {
    const IndexBuffers buffers = make_index_buffers(mesh.view(), {.max_error = 0.0, .with_culling = true});
    expect_sound(mesh.view(), buffers, 1);
    EXPECT_TRUE(buffers.needs_culling);
    EXPECT_EQ(buffers.worst_inverted_rate, 0);
  }
}

// Seen from opposite sides, a sphere's halves change places.
TEST(IndexBuffers, OneIsNotEnoughWithoutCulling) {
  const Mesh mesh = shapes::icosphere(2);
  const IndexBuffers buffers = make_index_buffers(mesh.view(), {.most_buffers = 1});
  expect_sound(mesh.view(), buffers, 1);
  EXPECT_FALSE(buffers.needs_culling);
  EXPECT_GT(buffers.mean_inverted_rate, 0.1);
}

TEST(IndexBuffers, AreAsFewAsTheErrorAllows) {
  const Mesh mesh = shapes::torus_knot(600);
  const IndexBuffers most = make_index_buffers(mesh.view(), {.most_buffers = 8});
  const double error = 2 * most.mean_inverted_rate;
  const IndexBuffers enough = make_index_buffers(mesh.view(), {.most_buffers = 8, .max_error = error});
  expect_sound(mesh.view(), enough, 7);
  EXPECT_GT(enough.buffer_count, 1u);
  EXPECT_LE(enough.mean_inverted_rate, error);
  const IndexBuffers fewer = make_index_buffers(mesh.view(), {.most_buffers = enough.buffer_count - 1});
  EXPECT_GT(fewer.mean_inverted_rate, error);
}

TEST(IndexBuffers, AreTheMostAllowedWhereTheErrorIsOutOfReach) {
  const Mesh mesh = shapes::torus_knot(600);
  const IndexBuffers buffers = make_index_buffers(mesh.view(), {.most_buffers = 3, .max_error = 0.0});
  expect_sound(mesh.view(), buffers, 3);
  EXPECT_EQ(buffers.buffer_count, 3u);
  EXPECT_GT(buffers.mean_inverted_rate, 0);
}

TEST(IndexBuffers, TellThatACycleCannotBeOrdered) {
  const Mesh mesh = shapes::triangle_cycle(3);
  const IndexBuffers buffers = make_index_buffers(mesh.view(), {.most_buffers = 6});
  expect_sound(mesh.view(), buffers, 6);
  EXPECT_GT(buffers.mean_inverted_rate, 0);
  const Box box = facet_bounds(mesh.view());
  const View above = default_view(box, box.centre() + glm::vec3(0, 0, 3 * box.radius()));
  EXPECT_GT(inverted_rate(mesh.view(), above, buffers), 0);
}

TEST(IndexBuffers, StandSmallAndFlatMeshes) {
  const Mesh empty;
  expect_sound(empty.view(), make_index_buffers(empty.view()), 1);
  const Mesh triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}, {}};
  const Mesh point{{{1, 1, 1}}, {{0, 0, 0}, {0, 0, 0}}, {}, {}};
  for (const Mesh& mesh : {triangle, point, shapes::coplanar(50, 1), shapes::duplicated_grid(3, 3)}) {
    const IndexBuffers buffers = make_index_buffers(mesh.view(), {.most_buffers = 3});
    expect_sound(mesh.view(), buffers, 3);
    EXPECT_EQ(buffers.worst_inverted_rate, 0);
  }
}

TEST(IndexBuffers, TellHowFarTheyAreAndStopWhenTold) {
  const Mesh mesh = shapes::icosphere(2);
  std::vector<double> told;
  const auto listen = [&](double done) {
    told.push_back(done);
    return true;
  };
  EXPECT_EQ(make_index_buffers(mesh.view(), {.most_buffers = 2, .progress = listen}).buffer_count, 2u);
  ASSERT_GT(told.size(), 10u);
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_GT(told.front(), 0);
  EXPECT_DOUBLE_EQ(told.back(), 1);
  for (const double last : {0.0, 0.3, 0.62, 0.9}) {
    int refusals = 0;
    const auto refuse = [&](double done) {
      refusals += done > last;
      return done <= last;
    };
    const IndexBuffers stopped = make_index_buffers(mesh.view(), {.most_buffers = 2, .progress = refuse});
    EXPECT_EQ(stopped.buffer_count, 0u);
    EXPECT_TRUE(stopped.facets.empty());
    EXPECT_EQ(refusals, 1);
  }
}

}  // namespace
}  // namespace facetsort
