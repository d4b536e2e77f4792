// The promises of ExactSorter that need no picture: what is drawn, as what triangles, how often the same, at what cost.
// That the order is right is for the referees to say: tests/check/exact_property_test.cpp.
#include "facetsort/exact/exact_sorter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <numeric>
#include <string>

#include "exact/every_order.h"
#include "facetsort/exact/facts.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/facets/facets.h"
#include "facetsort/report/allocations.h"
#include "shapes.h"
#include "support/instruction_sets.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

struct NamedMesh {
  std::string name;
  Mesh mesh;
};

// Corners on a lattice, some facets degenerate and some in one plane, cut in every way.
Mesh lattice() {
  Mesh mesh;
  for (int i = 0; i < 27; ++i) mesh.positions.push_back(glm::vec3(glm::ivec3(i % 3, i / 3 % 3, i / 9)));
  std::uint32_t state = 1;
  const auto vertex = [&] { return (state = state * 1664525u + 1013904223u) / 65536u % 27u; };
  for (int f = 0; f < 24; ++f) mesh.triangles.push_back(glm::uvec3{vertex(), vertex(), vertex()});
  return mesh;
}

// One list for every test below: clean, dirty, extreme.
const std::vector<NamedMesh>& meshes() {
  static const std::vector<NamedMesh> list = [] {
    std::vector<NamedMesh> made;
    for (const char* name : {"teapot_1k", "hand_2k"}) made.push_back({name, load(name)});
    made.push_back({"torus_knot", shapes::torus_knot(2000)});
    made.push_back({"triangle_cycle", shapes::triangle_cycle(9)});
    made.push_back({"slab_cycle", shapes::slab_cycle(3)});
    made.push_back({"interpenetrating", shapes::interpenetrating(2)});
    made.push_back({"woven_mat", shapes::woven_mat(6)});
    made.push_back({"comb", shapes::comb(12)});
    made.push_back({"soup", shapes::soup(16, 2)});
    made.push_back({"scattered", shapes::scattered(600, 0.15f, 3)});
    made.push_back({"lattice", lattice()});
    made.push_back({"coplanar", shapes::coplanar(60, 4)});
    made.push_back({"duplicated_grid", shapes::duplicated_grid(5, 4)});
    made.push_back({"sliver_fan", shapes::sliver_fan(100, 1e5f)});
    return made;
  }();
  return list;
}

std::vector<SortView> views_of(const Mesh& mesh) {
  const Box box = facet_bounds(mesh.view());
  std::vector<SortView> views;
  for (const glm::vec3& direction : {glm::vec3(0, 0, 1), glm::vec3(0.36f, -0.48f, 0.8f), glm::vec3(-0.8f, 0.6f, 0)}) {
    for (const float radii : {0.3f, 2.5f}) {
      views.push_back({glm::vec4(box.centre() + radii * box.radius() * direction, 1), -direction});
    }
    views.push_back({glm::vec4(direction, 0), -direction});
  }
  return views;
}

