// What must be true of the exact order whatever the mesh and the eye, judged by both referees and by the blend target's
// coverage, on random meshes; a mesh that fails is made as small as it can be and written down as code.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "exact/every_order.h"
#include "exact/shrink.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/check/verdict.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/mesh/inspect.h"
#include "shapes.h"
#include "support/effort.h"

namespace facetsort {
namespace {

struct Tally {
  std::size_t covered_pixels = 0, cut_views = 0, rays = 0, unjudged_rays = 0;
  // Of rays along an edge, to the last bit of a double, where coverage is exact: the two disagree about what they meet.
  std::size_t fragments_of_rays_alone = 0;
};

// Where the eye is on the mesh, every ray starts on an edge or in a facet, and none can be judged.
struct Look {
  View view;
  bool from_the_mesh = false;
};

// What the draw ids of an order leave out, repeat or mix up; empty where every facet comes whole once, or in all of its
// pieces.
std::string permutation_fault(const Mesh& mesh, std::span<const std::uint32_t> order, const Pieces& pieces) {
  const std::size_t facets = mesh.triangles.size();
  std::vector<int> whole(facets), in_pieces(facets), times(facets + pieces.pieces.size());
  for (const std::uint32_t id : order) {
    if (id >= times.size()) return "draw id " + std::to_string(id) + " is none";
    if (++times[id] > 1) return "draw id " + std::to_string(id) + " comes twice";
    ++(id < facets ? whole : in_pieces)[pieces.facet_of(id, facets)];
  }
  for (std::size_t f = 0; f < facets; ++f) {
    if (whole[f] == 1 && in_pieces[f] == 0) continue;
    if (whole[f] == 0 && in_pieces[f] > 0) continue;
    return "facet " + std::to_string(f) + " comes whole " + std::to_string(whole[f]) + " times and in " +
           std::to_string(in_pieces[f]) + " pieces";
  }
  return {};
}

std::string inversion(const char* referee, const Verdict& verdict) {
  if (verdict.uncovered_fragments > 0) {
    return std::string(referee) + ": " + std::to_string(verdict.uncovered_fragments) + " fragments not drawn";
  }
  if (verdict.inverted_pixels == 0) return {};
  char text[160];
  std::snprintf(text, sizeof text, "%s: %zu pixels inverted, the worst %zu: facet %u after %u, which is nearer by %g R",
                referee, verdict.inverted_pixels, verdict.worst_pixel, verdict.worst_far_facet,
                verdict.worst_near_facet, verdict.worst_backtrack);
  return text;
}

// Growth without a bound to speak of: everything is to be ordered.
constexpr double no_bound = 1e9;

// Checks one mesh from any number of eyes.
class Checker {
 public:
  Checker(const Mesh& mesh, OrderFrom from)
      : mesh_(mesh),
        sorter_(mesh.view(), {.max_growth = no_bound, .from = from}),
        referee_(EmbreeReferee::create(mesh.view())) {}

  // What is wrong with the order from this eye; empty where nothing is.
  std::string fault(const Look& look, Tally& tally) {
    const View& view = look.view;
    const std::span<const std::uint32_t> order = sorter_.sort({view.homogeneous_eye(), view.forward()});
    const Pieces pieces = sorter_.pieces();
    std::string found = permutation_fault(mesh_, order, pieces);
    if (!found.empty()) return found;
    const ExactStatistics& statistics = sorter_.statistics();
    if (statistics.crossing_pairs_uncut + statistics.unordered_pairs > 0) return "left uncut without need";
    tally.cut_views += statistics.pieces > mesh_.triangles.size();

    const JudgeOptions options{.bounding_radius = static_cast<double>(facet_bounds(mesh_.view()).radius())};
    const auto judge = [&](const FragmentLists& lists) {
      return judge_drawing(lists, fragment_ranks(mesh_.view(), view, lists, order, pieces), options);
    };
    const FragmentLists lists = collect_fragments(mesh_.view(), view);
    const Verdict by_lists = judge(lists);
    tally.covered_pixels += by_lists.covered_pixels;
    found = inversion("lists", by_lists);
    if (!found.empty()) return found;

    if (!referee_.ok()) return referee_.status().message;
    const Result<RayHits> hits = referee_.value().cast(view);
    if (!hits.ok()) return hits.status().message;
    if (!look.from_the_mesh) {
      tally.rays += hits.value().rays;
      tally.unjudged_rays += hits.value().unjudged_rays;
    }
    Verdict by_rays = judge(hits.value().lists);
    tally.fragments_of_rays_alone += std::exchange(by_rays.uncovered_fragments, 0);
    found = inversion("rays", by_rays);
    if (!found.empty()) return found;
    return coverage_fault(view, lists, order, pieces);
  }

