// Pieces of facets on the blend target: what a facet covers, its pieces cover once.
#include "facetsort/facets/pieces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>

#include "blend/pictures.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/shading.h"
#include "facetsort/exact/plane_points.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/report/allocations.h"
#include "shapes.h"
#include "support/mesh_files.h"
#include "support/threads.h"

namespace facetsort {
namespace {

// A mesh some of whose facets are cut, and the draw ids of all that is left of each facet.
class CutMesh {
 public:
  explicit CutMesh(Mesh mesh) : mesh_(std::move(mesh)), parts_(mesh_.triangles.size()) {
    for (std::uint32_t facet = 0; facet < parts_.size(); ++facet) parts_[facet] = {facet};
  }

  // Cuts one part of the facet in two. `plane`: as in Cut.
  void cut(std::uint32_t facet, std::size_t part, std::uint32_t plane) {
    std::vector<Cut> cuts;
    std::uint32_t& id = parts_[facet][part];
    if (id >= facet_count()) {
      const auto old = pieces().cuts_of(pieces_[id - facet_count()]);
      cuts.assign(old.begin(), old.end());
    }
    cuts.push_back({plane, 1});
    id = add_piece(facet, cuts);
    cuts.back().side = -1;
    parts_[facet].push_back(add_piece(facet, cuts));
  }

  std::uint32_t add_plane(const CutPlane& plane) {
    planes_.push_back(plane);
    return static_cast<std::uint32_t>(facet_count() + planes_.size() - 1);
  }

  std::uint32_t facet_count() const { return static_cast<std::uint32_t>(mesh_.triangles.size()); }
  const Mesh& mesh() const { return mesh_; }
  Pieces pieces() const { return {pieces_, cuts_, planes_}; }
  const std::vector<std::uint32_t>& parts(std::uint32_t facet) const { return parts_[facet]; }

  // All that is to be drawn, facet after facet.
  std::vector<std::uint32_t> draw_ids(std::span<const std::uint32_t> facets) const {
    std::vector<std::uint32_t> ids;
    for (const std::uint32_t facet : facets) ids.insert(ids.end(), parts_[facet].begin(), parts_[facet].end());
    return ids;
  }
  std::vector<std::uint32_t> shuffled_draw_ids(std::mt19937& random) const {
    std::vector<std::uint32_t> facets(facet_count());
    std::iota(facets.begin(), facets.end(), 0u);
    std::vector<std::uint32_t> ids = draw_ids(facets);
    std::shuffle(ids.begin(), ids.end(), random);
    return ids;
  }

 private:
  std::uint32_t add_piece(std::uint32_t facet, const std::vector<Cut>& cuts) {
    pieces_.push_back({facet, static_cast<std::uint32_t>(cuts_.size()), static_cast<std::uint32_t>(cuts.size())});
    cuts_.insert(cuts_.end(), cuts.begin(), cuts.end());
    return static_cast<std::uint32_t>(facet_count() + pieces_.size() - 1);
  }