// FNV-1a of all that an order draws.
class Hash {
 public:
  void add(std::uint32_t value) {
    for (int byte = 0; byte < 4; ++byte) value_ = (value_ ^ (value >> 8 * byte & 0xff)) * 0x100000001b3ull;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ull;
};

std::uint64_t hash_of(ExactSorter& sorter, const Mesh& mesh, const SortView& view) {
  Hash hash;
  const std::span<const std::uint32_t> order = sorter.sort(view);
  const Pieces pieces = sorter.pieces();
  for (const std::uint32_t id : order) {
    hash.add(id);
    if (id < mesh.triangles.size()) continue;
    const Piece& piece = pieces.pieces[id - mesh.triangles.size()];
    hash.add(piece.facet);
    for (const Cut& cut : pieces.cuts_of(piece)) {
      const CutPlane plane = pieces.plane_of(cut, mesh.triangles);
      for (const std::uint32_t part : {plane.first, plane.second, plane.third, plane.edge_end, plane.facet,
                                       static_cast<std::uint32_t>(cut.side)}) {
        hash.add(part);
      }
    }
  }
  for (const CutVertex& vertex : sorter.triangles().vertices) {
    for (int i = 0; i < 3; ++i) hash.add(std::bit_cast<std::uint32_t>(vertex.position[i]));
  }
  return hash.value();
}

std::vector<std::uint64_t> hashes_of(const Mesh& mesh, OrderFrom from) {
  ExactSorter sorter(mesh.view(), {.from = from});
  std::vector<std::uint64_t> hashes;
  for (const SortView& view : views_of(mesh)) hashes.push_back(hash_of(sorter, mesh, view));
  return hashes;
}

std::vector<std::vector<std::uint64_t>> hashes_of_all(OrderFrom from) {
  std::vector<std::vector<std::uint64_t>> hashes;
  for (const NamedMesh& named : meshes()) hashes.push_back(hashes_of(named.mesh, from));
  return hashes;
}

bool degenerate(const Mesh& mesh, std::uint32_t facet) {
  const MeshView view = mesh.view();
  return collinear(view.corner(facet, 0), view.corner(facet, 1), view.corner(facet, 2));
}

using Position = std::array<float, 3>;
Position key_of(const glm::vec3& p) {
  return {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};
}

// The triangles of an order by the facet that they come from, as positions.
class TrianglesOfFacets {
 public:
  TrianglesOfFacets(const Mesh& mesh, const OrderedTriangles& ordered) : mesh_(mesh), ordered_(ordered) {
    of_facet_.resize(mesh.triangles.size());
    for (std::size_t i = 0; i < ordered.triangles.size(); ++i) of_facet_.at(ordered.source[i]).push_back(i);
  }

  // Every cut vertex lies where its barycentric place says, and serves its own facet only.
  void expect_vertices_of_their_facet() const {
    const double radius = static_cast<double>(facet_bounds(mesh_.view()).radius());
    for (std::size_t i = 0; i < ordered_.triangles.size(); ++i) {
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t index = ordered_.triangles[i][k];
        const glm::uvec3 facet = mesh_.triangles[ordered_.source[i]];
        if (index < mesh_.positions.size()) {
          ASSERT_TRUE(index == facet.x || index == facet.y || index == facet.z);
        } else {
          ASSERT_EQ(vertex(index).facet, ordered_.source[i]);
        }
      }
    }
    for (const CutVertex& vertex : ordered_.vertices) {
      glm::dvec3 place(0);
      double sum = 0, reach = radius;
      for (int k = 0; k < 3; ++k) {
        const glm::dvec3 corner(mesh_.view().corner(vertex.facet, k));
        ASSERT_GE(vertex.barycentric[k], 0.0f);
        place += static_cast<double>(vertex.barycentric[k]) * corner;
        sum += static_cast<double>(vertex.barycentric[k]);
        reach = std::max(reach, glm::length(corner));
      }
      ASSERT_NEAR(sum, 1, 0x1p-22);
      ASSERT_LE(glm::distance(place, glm::dvec3(vertex.position)), 0x1p-21 * reach);
    }
  }

  // Areas as vectors, so that a triangle turned over would show.
  void expect_whole_areas() const {
    for (std::uint32_t facet = 0; facet < of_facet_.size(); ++facet) {
      const glm::dvec3 a(mesh_.view().corner(facet, 0)), b(mesh_.view().corner(facet, 1));
      const glm::dvec3 c(mesh_.view().corner(facet, 2)), area = glm::cross(b - a, c - a);
      const double longest = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
      const double reach = std::max({glm::length(a), glm::length(b), glm::length(c)});
      glm::dvec3 sum(0);
      for (const std::size_t i : of_facet_[facet]) {
        const glm::dvec3 p(position(i, 0)), q(position(i, 1)), r(position(i, 2)), part = glm::cross(q - p, r - p);
        ASSERT_GE(glm::dot(part, area), -0x1p-20 * reach * longest * glm::length(area)) << "facet " << facet;
        sum += part;
      }
      const double corners = static_cast<double>(of_facet_[facet].size() + 2);
      ASSERT_LE(glm::distance(sum, area), 0x1p-22 * reach * longest * corners) << "facet " << facet;
    }
  }

