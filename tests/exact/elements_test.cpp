// What is known of the points and edges of elements before any view, and what filters make of it.
#include "facetsort/exact/elements.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/parted_mesh.h"
#include "facetsort/exact/screen.h"
#include "facetsort/facets/facets.h"
#include "shapes.h"

namespace facetsort::exact_internal {
namespace {

// The parts of a tree over a mesh, as ExactSorter lays them out.
class TreeElements {
 public:
  explicit TreeElements(Mesh mesh) : mesh_(std::move(mesh)), parted_(mesh_.view(), 1000) {
    const std::optional<OrderTree> tree = build_order_tree(parted_, 1000, 1, nullptr);
    std::vector<std::uint32_t> all;
    for (const OrderTree::Node& node : tree->nodes) {
      for (const std::uint32_t part : tree->members_of(node)) all.push_back(part);
      for (const OrderTree::Halving& halving : tree->halvings_of(node)) all.push_back(halving.whole);
    }
    elements_ = make_elements(parted_.points, parted_.pieces, parted_.degenerate, all, false);
    find_outline_ids(parted_.points, parted_.pieces, elements_);
  }
  TreeElements(const TreeElements&) = delete;

  const Mesh& mesh() const { return mesh_; }
  const Points& points() const { return parted_.points; }
  const Elements& elements() const { return elements_; }

  // No vertex parts from the line of two points and a third: they are on one line.
  bool are_collinear(PointId a, PointId b, PointId c) const {
    for (PointId vertex = 0; vertex < mesh_.positions.size(); ++vertex) {
      if (points().orientation(a, b, c, vertex) != 0) return false;
    }
    return true;
  }

  SeenPart seen(const Screen& screen, std::uint32_t element) const {
    return {elements_.facet[element], screen.facing(element), elements_.corners(element)};
  }

 private:
  Mesh mesh_;
  PartedMesh parted_;
  Elements elements_;
};

// Two that cross, facets of one through edges of the other.
Mesh spheres() {
  Mesh mesh = shapes::icosphere(1);
  const std::size_t vertices = mesh.positions.size(), facets = mesh.triangles.size();
  for (std::size_t i = 0; i < vertices; ++i) mesh.positions.push_back(mesh.positions[i] + glm::vec3(0.6f, 0.1f, 0.2f));
  for (std::size_t i = 0; i < facets; ++i) {
    mesh.triangles.push_back(mesh.triangles[i] + static_cast<std::uint32_t>(vertices));
  }
  return mesh;
}

// Facets with corners at whole coordinates: many planes go through one point.
Mesh lattice() {
  Mesh mesh = shapes::soup(24, 9);
  for (glm::vec3& p : mesh.positions) p = glm::round(p * 2.0f);
  return mesh;
}

struct Source {
  const char* name;
  Mesh (*make)();
};

const Source sources[] = {{"Spheres", spheres}, {"Lattice", lattice}};

class ElementsOf : public testing::TestWithParam<Source> {};
INSTANTIATE_TEST_SUITE_P(Sources, ElementsOf, testing::ValuesIn(sources),
                         [](const auto& source) { return source.param.name; });

TEST_P(ElementsOf, PointsThatShareASlotCoincide) {
  const TreeElements tree(GetParam().make());
  const Elements& elements = tree.elements();
  std::size_t other_names = 0;
  for (std::size_t i = 0; i < elements.corner_slot.size(); ++i) {
    const PointId point = elements.corner_point[i], named = elements.slot_point[elements.corner_slot[i]];
    other_names += point != named;
    ASSERT_TRUE(tree.points().coincide(point, named));
  }
  // Spheres meet in points that both name alike.
  EXPECT_TRUE(GetParam().make != lattice || other_names > 0);
}

TEST_P(ElementsOf, SlotsOnAnEdgesLineAreCollinearWithIt) {
  const TreeElements tree(GetParam().make());
  const Elements& elements = tree.elements();
  std::size_t beyond_ends = 0;
  for (std::uint32_t element = 0; element < elements.count(); element += 7) {
    const auto slots = elements.slots(element), lines = elements.lines(element);
    for (std::size_t k = 0; k < slots.size(); ++k) {
      const std::uint32_t from = slots[k], to = slots[(k + 1) % slots.size()];
      ASSERT_TRUE(elements.is_on_line(from, lines[k]) && elements.is_on_line(to, lines[k]));
      if (from == to) continue;
      for (std::uint32_t slot = 0; slot < elements.slot_point.size(); ++slot) {
        if (slot == from || slot == to || !elements.is_on_line(slot, lines[k])) continue;
        ++beyond_ends;
        ASSERT_TRUE(tree.are_collinear(elements.slot_point[from], elements.slot_point[to], elements.slot_point[slot]));
      }
    }
  }
  EXPECT_GT(beyond_ends, 0u);
}

TEST_P(ElementsOf, WhatTheScreenIsSureOfIsSo) {
  const TreeElements tree(GetParam().make());
  const Elements& elements = tree.elements();
  const Box box = facet_bounds(tree.mesh().view());
  const glm::vec3 outside = box.centre() + 3.0f * box.radius() * glm::vec3(0.36f, 0.48f, 0.8f);
  const Eye eyes[] = {{outside, 1}, {0.36f, 0.48f, 0.8f, 0}, {box.centre() + glm::vec3(0.01f, 0.02f, 0.03f), 1}};
  std::mt19937 random(1);
  std::size_t sure = 0, unsure = 0;
  for (const Eye& eye : eyes) {
    Screen screen;
    std::vector<float> keys;
    screen.look(tree.points(), elements, eye, keys);
    for (int i = 0; i < 20000; ++i) {
      const auto a = static_cast<std::uint32_t>(random() % elements.count());
      // Neighbours in the tree are neighbours in space.
      const auto b = static_cast<std::uint32_t>((a + 1 + random() % 64) % elements.count());
      const FacetId a_plane = tree.points().same_plane(elements.facet[a]);
      if (a_plane == tree.points().same_plane(elements.facet[b])) continue;
      if (screen.facing(a) == 0 || screen.facing(b) == 0) continue;
      const Seen::Overlap seen = screen.overlap(elements, a, b);
      if (seen == Seen::either) {
        ++unsure;
        continue;
      }
      ++sure;
      ASSERT_EQ(seen == Seen::overlapping,
                overlap(tree.points(), screen.viewpoint(), tree.seen(screen, a), tree.seen(screen, b)));
    }
  }
  EXPECT_GT(sure, 5 * unsure);
}

}  // namespace
}  // namespace facetsort::exact_internal