  Mesh mesh_;
  std::vector<std::vector<std::uint32_t>> parts_;
  std::vector<Piece> pieces_;
  std::vector<Cut> cuts_;
  std::vector<CutPlane> planes_;
};

bool has_area(const Mesh& mesh, const glm::uvec3& vertices) {
  return !collinear(mesh.positions[vertices.x], mesh.positions[vertices.y], mesh.positions[vertices.z]);
}

// The plane through two vertices and where the edge from the third to `end` pierces the facet's plane, if it does.
std::optional<CutPlane> join_within(const Mesh& mesh, std::uint32_t facet, const glm::uvec3& through,
                                    std::uint32_t end) {
  const auto side = [&](std::uint32_t vertex) {
    const MeshView view = mesh.view();
    return orientation(view.corner(facet, 0), view.corner(facet, 1), view.corner(facet, 2), mesh.positions[vertex]);
  };
  if (side(through.z) * side(end) >= 0) return std::nullopt;
  return CutPlane{through.x, through.y, through.z, end, facet};
}

// Two facets in three are cut up to four times: by any facet's plane, by that of a facet with a common vertex, through
// one of their own corners, along one of their own edges, by a join, or by their own plane.
CutMesh cut_at_random(Mesh mesh, std::mt19937& random) {
  CutMesh cut(std::move(mesh));
  const std::vector<glm::uvec3>& triangles = cut.mesh().triangles;
  const std::uint32_t facets = cut.facet_count();
  const auto vertices = static_cast<std::uint32_t>(cut.mesh().positions.size());
  std::vector<std::vector<std::uint32_t>> facets_at(vertices);
  for (std::uint32_t facet = 0; facet < facets; ++facet) {
    for (int i = 0; i < 3; ++i) facets_at[triangles[facet][i]].push_back(facet);
  }
  for (std::uint32_t facet = 0; facet < facets; ++facet) {
    if (facet % 3 == 0) continue;
    for (auto cuts = random() % 4 + 1; cuts > 0; --cuts) {
      const auto corner = static_cast<int>(random() % 3);
      const std::uint32_t own = triangles[facet][corner], other = triangles[facet][(corner + 1) % 3];
      const auto any_vertex = [&] { return static_cast<std::uint32_t>(random() % vertices); };
      std::uint32_t plane = facet;
      glm::uvec3 through = triangles[facet];
      std::optional<CutPlane> join;
      switch (random() % 20) {
        case 0:
          break;
        case 1: case 2: case 3: case 4:
          plane = facets_at[own][random() % facets_at[own].size()];
          through = triangles[plane];
          break;
        case 5: case 6: case 7:
          through = {own, any_vertex(), any_vertex()};
          plane = facets;
          break;
        case 8: case 9:
          through = {any_vertex(), own, other};
          plane = facets;
          break;
        case 10: case 11: case 12: case 13:
          through = {any_vertex(), any_vertex(), any_vertex()};
          plane = facets;
          join = join_within(cut.mesh(), facet, through, any_vertex());
          break;
        default:
          plane = static_cast<std::uint32_t>(random() % facets);
          through = triangles[plane];
      }
      if (!has_area(cut.mesh(), through)) continue;
      const CutPlane added = join.value_or(CutPlane{through.x, through.y, through.z});
      cut.cut(facet, random() % cut.parts(facet).size(), plane < facets ? plane : cut.add_plane(added));
    }
  }
  return cut;
}

// On which side of a plane the point lies that the facet shows at a pixel, by exact arithmetic alone.
int exact_side(const Mesh& mesh, const View& view, std::uint32_t facet, const CutPlane& plane, int x, int y,
               std::size_t& ties) {
  const Camera camera(view);
  const glm::dmat3 rows(camera.row_x, camera.row_y, camera.row_w);
  const auto positions = [&](const glm::uvec3& t) {
    return std::array{mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
  };
  const auto corners = positions(mesh.triangles[facet]);
  const EdgeSigns signs =
      exact_cut_signs(corners, points_of(mesh.view(), plane), view.eye, rows, camera.offset, x + 0.5, y + 0.5);
  ties += signs.at_pixel == 0;
  const int side = signs.at_pixel != 0 ? signs.at_pixel : signs.x != 0 ? signs.x : signs.y;
  return side == 0 ? 1 : side * exact_facing(corners[0], corners[1], corners[2], view.eye, rows, camera.offset);
}

// What drawing in the order of the ranks must give.
Image blended_by_rank(const View& view, const FragmentLists& lists, const std::vector<std::uint32_t>& ranks,
                      const std::vector<glm::vec4>& colours) {
  Image image{view.width, view.height, PixelFormat::rgba32f, {}};
  for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> drawn;  // rank and facet
    for (std::size_t i = lists.offsets[pixel]; i < lists.offsets[pixel + 1]; ++i) {
      drawn.emplace_back(ranks[i], lists.fragments[i].facet);
    }
    std::sort(drawn.begin(), drawn.end());
    glm::vec4 blended = background;
    for (const auto& [rank, facet] : drawn) blended = colours[facet] + blended * (1.0f - colours[facet].a);
    image.pixels.push_back(blended);
  }
  return image;
}

Image draw(const CutMesh& cut, const View& view, const std::vector<std::uint32_t>& order,
           const std::vector<glm::vec4>& colours) {
  constexpr DrawPass plain[] = {{}};
  Image image;
  Rasteriser().draw(cut.mesh().view(), view, order, colours, plain, background, PixelFormat::rgba32f, image,
                    cut.pieces());
  return image;
}

void expect_same_pixels(const Image& found, const Image& expected) {
  ASSERT_EQ(found.pixels.size(), expected.pixels.size());
  for (std::size_t pixel = 0; pixel < found.pixels.size(); ++pixel) {
    ASSERT_EQ(found.pixels[pixel], expected.pixels[pixel]) << "pixel " << pixel;
  }
}

std::vector<glm::vec4> colours_of(const Mesh& mesh, const View& view) {
  std::vector<glm::vec4> colours;
  facet_colours(mesh.view(), view.homogeneous_eye(), colours);
  return colours;
}

// Exactly one piece of a fragment's facet has all its cuts' sides right, it is the one that fragment_ranks() finds, and
// the picture is blended of these.
void expect_exact_pieces(const CutMesh& cut, const View& view, std::mt19937& random, std::size_t& ties) {
  const Mesh& mesh = cut.mesh();
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const std::vector<std::uint32_t> order = cut.shuffled_draw_ids(random);
  const std::vector<std::uint32_t> ranks = fragment_ranks(mesh.view(), view, lists, order, cut.pieces());
  ASSERT_EQ(ranks.size(), lists.fragments.size());
  ASSERT_GT(ranks.size(), 0u);
  for (int y = 0; y < view.height; ++y) {
    for (int x = 0; x < view.width; ++x) {
      const auto pixel = static_cast<std::size_t>(y * view.width + x);
      for (std::size_t i = lists.offsets[pixel]; i < lists.offsets[pixel + 1]; ++i) {
        const std::uint32_t facet = lists.fragments[i].facet;
        std::vector<std::uint32_t> covering;
        for (const std::uint32_t id : cut.parts(facet)) {
          bool covers = true;
          if (id >= cut.facet_count()) {
            for (const Cut& c : cut.pieces().cuts_of(cut.pieces().pieces[id - cut.facet_count()])) {
              const CutPlane plane = cut.pieces().plane_of(c, mesh.triangles);
              covers = covers && exact_side(mesh, view, facet, plane, x, y, ties) == c.side;
            }
          }
          if (covers) covering.push_back(id);
        }
        ASSERT_EQ(covering.size(), 1u) << "facet " << facet << " at pixel " << x << ", " << y;
        ASSERT_EQ(order[ranks[i]], covering[0]) << "facet " << facet << " at pixel " << x << ", " << y;
      }
    }
  }
  const std::vector<glm::vec4> colours = colours_of(mesh, view);
  expect_same_pixels(draw(cut, view, order, colours), blended_by_rank(view, lists, ranks, colours));
}

Mesh scaled(Mesh mesh, float scale) {
  for (glm::vec3& position : mesh.positions) position *= scale;
  return mesh;
}

TEST(Pieces, CoverEachPixelOfTheirFacetOnce) {
  std::mt19937 random(1);
  std::size_t ties = 0;
  for (const Mesh& mesh : {shapes::soup(30, 5), shapes::icosphere(1), shapes::sliver_fan(30, 1e4f)}) {
    const CutMesh cut = cut_at_random(mesh, random);
    for (const Projection projection : {Projection::perspective, Projection::orthographic}) {
      const Box box = facet_bounds(mesh.view());
      const glm::vec3 eye = box.centre() + 2.0f * box.radius() * glm::vec3(0.36f, 0.48f, 0.8f);
      expect_exact_pieces(cut, sized(default_view(box, eye, projection), 40, 34), random, ties);
    }
  }
}

TEST(Pieces, AreExactAtAnyScale) {
  std::mt19937 random(2);
  std::size_t ties = 0;
  for (const float scale : {1e-30f, 1e30f, 0x1p-140f}) {
    SCOPED_TRACE(scale);
    const CutMesh cut = cut_at_random(scaled(shapes::soup(20, 6), scale), random);
    const Box box = facet_bounds(cut.mesh().view());
    const glm::vec3 eye = box.centre() + 2.0f * box.radius() * glm::vec3(0.36f, 0.48f, 0.8f);
    View view = sized(default_view(box, eye), 24, 20);
    view.near_distance = std::max(view.near_distance, std::numeric_limits<float>::denorm_min());
    expect_exact_pieces(cut, view, random, ties);
  }
  // Sizes from 1e-6 to 1e6 beside each other.
  const CutMesh cut = cut_at_random(shapes::many_scales(), random);
  expect_exact_pieces(cut, sized(default_view(facet_bounds(cut.mesh().view()), {3, 2, 4}), 24, 20), random, ties);
}

TEST(Pieces, AreExactAroundAnEyeInside) {
  std::mt19937 random(3);
  std::size_t ties = 0;
  const CutMesh cut = cut_at_random(shapes::soup(30, 7), random);
  const Box box = facet_bounds(cut.mesh().view());
  for (const float near_distance : {0.05f, 1e-20f}) {
    View view = sized(default_view(box, box.centre() + glm::vec3(0.01f, 0.02f, 0.005f)), 32, 32);
    view.vertical_fov_degrees = 120;
    view.near_distance = near_distance;
    expect_exact_pieces(cut, view, random, ties);
  }
  // An eye at a vertex, and so in the planes of facets and cuts.
  View view = sized(default_view(box, cut.mesh().positions[20]), 32, 32);
  view.vertical_fov_degrees = 120;
  expect_exact_pieces(cut, view, random, ties);
}

// Facets and planes through whole coordinates, which are pixel centres: cuts pass through centres, facets and planes
// are seen edge-on.
TEST(Pieces, ShareThePixelsThatACutPassesThrough) {
  std::mt19937 random(4);
  std::uniform_int_distribution<int> coordinate(0, 12);
  Mesh mesh;
  for (int i = 0; i < 60; ++i) mesh.positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
  for (std::uint32_t i = 0; i < 100; ++i) {
    mesh.triangles.emplace_back(random() % 60, random() % 60, random() % 60);
  }
  const CutMesh cut = cut_at_random(mesh, random);
  View view;
  view.projection = Projection::orthographic;
  view.width = view.height = 16;
  view.height_in_units = 16;
  view.eye = {6.5f, 6.5f, 20};
  view.at = {6.5f, 6.5f, 0};
  std::size_t ties = 0;
  expect_exact_pieces(cut, view, random, ties);
  EXPECT_GT(ties, 100u);

  View perspective = view;
  perspective.projection = Projection::perspective;
  perspective.eye = {6, 6, 18};
  perspective.at = {6, 6, 0};
  perspective.width = perspective.height = 25;
  expect_exact_pieces(cut, perspective, random, ties);
}

// More cuts in one tile than the kernels keep in float.
TEST(Pieces, MayHaveManyCorners) {
  Mesh mesh;
  mesh.positions = {{-5, -4, 0}, {5, -4, 0}, {0, 6, 0}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}};
  const int sides = 40;
  for (int i = 0; i < sides; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / static_cast<float>(sides);
    mesh.positions.emplace_back(std::cos(angle), std::sin(angle), 0);
  }
  CutMesh cut(mesh);
  for (std::uint32_t i = 0; i < sides; ++i) {
    // The part that is last, on the side of the middle, goes on being cut.
    cut.cut(0, i, cut.add_plane({4 + i, 4 + (i + 1) % sides, 3}));
  }
  ASSERT_EQ(cut.parts(0).size(), sides + 1u);
  View view;
  view.eye = {0, 0, 4};
  view.width = view.height = 24;
  std::mt19937 random(5);
  std::size_t ties = 0;
  expect_exact_pieces(cut, view, random, ties);
  // The polygon in the middle alone is nearly a disc of radius 1; the picture is 8 tan(22.5 degrees) units high.
  const std::vector<std::uint32_t> middle{cut.parts(0).back()};
  const std::vector<glm::vec4> white{glm::vec4(1)};
  const Image image = draw(cut, view, middle, white);
  const auto covered = std::count(image.pixels.begin(), image.pixels.end(), glm::vec4(1));
  const double pixel_side = 8 * 0.414214 / 24;
  EXPECT_NEAR(static_cast<double>(covered), 3.1287 / (pixel_side * pixel_side), 9);
}

// Colours that count: red the fragments, green and blue their facets' ids and the squares of these, all of them exact.
TEST(Pieces, CoverWhatTheirFacetsCoverOnAMeshOfManyTiles) {
  const Mesh mesh = load("spiralstair_15k");
  std::mt19937 random(6);
  const CutMesh cut = cut_at_random(mesh, random);
  const Box box = facet_bounds(mesh.view());
  std::vector<glm::vec4> counting(mesh.triangles.size());
  for (std::size_t i = 0; i < counting.size(); ++i) {
    const auto id = static_cast<float>(i % 509);
    counting[i] = {1, id, id * id, 0};
  }
  constexpr DrawPass plain[] = {{}};
  for (const float radii : {2.5f, 0.6f, 0.05f}) {
    SCOPED_TRACE(radii);
    const View view =
        sized(default_view(box, box.centre() + radii * box.radius() * glm::vec3(0.48f, 0.36f, 0.8f)), 330, 250);
    const std::vector<std::uint32_t> order = cut.shuffled_draw_ids(random);
    Image image;
    Rasteriser().draw(mesh.view(), view, order, counting, plain, glm::vec4(0), PixelFormat::rgba32f, image,
                      cut.pieces());
    const FragmentLists lists = collect_fragments(mesh.view(), view);
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      glm::vec4 expected(0);
      for (const Fragment& fragment : lists.pixel(pixel)) expected += counting[fragment.facet];
      ASSERT_EQ(image.pixels[pixel], expected) << "pixel " << pixel;
    }
  }
}