  // Each facet's triangles meet edge to edge, and along an edge of the mesh all facets beside it have the same
  // vertices. Rounding may close a facet's tip between cuts, whose corner then is no longer in the outline.
  void expect_no_t_junction(std::size_t most_closed_tips) const {
    std::size_t closed_tips = 0;
    std::map<std::pair<Position, Position>, std::vector<Position>> vertices_along;
    for (std::uint32_t facet = 0; facet < of_facet_.size(); ++facet) {
      if (degenerate(mesh_, facet)) continue;
      const std::map<Position, Position> next = outline(facet);
      if (!has_all_corners(facet, next)) {
        ++closed_tips;
        continue;
      }
      Position at = key_of(mesh_.view().corner(facet, 0));
      std::size_t steps = 0;
      for (int side = 0; side < 3; ++side) {
        const Position from = at, to = key_of(mesh_.view().corner(facet, (side + 1) % 3));
        std::vector<Position> along;
        while (at != to) {
          const auto step = next.find(at);
          ASSERT_TRUE(step != next.end()) << "the outline of facet " << facet << " is broken";
          at = step->second;
          ASSERT_LE(++steps, next.size());
          if (at != to) along.push_back(at);
        }
        if (to < from) std::reverse(along.begin(), along.end());
        const auto [known, is_first] = vertices_along.try_emplace(std::minmax(from, to), along);
        if (is_first) continue;
        ASSERT_EQ(known->second, along) << "T-junction on side " << side << " of facet " << facet;
      }
      ASSERT_EQ(steps, next.size()) << "facet " << facet << " has a hole";
    }
    EXPECT_LE(closed_tips, most_closed_tips);
  }

 private:
  const CutVertex& vertex(std::uint32_t index) const { return ordered_.vertices.at(index - mesh_.positions.size()); }
  glm::vec3 position(std::size_t triangle, int corner) const {
    const std::uint32_t index = ordered_.triangles[triangle][corner];
    return index < mesh_.positions.size() ? mesh_.positions[index] : vertex(index).position;
  }

  bool has_all_corners(std::uint32_t facet, const std::map<Position, Position>& next) const {
    return next.contains(key_of(mesh_.view().corner(facet, 0))) &&
           next.contains(key_of(mesh_.view().corner(facet, 1))) && next.contains(key_of(mesh_.view().corner(facet, 2)));
  }

  // Directed edges of the facet's triangles that no other of them runs along the other way.
  std::map<Position, Position> outline(std::uint32_t facet) const {
    std::map<std::pair<Position, Position>, int> times;
    for (const std::size_t i : of_facet_[facet]) {
      for (int k = 0; k < 3; ++k) {
        const Position from = key_of(position(i, k)), to = key_of(position(i, (k + 1) % 3));
        ++times[{from, to}];
        --times[{to, from}];
      }
    }
    std::map<Position, Position> next;
    for (const auto& [edge, count] : times) {
      if (count <= 0) continue;
      EXPECT_EQ(count, 1);
      EXPECT_TRUE(next.emplace(edge.first, edge.second).second);
    }
    return next;
  }

  const Mesh& mesh_;
  const OrderedTriangles& ordered_;
  std::vector<std::vector<std::size_t>> of_facet_;
};

class EveryOrder : public testing::TestWithParam<OrderFrom> {};
INSTANTIATE_TEST_SUITE_P(ExactSorter, EveryOrder, testing::ValuesIn(every_order),
                         [](const auto& from) { return name_of(from.param); });

