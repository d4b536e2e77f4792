#include "facetsort/blend/view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace facetsort {
namespace {

constexpr Projection projections[] = {Projection::perspective, Projection::orthographic};

View oblique_view(Projection projection) {
  View view;
  view.eye = {3, -2, 5};
  view.at = {0.5f, 0.25f, -1};
  view.up = {0.2f, 1, 0.1f};
  view.projection = projection;
  view.width = 40;
  view.height = 30;
  return view;
}

glm::dvec2 pixel_of(const Camera& camera, const glm::dvec3& point) {
  const glm::dvec3 p = camera.project(point);
  return {p.x / p.z, p.y / p.z};
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

TEST(Camera, ProjectsEachRayOntoItsPixelCentre) {
  for (const Projection projection : projections) {
    const Camera camera(oblique_view(projection));
    for (int y = 0; y < 30; ++y) {
      for (int x = 0; x < 40; ++x) {
        const Ray ray = camera.pixel_ray(x, y);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-15);
        for (const double t : {0.5, 7.0}) {
          const glm::dvec3 point = ray.origin + t * ray.direction;
          const glm::dvec2 pixel = pixel_of(camera, point);
          EXPECT_NEAR(pixel.x, x + 0.5, 1e-12);
          EXPECT_NEAR(pixel.y, y + 0.5, 1e-12);
          const double along_axis = glm::dot(point - camera.eye, camera.forward);
          EXPECT_NEAR(camera.project(point).z, projection == Projection::perspective ? along_axis : 1, 1e-14);
        }
      }
    }
  }
}

TEST(Camera, HasAnOrthonormalFrame) {
  for (const Projection projection : projections) {
    const Camera camera(oblique_view(projection));
    EXPECT_NEAR(glm::dot(camera.right, camera.down), 0, 1e-15);
    EXPECT_NEAR(glm::dot(camera.right, camera.forward), 0, 1e-15);
    EXPECT_NEAR(glm::length(camera.right), 1, 1e-15);
    expect_near(glm::cross(camera.forward, camera.right), camera.down, 1e-15);
  }
}

TEST(Camera, PutsRightOnTheRightAndUpOnTop) {
  for (const Projection projection : projections) {
    View view;
    view.projection = projection;
    const Camera camera(view);
    EXPECT_EQ(pixel_of(camera, {0, 0, 0}), glm::dvec2(256, 256));
    EXPECT_GT(pixel_of(camera, {0.5, 0, 0}).x, 300);
    EXPECT_EQ(pixel_of(camera, {0.5, 0, 0}).y, 256);
    EXPECT_LT(pixel_of(camera, {0, 0.5, 0}).y, 200);
  }
}

TEST(Camera, FillsThePictureWithTheStatedHeight) {
  View view;
  view.vertical_fov_degrees = 90;  // at distance 3, 6 high
  view.width = 200;
  view.height = 100;
  EXPECT_NEAR(pixel_of(Camera(view), {0, 3, 0}).y, 0, 1e-12);
  EXPECT_NEAR(pixel_of(Camera(view), {6, -3, 0}).y, 100, 1e-12);
  EXPECT_NEAR(pixel_of(Camera(view), {6, -3, 0}).x, 200, 1e-12);

  view.projection = Projection::orthographic;
  view.height_in_units = 8;
  EXPECT_NEAR(pixel_of(Camera(view), {-8, 4, 1}).y, 0, 1e-12);
  EXPECT_NEAR(pixel_of(Camera(view), {-8, 4, 1}).x, 0, 1e-12);
}

TEST(Camera, FindsAnUpWhereTheGivenOneIsAlongTheView) {
  View view;
  view.eye = {1, 7, 2};
  view.at = {1, -3, 2};
  EXPECT_EQ(Camera(view).down, glm::dvec3(0, 0, -1));
  view.up = {0, -2, 0};
  EXPECT_EQ(Camera(view).down, glm::dvec3(0, 0, -1));
  view.up = {0, 0, 0};
  EXPECT_EQ(Camera(view).down, glm::dvec3(0, 0, -1));
  view.at = {1, 7, -3};  // along z, up too
  view.up = {0, 0, 1};
  EXPECT_EQ(Camera(view).down, glm::dvec3(-1, 0, 0));
}

TEST(Camera, CutsNothingOffInOrthographicViews) {
  View view;
  view.near_distance = 0.25f;
  EXPECT_EQ(Camera(view).near_distance, 0.25);
  view.projection = Projection::orthographic;
  EXPECT_EQ(Camera(view).near_distance, 0);
}

TEST(Camera, ScalesByPowersOfTwoToTheBit) {
  for (const Projection projection : projections) {
    const View view = oblique_view(projection);
    const Camera camera(view);
    for (const int exponent : {-120, -100, 100, 120}) {
      const float scale = std::ldexp(1.0f, exponent);
      View scaled = view;
      scaled.eye *= scale;
      scaled.at *= scale;
      scaled.height_in_units *= scale;
      const glm::dvec3 point(0.3, -0.2, 0.7);
      EXPECT_EQ(pixel_of(Camera(scaled), std::ldexp(1.0, exponent) * point), pixel_of(camera, point));
    }
  }
}

TEST(View, GivesTheSortItsEye) {
  View view = oblique_view(Projection::perspective);
  EXPECT_EQ(view.homogeneous_eye(), glm::vec4(3, -2, 5, 1));
  expect_near(view.forward(), glm::normalize(glm::dvec3(-2.5, 2.25, -6)), 1e-7);
  view.projection = Projection::orthographic;
  EXPECT_EQ(view.homogeneous_eye(), glm::vec4(2.5f, -2.25f, 6, 0));
}

TEST(View, IsRefusedWithTheReason) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  constexpr float largest = std::numeric_limits<float>::max();
  View good;
  EXPECT_TRUE(validate(good).ok());
  const auto expect_refused = [&](const char* word, auto change) {
    View view = good;
    change(view);
    const Status status = validate(view);
    EXPECT_EQ(status.fault, Fault::bad_argument) << word;
    EXPECT_NE(status.message.find(word), std::string::npos) << status.message;
  };
  expect_refused("eye", [&](View& v) { v.eye.y = nan; });
  expect_refused("looked at", [&](View& v) { v.at.z = infinity; });
  expect_refused("up", [&](View& v) { v.up.x = nan; });
  expect_refused("at the point", [&](View& v) { v.at = v.eye; });
  expect_refused("too far", [&](View& v) {
    v.eye.x = largest;
    v.at.x = -largest;
  });
  expect_refused("field of view", [&](View& v) { v.vertical_fov_degrees = 0; });
  expect_refused("field of view", [&](View& v) { v.vertical_fov_degrees = 180; });
  expect_refused("field of view", [&](View& v) { v.vertical_fov_degrees = nan; });
  expect_refused("near", [&](View& v) { v.near_distance = -1; });
  expect_refused("near", [&](View& v) { v.near_distance = infinity; });
  expect_refused("no pixels", [&](View& v) { v.width = 0; });
  expect_refused("no pixels", [&](View& v) { v.height = -5; });
  expect_refused("2^30", [&](View& v) { v.width = v.height = 1 << 16; });
  good.projection = Projection::orthographic;
  good.vertical_fov_degrees = 0;  // not used there
  EXPECT_TRUE(validate(good).ok());
  expect_refused("height", [&](View& v) { v.height_in_units = 0; });
  expect_refused("height", [&](View& v) { v.height_in_units = infinity; });
}