TEST(Pieces, OfAFacetDrawnOneAfterTheOtherAreThePictureOfTheWhole) {
  std::mt19937 random(7);
  for (const bool coloured : {false, true}) {
    const Mesh plain_mesh = load("teapot_1k");
    const CutMesh cut = cut_at_random(coloured ? with_vertex_colours(plain_mesh) : plain_mesh, random);
    const Mesh& mesh = cut.mesh();
    const Box box = facet_bounds(mesh.view());
    const View view = sized(default_view(box, box.centre() + box.radius() * glm::vec3(0.9f, 0.4f, 1.1f)), 150, 120);
    std::vector<std::uint32_t> facets(mesh.triangles.size());
    std::iota(facets.begin(), facets.end(), 0u);
    std::shuffle(facets.begin(), facets.end(), random);
    const std::vector<glm::vec4> colours = coloured ? std::vector<glm::vec4>{} : colours_of(mesh, view);
    for (const bool depth_test : {false, true}) {
      for (const PixelFormat format : {PixelFormat::rgba32f, PixelFormat::rgba8}) {
        const DrawPass passes[] = {
            {.cull = Cull::front_faces},
            {.depth_test = depth_test ? DepthTest::less : DepthTest::off, .depth_write = depth_test}};
        Image whole, pieces;
        Rasteriser().draw(mesh.view(), view, facets, colours, passes, background, format, whole);
        Rasteriser().draw(mesh.view(), view, cut.draw_ids(facets), colours, passes, background, format, pieces,
                          cut.pieces());
        expect_same_pixels(pieces, whole);
      }
    }
  }
}