TEST_P(EveryOrder, GivesTrianglesThatAreTheMeshWithoutCracks) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    ExactSorter sorter(mesh.view(), {.from = GetParam()});
    std::size_t cut_vertices = 0;
    for (const SortView& view : views_of(mesh)) {
      sorter.sort(view);
      const OrderedTriangles ordered = sorter.triangles();
      cut_vertices += ordered.vertices.size();
      ASSERT_EQ(ordered.source.size(), ordered.triangles.size());
      ASSERT_EQ(ordered.triangles.size(), sorter.statistics().triangles);
      const TrianglesOfFacets triangles(mesh, ordered);
      triangles.expect_vertices_of_their_facet();
      triangles.expect_whole_areas();
      triangles.expect_no_t_junction(GetParam() == OrderFrom::pairs ? 0 : mesh.triangles.size() / 4);
      if (HasFatalFailure()) return;
    }
    const ExactStatistics& statistics = sorter.statistics();
    EXPECT_EQ(cut_vertices > 0, statistics.prepared_cuts + statistics.view_cuts > 0 || name == "slab_cycle" ||
                                    name == "triangle_cycle" || name == "woven_mat" || name == "comb");
  }
}

// The triangles come in the order of the draw ids: the sources, repeats left out, are the facets of the order.
TEST_P(EveryOrder, GivesTrianglesInTheOrder) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    ExactSorter sorter(mesh.view(), {.from = GetParam()});
    for (const SortView& view : views_of(mesh)) {
      std::vector<std::uint32_t> facets;
      const std::span<const std::uint32_t> order = sorter.sort(view);
      for (const std::uint32_t id : order) facets.push_back(sorter.pieces().facet_of(id, mesh.triangles.size()));
      facets.erase(std::unique(facets.begin(), facets.end()), facets.end());
      std::vector<std::uint32_t> sources = sorter.triangles().source;
      sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
      ASSERT_EQ(sources, facets);
    }
  }
}

TEST_P(EveryOrder, DrawsEveryFacetOnce) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const std::size_t facets = mesh.triangles.size();
    ExactSorter sorter(mesh.view(), {.from = GetParam()});
    for (const SortView& view : views_of(mesh)) {
      const std::span<const std::uint32_t> sorted = sorter.sort(view);
      std::vector<std::uint32_t> order(sorted.begin(), sorted.end());
      EXPECT_EQ(order.size(), sorter.statistics().pieces);
      std::vector<int> whole(facets), cut(facets);
      for (const std::uint32_t id : order) {
        ASSERT_LT(id, facets + sorter.pieces().pieces.size());
        ++(id < facets ? whole : cut)[sorter.pieces().facet_of(id, facets)];
      }
      for (std::size_t f = 0; f < facets; ++f) {
        ASSERT_TRUE((whole[f] == 1 && cut[f] == 0) || (whole[f] == 0 && cut[f] >= 2)) << f;
      }
      std::sort(order.begin(), order.end());
      ASSERT_EQ(std::adjacent_find(order.begin(), order.end()), order.end());
    }
  }
}

TEST_P(EveryOrder, SameOrderForAnyThreadCount) {
  const auto expected = hashes_of_all(GetParam());
  for (const int threads : {1, 2, 3, 8}) {
    with_threads(threads, [&] { EXPECT_EQ(hashes_of_all(GetParam()), expected) << threads << " threads"; });
  }
}

TEST_P(EveryOrder, SameOrderForAnyInstructionSet) {
  const auto expected = hashes_of_all(GetParam());
  const int tried = for_each_instruction_set([&] { EXPECT_EQ(hashes_of_all(GetParam()), expected); });
  EXPECT_GE(tried, 1);
}

TEST_P(EveryOrder, UsedAgainGivesWhatAFreshOneGives) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    ExactSorter used(mesh.view(), {.from = GetParam()});
    std::vector<SortView> views = views_of(mesh);
    for (const SortView& view : views) used.sort(view);
    std::reverse(views.begin(), views.end());
    for (const SortView& view : views) {
      ExactSorter fresh(mesh.view(), {.from = GetParam()});
      ASSERT_EQ(hash_of(used, mesh, view), hash_of(fresh, mesh, view));
      ASSERT_EQ(used.statistics().triangles, fresh.statistics().triangles);
      ASSERT_EQ(used.statistics().candidate_pairs, fresh.statistics().candidate_pairs);
      ASSERT_EQ(used.statistics().predicate_fallbacks, fresh.statistics().predicate_fallbacks);
    }
  }
}

