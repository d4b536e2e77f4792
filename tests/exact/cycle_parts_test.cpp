// Halves of parts and what they overlap, filters against exact signs; and cuts that are undone.
#include "facetsort/exact/cycle_parts.h"

#include <gtest/gtest.h>

#include <random>

#include "exact/point_space.h"
#include "facetsort/exact/needless_cuts.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort::exact_internal {
namespace {

// Triangles one above the other, each tilted within a slab of its own: none cross.
Mesh stack_of_triangles(int count, std::uint32_t seed) {
  std::mt19937 random(seed);
  // Few steps, so that corners often lie on the plane or the edge of another triangle as the eye sees them.
  const auto steps = [&](int most) { return static_cast<float>(random() % (most + 1)) / static_cast<float>(most); };
  Mesh mesh;
  while (mesh.triangles.size() < static_cast<std::size_t>(count)) {
    glm::vec3 corner[3];
    for (glm::vec3& c : corner) {
      c = {steps(8), steps(8), static_cast<float>(mesh.triangles.size()) + 0.75f * steps(4)};
    }
    if (normal_sign(corner[0], corner[1], corner[2], 2) == 0) continue;
    const std::uint32_t first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), corner, corner + 3);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

class Stack {
 public:
  Stack(int count, std::uint32_t seed, const Viewpoint& from)
      : mesh_(stack_of_triangles(count, seed)),
        from_(from),
        space_(space_of(mesh_.view())),
        points_(space_),
        parts_(points_, from, from.eye.w != 0 ? glm::dvec3(from.eye) : glm::dvec3(0)) {
    for (FacetId f = 0; f < mesh_.triangles.size(); ++f) {
      const MeshView view = mesh_.view();
      const int facing = side_of_plane(view.corner(f, 0), view.corner(f, 1), view.corner(f, 2), from.eye);
      parts_.add_member(f, facing, whole_facet(space_, f).corners, {});
    }
  }
  Stack(const Stack&) = delete;

  CycleParts& parts() { return parts_; }

  Hiding relation(std::uint32_t a, std::uint32_t b) const {
    std::vector<PointId> loops[2];
    for (const PartCorner& corner : parts_.corners(a)) loops[0].push_back(corner.point);
    for (const PartCorner& corner : parts_.corners(b)) loops[1].push_back(corner.point);
    return hiding(parts_.points(), from_, {parts_[a].facet, parts_[a].facing, loops[0]},
                  {parts_[b].facet, parts_[b].facing, loops[1]});
  }
  bool overlap(std::uint32_t a, std::uint32_t b) const { return relation(a, b) != Hiding::none; }

  bool halve_by(std::uint32_t part, std::uint32_t other) {
    return part != other && parts_.halve(part, parts_[other].facet, parts_[other].facing);
  }

