// What is read from a presorted mesh is what a plain walk of its tree gives, whatever tree, eye, earlier eyes, thread
// count and instruction set. Trees here need no sense in space: most are random.
#include "facetsort/order/presorted_reader.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "facetsort/exact/predicates.h"
#include "facetsort/exact/presort.h"
#include "facetsort/report/allocations.h"
#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/threads.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;

// What is drawn, as indices, the facet of each triangle, and draw ids.
struct Drawn {
  Ids indices, facets, draw_ids;

  bool operator==(const Drawn&) const = default;
};

// By a stack, node after node, with no sums.
class Walk {
 public:
  Walk(const PresortedView& mesh, bool culls) : mesh_(mesh), culls_(culls) {
    std::size_t in_nodes = 0;
    for (const PresortedNode& node : mesh.nodes) in_nodes += node.piece_count;
    std::size_t piece = loose_ = mesh.pieces.size() - in_nodes;
    for (const PresortedNode& node : mesh.nodes) {
      first_piece_.push_back(piece);
      piece += node.piece_count;
    }
    std::size_t triangle = 0;
    auto draw_id = static_cast<std::uint32_t>(mesh.mesh.facet_count());
    for (const PresortedPiece& of : mesh.pieces) {
      first_triangle_.push_back(triangle);
      triangle += of.triangle_count;
      draw_id_.push_back(of.cut_count == 0 ? of.facet : draw_id++);
    }
  }

  Drawn operator()(const glm::vec4& eye) {
    drawn_ = {};
    for (std::size_t piece = 0; piece < loose_; ++piece) draw(piece);
    std::vector<std::pair<std::size_t, bool>> left;  // nodes; whether what is beyond them is drawn
    if (!mesh_.nodes.empty()) left.push_back({0, false});
    while (!left.empty()) {
      const auto [i, beyond_is_drawn] = left.back();
      left.pop_back();
      const PresortedNode& node = mesh_.nodes[i];
      if (beyond_is_drawn) {
        draw_node(i, eye);
        continue;
      }
      std::pair<std::size_t, std::uint32_t> near{i + 1, node.front_nodes};
      std::pair<std::size_t, std::uint32_t> far{i + 1 + node.front_nodes, node.back_nodes};
      if (side(node.plane, eye) < 0) std::swap(near, far);
      if (near.second > 0) left.push_back({near.first, false});
      left.push_back({i, true});
      if (far.second > 0) left.push_back({far.first, false});
    }
    return std::move(drawn_);
  }

 private:
  int side(const glm::uvec3& plane, const glm::vec4& eye) const {
    const auto& positions = mesh_.mesh.positions;
    return side_of_plane(positions[plane.x], positions[plane.y], positions[plane.z], eye);
  }

  void draw_node(std::size_t node, const glm::vec4& eye) {
    for (std::uint32_t k = 0; k < mesh_.nodes[node].piece_count; ++k) {
      const std::size_t piece = first_piece_[node] + k;
      if (!culls_ || side(mesh_.mesh.triangles[mesh_.pieces[piece].facet], eye) > 0) draw(piece);
    }
  }

  void draw(std::size_t piece) {
    drawn_.draw_ids.push_back(draw_id_[piece]);
    for (std::uint32_t k = 0; k < mesh_.pieces[piece].triangle_count; ++k) {
      for (int i = 0; i < 3; ++i) drawn_.indices.push_back(mesh_.triangles[first_triangle_[piece] + k][i]);
      drawn_.facets.push_back(mesh_.pieces[piece].facet);
    }
  }

  PresortedView mesh_;
  bool culls_;
  std::size_t loose_;
  std::vector<std::size_t> first_piece_, first_triangle_;  // of each node, of each piece
  Ids draw_id_;
  Drawn drawn_;
};

