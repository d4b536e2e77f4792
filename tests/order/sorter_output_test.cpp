// What a renderer asks of a Sorter: index buffers, ranges, culling, new positions; and that the order is one and the
// same for every instruction set and thread count.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <numeric>
#include <random>

#include "facetsort/order/sorter.h"
#include "facetsort/order/spatial_order.h"
#include "facetsort/report/allocations.h"
#include "order/uneven_meshes.h"
#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;

SortView view_from(const Mesh& mesh, const glm::vec3& direction, float radii) {
  const Box box = facet_bounds(mesh.view());
  return {glm::vec4(box.centre() + radii * box.radius() * direction, 1), -direction};
}

std::vector<SortView> inside_and_outside_views(const Mesh& mesh) {
  return {view_from(mesh, glm::vec3(0.36f, 0.48f, 0.8f), 2.5f),
          view_from(mesh, glm::vec3(-0.8f, 0.36f, 0.48f), 0.3f),
          view_from(mesh, glm::vec3(0.48f, -0.8f, 0.36f), 50),
          {glm::vec4(0.6f, 0, 0.8f, 0), glm::vec3(-0.6f, 0, -0.8f)}};
}

// A comparison sort of the Sorter's own keys: what every way through it must give.
Ids expected_order(Sorter& sorter, Ids ids, Direction direction = Direction::back_to_front) {
  const std::span<const float> keys = sorter.keys();
  std::sort(ids.begin(), ids.end(), [&](std::uint32_t a, std::uint32_t b) {
    if (keys[a] != keys[b]) return direction == Direction::back_to_front ? keys[a] > keys[b] : keys[a] < keys[b];
    return a < b;
  });
  return ids;
}

Ids all_ids(const Mesh& mesh) {
  Ids ids(mesh.triangles.size());
  std::iota(ids.begin(), ids.end(), 0u);
  return ids;
}

Ids copy(std::span<const std::uint32_t> ids) {
  return {ids.begin(), ids.end()};
}

TEST(SorterOutput, IsTheOrderOfAComparisonSortHoweverDepthsAreSpread) {
  for (const auto& [name, mesh] : uneven_meshes()) {
    SCOPED_TRACE(name);
    for (const Direction direction : {Direction::back_to_front, Direction::front_to_back}) {
      Sorter sorter(mesh.view(), {.method = Method::centroid_depth,
                                  .direction = direction,
                                  .precision = Precision::whole});
      for (const glm::vec3 axis : {glm::vec3(0, 0, 1), glm::vec3(0.1f, 0.2f, -0.9f)}) {
        const Ids order = copy(sorter.sort({glm::vec4(axis, 0), -axis}));
        ASSERT_EQ(order, expected_order(sorter, all_ids(mesh), direction));
      }
    }
  }
}

std::uint64_t hash(std::uint64_t hash, std::span<const std::uint32_t> ids) {
  for (const std::uint32_t id : ids) hash = (hash ^ id) * 0x100000001b3u;
  return hash;
}

// Of facets that face the eye and lie in its view, nearest first.
Ids culled_indices(const Mesh& mesh, Precision precision) {
  Sorter sorter(mesh.view(), {.direction = Direction::front_to_back,
                              .precision = precision,
                              .cull_back_faces = true,
                              .cull_by_clip_planes = true});
  SortView view = inside_and_outside_views(mesh)[1];
  const glm::vec3 eye(view.eye);
  const std::array planes = clip_planes_of(glm::perspective(0.7f, 1.0f, 0.01f, 100.0f) *
                                           glm::lookAt(eye, eye + view.forward, glm::vec3(0, 1, 0)));
  view.clip_planes = planes;
  Ids indices(3 * mesh.triangles.size());
  indices.resize(3 * sorter.sort_indices(view, mesh.triangles, std::span(indices)));
  return indices;
}