TEST_P(EveryOrder, HoldsNoMoreWhenAnOrbitIsRepeated) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    with_threads(1, [&, &mesh = mesh] {
      ExactSorter sorter(mesh.view(), {.from = GetParam()});
      EXPECT_GT(sorter.prepared_bytes(), 0u);
      const auto orbit = [&] {
        const AllocationScope scope;
        for (const SortView& view : views_of(mesh)) sorter.sort(view);
        return scope.count();
      };
      orbit();
      const std::size_t bytes = sorter.memory_bytes(), prepared = sorter.prepared_bytes();
      EXPECT_GE(bytes, prepared);
      const AllocationCount second = orbit(), third = orbit();
      EXPECT_EQ(sorter.memory_bytes(), bytes);
      EXPECT_EQ(sorter.prepared_bytes(), prepared);
      EXPECT_EQ(third.calls, second.calls);
      EXPECT_LE(third.peak_bytes,
                second.peak_bytes + second.peak_bytes / 20);  // what is freed varies with the last view
    });
  }
}

// An orbit by a millionth of a turn a step crosses few planes; half a turn crosses some.
TEST_P(EveryOrder, TellsWhereItHolds) {
  const Mesh mesh = load("teapot_1k");
  const Box box = facet_bounds(mesh.view());
  const auto view_at = [&](double angle) {
    const glm::vec3 direction(std::cos(angle), 0.3, std::sin(angle));
    return SortView{glm::vec4(box.centre() + 2.5f * box.radius() * direction, 1), -direction};
  };
  ExactSorter sorter(mesh.view(), {.from = GetParam()});
  EXPECT_FALSE(sorter.keeps_order(view_at(0)));
  int kept = 0;
  for (int k = 0; k < 40; ++k) {
    const SortView view = view_at(0.3 + k * 6e-6);
    const std::span<const std::uint32_t> ids = sorter.sort(view);
    const std::vector<std::uint32_t> order(ids.begin(), ids.end());
    EXPECT_TRUE(sorter.keeps_order(view));
    const SortView next = view_at(0.3 + (k + 1) * 6e-6);
    if (!sorter.keeps_order(next)) continue;
    ++kept;
    const std::span<const std::uint32_t> next_ids = sorter.sort(next);
    ASSERT_TRUE(std::equal(order.begin(), order.end(), next_ids.begin(), next_ids.end()));
  }
  EXPECT_EQ(kept > 10, GetParam() == OrderFrom::presorted) << kept;
  EXPECT_FALSE(sorter.keeps_order(view_at(3)));
}

TEST_P(EveryOrder, MovedSorterGoesOn) {
  const Mesh mesh = shapes::interpenetrating(1);
  const SortView view = views_of(mesh)[1];
  ExactSorter first(mesh.view(), {.from = GetParam()});
  const std::uint64_t expected = hash_of(first, mesh, view);
  ExactSorter second(std::move(first));
  EXPECT_EQ(hash_of(second, mesh, view), expected);
}

TEST(ExactSorter, OrderIsTheSameAtAnyPowerOfTwo) {
  for (const auto& [name, mesh] : meshes()) {
    SCOPED_TRACE(name);
    const std::vector<SortView> views = views_of(mesh);
    ExactSorter sorter(mesh.view());
    for (const float scale : {0x1p-60f, 0x1p60f}) {
      Mesh scaled = mesh;
      for (glm::vec3& p : scaled.positions) p *= scale;
      ExactSorter scaled_sorter(scaled.view());
      for (SortView view : views) {
        const std::span<const std::uint32_t> order = sorter.sort(view);
        view.eye = glm::vec4(glm::vec3(view.eye) * scale, view.eye.w);
        const std::span<const std::uint32_t> scaled_order = scaled_sorter.sort(view);
        ASSERT_TRUE(std::equal(order.begin(), order.end(), scaled_order.begin(), scaled_order.end())) << scale;
      }
    }
  }
}

