// What a plan says of meshes whose needs are known, and that what it calls proved is right from anywhere.
#include "facetsort/plan/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "facetsort/check/picture_verdict.h"
#include "facetsort/plan/planned_renderer.h"
#include "shapes.h"
#include "support/random_views.h"

namespace facetsort {
namespace {

constexpr PlanOptions quick{.frames = 100, .views = 2, .width = 64, .height = 64};

Mesh sphere_at(const glm::vec3& centre) {
  Mesh mesh = shapes::icosphere(1);
  for (glm::vec3& position : mesh.positions) position += centre;
  return mesh;
}

void append(Mesh& mesh, const Mesh& other) {
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), other.positions.begin(), other.positions.end());
  for (const glm::uvec3& triangle : other.triangles) mesh.triangles.push_back(triangle + first);
}

Mesh two_spheres() {
  Mesh mesh = sphere_at({-2, 0, 0});
  append(mesh, sphere_at({2, 0, 0}));
  return mesh;
}

// A cube with one corner pushed in.
Mesh dented_box() {
  Mesh mesh = shapes::box();
  const glm::vec3 corner = mesh.positions[0], centre(0);
  for (glm::vec3& position : mesh.positions) {
    if (position == corner) position = glm::mix(corner, centre, 0.9f);
  }
  return mesh;
}

void colour(Mesh& mesh, float alpha) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    mesh.facet_colours.emplace_back(i % 2 == 0 ? 1 : 0, i % 3 == 0 ? 1 : 0, i % 5 == 0 ? 1 : 0, alpha);
  }
}

void set_material(Mesh& mesh, const Material& material) {
  mesh.materials = {material};
  mesh.facet_materials.assign(mesh.triangles.size(), 0);
}

bool leaves_out(const MeshPlan& plan, const std::string& what) {
  return std::any_of(plan.left_out.begin(), plan.left_out.end(),
                     [&](const LeftOut& left) { return left.what.find(what) != std::string::npos; });
}

std::size_t wrong_pixels(const Mesh& mesh, StrategyRenderer& renderer, const View& view) {
  const FragmentLists lists = collect_fragments(mesh.view(), view);
  Image reference, picture;
  blend_lists(mesh.view(), view, lists, PixelFormat::rgba32f, reference);
  renderer.draw(view, PixelFormat::rgba32f, picture);
  const double radius = static_cast<double>(facet_bounds(mesh.view()).radius());
  const PictureVerdict verdict =
      judge_picture(mesh.view(), view, lists, reference, picture, {.bounding_radius = radius > 0 ? radius : 1.0});
  return verdict.wrong_pixels;
}

View view_from(const glm::vec3& eye) {
  View view;
  view.eye = eye;
  view.width = view.height = 96;
  return view;
}

TEST(Plan, AConvexClosedMeshNeedsBackFacesAndThenFrontFaces) {
  const Mesh box = shapes::box();
  const MeshPlan plan = plan_mesh(box.view(), quick);
  EXPECT_EQ(plan.strategy.name(), "separate_culling_pass");
  EXPECT_EQ(plan.certainty, Certainty::proved);
  EXPECT_TRUE(leaves_out(plan, "sorting"));
  EXPECT_TRUE(plan.timed.empty());
}

TEST(Plan, ADentTakesThatAway) {
  const Mesh dented = dented_box();
  const MeshPlan plan = plan_mesh(dented.view(), quick);
  ASSERT_TRUE(plan.geometry);
  EXPECT_EQ(plan.geometry->convex_closed_components, 0u);
  EXPECT_NE(plan.strategy.kind, StrategyKind::separate_culling_pass);
  EXPECT_FALSE(plan.culls_where_apart);
  EXPECT_EQ(plan.certainty, Certainty::proved);
}

TEST(Plan, AConvexMeshSeenFromOutsideAloneHasOneLayer) {
  Mesh box = shapes::box();
  set_material(box, {.base_colour = glm::vec4(1, 0, 0, 0.5f), .double_sided = false});
  EXPECT_EQ(plan_mesh(box.view(), quick).strategy.name(), "unsorted");
}