// Every method, and every way out, over meshes that take every way through.
std::uint64_t hash_of_everything() {
  std::uint64_t sum = 0;
  for (const Mesh& mesh : {shapes::torus_knot(20000), shapes::torus_knot(200000), shapes::soup(70000, 3)}) {
    for (const Precision precision : {Precision::quantised, Precision::whole}) {
      for (const Method method : depth_key_methods()) {
        Sorter sorter(mesh.view(), {.method = method,
                                    .precision = precision,
                                    .cull_back_faces = method == Method::bounds_centre});
        for (const SortView& view : inside_and_outside_views(mesh)) sum = hash(sum, sorter.sort(view));
      }
      sum = hash(sum, culled_indices(mesh, precision));
    }
  }
  return sum;
}

TEST(SorterOutput, SameOrderForAnyInstructionSetAndThreadCount) {
  const std::uint64_t expected = hash_of_everything();
  const int tried = for_each_instruction_set([&] { EXPECT_EQ(hash_of_everything(), expected); });
  EXPECT_GE(tried, 2) << "the baseline and another";
  for (const int threads : {1, 2, 3, 8}) {
    with_threads(threads, [&] { EXPECT_EQ(hash_of_everything(), expected) << threads << " threads"; });
  }
}

template <typename Index>
void expect_index_buffer(const Mesh& mesh, std::span<const Index> indices, std::span<const std::uint32_t> order) {
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (int i = 0; i < 3; ++i) ASSERT_EQ(indices[3 * k + i], static_cast<Index>(mesh.triangles[order[k]][i]));
  }
}

TEST(SorterOutput, WritesIndicesAndIdsAndNothingBehindThem) {
  const Mesh small = shapes::torus_knot(20000), large = shapes::torus_knot(120000), huge = shapes::torus_knot(400000);
  const std::pair<const Mesh*, Precision> cases[] = {{&small, Precision::quantised},
                                                     {&small, Precision::whole},
                                                     {&large, Precision::quantised},
                                                     {&large, Precision::whole},
                                                     {&huge, Precision::quantised}};
  for (const auto& [of_case, precision] : cases) {
    const Mesh* mesh = of_case;  // clang 14 lets no lambda take a binding
    Sorter sorter(mesh->view(), {.precision = precision, .cull_back_faces = true});
    const SortView view = inside_and_outside_views(*mesh)[0];
    const Ids order = copy(sorter.sort(view));
    ASSERT_LT(order.size(), mesh->triangles.size());
    const auto expect = [&]<typename Index>(Index untouched) {
      std::vector<Index> indices(3 * mesh->triangles.size(), untouched);
      Ids ids(mesh->triangles.size(), 0xabababab);
      ASSERT_EQ(sorter.sort_indices(view, mesh->triangles, std::span(indices), ids), order.size());
      expect_index_buffer<Index>(*mesh, indices, order);
      EXPECT_TRUE(std::equal(order.begin(), order.end(), ids.begin()));
      EXPECT_TRUE(std::all_of(indices.begin() + static_cast<std::ptrdiff_t>(3 * order.size()), indices.end(),
                              [&](Index index) { return index == untouched; }));
      EXPECT_TRUE(std::all_of(ids.begin() + static_cast<std::ptrdiff_t>(order.size()), ids.end(),
                              [](std::uint32_t id) { return id == 0xabababab; }));
    };
    expect(std::uint32_t{0xcdcdcdcd});
    if (mesh->positions.size() < 65536) expect(std::uint16_t{0xcdcd});
  }
}

TEST(SorterOutput, FrontToBackIsTheOtherWayRoundButForTies) {
  const Mesh mesh = load("hand_2k");
  Sorter back(mesh.view(), {.precision = Precision::whole}),
      front(mesh.view(), {.direction = Direction::front_to_back, .precision = Precision::whole});
  for (const SortView& view : inside_and_outside_views(mesh)) {
    const Ids far_first = copy(back.sort(view)), near_first = copy(front.sort(view));
    EXPECT_EQ(near_first, expected_order(back, all_ids(mesh), Direction::front_to_back));
    EXPECT_EQ(back.keys()[far_first.front()], front.keys()[near_first.back()]);
  }
}

