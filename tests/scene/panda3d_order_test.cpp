#include "facetsort/scene/panda3d_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "scene/fixture.h"

namespace facetsort {
namespace {

std::string drawn(const std::vector<Panda3DItem>& items, const Panda3DCamera& camera = {},
                  const std::vector<Panda3DBin>& bins = panda3d_default_bins()) {
  const Result<std::vector<ObjectDraw>> draws = panda3d_draw_order(items, camera, bins);
  return draws.ok() ? text_of(draws.value()) : draws.status().message;
}

Panda3DItem in_bin(const std::string& bin, int draw_order = 0, double distance = 0) {
  return {.bin = bin, .draw_order = draw_order, .bounds_centre = {0, distance, 0}};
}

TEST(Panda3DOrder, HasTheManualsDefaultBins) {
  const std::vector<Panda3DBin> bins = panda3d_default_bins();
  const std::vector<std::string> names{"background", "opaque", "transparent", "fixed", "unsorted"};
  const std::vector<Panda3DBinType> types{Panda3DBinType::fixed, Panda3DBinType::state_sorted,
                                          Panda3DBinType::back_to_front, Panda3DBinType::fixed,
                                          Panda3DBinType::unsorted};
  ASSERT_EQ(bins.size(), 5u);
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(bins[i].name, names[i]);
    EXPECT_EQ(bins[i].sort, 10 * (i + 1));
    EXPECT_EQ(bins[i].type, types[i]);
  }
}

TEST(Panda3DOrder, PutsWhatHasNoBinIntoOpaqueOrTransparent) {
  EXPECT_EQ(panda3d_bin_name({}), "opaque");
  EXPECT_EQ(panda3d_bin_name({.transparency = true}), "transparent");
  EXPECT_EQ(panda3d_bin_name({.bin = "fixed", .transparency = true}), "fixed");
}

TEST(Panda3DOrder, MeasuresFromTheCameraPlane) {
  const Panda3DCamera camera{.position = {1, 1, 1}, .forward = {0, 0.6, 0.8}};
  EXPECT_DOUBLE_EQ(panda3d_distance({.bounds_centre = {9, 2, 3}}, camera), 0.6 + 1.6);
  EXPECT_DOUBLE_EQ(panda3d_distance({.bounds_centre = {-9, 1, -1}}, camera), -1.6);
}

TEST(Panda3DOrder, ComparesByOneKeyABinType) {
  const Panda3DObject a{0, 1, 2, 3}, b{1, 2, 3, 4}, same_keys{2, 1, 2, 3};
  EXPECT_LT(panda3d_compare_fixed(a, b), 0);
  EXPECT_GT(panda3d_compare_fixed(b, a), 0);
  EXPECT_LT(panda3d_compare_state_sorted(a, b), 0);
  EXPECT_GT(panda3d_compare_state_sorted(b, a), 0);
  EXPECT_LT(panda3d_compare_front_to_back(a, b), 0);
  EXPECT_GT(panda3d_compare_front_to_back(b, a), 0);
  EXPECT_LT(panda3d_compare_back_to_front(b, a), 0);
  EXPECT_GT(panda3d_compare_back_to_front(a, b), 0);
  for (const auto compare : {panda3d_compare_fixed, panda3d_compare_state_sorted, panda3d_compare_front_to_back,
                             panda3d_compare_back_to_front}) {
    EXPECT_EQ(compare(a, same_keys), 0);
  }
}

TEST(Panda3DOrder, DrawsBinsInTurn) {
  EXPECT_EQ(drawn({in_bin("unsorted"), in_bin("fixed"), in_bin("transparent"), in_bin("opaque"), in_bin("background")}),
            "4f 3f 2f 1f 0f");
}

TEST(Panda3DOrder, SortsEachBinByItsType) {
  const auto items_in = [](const std::string& bin) {
    std::vector<Panda3DItem> items{in_bin(bin, 2, 5), in_bin(bin, 1, 9), in_bin(bin, -1, 7), in_bin(bin, 2, 9)};
    items[0].state = items[2].state = 3;
    return items;
  };
  EXPECT_EQ(drawn(items_in("background")), "2f 1f 0f 3f");
  EXPECT_EQ(drawn(items_in("opaque")), "1f 3f 0f 2f");
  EXPECT_EQ(drawn(items_in("transparent")), "1f 3f 2f 0f");
  EXPECT_EQ(drawn(items_in("fixed")), "2f 1f 0f 3f");
  EXPECT_EQ(drawn(items_in("unsorted")), "0f 1f 2f 3f");
  const std::vector<Panda3DBin> bins{{"solid", 0, Panda3DBinType::front_to_back}};
  EXPECT_EQ(drawn(items_in("solid"), {}, bins), "0f 2f 1f 3f");
}

TEST(Panda3DOrder, TakesExtraBins) {
  std::vector<Panda3DBin> bins = panda3d_default_bins();
  bins.push_back({"glow", 25, Panda3DBinType::back_to_front});
  bins.push_back({"sky", -5, Panda3DBinType::unsorted});
  bins.push_back({"also 25", 25, Panda3DBinType::unsorted});
  EXPECT_EQ(drawn({in_bin("also 25"), in_bin("transparent"), in_bin("glow", 0, 1), in_bin("glow", 0, 2),
                   in_bin("opaque"), in_bin("sky")},
                  {}, bins),
            "5f 4f 3f 2f 0f 1f");
}

TEST(Panda3DOrder, KeepsDepthFlagsApartFromTransparency) {
  EXPECT_EQ(drawn({{.transparency = true}}), "0f");
  EXPECT_EQ(drawn({{.transparency = true, .depth_write = false, .two_sided = true}}), "0aw");
  EXPECT_EQ(drawn({{.bin = "fixed", .depth_test = false}}), "0ft");
}

TEST(Panda3DOrder, RefusesBinsItDoesNotKnowAndBinsNamedTwice) {
  EXPECT_EQ(drawn({{}, in_bin("glow")}), "item 1: no bin named glow");
  EXPECT_EQ(drawn({{.transparency = true}}, {}, {{"opaque", 1, Panda3DBinType::unsorted}}),
            "item 0: no bin named transparent");
  EXPECT_EQ(drawn({}, {}, {{"a", 1, Panda3DBinType::fixed}, {"a", 2, Panda3DBinType::fixed}}), "two bins named a");
  EXPECT_EQ(panda3d_draw_order(std::vector{in_bin("glow")}, {}).status().fault, Fault::bad_argument);
}

// What a random scene's draws must be, whatever they are: each item once, and of any two neighbours the first first.
TEST(Panda3DOrder, LeavesNoPairTheWrongWayRound) {
  std::mt19937 random(5);
  const auto pick = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
  std::vector<Panda3DBin> bins = panda3d_default_bins();
  bins.push_back({"front_to_back", 30, Panda3DBinType::front_to_back});
  const Panda3DCamera camera{.position = {0, -1, 0}, .forward = {0, 0.6, 0.8}};
  int ties = 0;
  for (int scene = 0; scene < 500; ++scene) {
    std::vector<Panda3DItem> items(pick(2, 100));
    for (Panda3DItem& item : items) {
      if (pick(0, 3) > 0) item.bin = bins[pick(0, int(bins.size()) - 1)].name;
      item.draw_order = pick(-2, 2);
      item.transparency = pick(0, 1) == 1;
      item.state = std::uint32_t(pick(0, 3));
      item.bounds_centre = {pick(-2, 2), pick(-2, 2), pick(-2, 2)};
    }
    const Result<std::vector<ObjectDraw>> draws = panda3d_draw_order(items, camera, bins);
    ASSERT_TRUE(draws.ok());
    std::vector<int> times(items.size());
    for (const ObjectDraw& draw : draws.value()) ++times.at(draw.item);
    ASSERT_EQ(std::count(times.begin(), times.end(), 1), std::ptrdiff_t(items.size()));

    for (std::size_t i = 1; i < items.size(); ++i) {
      const std::uint32_t before = draws.value()[i - 1].item, after = draws.value()[i].item;
      const Panda3DItem &a = items[before], &b = items[after];
      const auto place = [&](const Panda3DItem& item) {
        return std::find_if(bins.begin(), bins.end(),
                            [&](const Panda3DBin& bin) { return bin.name == panda3d_bin_name(item); });
      };
      const auto a_bin = place(a), b_bin = place(b);
      ASSERT_LE(a_bin->sort, b_bin->sort);
      if (a_bin != b_bin) continue;
      const double a_distance = panda3d_distance(a, camera), b_distance = panda3d_distance(b, camera);
      const std::map<Panda3DBinType, double> falls{{Panda3DBinType::fixed, a.draw_order - b.draw_order},
                                                   {Panda3DBinType::state_sorted, double(a.state) - double(b.state)},
                                                   {Panda3DBinType::back_to_front, b_distance - a_distance},
                                                   {Panda3DBinType::front_to_back, a_distance - b_distance},
                                                   {Panda3DBinType::unsorted, 0}};
      ASSERT_LE(falls.at(a_bin->type), 0);
      if (falls.at(a_bin->type) < 0) continue;
      ASSERT_LT(before, after);
      ++ties;
    }
  }
  EXPECT_GT(ties, 1000);
}

}  // namespace
}  // namespace facetsort