TEST(Plan, OpaqueFacetsNeedNoOrder) {
  Mesh soup = shapes::soup(200, 1);
  set_material(soup, {.alpha_mode = AlphaMode::opaque});
  const MeshPlan plan = plan_mesh(soup.view(), quick);
  EXPECT_EQ(plan.strategy.name(), "unsorted");
  EXPECT_EQ(plan.certainty, Certainty::proved);
  EXPECT_TRUE(leaves_out(plan, "sorting"));
  EXPECT_FALSE(plan.geometry) << "found though nothing needs it";
}

TEST(Plan, AddedColoursNeedNoOrder) {
  Mesh mesh = dented_box();
  colour(mesh, 0.5f);
  const MeshPlan plan = plan_mesh(mesh.view(), {.additive = true});
  EXPECT_EQ(plan.strategy.name(), "additive");
  EXPECT_EQ(plan.certainty, Certainty::proved);
  EXPECT_TRUE(leaves_out(plan, "sorting"));
  EXPECT_TRUE(plan.timed.empty());
}

TEST(Plan, BlendedFacetsOfFullAlphaNeedDepthAlone) {
  Mesh soup = shapes::soup(200, 1);
  soup.facet_colours.clear();
  colour(soup, 1);
  const MeshPlan plan = plan_mesh(soup.view(), quick);
  EXPECT_EQ(plan.strategy.name(), "depth_write");
  EXPECT_EQ(plan.layers_that_matter, 1u);
}

TEST(Plan, ThinAlphasNeedNoOrder) {
  // Ten layers: 45 pairs, each worth alpha^2 of the range of colours at most: 45 * 0.006^2 is 0.0016, below 0.5 / 255.
  Mesh stack = shapes::duplicated_grid(1, 5);
  stack.facet_colours.clear();
  ASSERT_EQ(stack.triangles.size(), 10u);
  for (std::size_t i = 0; i < stack.positions.size(); ++i) stack.positions[i].z += 0.1f * static_cast<float>(i);
  colour(stack, 0.006f);
  EXPECT_EQ(plan_mesh(stack.view(), quick).strategy.name(), "premultiplied_over");
  // 45 * 0.007^2 is 0.0022.
  stack.facet_colours.clear();
  colour(stack, 0.007f);
  EXPECT_NE(plan_mesh(stack.view(), quick).strategy.name(), "premultiplied_over");
}

TEST(Plan, FacetsOfOnePlaneNeedNoOrder) {
  const Mesh plane = shapes::coplanar(50, 3);
  EXPECT_EQ(plan_mesh(plane.view(), quick).strategy.name(), "unsorted");
}

TEST(Plan, SaysHowManyLayersShow) {
  // Half of the light at each: 2^-9 is the first power below 0.5 / 255.
  const Mesh knot = shapes::torus_knot(500);
  const MeshPlan plan = plan_mesh(knot.view(), quick);
  EXPECT_EQ(plan.layers_that_matter, 9u);
  EXPECT_EQ(plan.certainty, Certainty::proved);
  EXPECT_TRUE(leaves_out(plan, "presorting"));  // for a hundred frames
}

TEST(Plan, BrightColoursShowThroughMoreLayers) {
  Mesh knot = shapes::torus_knot(500);
  knot.facet_colours.assign(knot.triangles.size(), glm::vec4(1, 1, 1, 0.5f));
  EXPECT_EQ(plan_mesh(knot.view(), quick).layers_that_matter, 9u);
  knot.facet_colours[7] = glm::vec4(1, 4, 1, 0.5f);
  EXPECT_EQ(plan_mesh(knot.view(), quick).layers_that_matter, 11u);
}