TEST(SorterOutput, RangesAreSortedByThemselvesWhereTheyLie) {
  const Mesh mesh = shapes::torus_knot(150000);
  std::vector<FacetRange> ranges;
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  ranges.push_back({0, 70000});  // a large one, then gaps, meshlets, and an empty one
  for (std::uint32_t first = 70003; first + 100 < count; first += 100) ranges.push_back({first, 97});
  ranges.push_back({count, 0});
  for (const bool culled : {false, true}) {
    Sorter sorter(mesh.view(), {.precision = Precision::whole, .cull_back_faces = culled});
    const SortView view = inside_and_outside_views(mesh)[0];
    const Ids order = copy(sorter.sort(view));
    for (const int threads : {1, 3}) {
      Ids indices(3 * mesh.triangles.size(), 7), ids(mesh.triangles.size(), 7), counts(ranges.size());
      with_threads(threads, [&] { sorter.sort_ranges(view, mesh.triangles, ranges, indices, counts, ids); });
      std::vector<bool> kept(count, false);
      for (const std::uint32_t id : order) kept[id] = true;
      sorter.sort(view);
      for (std::size_t r = 0; r < ranges.size(); ++r) {
        Ids expected;
        for (std::uint32_t id = ranges[r].first; id < ranges[r].first + ranges[r].count; ++id) {
          if (kept[id]) expected.push_back(id);
        }
        expected = expected_order(sorter, expected);
        ASSERT_EQ(counts[r], expected.size());
        ASSERT_TRUE(std::equal(expected.begin(), expected.end(), ids.begin() + ranges[r].first));
        expect_index_buffer<std::uint32_t>(mesh, std::span(indices).subspan(3 * ranges[r].first), expected);
      }
      EXPECT_EQ(ids[70001], 7u) << "written between ranges";
    }
  }
}

// In double, from the corners: what a facet seen from the front is.
bool faces(const Mesh& mesh, std::uint32_t facet, const glm::vec4& eye) {
  const Plane plane = facet_plane(mesh.view(), facet);
  return glm::dot(plane.normal, glm::dvec3(eye)) - eye.w * plane.offset > 0;
}

class CullingMethod : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(SorterOutput, CullingMethod,
                         testing::ValuesIn(depth_key_methods().begin(), depth_key_methods().end()),
                         [](const auto& method) { return std::string(method_name(method.param)); });

TEST_P(CullingMethod, LeavesOutWhatIsSeenFromBehindAndNothingElse) {
  for (const Mesh& mesh : {load("hand_2k"), shapes::torus_knot(80000), shapes::sliver_fan(64, 1e5f)}) {
    SorterOptions options{.method = GetParam(), .precision = Precision::whole};
    Sorter whole(mesh.view(), options);
    options.cull_back_faces = true;
    Sorter culling(mesh.view(), options);
    for (const SortView& view : inside_and_outside_views(mesh)) {
      const Ids order = copy(whole.sort(view)), culled = copy(culling.sort(view));
      std::vector<bool> kept(order.size(), false);
      for (const std::uint32_t id : culled) kept[id] = true;
      Ids expected = order;
      std::erase_if(expected, [&](std::uint32_t id) { return !kept[id]; });
      EXPECT_EQ(culled, expected) << "the order of those that stay is the whole order's";
      std::size_t behind = 0, stay = 0;
      for (const std::uint32_t id : order) {
        ASSERT_TRUE(kept[id] || !faces(mesh, id, view.eye)) << "facet " << id << " faces the eye";
        behind += !faces(mesh, id, view.eye);
        stay += kept[id] && !faces(mesh, id, view.eye);
      }
      EXPECT_LE(stay, behind / 100 + 2) << "of " << behind << " seen from behind";
    }
  }
}

Mesh joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  mesh.facet_colours.clear();
  mesh.vertex_colours.clear();
  const auto offset = static_cast<std::uint32_t>(a.positions.size());
  mesh.positions.insert(mesh.positions.end(), b.positions.begin(), b.positions.end());
  for (const glm::uvec3& triangle : b.triangles) mesh.triangles.push_back(triangle + offset);
  return mesh;
}