 private:
  Mesh mesh_;
  Viewpoint from_;
  PointSpace space_;
  Points points_;
  CycleParts parts_;
};

constexpr int stack_size = 24;
// Above all in perspective and orthographic, beside them, and between two with the rest on all sides.
const Viewpoint viewpoints[] = {{Eye(0.4f, 0.6f, 40, 1), false},
                                {Eye(0, 0, 1, 0), false},
                                {Eye(9.1f, 0.3f, 11.3f, 1), false},
                                {Eye(0.45f, 0.55f, 11.9f, 1), true}};

TEST(CycleParts, FindOverlapsAsExactSignsDo) {
  std::size_t overlaps = 0, cuts = 0, parted = 0;
  for (const Viewpoint& from : viewpoints) {
    for (std::uint32_t seed = 1; seed <= 4; ++seed) {
      Stack stack(stack_size, seed, from);
      CycleParts& parts = stack.parts();
      for (std::uint32_t part = 0; part < stack_size; ++part) {
        for (std::uint32_t by = 0; by < stack_size; ++by) {
          if (parts[part].facing == 0 || parts[by].facing == 0 || !stack.halve_by(part, by)) continue;
          ++cuts;
          const std::uint32_t half = parts[part].first_half;
          for (std::uint32_t other = 0; other < stack_size; ++other) {
            if (other == part || parts[other].facing == 0) continue;
            ASSERT_EQ(parts.overlap(part, other), stack.overlap(part, other));
            if (!stack.overlap(part, other)) continue;
            ++overlaps;
            const int expected = (stack.overlap(half, other) ? 1 : 0) + (stack.overlap(half + 1, other) ? 2 : 0);
            ASSERT_NE(expected, 0);
            ASSERT_EQ(parts.overlapping_halves(part, other), expected) << part << ' ' << by << ' ' << other;
            parted += expected != 3;
            // Halves are seen as their member is.
            if (expected % 2 == 1) {
              ASSERT_EQ(stack.relation(half, other), stack.relation(part, other));
            }
          }
          parts.undo_halve(part);
        }
      }
    }
  }
  EXPECT_GT(cuts, 100u);
  EXPECT_GT(overlaps, 1000u);
  EXPECT_GT(parted, 100u);
}

TEST(CycleParts, HalvesLieBeyondAndBeforeTheCut) {
  for (const Viewpoint& from : viewpoints) {
    Stack stack(stack_size, 9, from);
    CycleParts& parts = stack.parts();
    const std::size_t points = parts.points().size();
    for (std::uint32_t part = 0; part < stack_size; ++part) {
      for (std::uint32_t by = 0; by < stack_size; ++by) {
        if (parts[by].facing == 0 || !stack.halve_by(part, by)) continue;
        ASSERT_EQ(parts.count(), stack_size + 2u);
        const std::uint32_t beyond = parts[part].first_half, before = beyond + 1;
        for (const std::uint32_t half : {beyond, before}) {
          EXPECT_EQ(parts[half].parent, part);
          EXPECT_EQ(parts[half].member, part);
          EXPECT_EQ(parts.corners(half)[parts[half].cut_edge].line, parts[by].facet);
          for (const PartCorner& corner : parts.corners(half)) {
            const int side = parts.points().side(parts[by].facet, corner.point) * parts[by].facing;
            EXPECT_TRUE(half == beyond ? side <= 0 : side >= 0);
          }
        }
        parts.undo_halve(part);
        ASSERT_EQ(parts.count(), static_cast<std::size_t>(stack_size));
        ASSERT_EQ(parts[part].first_half, CycleParts::none);
        ASSERT_EQ(parts.points().size(), points);
      }
    }
  }
}

// Seen from above, triangles in slabs need no cut, so all of them come together again, however they were cut.
TEST(NeedlessCuts, AreUndone) {
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    Stack stack(stack_size, seed, viewpoints[seed % 2]);
    CycleParts& parts = stack.parts();
    std::vector<HidingPair> pairs;
    for (std::uint32_t a = 0; a < stack_size; ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        const Hiding relation = stack.relation(a, b);
        ASSERT_NE(relation, Hiding::first_behind_second);
        if (relation == Hiding::second_behind_first) pairs.push_back({b, a});
      }
    }
    std::mt19937 random(seed);
    for (int i = 0; i < 2000; ++i) {
      const std::uint32_t part = static_cast<std::uint32_t>(random() % parts.count());
      const std::uint32_t by = static_cast<std::uint32_t>(random() % stack_size);
      if (parts[part].first_half == CycleParts::none) stack.halve_by(part, by);
    }
    ASSERT_GT(parts.count(), stack_size + 10u);
    std::vector<std::uint32_t> order;
    for (std::uint32_t member = 0; member < stack_size; ++member) {
      for (std::uint32_t part = 0; part < parts.count(); ++part) {
        if (parts[part].member == member && parts[part].first_half == CycleParts::none) order.push_back(part);
      }
    }
    std::vector<std::uint32_t> place(parts.count(), CycleParts::none);
    const std::vector<std::uint32_t> whole = undo_needless_cuts(parts, pairs, order);
    ASSERT_EQ(whole.size(), static_cast<std::size_t>(stack_size));
    for (std::uint32_t i = 0; i < whole.size(); ++i) {
      ASSERT_LT(whole[i], static_cast<std::uint32_t>(stack_size));
      place[whole[i]] = i;
    }
    for (const HidingPair& pair : pairs) EXPECT_LT(place[pair.first], place[pair.second]);
  }
}

}  // namespace
}  // namespace facetsort::exact_internal
