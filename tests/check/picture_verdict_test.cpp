#include "facetsort/check/picture_verdict.h"

#include <gtest/gtest.h>

#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {
namespace {

// `layers` triangles that cover a small picture, coincident in pairs where `paired`.
Mesh layers(int count, bool paired) {
  Mesh mesh;
  for (int layer = 0; layer < count; ++layer) {
    const auto z = static_cast<float>(paired ? layer / 2 : layer);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(-500, -500), glm::vec2(1500, -500), glm::vec2(-500, 1500)}) {
      mesh.positions.emplace_back(corner, z);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

struct Judged {
  Mesh mesh;
  View view;
  FragmentLists lists;
  Image reference;

  explicit Judged(Mesh mesh_in) : mesh(std::move(mesh_in)) {
    view.eye = {0, 0, 100};
    view.width = view.height = 8;
    lists = collect_fragments(mesh.view(), view);
    blend_lists(mesh.view(), view, lists, PixelFormat::rgba32f, reference);
  }

  // The verdict on the picture of the facets drawn in an order.
  PictureVerdict of(std::vector<std::uint32_t> order) const {
    std::vector<glm::vec4> colours;
    facet_colours(mesh.view(), view.homogeneous_eye(), colours);
    Image picture;
    const DrawPass plain[] = {{}};
    Rasteriser().draw(mesh.view(), view, order, colours, plain, background, PixelFormat::rgba32f, picture);
    return judge_picture(mesh.view(), view, lists, reference, picture, {.bounding_radius = 1000});
  }
};

TEST(PictureVerdict, SwappedLayersAreWrongWhereTheyDoNotTie) {
  const Judged judged(layers(3, false));
  EXPECT_EQ(judged.of({0, 1, 2}).wrong_pixels, 0u);
  EXPECT_EQ(judged.of({0, 1, 2}).max_error, 0.0);
  const PictureVerdict swapped = judged.of({0, 2, 1});
  EXPECT_EQ(swapped.wrong_pixels, 64u);
  EXPECT_EQ(swapped.covered_pixels, 64u);
  EXPECT_EQ(swapped.unjudged_pixels, 0u);
  EXPECT_GT(swapped.rmse, 0.01);
}

TEST(PictureVerdict, LayersThatTieMayBeDrawnEitherWayAndNoOther) {
  const Judged judged(layers(6, true));
  EXPECT_EQ(judged.of({1, 0, 3, 2, 5, 4}).wrong_pixels, 0u);
  EXPECT_EQ(judged.of({0, 1, 3, 2, 4, 5}).wrong_pixels, 0u);
  EXPECT_GT(judged.of({1, 0, 3, 2, 5, 4}).max_error, 1.0 / 255) << "it does differ from the reference";
  EXPECT_EQ(judged.of({2, 3, 0, 1, 4, 5}).wrong_pixels, 64u);
  EXPECT_EQ(judged.of({0, 1, 2, 3, 4}).wrong_pixels, 64u) << "a layer is missing";
}

TEST(PictureVerdict, SaysWhereThereAreTooManyOrdersToTry) {
  Mesh mesh = layers(1, false);
  mesh.triangles.assign(9, mesh.triangles[0]);  // 9! orders
  const Judged judged(mesh);
  const PictureVerdict verdict = judged.of({8, 7, 6, 5, 4, 3, 2, 1, 0});
  EXPECT_EQ(verdict.unjudged_pixels, 64u);
  EXPECT_EQ(verdict.wrong_pixels, 0u);
}

TEST(PictureVerdict, GapIsInRadii) {
  const Judged judged(layers(2, false));  // one unit apart
  Image swapped;
  const DrawPass plain[] = {{}};
  std::vector<glm::vec4> colours;
  facet_colours(judged.mesh.view(), judged.view.homogeneous_eye(), colours);
  const std::vector<std::uint32_t> order{1, 0};
  Rasteriser().draw(judged.mesh.view(), judged.view, order, colours, plain, background, PixelFormat::rgba32f, swapped);
  const auto wrong = [&](double radius) {
    return judge_picture(judged.mesh.view(), judged.view, judged.lists, judged.reference, swapped,
                         {.bounding_radius = radius, .gap_radii = 1e-3})
        .wrong_pixels;
  };
  EXPECT_EQ(wrong(900), 64u);
  EXPECT_EQ(wrong(2000), 0u);
}

}  // namespace
}  // namespace facetsort
