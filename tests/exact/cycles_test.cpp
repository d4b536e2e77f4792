// Cycles that are cut until they are none.
#include "facetsort/exact/cycles.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "exact/point_space.h"
#include "facetsort/exact/predicates.h"
#include "shapes.h"
#include "support/threads.h"

namespace facetsort::exact_internal {
namespace {

// All facets of a mesh as members of one cycle, and every pair that hides one another.
class CycleOf {
 public:
  CycleOf(Mesh mesh, const Viewpoint& from)
      : mesh_(std::move(mesh)), from_(from), space_(space_of(mesh_.view())), points_(space_) {
    for (FacetId f = 0; f < mesh_.triangles.size(); ++f) {
      const MeshView view = mesh_.view();
      const int facing = side_of_plane(view.corner(f, 0), view.corner(f, 1), view.corner(f, 2), from.eye);
      members_.push_back({f, facing, whole_facet(space_, f).corners, {}});
    }
    for (std::uint32_t a = 0; a < members_.size(); ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        const Hiding relation = relation_of(points_, members_[a], members_[b]);
        if (relation == Hiding::first_behind_second) pairs_.push_back({a, b});
        if (relation == Hiding::second_behind_first) pairs_.push_back({b, a});
      }
    }
  }
  CycleOf(const CycleOf&) = delete;

  OrderedCycle order(std::size_t most_cuts) const { return order_cycle(points_, from_, members_, pairs_, most_cuts); }

  const std::vector<HidingPair>& pairs() const { return pairs_; }
  bool has_cycle() const {
    return ComponentFinder().find(list_behind(members_.size(), pairs_)).count() < members_.size();
  }

  // Nothing comes after what it should hide behind, each member comes whole or in pieces that cuts leave, and no two
  // pieces could be one.
  void expect_ordered(const OrderedCycle& cycle) const {
    EXPECT_FALSE(cycle.gave_up);
    std::vector<CycleMember> parts;
    std::vector<std::size_t> whole(members_.size()), pieces(members_.size());
    for (const OrderedPart& part : cycle.order) {
      parts.push_back(members_.at(part.member));
      ++(part.is_whole ? whole : pieces)[part.member];
      if (part.is_whole) continue;
      const Part& piece = cycle.pieces.parts.at(part.piece);
      ASSERT_EQ(piece.facet, parts.back().facet);
      const auto corners = cycle.pieces.corners_of(piece);
      parts.back().corners.assign(corners.begin(), corners.end());
      ASSERT_GE(corners.size(), 3u);
      ASSERT_GT(piece.cut_count, 0u);
      for (const Cut& cut : cycle.pieces.cuts_of(piece)) {
        for (const PartCorner& corner : corners) ASSERT_GE(cycle.points.side(cut.plane, corner.point) * cut.side, 0);
      }
    }
    std::size_t cut_members = 0, all_pieces = 0;
    for (std::size_t m = 0; m < members_.size(); ++m) {
      ASSERT_TRUE((whole[m] == 1 && pieces[m] == 0) || (whole[m] == 0 && pieces[m] >= 2)) << m;
      cut_members += whole[m] == 0;
      all_pieces += pieces[m];
    }
    EXPECT_EQ(all_pieces, cut_members + cycle.cuts);
    std::vector<std::vector<std::size_t>> hidden_by(parts.size());
    for (std::size_t early = 0; early < parts.size(); ++early) {
      for (std::size_t late = early + 1; late < parts.size(); ++late) {
        const Hiding relation = relation_of(cycle.points, parts[early], parts[late]);
        ASSERT_NE(relation, Hiding::second_behind_first) << early << ' ' << late;
        if (relation == Hiding::first_behind_second) hidden_by[early].push_back(late);
      }
    }
    for (std::size_t early = 0; early < parts.size(); ++early) {
      if (pieces[cycle.order[early].member] != 2) continue;
      for (std::size_t late = early + 1; late < parts.size(); ++late) {
        if (cycle.order[late].member != cycle.order[early].member) continue;
        EXPECT_TRUE(leads_to(hidden_by, early, late)) << "member " << cycle.order[early].member << " cut for nothing";
      }
    }
  }

 private:
  static bool leads_to(const std::vector<std::vector<std::size_t>>& hidden_by, std::size_t from, std::size_t to) {
    std::vector<bool> reached(to + 1);
    reached[from] = true;
    for (std::size_t i = from; i < to; ++i) {
      if (!reached[i]) continue;
      for (const std::size_t next : hidden_by[i]) {
        if (next <= to) reached[next] = true;
      }
    }
    return reached[to];
  }