TEST(Pieces, AreTheSamePictureAndRanksForAnyThreadCount) {
  std::mt19937 random(8);
  const CutMesh cut = cut_at_random(load("hand_2k"), random);
  const Mesh& mesh = cut.mesh();
  const Box box = facet_bounds(mesh.view());
  const glm::vec3 eye = box.centre() + 2.0f * box.radius() * glm::vec3(0.48f, 0.36f, 0.8f);
  const View view = sized(default_view(box, eye), 200, 180);
  const std::vector<std::uint32_t> order = cut.shuffled_draw_ids(random);
  const std::vector<glm::vec4> colours = colours_of(mesh, view);
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const std::vector<std::uint32_t> ranks = fragment_ranks(mesh.view(), view, lists, order, cut.pieces());
  const Image expected = blended_by_rank(view, lists, ranks, colours);
  for (const int threads : {1, 2, 3, 8}) {
    with_threads(threads, [&] {
      SCOPED_TRACE(threads);
      expect_same_pixels(draw(cut, view, order, colours), expected);
      EXPECT_EQ(fragment_ranks(mesh.view(), view, lists, order, cut.pieces()), ranks) << threads;
    });
  }
}

TEST(Pieces, WhoseCutsWereMeasuredBeforeAreTheSamePicture) {
  std::mt19937 random(10);
  const CutMesh cut = cut_at_random(load("teapot_1k"), random);
  const Box box = facet_bounds(cut.mesh().view());
  const std::vector<std::uint32_t> order = cut.shuffled_draw_ids(random);
  const std::vector<MeasuredCut> measured = measure_cuts(cut.mesh().view(), cut.pieces());
  ASSERT_EQ(measured.size(), cut.pieces().cuts.size());
  constexpr DrawPass plain[] = {{}};
  // Facets of few pixels, of many, and across the near plane.
  for (const float radii : {9.0f, 2.0f, 0.3f}) {
    SCOPED_TRACE(radii);
    const View view =
        sized(default_view(box, box.centre() + radii * box.radius() * glm::vec3(0.48f, 0.36f, 0.8f)), 200, 180);
    const std::vector<glm::vec4> colours = colours_of(cut.mesh(), view);
    const Image expected = draw(cut, view, order, colours);
    for (const std::size_t count : {measured.size(), measured.size() / 2}) {
      Pieces pieces = cut.pieces();
      pieces.measured = std::span(measured).first(count);
      Image image;
      Rasteriser().draw(cut.mesh().view(), view, order, colours, plain, background, PixelFormat::rgba32f, image,
                        pieces);
      expect_same_pixels(image, expected);
    }
  }
}