 private:
  // Premultiplied source-over with alpha 0 adds: each fragment counts 1 in red.
  std::string coverage_fault(const View& view, const FragmentLists& lists, std::span<const std::uint32_t> order,
                             const Pieces& pieces) {
    const std::vector<glm::vec4> ones(mesh_.triangles.size(), glm::vec4(1, 0, 0, 0));
    const DrawPass passes[] = {{}};
    rasteriser_.draw(mesh_.view(), view, order, ones, passes, glm::vec4(0), PixelFormat::rgba32f, coverage_, pieces);
    for (std::size_t pixel = 0; pixel < coverage_.pixels.size(); ++pixel) {
      const std::size_t expected = lists.pixel(pixel).size();
      if (coverage_.pixels[pixel].r != static_cast<float>(expected)) {
        return "pixel " + std::to_string(pixel) + " is drawn " + std::to_string(coverage_.pixels[pixel].r) +
               " times, not " + std::to_string(expected);
      }
    }
    return {};
  }

  const Mesh& mesh_;
  ExactSorter sorter_;
  Rasteriser rasteriser_;
  Image coverage_;
  Result<EmbreeReferee> referee_;
};

std::string as_code(const View& view) {
  char text[512];
  const auto d = [](float x) { return static_cast<double>(x); };
  std::snprintf(
      text, sizeof text,
      "const View view{.eye{%af, %af, %af}, .at{%af, %af, %af}, .projection = Projection::%s, "
      ".vertical_fov_degrees = %af, .height_in_units = %af, .near_distance = %af, .width = %d, .height = %d};",
      d(view.eye.x), d(view.eye.y), d(view.eye.z), d(view.at.x), d(view.at.y), d(view.at.z),
      view.projection == Projection::perspective ? "perspective" : "orthographic", d(view.vertical_fov_degrees),
      d(view.height_in_units), d(view.near_distance), view.width, view.height);
  return text;
}

// Checks all views; of a failure, shrinks the mesh and reports it as code.
void expect_exact(const Mesh& mesh, const std::vector<Look>& looks, OrderFrom from, Tally& tally) {
  ASSERT_TRUE(validate(mesh.view()).ok());
  Checker checker(mesh, from);
  for (const Look& look : looks) {
    std::string fault = checker.fault(look, tally);
    if (fault.empty()) continue;
    Tally ignored;
    const Mesh smallest =
        shrink(mesh, [&](const Mesh& part) { return !Checker(part, from).fault(look, ignored).empty(); });
    fault = Checker(smallest, from).fault(look, ignored);
    FAIL() << fault << "\n" << as_code(smallest) << "\n" << as_code(look.view);
  }
}

// The same sequence on every machine; the standard leaves the distributions to each library.
class Random {
 public:
  explicit Random(std::uint32_t seed) : generator_(seed) {}
  std::uint32_t bits() { return static_cast<std::uint32_t>(generator_()); }
  std::uint32_t below(std::uint32_t end) { return bits() % end; }
  float between(float low, float high) { return low + (high - low) * static_cast<float>(bits() >> 8) * 0x1p-24f; }
  // Of the unit cube. Braces evaluate in sequence.
  glm::vec3 point() { return glm::vec3{between(0, 1), between(0, 1), between(0, 1)}; }
  glm::vec3 direction() {
    const glm::vec3 d = 2.0f * point() - 1.0f;
    return glm::length(d) > 0.1f ? glm::normalize(d) : glm::vec3(0.6f, 0, 0.8f);
  }