  Hiding relation_of(const Points& points, const CycleMember& a, const CycleMember& b) const {
    std::vector<PointId> loops[2];
    for (const PartCorner& corner : a.corners) loops[0].push_back(corner.point);
    for (const PartCorner& corner : b.corners) loops[1].push_back(corner.point);
    return hiding(points, from_, {a.facet, a.facing, loops[0]}, {b.facet, b.facing, loops[1]});
  }

  Mesh mesh_;
  Viewpoint from_;
  PointSpace space_;
  Points points_;
  std::vector<CycleMember> members_;
  std::vector<HidingPair> pairs_;
};

constexpr std::size_t no_cut_limit = 1'000'000;
const Viewpoint from_above[] = {{Eye(0, 0, 4, 1), false}, {Eye(0, 0, 1, 0), false}, {Eye(0, 0, 4, 1), true}};

TEST(OrderCycle, CutsTheClassicThreeOnce) {
  for (const Viewpoint& from : from_above) {
    const CycleOf three(shapes::triangle_cycle(3), from);
    ASSERT_TRUE(three.has_cycle());
    EXPECT_EQ(three.pairs().size(), 3u);
    const OrderedCycle ordered = three.order(no_cut_limit);
    three.expect_ordered(ordered);
    EXPECT_EQ(ordered.cuts, 1u);
    EXPECT_EQ(ordered.order.size(), 4u);
  }
}

TEST(OrderCycle, OrdersLargerOnes) {
  for (const Viewpoint& from : from_above) {
    for (const int n : {4, 9, 40}) {
      const CycleOf ring(shapes::triangle_cycle(n), from);
      ASSERT_TRUE(ring.has_cycle());
      const OrderedCycle ordered = ring.order(no_cut_limit);
      ring.expect_ordered(ordered);
      EXPECT_EQ(ordered.cuts, 1u);
    }
  }
  const CycleOf comb(shapes::comb(20), {Eye(1, 0.5f, 5, 1), false});
  ASSERT_TRUE(comb.has_cycle());
  comb.expect_ordered(comb.order(no_cut_limit));
  const CycleOf mat(shapes::woven_mat(3), {Eye(1, 1, 6, 1), false});
  ASSERT_TRUE(mat.has_cycle());
  mat.expect_ordered(mat.order(no_cut_limit));
}

TEST(OrderCycle, GivesUpWhereTooManyCutsAreNeeded) {
  const CycleOf three(shapes::triangle_cycle(3), from_above[0]);
  EXPECT_TRUE(three.order(0).gave_up);
  EXPECT_FALSE(three.order(1).gave_up);
  const CycleOf mat(shapes::woven_mat(4), {Eye(1.5f, 1.5f, 8, 1), false});
  EXPECT_TRUE(mat.order(3).gave_up);
  // What counts is what is left once needless cuts are undone.
  const std::size_t needed = mat.order(no_cut_limit).cuts;
  EXPECT_FALSE(mat.order(needed).gave_up);
  EXPECT_TRUE(mat.order(needed - 1).gave_up);
}

// Large enough for planes to be judged by several threads.
TEST(OrderCycle, IsTheSameForAnyThreadCount) {
  const CycleOf mat(shapes::woven_mat(14), {Eye(6.5f, 6.5f, 20, 1), false});
  const OrderedCycle expected = mat.order(no_cut_limit);
  mat.expect_ordered(expected);
  for (const int threads : {1, 2, 3, 8}) {
    const OrderedCycle again = with_threads(threads, [&] { return mat.order(no_cut_limit); });
    ASSERT_EQ(again.order.size(), expected.order.size());
    for (std::size_t i = 0; i < expected.order.size(); ++i) {
      ASSERT_EQ(again.order[i].member, expected.order[i].member);
      ASSERT_EQ(again.order[i].is_whole, expected.order[i].is_whole);
      if (expected.order[i].is_whole) continue;
      const auto cuts = again.pieces.cuts_of(again.pieces.parts[again.order[i].piece]);
      const auto expected_cuts = expected.pieces.cuts_of(expected.pieces.parts[expected.order[i].piece]);
      ASSERT_TRUE(std::equal(cuts.begin(), cuts.end(), expected_cuts.begin(), expected_cuts.end(),
                             [](const Cut& a, const Cut& b) { return a.plane == b.plane && a.side == b.side; }));
    }
  }
}

}  // namespace
}  // namespace facetsort::exact_internal