// Expects nothing to be written after what is drawn.
Drawn read(PresortedReader& reader, const PresortedView& mesh, const glm::vec4& eye) {
  constexpr std::uint32_t untouched = 0xfefefefe;
  const std::size_t most = mesh.triangles.size();
  Drawn drawn{Ids(3 * most, untouched), Ids(most, untouched), Ids(mesh.pieces.size(), untouched)};
  const std::size_t count = reader.read_indices(eye, drawn.indices, drawn.facets);
  Ids indices_alone(3 * most, untouched);
  EXPECT_EQ(reader.read_indices(eye, indices_alone), count);
  EXPECT_EQ(indices_alone, drawn.indices);
  const std::size_t ids = reader.read_draw_ids(eye, drawn.draw_ids);
  const auto expect_rest_untouched = [](Ids& values, std::size_t size) {
    ASSERT_LE(size, values.size());
    const auto is_untouched = [](std::uint32_t value) { return value == untouched; };
    EXPECT_TRUE(std::all_of(values.begin() + static_cast<std::ptrdiff_t>(size), values.end(), is_untouched));
    values.resize(size);
  };
  expect_rest_untouched(drawn.indices, 3 * count);
  expect_rest_untouched(drawn.facets, count);
  expect_rest_untouched(drawn.draw_ids, ids);
  return drawn;
}

void expect_walk(const PresortedView& mesh, const std::vector<glm::vec4>& eyes) {
  for (const bool culls : {false, true}) {
    SCOPED_TRACE(culls);
    PresortedReader reader(mesh, {.cull_back_faces = culls});
    Walk walk(mesh, culls);
    for (const glm::vec4& eye : eyes) ASSERT_EQ(read(reader, mesh, eye), walk(eye)) << eye.x;
  }
}

// How many of the nodes below a node are in front of it.
using Shape = std::uint32_t (*)(std::mt19937& random, std::uint32_t below);

std::uint32_t split_anywhere(std::mt19937& random, std::uint32_t below) {
  return std::uniform_int_distribution<std::uint32_t>(0, below)(random);
}
std::uint32_t split_in_half(std::mt19937&, std::uint32_t below) {
  return below / 2;
}
std::uint32_t all_on_either(std::mt19937& random, std::uint32_t below) {
  return random() % 2 == 0 ? 0 : below;
}

class TreeMaker {
 public:
  explicit TreeMaker(std::uint32_t seed) : random_(seed) {
    std::uniform_real_distribution<float> coordinate(-1, 1);
    for (int i = 0; i < 300; ++i) {
      data_.positions.push_back({coordinate(random_), coordinate(random_), coordinate(random_)});
    }
  }

  // The first `crowded` nodes have pieces in any number, the others one or two.
  PresortedData make(std::uint32_t nodes, Shape shape, std::uint32_t crowded = 0xffffffff) {
    crowded_ = crowded;
    for (int k = 0; k < 5; ++k) add_piece({7, 7, 7});  // without area, and so without a node
    std::vector<std::uint32_t> left;                   // sizes of subtrees to come
    if (nodes > 0) left.push_back(nodes);
    while (!left.empty()) {
      const std::uint32_t below = left.back() - 1, front = shape(random_, below);
      left.pop_back();
      add_node(front, below - front);
      if (below > front) left.push_back(below - front);
      if (front > 0) left.push_back(front);
    }
    return std::move(data_);
  }

 private:
  void add_node(std::uint32_t front, std::uint32_t back) {
    const glm::uvec3 plane = any_triangle();
    // Most have a piece or two, some none, few very many.
    const std::uint32_t kind = data_.nodes.size() < crowded_ ? any(64) : 8;
    const std::uint32_t pieces = kind == 0 ? any(700) : kind < 8 ? 0 : 1 + any(2);
    for (std::uint32_t k = 0; k < pieces; ++k) {
      add_piece(any(2) == 0 ? plane : glm::uvec3(plane.x, plane.z, plane.y));
    }
    data_.nodes.push_back({plane, pieces, front, back});
  }

  void add_piece(const glm::uvec3& facet) {
    const std::uint32_t triangles = any(4) == 0 ? 1 + any(5) : 1, cuts = any(2);
    data_.pieces.push_back({static_cast<std::uint32_t>(data_.facets.size()), triangles, cuts});
    data_.facets.push_back(facet);
    for (std::uint32_t k = 0; k < triangles; ++k) data_.triangles.push_back(any_triangle());
    data_.cuts.resize(data_.cuts.size() + cuts);
  }

  glm::uvec3 any_triangle() {
    const std::uint32_t a = any(100), b = 100 + any(100), c = 200 + any(100);
    return {a, b, c};
  }

  std::uint32_t any(std::uint32_t count) { return std::uniform_int_distribution<std::uint32_t>(0, count - 1)(random_); }

  std::mt19937 random_;
  std::uint32_t crowded_ = 0;
  PresortedData data_;
};