TEST(Plan, CrossingFacetsAreCutOrComparedAPixel) {
  const Mesh crossing = shapes::interpenetrating(1);
  const MeshPlan plan = plan_mesh(crossing.view(), quick);
  ASSERT_TRUE(plan.geometry);
  EXPECT_GT(plan.geometry->intersecting_pairs, 0u);
  const bool compares_depths = plan.strategy.kind == StrategyKind::multi_layer;
  EXPECT_TRUE(compares_depths || (plan.strategy.kind == StrategyKind::facet_sort && is_exact(plan.strategy.method)));
  EXPECT_EQ(leaves_out(plan, "cuts"), compares_depths);
}

TEST(Plan, ThinLayersThatNoPixelCanKeepAreSorted) {
  Mesh knot = shapes::torus_knot(500);
  knot.facet_colours.clear();
  colour(knot, 0.05f);
  const MeshPlan plan = plan_mesh(knot.view(), quick);
  EXPECT_EQ(plan.strategy.kind, StrategyKind::facet_sort);
  EXPECT_TRUE(is_exact(plan.strategy.method));
}

TEST(Plan, ABudgetIsKeptInTheViewsStated) {
  const Mesh knot = shapes::torus_knot(500);
  PlanOptions options = quick;
  options.error_budget = 0.5;
  const MeshPlan plan = plan_mesh(knot.view(), options);
  for (const TimedStrategy& timed : plan.timed) EXPECT_LE(timed.worst_wrong, 0.25);
  EXPECT_TRUE(std::any_of(plan.timed.begin(), plan.timed.end(),
                          [](const TimedStrategy& timed) { return timed.certainty == Certainty::measured; }));
}

// What is proved has no wrong pixel in views that the plan has not seen, from outside and from within: what was chosen,
// and what was only slower.
TEST(Plan, WhatIsProvedIsRight) {
  std::vector<Mesh> meshes{shapes::box(),
                           dented_box(),
                           two_spheres(),
                           shapes::torus_knot(500),
                           shapes::interpenetrating(1),
                           shapes::triangle_cycle(5),
                           shapes::woven_mat(4),
                           shapes::nested_shells(3, 0.2f, 1),
                           shapes::soup(60, 7)};
  Mesh thin = shapes::torus_knot(500);
  thin.facet_colours.clear();
  colour(thin, 0.05f);
  meshes.push_back(thin);
  PlanOptions options = quick;
  options.frames = 1000000;
  std::size_t proved = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const Mesh& mesh = meshes[m];
    std::vector<View> views = random_views(mesh.view(), 5, 11);
    const std::vector<View> inside = views_inside(facet_bounds(mesh.view()), 1);
    views.insert(views.end(), inside.begin(), inside.end());
    PlannedRenderer planned(mesh.view(), options);
    ASSERT_EQ(planned.plan().certainty, Certainty::proved);
    for (View& view : views) {
      view.width = view.height = 128;
      planned.order(view);
      EXPECT_EQ(wrong_pixels(mesh, planned.renderer(), view), 0u)
          << "mesh " << m << " by " << planned.renderer().strategy().name();
    }
    for (const TimedStrategy& timed : planned.plan().timed) {
      StrategyRenderer renderer(mesh.view(), timed.strategy);
      for (const View& view : views) {
        renderer.order(view);
        EXPECT_EQ(wrong_pixels(mesh, renderer, view), 0u) << "mesh " << m << " by " << timed.strategy.name();
        ++proved;
      }
    }
  }
  EXPECT_GT(proved, 100u);
}

TEST(Plan, SurvivesDamagedMeshes) {
  Mesh point;
  point.positions = {{1, 2, 3}};
  point.triangles = {{0, 0, 0}};
  Mesh line;
  line.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  line.triangles = {{0, 1, 2}, {2, 1, 0}};
  Mesh huge = shapes::box();
  for (glm::vec3& position : huge.positions) position *= 1e38f;
  for (const Mesh& mesh : {point, line, huge, shapes::many_scales(), shapes::sliver_fan(9, 1e6f)}) {
    const MeshPlan plan = plan_mesh(mesh.view(), quick);
    EXPECT_FALSE(plan.reason.empty());
    EXPECT_EQ(plan.facets, mesh.triangles.size());
  }
}