TEST(Views, LieEvenlyOnTheFibonacciSphere) {
  expect_near(fibonacci_direction(0, 1), {0, 0, 1}, 0);
  constexpr int n = 200;
  std::vector<glm::dvec3> directions;
  glm::dvec3 sum(0);
  for (int i = 0; i < n; ++i) {
    directions.push_back(fibonacci_direction(i, n));
    EXPECT_NEAR(glm::length(directions.back()), 1, 1e-15);
    EXPECT_EQ(directions.back().y, 1 - (2.0 * i + 1) / n);
    sum += directions.back();
  }
  EXPECT_LT(glm::length(sum), 1);
  // Evenly spread points would be about sqrt(4 pi / n) = 0.25 apart.
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) EXPECT_GT(glm::length(directions[i] - directions[j]), 0.15);
}

TEST(Views, LookAtTheBoxFromAllAround) {
  const Box bounds{{-1, 2, 3}, {3, 4, 7}};  // radius 3
  for (const Projection projection : projections) {
    const std::vector<View> views = views_around(bounds, 10, 2.5f, projection);
    ASSERT_EQ(views.size(), 10u);
    for (int i = 0; i < 10; ++i) {
      EXPECT_TRUE(validate(views[i]).ok());
      EXPECT_EQ(views[i].projection, projection);
      EXPECT_EQ(views[i].at, glm::vec3(1, 3, 5));
      EXPECT_FLOAT_EQ(views[i].height_in_units, 6);
      EXPECT_FLOAT_EQ(views[i].near_distance, 3e-4f);
      expect_near(glm::dvec3(views[i].eye - views[i].at) / 7.5, fibonacci_direction(i, 10), 1e-6);
    }
  }
}