TEST(SorterOutput, NewPositionsOfARangeAreAsThoseOfAll) {
  const Mesh shell = joined(shapes::box(), shapes::nested_shells(1, 0.5f, 3));
  const float radius = facet_bounds(shell.view()).radius();
  Mesh knot = shapes::torus_knot(5000);
  const float size = facet_bounds(knot.view()).radius();
  for (glm::vec3& position : knot.positions) position *= 0.3f * radius / size;
  // Not at the border of a block.
  const FacetRange of_knot{static_cast<std::uint32_t>(shell.triangles.size()),
                           static_cast<std::uint32_t>(knot.triangles.size())};
  ASSERT_NE(of_knot.first % 64, 0u);
  const Mesh before = joined(joined(shell, knot), shapes::box());
  for (const Method method : depth_key_methods()) {
    const SorterOptions options{.method = method, .cull_back_faces = true, .cull_by_clip_planes = true};
    Sorter sorter(before.view(), options);
    Mesh after = before;
    for (const float way : {0.1f, -0.2f, 5.0f, 0.3f}) {  // within the shell, and far out of it
      for (std::size_t v = 0; v < knot.positions.size(); ++v) {
        after.positions[shell.positions.size() + v] = knot.positions[v] + glm::vec3(way * radius, way, 0);
      }
      sorter.set_positions(after.triangles, std::span<const glm::vec3>(after.positions), of_knot);
      if (way == 0.3f) sorter.set_positions(after.triangles, std::span<const glm::vec3>(after.positions));
      Sorter anew(after.view(), options);
      for (SortView view : inside_and_outside_views(after)) {
        const std::array plane{glm::vec4(1, 0.5f, 0, 0.4f * radius)};
        view.clip_planes = plane;
        EXPECT_EQ(copy(sorter.sort(view)), copy(anew.sort(view))) << method_name(method) << ' ' << way;
      }
    }
  }
}

// Large meshes' indices are written past the caches, where they lie on whole vectors.
TEST(SorterOutput, LargeMeshesComeOutTheSameAtEveryAddress) {
  const Mesh mesh = shapes::torus_knot(300000);
  const std::size_t facets = mesh.triangles.size();
  const SortView view = inside_and_outside_views(mesh)[0];
  for (const Precision precision : {Precision::quantised, Precision::whole}) {
    Sorter sorter(mesh.view(), {.precision = precision});
    const Ids order = copy(sorter.sort(view));
    for (const std::size_t offset : {0u, 1u, 2u, 3u}) {
      Ids memory(3 * facets + 8, 0xdeadbeefu);
      const std::span<std::uint32_t> indices = std::span(memory).subspan(4 + offset, 3 * facets);
      ASSERT_EQ(sorter.sort_indices(view, mesh.triangles, indices), facets);
      std::size_t different = 0;
      for (std::size_t k = 0; k < facets; ++k) {
        for (int i = 0; i < 3; ++i) different += indices[3 * k + i] != mesh.triangles[order[k]][i];
      }
      EXPECT_EQ(different, 0u) << offset;
      EXPECT_TRUE(std::all_of(memory.begin(), memory.begin() + 4 + offset, [](auto i) { return i == 0xdeadbeefu; }));
      EXPECT_TRUE(
          std::all_of(memory.begin() + 4 + offset + 3 * facets, memory.end(), [](auto i) { return i == 0xdeadbeefu; }));
    }
  }
}

// Of a block's normals some are seen edge-on from eyes that are nearly on the axis of their cone.
TEST(SorterOutput, NothingSeenFromTheFrontIsLeftOutWithItsBlock) {
  Mesh mesh;
  const auto add = [&](const glm::dvec3& at, const glm::dvec3& towards) {
    const glm::dvec3 normal = glm::normalize(towards);
    const glm::dvec3 a = glm::normalize(glm::cross(normal, glm::dvec3(0.3, 0.5, 0.77))), b = glm::cross(normal, a);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (int k = 0; k < 3; ++k) {
      const double turn = glm::radians(120.0 * k);
      mesh.positions.emplace_back(at + (std::cos(turn) * a + std::sin(turn) * b) / 1024.0);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  };
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      add({x, y, -1}, {-x, -y, 1});
      add({x, y, 1}, {0, 0, 1});
    }
  }
  Sorter sorter(mesh.view(), {.cull_back_faces = true});
  std::size_t left_out = 0;
  for (float aside = 1e-4f; aside < 1.5e-3f; aside += 2e-5f) {
    for (float below = 3; below < 3.0045f; below += 1e-5f) {
      const SortView view{glm::vec4(-aside, -aside, -below, 1), glm::vec3(0, 0, 1)};
      std::array<bool, 8> is_kept{};
      for (const std::uint32_t id : sorter.sort(view)) is_kept[id] = true;
      for (std::uint32_t id = 0; id < 8; ++id) left_out += faces(mesh, id, view.eye) && !is_kept[id];
    }
  }
  EXPECT_EQ(left_out, 0u);
}

