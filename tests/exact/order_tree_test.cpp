// What every order tree holds, whatever the mesh.
#include "facetsort/exact/order_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <optional>
#include <vector>

#include "exact/point_space.h"
#include "facetsort/exact/crossings.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/positions.h"
#include "shapes.h"
#include "support/threads.h"

namespace facetsort::exact_internal {
namespace {

// A tree over all parts of a mesh, crossing facets parted.
class TreeOf {
 public:
  explicit TreeOf(Mesh mesh, std::size_t most_cuts = 1'000'000)
      : mesh_(std::move(mesh)),
        space_(space_of(mesh_.view())),
        points_(space_),
        pieces_(part_crossing_facets(points_, find_degenerate_facets(mesh_.view()), 1'000'000'000).pieces),
        parts_(parts_to_draw(pieces_, mesh_.triangles.size())),
        pieces_before_(pieces_.parts.size()),
        points_before_(points_.size()),
        planes_before_(points_.plane_count()),
        tree_(build_order_tree(points_, pieces_, parts_, {.most_cuts = most_cuts})) {}
  TreeOf(const TreeOf&) = delete;

  const std::optional<OrderTree>& tree() const { return tree_; }
  const std::vector<std::uint32_t>& parts() const { return parts_; }
  bool nothing_added() const {
    return pieces_.parts.size() == pieces_before_ && points_.size() == points_before_ &&
           points_.plane_count() == planes_before_;
  }

  std::vector<PointId> corners(std::uint32_t part) const {
    std::vector<PointId> result;
    const std::size_t facets = mesh_.triangles.size();
    if (part < facets) {
      for (int i = 0; i < 3; ++i) result.push_back(space_.corner(part, i));
    } else {
      for (const PartCorner& corner : pieces_.corners_of(pieces_.parts[part - facets])) result.push_back(corner.point);
    }
    return result;
  }

  // All below a node is on its side, all members are in the plane, and halves make their whole.
  void expect_sides() const {
    for (const OrderTree::Node& node : tree_->nodes) {
      for (const std::uint32_t part : tree_->members_of(node)) expect_side(node.plane, part, 0);
      for (const std::uint32_t part : below(node.front)) expect_side(node.plane, part, 1);
      for (const std::uint32_t part : below(node.back)) expect_side(node.plane, part, -1);
      for (const OrderTree::Halving& halving : tree_->halvings_of(node)) {
        expect_side(node.plane, halving.front, 1);
        expect_side(node.plane, halving.back, -1);
        EXPECT_EQ(facet_of(halving.front), facet_of(halving.whole));
        EXPECT_EQ(facet_of(halving.back), facet_of(halving.whole));
      }
    }
  }

  // Every part is a member once, or is cut once into two that are.
  void expect_every_part_once() const {
    std::vector<std::uint32_t> made = parts_, found = tree_->members;
    for (const OrderTree::Halving& halving : tree_->halvings) {
      made.push_back(halving.front);
      made.push_back(halving.back);
      found.push_back(halving.whole);
    }
    std::sort(made.begin(), made.end());
    std::sort(found.begin(), found.end());
    EXPECT_EQ(made, found);
  }

  // A row of nodes each, which together are all below the top.
  void expect_subtrees_apart() const {
    std::size_t next = tree_->top_nodes();
    for (const OrderTree::Subtree& subtree : tree_->subtrees) {
      EXPECT_EQ(subtree.first_node, next);
      next += subtree.node_count;
      for (std::size_t i = subtree.first_node; i < next; ++i) {
        for (const std::uint32_t below : {tree_->nodes[i].front, tree_->nodes[i].back}) {
          EXPECT_TRUE(below == OrderTree::none || (below > i && below < next));
        }
      }
    }
    EXPECT_EQ(next, tree_->nodes.size());
  }

 private:
  void expect_side(PlaneId plane, std::uint32_t part, int side) const {
    bool reaches = side == 0;
    for (const PointId corner : corners(part)) {
      const int found = points_.side(plane, corner);
      EXPECT_TRUE(found == 0 || found == side);
      reaches = reaches || found == side;
    }
    EXPECT_TRUE(reaches);
  }
  FacetId facet_of(std::uint32_t part) const {
    const std::size_t facets = mesh_.triangles.size();
    return part < facets ? part : pieces_.parts[part - facets].facet;
  }
  std::vector<std::uint32_t> below(std::uint32_t root) const {
    std::vector<std::uint32_t> members, left;
    if (root != OrderTree::none) left.push_back(root);
    while (!left.empty()) {
      const OrderTree::Node& node = tree_->nodes[left.back()];
      left.pop_back();
      members.insert(members.end(), tree_->members_of(node).begin(), tree_->members_of(node).end());
      for (const std::uint32_t next : {node.front, node.back}) {
        if (next != OrderTree::none) left.push_back(next);
      }
    }
    return members;
  }

  Mesh mesh_;
  PointSpace space_;
  Points points_;
  PartList pieces_;
  std::vector<std::uint32_t> parts_;
  std::size_t pieces_before_, points_before_, planes_before_;
  std::optional<OrderTree> tree_;
};

void expect_sound(const Mesh& mesh) {
  const TreeOf tree(mesh);
  ASSERT_TRUE(tree.tree());
  tree.expect_every_part_once();
  tree.expect_sides();
  tree.expect_subtrees_apart();
}

TEST(OrderTree, IsSound) {
  for (const Mesh& mesh : {shapes::box(), shapes::icosphere(3), shapes::soup(40, 3), shapes::woven_mat(6),
                           shapes::slab_cycle(12), shapes::interpenetrating(2), shapes::comb(20)}) {
    expect_sound(mesh);
  }
}

TEST(OrderTree, GrowsSubtreesOfLargeMeshes) {
  const TreeOf tree(shapes::torus_knot(20'000));
  ASSERT_TRUE(tree.tree());
  EXPECT_GT(tree.tree()->subtrees.size(), 4u);
  EXPECT_GT(tree.tree()->top_nodes(), 3u);
  tree.expect_every_part_once();
  tree.expect_subtrees_apart();
}

TEST(OrderTree, OfAConvexBodyCutsNothing) {
  const TreeOf tree(shapes::icosphere(2));
  ASSERT_TRUE(tree.tree());
  EXPECT_LT(tree.tree()->halvings.size(), shapes::icosphere(2).triangles.size() / 4);
  EXPECT_TRUE(TreeOf(shapes::box()).tree()->halvings.empty());
}

TEST(OrderTree, OfOnePlaneIsOneNode) {
  const Mesh mesh = shapes::coplanar(50, 1);
  const TreeOf tree(mesh);
  ASSERT_TRUE(tree.tree());
  ASSERT_EQ(tree.tree()->nodes.size(), 1u);
  EXPECT_EQ(tree.tree()->nodes[0].member_count, mesh.triangles.size());
  EXPECT_TRUE(std::is_sorted(tree.tree()->members.begin(), tree.tree()->members.end()));
}

TEST(OrderTree, OfNothingIsEmpty) {
  const Mesh mesh = shapes::box();
  const PointSpace space = space_of(mesh.view());
  Points points(space);
  PartList pieces;
  const std::optional<OrderTree> tree = build_order_tree(points, pieces, {}, {.most_cuts = 100});
  ASSERT_TRUE(tree);
  EXPECT_TRUE(tree->nodes.empty());
}

TEST(OrderTree, LeavesNothingBehindWhereItTakesTooManyCuts) {
  for (const Mesh& mesh : {shapes::woven_mat(10), shapes::torus_knot(10'000)}) {
    const std::size_t needed = TreeOf(mesh).tree()->halvings.size();
    ASSERT_GT(needed, 2u);
    const TreeOf bounded(mesh, needed - 1);
    EXPECT_FALSE(bounded.tree());
    EXPECT_TRUE(bounded.nothing_added());
    EXPECT_TRUE(TreeOf(mesh, needed).tree());
  }
}

TEST(OrderTree, IsTheSameForAnyThreadCount) {
  const Mesh mesh = shapes::torus_knot(10'000);
  const TreeOf expected(mesh);
  for (const int threads : {1, 3, 8}) {
    with_threads(threads, [&] {
      const TreeOf tree(mesh);
      ASSERT_EQ(tree.tree()->members, expected.tree()->members);
      for (const std::uint32_t part : tree.tree()->members) ASSERT_EQ(tree.corners(part), expected.corners(part));
    });
  }
}

}  // namespace
}  // namespace facetsort::exact_internal