 private:
  std::mt19937 generator_;
};

View sized(View view, int size) {
  view.width = view.height = size;
  return view;
}

// Eyes where orders go wrong: outside at several distances, inside, on a vertex, in a facet's plane, in a facet, at the
// end of an edge's line, far away; orthographic ones any way, along an axis and along an edge.
std::vector<Look> adversarial_looks(const Mesh& mesh, Random& random, int size) {
  const Box box = facet_bounds(mesh.view());
  const glm::vec3 centre = box.centre();
  const float radius = box.radius();
  const std::uint32_t facet = random.below(static_cast<std::uint32_t>(mesh.triangles.size()));
  const glm::vec3 a = mesh.view().corner(facet, 0), b = mesh.view().corner(facet, 1), c = mesh.view().corner(facet, 2);
  std::vector<Look> looks;
  const auto look_from = [&](const glm::vec3& eye, Projection projection = Projection::perspective) {
    looks.push_back({sized(default_view(box, eye, projection), size)});
  };
  for (const float radii : {1.05f, 2.5f, 30.0f}) {
    look_from(centre + radii * radius * random.direction());
    looks.back().view.vertical_fov_degrees = std::min(120.0f, 140.0f / radii);
  }
  look_from(centre + 2.5f * radius * random.direction(), Projection::orthographic);
  for (const glm::vec3& along : {glm::vec3(0, 0, 1), glm::vec3(-1, 0, 0), b - a}) {
    if (along == glm::vec3(0)) continue;
    look_from(centre + 2.5f * radius * glm::vec3(glm::normalize(glm::dvec3(along))), Projection::orthographic);
  }
  look_from(a + 2.0f * (a - c));  // in the plane, up to rounding, and beyond the edge from c to a
  looks.back().view.vertical_fov_degrees = 60;
  look_from(centre + 1e6f * radius * random.direction());
  looks.back().view.vertical_fov_degrees = 1.2e-4f;
  const auto look_around = [&](const glm::vec3& eye, bool from_the_mesh) {
    const std::vector<View> faces = cube_views(box, eye);
    looks.push_back({sized(faces[random.below(3)], size), from_the_mesh});
    looks.push_back({sized(faces[3 + random.below(3)], size), from_the_mesh});
  };
  look_around(centre + 0.4f * radius * random.direction(), false);
  look_around(a, true);
  look_around((a + b + c) / 3.0f, true);
  return looks;
}

// Random meshes of a few dozen facets, by kind.
struct Family {
  const char* name;
  Mesh (*make)(Random& random);
};

Mesh anything(Random& random) {
  const std::uint32_t facets = 6 + random.below(30);
  return shapes::soup(facets, random.bits());
}

// Corners on a lattice: shared vertices and edges, facets in one plane and in each other's, duplicates, degenerate
// ones.
Mesh on_a_lattice(Random& random) {
  const std::uint32_t side = 2 + random.below(3);
  Mesh mesh;
  for (std::uint32_t i = 0; i < side * side * side; ++i) {
    mesh.positions.push_back(glm::vec3(glm::uvec3(i % side, i / side % side, i / (side * side))));
  }
  const std::size_t facets = 6 + random.below(30);
  const auto vertex = [&] { return random.below(side * side * side); };
  for (std::size_t f = 0; f < facets; ++f) mesh.triangles.push_back(glm::uvec3{vertex(), vertex(), vertex()});
  mesh.triangles.emplace_back(0, 1, side * side * side - 1);  // one with area and reach
  return mesh;
}

// Facets between a few vertices: many through each vertex and edge.
Mesh around_few_vertices(Random& random) {
  Mesh mesh;
  const std::uint32_t vertices = 5 + random.below(6), facets = 6 + random.below(24);
  for (std::size_t v = 0; v < vertices; ++v) mesh.positions.push_back(random.point());
  while (mesh.triangles.size() < facets) {
    const auto vertex = [&] { return random.below(vertices); };
    const glm::uvec3 t{vertex(), vertex(), vertex()};
    if (t.x != t.y && t.y != t.z && t.z != t.x) mesh.triangles.push_back(t);
  }
  return mesh;
}

// Long thin facets, where boxes and mid-points say nothing.
Mesh needles(Random& random) {
  Mesh mesh;
  const std::uint32_t facets = 6 + random.below(30);
  for (std::uint32_t f = 0; f < facets; ++f) {
    const glm::vec3 a = random.point(), b = random.point();
    const glm::vec3 c = b + 0.02f * random.point();
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    mesh.triangles.emplace_back(3 * f, 3 * f + 1, 3 * f + 2);
  }
  return mesh;
}

// Facets of all sizes, some far smaller than the gap.
Mesh of_all_sizes(Random& random) {
  Mesh mesh;
  const std::uint32_t facets = 6 + random.below(30);
  for (std::uint32_t f = 0; f < facets; ++f) {
    const float size = std::exp2(-20 * random.between(0, 1));
    const glm::vec3 centre = 0.2f * random.point();
    for (int i = 0; i < 3; ++i) mesh.positions.push_back(centre + size * (random.point() - 0.5f));
    mesh.triangles.emplace_back(3 * f, 3 * f + 1, 3 * f + 2);
  }
  return mesh;
}

// Two closed bodies through each other, the one a moved and shrunken copy of the other: edges cross facets, and
// vertices lie in facets where the move is by whole steps.
Mesh pushed_together(Random& random) {
  Mesh mesh = random.below(2) == 0 ? shapes::box() : shapes::icosphere(static_cast<int>(random.below(2)));
  const Mesh other = random.below(2) == 0 ? shapes::box() : shapes::icosphere(0);
  const auto step = [&] { return static_cast<float>(random.below(5)); };
  const glm::vec3 steps{step(), step(), step()};
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec3& p : other.positions) mesh.positions.push_back(0.5f * p + 0.25f * steps - 0.5f);
  for (const glm::uvec3& t : other.triangles) mesh.triangles.push_back(t + first);
  return mesh;
}

// Few facets that all lie in few planes.
Mesh in_few_planes(Random& random) {
  const std::uint32_t facets = 5 + random.below(10);
  Mesh mesh = shapes::coplanar(facets, random.bits());
  for (const int axis : {0, 2}) {
    const Mesh plane = shapes::coplanar(5, random.bits());
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec3& p : plane.positions) {
      mesh.positions.emplace_back(p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]);
    }
    for (const glm::uvec3& t : plane.triangles) mesh.triangles.push_back(t + first);
  }
  return mesh;
}