// Blocks of neighbours are told by the cone of their normals; blocks of facets from anywhere can't be.
TEST(SorterOutput, BlocksThatAreToldAtOnceChangeNothing) {
  std::mt19937 random(11);
  for (const Mesh& mesh : {shapes::torus_knot(20000), shapes::nested_shells(2, 0.5f, 4), load("hand_2k")}) {
    const auto triangles_kept = [](const Mesh& of, const SortView& view) {
      Sorter sorter(of.view(), {.cull_back_faces = true});
      std::vector<std::array<std::uint32_t, 3>> kept;
      for (const std::uint32_t id : sorter.sort(view)) {
        const glm::uvec3& t = of.triangles[id];
        kept.push_back({t.x, t.y, t.z});
      }
      std::sort(kept.begin(), kept.end());
      return kept;
    };
    Mesh near = mesh, scattered = mesh;
    const Ids order = spatial_order(mesh.view());
    for (std::size_t k = 0; k < order.size(); ++k) near.triangles[k] = mesh.triangles[order[k]];
    std::shuffle(scattered.triangles.begin(), scattered.triangles.end(), random);
    for (const SortView& view : inside_and_outside_views(mesh)) {
      const auto kept = triangles_kept(near, view);
      EXPECT_EQ(kept, triangles_kept(scattered, view));
      EXPECT_LT(kept.size(), mesh.triangles.size());
    }
  }
}

TEST(SorterOutput, ClipPlanesLeaveOutOnlyWhatLiesOutside) {
  const Mesh mesh = shapes::torus_knot(100000);
  Sorter whole(mesh.view(), {.precision = Precision::whole}),
      clipping(mesh.view(), {.precision = Precision::whole, .cull_by_clip_planes = true});
  for (SortView view : inside_and_outside_views(mesh)) {
    if (view.eye.w == 0) continue;
    const glm::vec3 eye(view.eye);
    const std::array planes =
        clip_planes_of(glm::perspective(0.5f, 1.3f, 0.01f, 1000.0f) *
                       glm::lookAt(eye, eye + view.forward + glm::vec3(0.1f), glm::vec3(0, 1, 0)));
    const Ids order = copy(whole.sort(view));
    EXPECT_EQ(copy(clipping.sort(view)), order) << "no planes, nothing left out";
    view.clip_planes = planes;
    const Ids clipped = copy(clipping.sort(view));
    std::vector<bool> kept(order.size(), false);
    for (const std::uint32_t id : clipped) kept[id] = true;
    std::size_t outside = 0, stay = 0;
    for (const std::uint32_t id : order) {
      const bool out = std::any_of(planes.begin(), planes.end(), [&](const glm::vec4& plane) {
        double most = -1;
        for (int i = 0; i < 3; ++i) {
          most = std::max(most, glm::dot(glm::dvec4(plane), glm::dvec4(mesh.view().corner(id, i), 1)));
        }
        return most < 0;
      });
      ASSERT_TRUE(kept[id] || out) << "facet " << id << " reaches inside";
      outside += out;
      stay += out && kept[id];
    }
    EXPECT_LE(stay, outside / 20 + order.size() / 100) << "of " << outside << " outside";
  }
}