// Nothing hides anything else: facets of one plane come by depth, duplicates among them by id.
TEST(ExactSorter, DuplicatesComeBySmallerIdFirst) {
  for (const int copies : {2, 7}) {
    const int cells = 9;
    const Mesh mesh = shapes::duplicated_grid(cells, copies);
    ExactSorter sorter(mesh.view());
    for (const SortView& view : views_of(mesh)) {
      const std::span<const std::uint32_t> order = sorter.sort(view);
      const std::uint32_t facets = 2 * cells * cells;
      std::vector<std::uint32_t> copies_seen(facets);
      for (const std::uint32_t id : order) {
        ASSERT_EQ(id / facets, copies_seen[id % facets]++) << id;
      }
      EXPECT_EQ(sorter.statistics().view_cuts, 0u);
    }
  }
}

TEST(ExactSorter, CoplanarFacetsAreNeitherCutNorHidden) {
  const Mesh mesh = shapes::coplanar(1000, 5);
  ExactSorter sorter(mesh.view());
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  // The plane is z = x / 2 + y / 4: seen along that axis, towards which all depths are alike, only ids are left; from
  // elsewhere, depth; from within the plane nothing is seen.
  for (const glm::vec4& eye : {glm::vec4(-2, -1, 4, 0), glm::vec4(3, -1, 2, 1), glm::vec4(5, 6, 4, 1)}) {
    const std::span<const std::uint32_t> sorted = sorter.sort({eye, {0, 0, -1}});
    std::vector<std::uint32_t> order(sorted.begin(), sorted.end());
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order, all);
    EXPECT_EQ(sorter.statistics().crossing_pairs, 0u);
    EXPECT_EQ(sorter.statistics().constraints, 0u);
  }
}

TEST(ExactSorter, KeepsFacetsThatNothingSees) {
  // A pane beyond another, seen through facets without area and a facet seen edge-on between the two.
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}, {-1, -1, 2}, {1, -1, 2},
                    {0, 1, 2},   {0, -1, 1}, {0, 1, 1}, {0, 0, 4}};
  mesh.triangles = {{3, 4, 5}, {6, 6, 6}, {6, 7, 7}, {6, 7, 6}, {6, 7, 8}, {0, 1, 2}};
  ExactSorter sorter(mesh.view());
  for (const glm::vec4& eye : {glm::vec4(0, 0, 9, 1), glm::vec4(0, 0, 1, 0), glm::vec4(0, 0.5f, 4, 1)}) {
    const std::span<const std::uint32_t> order = sorter.sort({eye, {0, 0, -1}});
    const Pieces pieces = sorter.pieces();
    std::vector<std::size_t> first(6, order.size());
    for (std::size_t i = order.size(); i-- > 0;) first[pieces.facet_of(order[i], 6)] = i;
    for (const std::size_t place : first) EXPECT_LT(place, order.size());
    EXPECT_LT(first[5], first[0]);
  }
}

