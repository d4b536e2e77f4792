// Quantised keys: all facets, each near the place that its whole key gives it, however depths are spread.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/order/sorter.h"
#include "order/uneven_meshes.h"
#include "shapes.h"
#include "support/threads.h"

namespace facetsort {
namespace {

using Ids = std::vector<std::uint32_t>;

Ids copy(std::span<const std::uint32_t> ids) {
  return {ids.begin(), ids.end()};
}

// As the header has it.
std::size_t most_places_off(std::size_t facets) {
  return std::max<std::size_t>(48, 16 + facets / 4096);
}

// The same facets, none farther from its place than it may be.
void expect_near(std::span<const std::uint32_t> quantised, std::span<const std::uint32_t> whole, std::size_t facets) {
  ASSERT_EQ(quantised.size(), whole.size());
  constexpr std::uint32_t nowhere = 0xffffffff;
  Ids places(facets, nowhere);
  for (std::size_t k = 0; k < whole.size(); ++k) places[whole[k]] = static_cast<std::uint32_t>(k);
  for (std::size_t k = 0; k < quantised.size(); ++k) {
    ASSERT_LT(quantised[k], facets);
    std::uint32_t& place = places[quantised[k]];
    ASSERT_NE(place, nowhere) << "facet " << quantised[k] << " is there twice, or should be left out";
    const std::size_t off = k < place ? place - k : k - place;
    ASSERT_LE(off, most_places_off(facets)) << "facet " << quantised[k];
    place = nowhere;
  }
}

std::vector<SortView> outside_views(const Mesh& mesh) {
  const Box box = facet_bounds(mesh.view());
  std::vector<SortView> views{{glm::vec4(0, 0, 1, 0), glm::vec3(0, 0, -1)}};
  for (const glm::vec3& direction : {glm::vec3(0.36f, 0.48f, 0.8f), glm::vec3(-0.8f, 0.36f, 0.48f)}) {
    views.push_back({glm::vec4(box.centre() + 2.5f * box.radius() * direction, 1), -direction});
  }
  return views;
}

TEST(Quantised, KeysHaveTwelveToSixteenBits) {
  EXPECT_EQ(key_bits(Precision::whole, 5), 32);
  EXPECT_EQ(key_bits(Precision::whole, 1'000'000), 32);
  EXPECT_EQ(key_bits(Precision::quantised, 1023), 32);  // whole
  EXPECT_EQ(key_bits(Precision::quantised, 1024), 12);
  EXPECT_EQ(key_bits(Precision::quantised, 8192), 12);
  EXPECT_EQ(key_bits(Precision::quantised, 8200), 13);
  EXPECT_EQ(key_bits(Precision::quantised, 10'000'000), 16);
}

TEST(Quantised, NoFacetIsFarFromItsPlaceHoweverDepthsAreSpread) {
  for (const auto& [name, mesh] : uneven_meshes()) {
    SCOPED_TRACE(name);
    for (const Direction direction : {Direction::back_to_front, Direction::front_to_back}) {
      SorterOptions options{.method = Method::centroid_depth, .direction = direction};
      Sorter quantised(mesh.view(), options);
      options.precision = Precision::whole;
      Sorter whole(mesh.view(), options);
      for (const SortView& view : outside_views(mesh)) {
        expect_near(quantised.sort(view), whole.sort(view), mesh.triangles.size());
      }
    }
  }
}

TEST(Quantised, OneFacetFarAwayMovesNoneOfTheOthers) {
  // Among these are some of the sample that steps are laid by.
  for (std::uint32_t outlier = 0; outlier < 2000; outlier += 97) {
    Mesh mesh = shapes::torus_knot(40000);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{1e5f, 0, 0}, {1e5f, 1, 0}, {1e5f, 0, 1}});
    mesh.triangles[outlier] = {first, first + 1, first + 2};
    const SortView view{glm::vec4(1, 0.3f, 0.2f, 0), glm::vec3(-1, -0.3f, -0.2f)};
    Sorter quantised(mesh.view()), whole(mesh.view(), {.precision = Precision::whole});
    expect_near(quantised.sort(view), whole.sort(view), mesh.triangles.size());
  }
}

TEST(Quantised, LeavesOutWhatWholeKeysLeaveOut) {
  const Mesh mesh = shapes::torus_knot(200000);
  const glm::vec4 planes[] = {{1, 0, 0, 0.1f}, {0.6f, 0, 0.8f, 0}};
  SorterOptions options{.cull_back_faces = true, .cull_by_clip_planes = true};
  Sorter quantised(mesh.view(), options);
  options.precision = Precision::whole;
  Sorter whole(mesh.view(), options);
  for (SortView view : outside_views(mesh)) {
    view.clip_planes = planes;
    const Ids expected = copy(whole.sort(view));
    ASSERT_LT(expected.size(), mesh.triangles.size() / 2);
    for (const int threads : {1, 3}) {
      with_threads(threads, [&] {
        quantised.forget_view();
        expect_near(quantised.sort(view), expected, mesh.triangles.size());
      });
    }
  }
}

TEST(Quantised, RangesAreSortedByThemselves) {
  const Mesh mesh = shapes::torus_knot(300000);
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::vector<FacetRange> ranges{{0, 150000}};
  for (std::uint32_t first = 150001; first + 20000 < count; first += 20000) ranges.push_back({first, 19999});
  const SortView view = outside_views(mesh)[1];
  const auto sorted = [&](Precision precision, int threads) {
    Sorter sorter(mesh.view(), {.precision = precision});
    Ids indices(3 * mesh.triangles.size()), ids(mesh.triangles.size()), counts(ranges.size());
    with_threads(threads, [&] { sorter.sort_ranges(view, mesh.triangles, ranges, indices, counts, ids); });
    for (std::size_t r = 0; r < ranges.size(); ++r) {
      EXPECT_EQ(counts[r], ranges[r].count);
      for (std::uint32_t k = ranges[r].first; k < ranges[r].first + ranges[r].count; ++k) {
        for (int i = 0; i < 3; ++i) EXPECT_EQ(indices[3 * k + i], mesh.triangles[ids[k]][i]);
      }
    }
    return ids;
  };
  const Ids whole = sorted(Precision::whole, 1), quantised = sorted(Precision::quantised, 1);
  EXPECT_EQ(sorted(Precision::quantised, 3), quantised);
  for (const FacetRange& range : ranges) {
    expect_near(std::span(quantised).subspan(range.first, range.count),
                std::span(whole).subspan(range.first, range.count), count);
  }
}

}  // namespace
}  // namespace facetsort