TEST(Views, CanBeTakenFromTheCentreAndOfAPoint) {
  const Box bounds{{1, 1, 1}, {3, 3, 3}};
  const View from_centre = default_view(bounds, {2, 2, 2});
  EXPECT_TRUE(validate(from_centre).ok());
  EXPECT_EQ(from_centre.forward(), glm::vec3(0, 0, -1));

  const Box point{{1, 1, 1}, {1, 1, 1}};
  for (const View& view : views_around(point, 3, 2, Projection::orthographic)) {
    EXPECT_TRUE(validate(view).ok());
    EXPECT_EQ(view.height_in_units, 2);
  }
}

TEST(Views, OfACubeSeeEachDirectionOnce) {
  for (const glm::vec3 eye : {glm::vec3(0.1f, 0.2f, -0.3f), glm::vec3(1e6f, 3, -2e7f)}) {
    const std::vector<View> views = cube_views({{-1, -1, -1}, {1, 1, 1}}, eye);
    ASSERT_EQ(views.size(), 6u);
    const glm::vec3 axes[] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    for (int i = 0; i < 6; ++i) EXPECT_EQ(views[i].forward(), axes[i]);
    for (int i = 0; i < 500; ++i) {
      int seen = 0;
      for (const View& view : views) {
        const Camera camera(view);
        const glm::dvec3 p = camera.project(glm::dvec3(eye) + fibonacci_direction(i, 500));
        seen += p.z > 0 && p.x >= 0 && p.x < 512 * p.z && p.y >= 0 && p.y < 512 * p.z;
      }
      EXPECT_EQ(seen, 1) << i;
    }
  }
}

TEST(Views, InsideStartFromEyesSpreadWithinTheBox) {
  const Box box{{1, 1, 1}, {3, 5, 9}};
  const std::vector<View> views = views_inside(box, 5);
  ASSERT_EQ(views.size(), 30u);
  for (int i = 0; i < 5; ++i) {
    const glm::vec3 eye = views[6 * i].eye;
    const glm::dvec3 direction = (glm::dvec3(eye) - glm::dvec3(2, 3, 5)) / glm::dvec3(0.5, 1, 2);
    EXPECT_LT(glm::length(direction - fibonacci_direction(i, 5)), 1e-6) << i;
    const std::vector<View> faces = cube_views(box, eye);
    for (int face = 0; face < 6; ++face) {
      EXPECT_EQ(views[6 * i + face].eye, eye);
      EXPECT_EQ(views[6 * i + face].forward(), faces[face].forward());
      EXPECT_TRUE(validate(views[6 * i + face]).ok());
    }
  }
}

}  // namespace
}  // namespace facetsort