std::vector<glm::vec4> eyes() {
  return {{0.1f, 0.2f, 3, 1},     {0.3f, -0.1f, 0.2f, 1}, {-40, 7, 1, 1}, {1e30f, 2e30f, -1e29f, 1},
          {0.5f, 0.6f, -0.1f, 0}, {1e-20f, 0, 2e-20f, 0}, {3, 3, 3, 1},   {3.001f, 3, 3, 1}};
}

TEST(PresortedReader, GivesAWalkOfAnyTree) {
  for (const std::uint32_t nodes : {1, 2, 3, 10, 191, 192, 193, 1000, 20000}) {
    for (const Shape shape : {&split_anywhere, &split_in_half, &all_on_either}) {
      SCOPED_TRACE(nodes);
      const PresortedData data = TreeMaker(nodes).make(nodes, shape);
      expect_walk(data.view(), eyes());
    }
  }
}

TEST(PresortedReader, GivesNothingOfNothing) {
  const PresortedData data;
  expect_walk(data.view(), eyes());
}

TEST(PresortedReader, DrawsPiecesWithoutANodeFirst) {
  const PresortedData data = TreeMaker(1).make(0, &split_in_half);
  ASSERT_EQ(data.pieces.size(), 5u);
  expect_walk(data.view(), eyes());
}

TEST(PresortedReader, ReadsTreesDeeperThanAnyStack) {
  const PresortedData data = TreeMaker(2).make(1'000'000, &all_on_either, 1);
  expect_walk(data.view(), {eyes()[0], eyes()[1]});
}

TEST(PresortedReader, TakesAnEyeInAPlaneForInFront) {
  const PresortedData data = TreeMaker(3).make(3000, &split_in_half);
  // A vertex is in every plane through it. Facets seen edge-on may stay, so that culling is left out.
  PresortedReader reader(data.view());
  Walk walk(data.view(), false);
  for (const std::size_t vertex : {0, 150, 299}) {
    const glm::vec4 eye(data.positions[vertex], 1);
    ASSERT_EQ(read(reader, data.view(), eye), walk(eye));
  }
  const glm::vec4 along_an_edge(data.positions[data.nodes[5].plane.y] - data.positions[data.nodes[5].plane.x], 0);
  ASSERT_EQ(read(reader, data.view(), along_an_edge), walk(along_an_edge));
}

TEST(PresortedReader, ReadsSliversAndAnyScale) {
  PresortedData data = TreeMaker(4).make(2000, &split_anywhere);
  for (const float scale : {1e-40f, 1e-20f, 1.0f, 1e36f}) {
    for (const float flatness : {1.0f, 1e-12f}) {
      PresortedData scaled = data;
      for (glm::vec3& p : scaled.positions) p = scale * glm::vec3(p.x, p.x + flatness * p.y, p.z);
      std::vector<glm::vec4> scaled_eyes;
      for (const glm::vec4& eye : eyes()) {
        if (std::abs(eye.x) < 1e3f) scaled_eyes.push_back(eye * glm::vec4(glm::vec3(eye.w == 0 ? 1 : scale), 1));
      }
      for (const glm::vec4& eye : scaled_eyes) {
        PresortedReader reader(scaled.view());
        ASSERT_EQ(read(reader, scaled.view(), eye), Walk(scaled.view(), false)(eye)) << scale;
      }
    }
  }
}

TEST(PresortedReader, ReadsAllFacetsInOnePlane) {
  const Mesh mesh = shapes::coplanar(1000, 1);
  const PresortedData data = presort(mesh.view())->data;
  expect_walk(data.view(), {{0.3f, 0.4f, 5, 1}, {0.3f, 0.4f, -5, 1}, {0.1f, 0.2f, -1, 0}});
}