TEST(ExactSorter, StatisticsSayWhatWasDone) {
  const SortView above{{0, 0, 5, 1}, {0, 0, -1}}, aside{{9, 0, 0.1f, 1}, {-1, 0, 0}};
  {
    const Mesh mesh = shapes::torus_knot(2000);
    ExactSorter sorter(mesh.view());
    sorter.sort(above);
    const ExactStatistics& statistics = sorter.statistics();
    EXPECT_EQ(statistics.crossing_pairs, 0u);
    EXPECT_EQ(statistics.prepared_cuts, 0u);
    EXPECT_EQ(statistics.prepared_pieces, mesh.triangles.size());
    EXPECT_EQ(statistics.pieces, mesh.triangles.size());
    EXPECT_EQ(statistics.triangles, mesh.triangles.size());
    EXPECT_GT(statistics.candidate_pairs, 0u);
    EXPECT_EQ(statistics.components, 0u);
  }
  {
    const Mesh mesh = shapes::interpenetrating(0);  // no pair only touches
    const ExactSorter sorter(mesh.view());
    EXPECT_EQ(sorter.statistics().crossing_pairs, inspect_geometry(mesh.view()).intersecting_pairs);
    EXPECT_EQ(sorter.statistics().crossing_pairs_uncut, 0u);
    EXPECT_GT(sorter.statistics().prepared_pieces, mesh.triangles.size());
    EXPECT_GE(sorter.statistics().prepared_cuts, sorter.statistics().prepared_pieces - mesh.triangles.size());
  }
  for (const int n : {3, 50, 1000}) {
    const Mesh mesh = shapes::triangle_cycle(n);
    ExactSorter sorter(mesh.view());
    sorter.sort(above);
    const std::size_t members = static_cast<std::size_t>(n);
    EXPECT_EQ(sorter.statistics().components, 1u);
    EXPECT_EQ(sorter.statistics().pieces_in_cycles, members);
    EXPECT_EQ(sorter.statistics().largest_component, members);
    EXPECT_GE(sorter.statistics().view_cuts, 1u);
    EXPECT_LE(sorter.statistics().view_cuts, 8u);  // a ring needs one; its members' planes meet a few more
    EXPECT_EQ(sorter.statistics().pieces, members + sorter.statistics().view_cuts);
    EXPECT_EQ(sorter.statistics().unordered_pairs, 0u);
    sorter.sort(aside);  // what the last view cut is forgotten
    EXPECT_EQ(sorter.statistics().components, 0u);
    EXPECT_EQ(sorter.statistics().view_cuts, 0u);
    EXPECT_EQ(sorter.statistics().triangles, members);
  }
  {
    const Mesh mesh = shapes::comb(100);
    ExactSorter sorter(mesh.view());
    sorter.sort(above);
    EXPECT_EQ(sorter.statistics().largest_component, mesh.triangles.size());
    EXPECT_LE(sorter.statistics().view_cuts, 4u);  // one cut of one bar is enough
  }
}

TEST(ExactSorter, GrowthStaysWithinItsBoundAndWhatIsLeftIsCounted) {
  const Mesh crossing = shapes::soup(150, 6), cycles = shapes::woven_mat(8);
  for (const double most : {1.0, 2.0, 4.0}) {
    SCOPED_TRACE(most);
    ExactSorter of_crossing(crossing.view(), {.max_growth = most}), of_cycles(cycles.view(), {.max_growth = most});
    EXPECT_GT(of_crossing.statistics().crossing_pairs, 1000u);
    EXPECT_GT(of_crossing.statistics().crossing_pairs_uncut, 0u);
    EXPECT_LE(of_crossing.statistics().crossing_pairs_uncut, of_crossing.statistics().crossing_pairs);
    for (const auto& [sorter, mesh] : {std::pair{&of_crossing, &crossing}, std::pair{&of_cycles, &cycles}}) {
      for (const SortView& view : views_of(*mesh)) {
        sorter->sort(view);
        const auto bound = static_cast<std::size_t>(most * static_cast<double>(mesh->triangles.size()));
        EXPECT_LE(sorter->statistics().triangles, bound);
        EXPECT_EQ(sorter->triangles().triangles.size(), sorter->statistics().triangles);
      }
    }
    of_cycles.sort(views_of(cycles)[1]);
    EXPECT_EQ(of_cycles.statistics().largest_component > 0, true);
    if (most == 1.0) {
      EXPECT_EQ(of_cycles.statistics().view_cuts, 0u);
      EXPECT_GE(of_cycles.statistics().unordered_pairs, of_cycles.statistics().components);
    }
  }
}

}  // namespace
}  // namespace facetsort