TEST(PlannedRenderer, DrawsPartsThatAreApartWithoutSorting) {
  const Mesh spheres = two_spheres();
  PlannedRenderer planned(spheres.view(), quick);
  ASSERT_TRUE(planned.plan().culls_where_apart);
  planned.order(view_from({0, 0, 12}));  // side by side
  EXPECT_EQ(planned.renderer().strategy().kind, StrategyKind::separate_culling_pass);
  EXPECT_EQ(wrong_pixels(spheres, planned.renderer(), view_from({0, 0, 12})), 0u);
  planned.order(view_from({12, 0, 0}));  // one behind the other
  EXPECT_EQ(planned.renderer().strategy(), planned.plan().strategy);
  EXPECT_NE(planned.plan().strategy.kind, StrategyKind::separate_culling_pass);
  EXPECT_EQ(wrong_pixels(spheres, planned.renderer(), view_from({12, 0, 0})), 0u);
}

TEST(PlannedRenderer, KeepsTheOrderOfTheSameView) {
  const Mesh knot = shapes::torus_knot(500);
  PlannedRenderer planned(knot.view(), quick);
  const View view = view_from({0, 0, 12}), other = view_from({0, 1, 12});
  View turned = other;
  turned.at.x = 1;  // layers and exact orders depend on the eye alone
  for (const View& next : {view, view, other, other, turned, view}) planned.order(next);
  EXPECT_EQ(planned.statistics().frames, 6u);
  EXPECT_EQ(planned.statistics().kept, 3u);
  EXPECT_EQ(wrong_pixels(knot, planned.renderer(), view), 0u);
  planned.forget_view();
  planned.order(view);
  EXPECT_EQ(planned.statistics().kept, 3u);
}

Scene scene_of(const std::vector<glm::vec3>& places, AlphaMode mode) {
  const Mesh box = shapes::box();
  Scene scene;
  scene.materials.push_back({.material = {.base_colour = glm::vec4(1, 0.5f, 0, 0.5f), .alpha_mode = mode}});
  scene.meshes.push_back({.positions = box.positions, .triangles = box.triangles});
  for (const glm::vec3& place : places) {
    SceneObject object;
    object.world[3] = glm::dvec4(glm::dvec3(place), 1);
    scene.objects.push_back(object);
  }
  return scene;
}

TEST(PlanScene, AnOpaqueSceneNeedsNothing) {
  const Result<Plan> plan = plan_scene(scene_of({{0, 0, 0}, {3, 0, 0}}, AlphaMode::opaque), quick);
  ASSERT_TRUE(plan.ok());
  EXPECT_EQ(plan.value().blended_objects, 0u);
  EXPECT_EQ(plan.value().objects.size(), 2u);
  EXPECT_TRUE(leaves_out(plan.value().whole, "sorting"));
}

TEST(PlanScene, TellsEachObjectsNeedsAndWhetherTheyOverlap) {
  const Result<Plan> one = plan_scene(scene_of({{0, 0, 0}}, AlphaMode::blend), quick);
  ASSERT_TRUE(one.ok());
  EXPECT_EQ(one.value().most_overlapping, 1u);
  EXPECT_TRUE(leaves_out(one.value().whole, "an order of objects"));

  const Result<Plan> three = plan_scene(scene_of({{0, 0, 0}, {0.5f, 0, 0}, {40, 0, 0}}, AlphaMode::blend), quick);
  ASSERT_TRUE(three.ok());
  EXPECT_GE(three.value().most_overlapping, 2u);
  EXPECT_FALSE(leaves_out(three.value().whole, "an order of objects"));
  for (const MeshPlan& object : three.value().objects) {
    EXPECT_EQ(object.strategy.name(), "separate_culling_pass");
    EXPECT_EQ(object.facets, 12u);
  }
}

}  // namespace
}  // namespace facetsort