TEST(SorterOutput, NewPositionsGiveWhatANewSorterGives) {
  const Mesh mesh = shapes::torus_knot(90000);
  Mesh bent = mesh;
  for (glm::vec3& p : bent.positions) p = 3.0f * glm::vec3(p.x, p.y + 0.3f * p.x * p.x, p.z) + glm::vec3(5, 0, 0);
  // As a skinned, interleaved vertex buffer.
  struct Vertex {
    float normal[3];
    glm::vec3 position;
    std::uint16_t odd;
  };
  std::vector<Vertex> vertices;
  for (const glm::vec3& p : bent.positions) vertices.push_back({{0, 0, 0}, p, 0});
  const StridedPositions positions(&vertices[0].position, vertices.size(), sizeof(Vertex));

  const SorterOptions options{.cull_back_faces = true, .cull_by_clip_planes = true};
  Sorter sorter(mesh.view(), options), fresh(bent.view(), options), strided(mesh.triangles, positions, options);
  const SortView view = inside_and_outside_views(bent)[0];
  sorter.sort(view);
  ASSERT_TRUE(sorter.is_sorted_for(view));
  with_threads(1, [&] {
    sorter.set_positions(mesh.triangles, positions);
    const AllocationScope scope;
    sorter.set_positions(mesh.triangles, positions);
    EXPECT_EQ(scope.count().calls, 0u);
  });
  EXPECT_FALSE(sorter.is_sorted_for(view));
  const Ids order = copy(fresh.sort(view));
  EXPECT_EQ(copy(sorter.sort(view)), order);
  EXPECT_EQ(copy(strided.sort(view)), order);
}

TEST(SorterOutput, DoesNothingForTheSameViewAgain) {
  const Mesh mesh = load("hand_2k");
  Sorter sorter(mesh.view(), {.cull_by_clip_planes = true});
  SortView view = inside_and_outside_views(mesh)[0];
  EXPECT_FALSE(sorter.is_sorted_for(view));
  const std::span<const std::uint32_t> order = sorter.sort(view);
  // What a second sort would put right shows whether it ran.
  const_cast<std::uint32_t&>(order[0]) ^= 1;
  const std::uint32_t changed = order[0];
  EXPECT_EQ(sorter.sort(view)[0], changed);
  sorter.forget_view();
  EXPECT_FALSE(sorter.is_sorted_for(view));
  const std::uint32_t right = changed ^ 1;
  EXPECT_EQ(sorter.sort(view)[0], right);
  const_cast<std::uint32_t&>(sorter.sort(view)[0]) ^= 1;

  Ids indices(3 * mesh.triangles.size());
  sorter.sort_indices(view, mesh.triangles, std::span(indices));
  EXPECT_TRUE(sorter.is_sorted_for(view));
  EXPECT_NE(sorter.sort(view)[0], changed) << "an index buffer leaves no ids behind";
  const glm::vec4 plane(1, 0, 0, 0);
  view.clip_planes = std::span(&plane, 1);
  EXPECT_FALSE(sorter.is_sorted_for(view));
  const std::size_t clipped = sorter.sort(view).size();
  EXPECT_LT(clipped, mesh.triangles.size());
  view.eye.x += 1;
  EXPECT_FALSE(sorter.is_sorted_for(view));
}

// Where the camera only turns, keys of distance stay; planes count where they cull.
TEST(SorterOutput, ComparesOfTheViewWhatItUses) {
  const Mesh mesh = load("hand_2k");
  const SortView view = inside_and_outside_views(mesh)[0];
  SortView turned = view, clipped = view, orthographic{glm::vec4(0, 0, 1, 0), glm::vec3(0, 0, -1)};
  turned.forward = glm::vec3(0.1f, 0.9f, 0);
  const glm::vec4 plane(1, 0, 0, 0);
  clipped.clip_planes = std::span(&plane, 1);
  for (const Method method : depth_key_methods()) {
    Sorter sorter(mesh.view(), method);
    sorter.sort(view);
    EXPECT_EQ(sorter.is_sorted_for(turned), method == Method::centroid_distance) << method_name(method);
    EXPECT_TRUE(sorter.is_sorted_for(clipped));
    sorter.sort(orthographic);
    orthographic.forward = turned.forward;
    EXPECT_TRUE(sorter.is_sorted_for(orthographic));
  }
}