TEST(PresortedReader, ReadsTreesOfMeshes) {
  for (const Mesh& mesh : {shapes::box(), shapes::icosphere(4), shapes::torus_knot(20'000), shapes::slab_cycle(12),
                           shapes::interpenetrating(3), shapes::comb(20)}) {
    const PresortedData data = presort(mesh.view())->data;
    ASSERT_FALSE(data.nodes.empty());
    expect_walk(data.view(), {{2.1f, 3.2f, 4.3f, 1}, {0.11f, 0.05f, -0.07f, 1}, {-0.31f, 0.52f, 0.79f, 0}});
  }
}

// Tiny steps, some of no length, small steps, jumps, out of the mesh and through it, and both projections.
std::vector<glm::vec4> journey() {
  std::vector<glm::vec4> eyes;
  glm::vec3 eye(1.7f, 0.4f, 1.1f);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> any(-1, 1);
  for (int k = 0; k < 400; ++k) {
    const float step = k % 100 == 99 ? 3.0f : k % 10 == 9 ? 0.05f : k % 5 == 4 ? 0.0f : 0.001f;
    eye += step * glm::vec3(any(random) - 0.2f * eye.x, any(random) - 0.2f * eye.y, any(random) - 0.2f * eye.z);
    eyes.push_back(glm::vec4(eye, k / 50 % 3 == 2 ? 0 : 1));
  }
  return eyes;
}

TEST(PresortedReader, ForgetsEarlierEyes) {
  const PresortedData data = TreeMaker(6).make(3000, &split_anywhere);
  expect_walk(data.view(), journey());
}

TEST(PresortedReader, KnowsTheEyeThatItReadFor) {
  const PresortedData data = TreeMaker(7).make(100, &split_in_half);
  PresortedReader reader(data.view());
  EXPECT_FALSE(reader.is_read_for(eyes()[0]));
  const Drawn first = read(reader, data.view(), eyes()[0]);
  EXPECT_TRUE(reader.is_read_for(eyes()[0]));
  EXPECT_FALSE(reader.is_read_for(eyes()[1]));
  reader.forget_eye();
  EXPECT_FALSE(reader.is_read_for(eyes()[0]));
  EXPECT_EQ(read(reader, data.view(), eyes()[0]), first);
}

TEST(PresortedReader, TellsWhetherAMovedEyeKeepsTheOrder) {
  const PresortedData data = TreeMaker(8).make(60, &split_anywhere);
  for (const bool culls : {false, true}) {
    SCOPED_TRACE(culls);
    PresortedReader reader(data.view(), {.cull_back_faces = culls});
    EXPECT_FALSE(reader.keeps_order(journey()[0]));
    Drawn last;
    int kept = 0, changed = 0;
    for (const glm::vec4& eye : journey()) {
      PresortedReader other(data.view(), {.cull_back_faces = culls});
      const Drawn expected = read(other, data.view(), eye);
      if (reader.keeps_order(eye)) {
        ASSERT_EQ(last, expected);
        ++kept;
      } else {
        EXPECT_FALSE(reader.is_read_for(eye));
        last = read(reader, data.view(), eye);
        ASSERT_EQ(last, expected);
        ++changed;
      }
      EXPECT_TRUE(reader.is_read_for(eye));
    }
    EXPECT_GT(kept, 50);
    EXPECT_GT(changed, 15);
  }
}

std::vector<Drawn> drawn_on_a_journey(const PresortedData& data) {
  std::vector<Drawn> result;
  const std::vector<glm::vec4> all = journey();
  for (const bool culls : {false, true}) {
    PresortedReader reader(data.view(), {.cull_back_faces = culls});
    for (std::size_t k = 0; k < all.size(); k += 23) result.push_back(read(reader, data.view(), all[k]));
  }
  return result;
}

TEST(PresortedReader, GivesTheSameForAnyThreadCountAndInstructionSet) {
  const PresortedData data = TreeMaker(8).make(10'000, &split_in_half);
  const std::vector<Drawn> expected = drawn_on_a_journey(data);
  for (const int threads : {1, 2, 3, 8}) {
    EXPECT_EQ(with_threads(threads, [&] { return drawn_on_a_journey(data); }), expected) << threads;
  }
  for_each_instruction_set([&] { EXPECT_EQ(drawn_on_a_journey(data), expected); });
}

TEST(PresortedReader, AllocatesNothingAfterTheFirstCall) {
  const PresortedData data = TreeMaker(9).make(20'000, &split_in_half);
  with_threads(1, [&] {
    PresortedReader reader(data.view(), {.cull_back_faces = true});
    Ids indices(3 * data.triangles.size()), facets(data.triangles.size()), draw_ids(data.pieces.size());
    const auto read_all = [&](const glm::vec4& eye) {
      reader.read_indices(eye, indices, facets);
      reader.read_draw_ids(eye, draw_ids);
    };
    read_all(eyes()[0]);
    const std::size_t bytes = reader.memory_bytes();
    const AllocationScope allocations;
    for (const glm::vec4& eye : eyes()) read_all(eye);
    EXPECT_EQ(allocations.count().calls, 1u);  // the list of eyes
    EXPECT_EQ(reader.memory_bytes(), bytes);
  });
}

}  // namespace
}  // namespace facetsort