TEST(Pieces, LeftOutOfTheOrderAreNotDrawn) {
  // A square of two triangles; a plane through the middle cuts the first.
  Mesh mesh;
  mesh.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, -1, 1}, {0, 1, 1}, {0, 0, -1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  CutMesh cut(mesh);
  const std::uint32_t plane = cut.add_plane({4, 5, 6});
  cut.cut(0, 0, plane);
  View view;
  view.width = view.height = 40;
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  const std::vector<std::uint32_t> order{1, cut.parts(0)[0]};
  const std::vector<std::uint32_t> ranks = fragment_ranks(mesh.view(), view, lists, order, cut.pieces());
  const Image image = draw(cut, view, order, {glm::vec4(1), glm::vec4(1)});
  std::size_t whole = 0, piece = 0, left_out = 0;
  for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
    for (std::size_t i = lists.offsets[pixel]; i < lists.offsets[pixel + 1]; ++i) {
      EXPECT_EQ(image.pixels[pixel] == glm::vec4(1), ranks[i] != not_drawn);
      whole += ranks[i] == 0;
      piece += ranks[i] == 1;
      left_out += ranks[i] == not_drawn;
    }
  }
  // Of the triangle's half of the square, the plane leaves a quarter on one side and three on the other.
  EXPECT_NEAR(static_cast<double>(std::min(piece, left_out)) / static_cast<double>(whole), 0.25, 0.05);
  EXPECT_NEAR(static_cast<double>(std::max(piece, left_out)) / static_cast<double>(whole), 0.75, 0.05);
}

TEST(Pieces, DrawnAgainAllocateNothing) {
  std::mt19937 random(9);
  const CutMesh cut = cut_at_random(load("teapot_1k"), random);
  const Box box = facet_bounds(cut.mesh().view());
  const View view = default_view(box, box.centre() + box.radius() * glm::vec3(0.9f, 0.4f, 2.0f));
  const std::vector<std::uint32_t> order = cut.shuffled_draw_ids(random);
  const std::vector<glm::vec4> colours = colours_of(cut.mesh(), view);
  constexpr DrawPass plain[] = {{}};
  Rasteriser rasteriser;
  Image image;
  const auto draw_once = [&] {
    rasteriser.draw(cut.mesh().view(), view, order, colours, plain, background, PixelFormat::rgba32f, image,
                    cut.pieces());
  };
  with_threads(1, [&] {
    draw_once();
    const unsigned long long fallbacks = exact_fallbacks();
    const AllocationScope scope;
    draw_once();
    // Exact decisions may allocate; a mesh like this asks for none, or few.
    EXPECT_LE(scope.count().calls, 20 * (exact_fallbacks() - fallbacks));
  });
}

}  // namespace
}  // namespace facetsort