TEST(SorterOutput, AllocatesNothingAfterTheFirstCallOfEach) {
  const Mesh mesh = shapes::torus_knot(150000);
  const std::vector<FacetRange> ranges{{0, 50000}, {50000, 1000}, {51000, 90000}};
  Ids indices(3 * mesh.triangles.size()), ids(mesh.triangles.size()), counts(ranges.size());
  const auto expect_none = [&](Precision precision) {
    Sorter sorter(mesh.view(), {.precision = precision, .cull_back_faces = true});
    const auto use = [&](const SortView& view) {
      sorter.sort(view);
      sorter.sort_indices(view, mesh.triangles, std::span(indices), ids);
      sorter.sort_ranges(view, mesh.triangles, ranges, std::span(indices), counts, ids);
    };
    const std::vector<SortView> views = inside_and_outside_views(mesh);
    use(views[0]);
    const AllocationScope scope;
    for (const SortView& view : views) use(view);
    EXPECT_EQ(scope.count().calls, 0u);
  };
  for (const Precision precision : {Precision::quantised, Precision::whole}) {
    for (const int threads : {1, 2, 8}) with_threads(threads, [&] { expect_none(precision); });
  }
}

TEST(SorterOutput, HoldsAtMost40BytesAFacet) {
  for (const std::size_t facets : {20000, 33000, 65000, 70000, 300000}) {
    const Mesh mesh = shapes::torus_knot(facets);
    for (const int threads : {1, 8}) {
      with_threads(threads, [&] {
        for (const Precision precision : {Precision::quantised, Precision::whole}) {
          Sorter sorter(mesh.view(), {.precision = precision, .cull_back_faces = true, .cull_by_clip_planes = true});
          Ids indices(3 * mesh.triangles.size());
          sorter.sort_indices(inside_and_outside_views(mesh)[0], mesh.triangles, std::span(indices));
          sorter.sort(inside_and_outside_views(mesh)[0]);
          EXPECT_LE(sorter.memory_bytes(), 40 * mesh.triangles.size());
        }
      });
    }
  }
}

TEST(SorterOutput, AnEyeNearSmallFacetsCostsNoDigits) {
  // Layers 1e-5 apart in a mesh a million times as large, an eye a hundredth before them and off the centre.
  const int layers = 100;
  Mesh mesh = facets_at(layers, [](std::size_t i) { return 1e-5f * static_cast<float>(i * 37 % layers); });
  for (glm::vec3& p : mesh.positions) p = p * glm::vec3(1e-2f, 1e-2f, 1) - glm::vec3(0.003f, 0.003f, 0);
  mesh.positions.insert(mesh.positions.end(), {{9, 9, 9}, {9, 10, 9}, {-10, -10, -9}});
  const auto last = static_cast<std::uint32_t>(mesh.positions.size()) - 1;
  mesh.triangles.push_back({last - 2, last - 1, last});
  const Ids order = copy(Sorter(mesh.view()).sort({glm::vec4(0, 0, 0.01f, 1), glm::vec3(0, 0, -1)}));
  for (std::size_t k = 2; k < order.size(); ++k) {
    EXPECT_LT(mesh.view().corner(order[k - 1], 0).z, mesh.view().corner(order[k], 0).z);
  }
}

TEST(SpatialOrder, IsAPermutationThatPutsNeighboursTogether) {
  Mesh mesh = shapes::torus_knot(40000);
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(1));
  const Ids order = spatial_order(mesh.view());
  Ids sorted = order;
  std::sort(sorted.begin(), sorted.end());
  ASSERT_EQ(sorted, all_ids(mesh));
  with_threads(1, [&] { EXPECT_EQ(spatial_order(mesh.view()), order); });

  const PointArrays centroids = facet_centroids(mesh.view(), facet_frame(facet_bounds(mesh.view())));
  const auto length = [&](const Ids& path) {
    double sum = 0;
    for (std::size_t k = 1; k < path.size(); ++k) {
      const auto at = [&](std::uint32_t id) { return glm::dvec3(centroids.x[id], centroids.y[id], centroids.z[id]); };
      sum += glm::distance(at(path[k - 1]), at(path[k]));
    }
    return sum;
  };
  EXPECT_LT(length(order), length(all_ids(mesh)) / 20);
}

}  // namespace
}  // namespace facetsort