constexpr Family families[] = {
    {"Anything", anything},        {"OnALattice", on_a_lattice}, {"AroundFewVertices", around_few_vertices},
    {"Needles", needles},          {"OfAllSizes", of_all_sizes}, {"PushedTogether", pushed_together},
    {"InFewPlanes", in_few_planes}};

class RandomMeshes : public testing::TestWithParam<std::tuple<Family, OrderFrom>> {};
INSTANTIATE_TEST_SUITE_P(Families, RandomMeshes,
                         testing::Combine(testing::ValuesIn(families), testing::ValuesIn(every_order)),
                         [](const auto& named) {
                           return std::get<0>(named.param).name + name_of(std::get<1>(named.param));
                         });

// FACETSORT_PROPERTY_SEEDS asks for more than the few of a quick run.
std::uint32_t seeds() {
  const char* text = std::getenv("FACETSORT_PROPERTY_SEEDS");
  return text == nullptr ? (is_sanitized ? 3 : 12) : static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10));
}

TEST_P(RandomMeshes, AreDrawnInOrderAndWithoutGaps) {
  Tally tally;
  for (std::uint32_t seed = 0; seed < seeds(); ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    const Mesh mesh = std::get<0>(GetParam()).make(random);
    expect_exact(mesh, adversarial_looks(mesh, random, 40), std::get<1>(GetParam()), tally);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(tally.covered_pixels, 100u * seeds());
  EXPECT_GT(tally.cut_views, 0u);
  EXPECT_LE(tally.unjudged_rays * 20, tally.rays);
  EXPECT_EQ(tally.fragments_of_rays_alone, 0u);
}

// A third of the seeds each: scales near either end of float32's range by a power of two, and far from the origin,
// where facets round to slivers and coincide.
TEST_P(RandomMeshes, AreDrawnInOrderAtAnyScaleAndPlace) {
  Tally tally;
  for (std::uint32_t seed = 0; seed < seeds(); ++seed) {
    SCOPED_TRACE(seed);
    Random random(1000 + seed);
    Mesh mesh = std::get<0>(GetParam()).make(random);
    for (glm::vec3& p : mesh.positions) {
      p = seed % 3 == 0 ? p * 0x1p-100f : seed % 3 == 1 ? p * 0x1p100f : p + glm::vec3(3000, -5000, 7000);
    }
    expect_exact(mesh, adversarial_looks(mesh, random, 24), std::get<1>(GetParam()), tally);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(tally.covered_pixels, 30u * seeds());
  EXPECT_LE(tally.fragments_of_rays_alone * 1000, tally.rays);
}

// A few facets of a mesh with many, so that the referees see them well.
View close_up(const Mesh& mesh, View view) {
  const glm::dvec3 eye(view.eye), a(mesh.view().corner(0, 0)), b(mesh.view().corner(0, 1)), c(mesh.view().corner(0, 2));
  view.at = mesh.view().corner(0, 0);
  const double length = std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
  view.vertical_fov_degrees = static_cast<float>(std::min(60.0, glm::degrees(length / glm::distance(eye, a))));
  return view;
}

struct Case {
  const char* name;
  Mesh (*make)();
  bool cut;  // whether some view has to cut
};

const Case extreme_cases[] = {
    {"TriangleCycle3", [] { return shapes::triangle_cycle(3); }, true},
    {"TriangleCycle100", [] { return shapes::triangle_cycle(100); }, true},
    {"TriangleCycle1000", [] { return shapes::triangle_cycle(1000); }, true},
    {"SlabCycle3", [] { return shapes::slab_cycle(3); }, true},
    {"SlabCycle7", [] { return shapes::slab_cycle(7); }, true},
    {"SlabCycle1000", [] { return shapes::slab_cycle(1000); }, true},
    {"WovenMat2", [] { return shapes::woven_mat(2); }, true},
    {"WovenMat30", [] { return shapes::woven_mat(30); }, true},
    {"Comb1", [] { return shapes::comb(1); }, true},
    {"Comb200", [] { return shapes::comb(200); }, true},
    {"Scroll", [] { return shapes::scroll(12, 60); }, false},
    {"Coplanar300", [] { return shapes::coplanar(300, 3); }, false},
    {"DuplicatedGrid", [] { return shapes::duplicated_grid(12, 5); }, false},
    {"NestedShells", [] { return shapes::nested_shells(12, 1e-3f, 2); }, false},
    {"NestedDeep", [] { return shapes::nested_shells(40, 2e-2f, 0); }, false},
    {"ManyScales", shapes::many_scales, false},
    {"Interpenetrating", [] { return shapes::interpenetrating(3); }, true},
    {"SliverFan", [] { return shapes::sliver_fan(1200, 300); }, false},
    {"SliverFanOfNeedles", [] { return shapes::sliver_fan(300, 3000); }, false},
    {"TorusKnot", [] { return shapes::torus_knot(10'000); }, false},
    {"Soup50", [] { return shapes::soup(50, 4); }, true},
    {"Scattered1000", [] { return shapes::scattered(1000, 0.1f, 5); }, true},
    {"Scattered10000", [] { return shapes::scattered(10'000, 0.03f, 6); }, true},
    {"Scattered100000", [] { return shapes::scattered(100'000, 0.008f, 7); }, true},
};

class ExtremeCases : public testing::TestWithParam<std::tuple<Case, OrderFrom>> {};
INSTANTIATE_TEST_SUITE_P(Shapes, ExtremeCases,
                         testing::Combine(testing::ValuesIn(extreme_cases), testing::ValuesIn(every_order)),
                         [](const auto& named) {
                           return std::get<0>(named.param).name + name_of(std::get<1>(named.param));
                         });

TEST_P(ExtremeCases, AreDrawnInOrderAndWithoutGaps) {
  const auto& [extreme, from] = GetParam();
  const Mesh mesh = extreme.make();
  const Box box = facet_bounds(mesh.view());
  Tally tally;
  // Straight from above, where cycles close; across; and, of the smaller ones, wherever else it may go wrong.
  const glm::vec3 up(0, 0, 2.5f * box.radius()), across = 1.3f * box.radius() * glm::vec3(0.6f, -0.64f, 0.48f);
  std::vector<Look> looks{{sized(default_view(box, box.centre() + up), 160)},
                          {sized(default_view(box, box.centre() + up, Projection::orthographic), 160)},
                          {sized(default_view(box, box.centre() + across), 160)}};
  looks.push_back({close_up(mesh, looks[0].view)});
  if (mesh.triangles.size() <= 2000) {
    Random random(9);
    for (const Look& look : adversarial_looks(mesh, random, cases(60))) looks.push_back(look);
  }
  expect_exact(mesh, looks, from, tally);
  EXPECT_GT(tally.covered_pixels, 500u);
  if (from == OrderFrom::pairs || extreme.cut) {
    EXPECT_EQ(tally.cut_views > 0, extreme.cut);
  }
}

TEST(Shrink, LeavesTheFacetsThatMatter) {
  const Mesh mesh = shapes::soup(100, 1);
  const glm::vec3 first = mesh.positions[3 * 17], second = mesh.positions[3 * 80 + 1];
  int tried = 0;
  const auto has_both = [&](const Mesh& part) {
    ++tried;
    bool found[2] = {false, false};
    for (const glm::uvec3& t : part.triangles) {
      for (int i = 0; i < 3; ++i) {
        found[0] = found[0] || part.positions[t[i]] == first;
        found[1] = found[1] || part.positions[t[i]] == second;
      }
    }
    return found[0] && found[1];
  };
  const Mesh smallest = shrink(mesh, has_both);
  EXPECT_EQ(smallest.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {3, 4, 5}}));
  EXPECT_EQ(smallest.positions[0], first);
  EXPECT_EQ(smallest.positions[4], second);
  EXPECT_LT(tried, 120);
  EXPECT_NE(as_code(smallest).find("{3, 4, 5}"), std::string::npos);
}

// Found by OnALattice and shrunk: a cut's end at (1.5, 1, 1) is a corner that another cut made of other planes.
TEST(ExactProperty, HoldsWhereTwoCutsMeetOnAnEdge) {
  const Mesh mesh{
      {{2, 0, 1}, {1, 2, 1}, {0, 0, 1}, {1, 2, 0}, {2, 0, 2}, {1, 0, 1}, {0, 0, 2}, {0, 0, 0}, {1, 0, 0}, {2, 2, 2}},
      {{0, 1, 2}, {3, 4, 5}, {5, 6, 3}, {7, 8, 9}},
      {},
      {}};
  View view = sized(default_view(facet_bounds(mesh.view()), {0.58f, 0.11f, 2.53f}), 80);
  view.vertical_fov_degrees = 120;
  Tally tally;
  for (const OrderFrom from : every_order) expect_exact(mesh, {{view}}, from, tally);
  EXPECT_GT(tally.covered_pixels, 500u);
}

// The property itself must be able to fail: the checks see an order that is wrong.
TEST(ExactProperty, SeesWhatIsWrong) {
  const Mesh mesh = shapes::triangle_cycle(3);
  const View view = sized(default_view(facet_bounds(mesh.view()), {0, 0, 4}), 40);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const std::vector<std::uint32_t> whole{0, 1, 2};
  const Verdict verdict = judge_drawing(lists, fragment_ranks(mesh.view(), view, lists, whole), {});
  EXPECT_NE(inversion("lists", verdict).find("nearer by"), std::string::npos);
  EXPECT_EQ(permutation_fault(mesh, whole, {}), "");
  for (const std::vector<std::uint32_t>& wrong :
       {std::vector<std::uint32_t>{0, 1}, std::vector<std::uint32_t>{0, 1, 1}, std::vector<std::uint32_t>{0, 1, 3}}) {
    EXPECT_NE(permutation_fault(mesh, wrong, {}), "");
  }
}

}  // namespace
}  // namespace facetsort
