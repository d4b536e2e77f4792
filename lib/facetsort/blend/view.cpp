#include "facetsort/blend/view.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace facetsort {
namespace {

constexpr double degree = std::numbers::pi / 180;

bool is_finite(const glm::vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

// In double neither the square of the smallest nor that of the largest float leaves the range of normal numbers.
glm::dvec3 normalised(const glm::dvec3& v) {
  return v / std::sqrt(glm::dot(v, v));
}

// From the eye towards the target. An orthographic sort is given eye - at rounded to float, so the same rounded
// direction is drawn.
glm::dvec3 axis(const View& view) {
  if (view.projection == Projection::orthographic) return glm::dvec3(view.at - view.eye);
  return glm::dvec3(view.at) - glm::dvec3(view.eye);
}

glm::dvec3 rightwards(const glm::dvec3& forward, const glm::dvec3& up) {
  // Squared sine of the angle below which up counts as along the view: float input has no direction left there.
  constexpr double smallest_sine_squared = 1e-12;
  for (const glm::dvec3& candidate : {up, glm::dvec3(0, 0, 1), glm::dvec3(1, 0, 0)}) {
    const glm::dvec3 across = glm::cross(forward, candidate);
    if (glm::dot(across, across) > smallest_sine_squared * glm::dot(candidate, candidate)) return normalised(across);
  }
  assert(false);  // forward cannot be along z and x
  return {};
}

// A length that moves every coordinate of `from` when added to it.
float visible_step(const glm::vec3& from, float radius) {
  return std::max({radius, std::abs(from.x), std::abs(from.y), std::abs(from.z)});
}

float usable_radius(const Box& bounds) {
  const float radius = bounds.radius();
  return radius > 0 ? radius : 1.0f;
}

Status refuse(const char* message) {
  return {Fault::bad_argument, message};
}

}  // namespace

glm::vec4 View::homogeneous_eye() const {
  return projection == Projection::perspective ? glm::vec4(eye, 1) : glm::vec4(eye - at, 0);
}

glm::vec3 View::forward() const {
  return glm::vec3(normalised(axis(*this)));
}

Status validate(const View& view) {
  if (!is_finite(view.eye)) return refuse("view: the eye is not finite");
  if (!is_finite(view.at)) return refuse("view: the point looked at is not finite");
  if (!is_finite(view.up)) return refuse("view: the up direction is not finite");
  if (view.eye == view.at) return refuse("view: the eye is at the point it looks at");
  if (!is_finite(view.eye - view.at)) return refuse("view: the eye is too far from the point it looks at");
  if (view.projection == Projection::perspective) {
    if (!(view.vertical_fov_degrees > 0 && view.vertical_fov_degrees < 180))
      return refuse("view: the field of view is not between 0 and 180 degrees");
    if (!(view.near_distance > 0) || !std::isfinite(view.near_distance))
      return refuse("view: the near distance is not above 0, or not finite");
  } else if (!(view.height_in_units > 0) || !std::isfinite(view.height_in_units)) {
    return refuse("view: the height of the picture is not above 0");
  }
  if (view.width < 1 || view.height < 1) return refuse("view: the picture has no pixels");
  if (std::int64_t{view.width} * view.height > (std::int64_t{1} << 30))
    return refuse("view: the picture has more than 2^30 pixels");
  return {};
}

Camera::Camera(const View& view)
    : eye(view.eye), perspective(view.projection == Projection::perspective), width(view.width), height(view.height) {
  assert(validate(view).ok());
  forward = normalised(axis(view));
  right = rightwards(forward, glm::dvec3(view.up));
  down = glm::cross(forward, right);
  const double centre_x = 0.5 * width, centre_y = 0.5 * height;
  if (perspective) {
    pixels_per_unit_ = centre_y / std::tan(0.5 * degree * static_cast<double>(view.vertical_fov_degrees));
    row_x = pixels_per_unit_ * right + centre_x * forward;
    row_y = pixels_per_unit_ * down + centre_y * forward;
    row_w = forward;
    offset = glm::dvec3(0);
    near_distance = static_cast<double>(view.near_distance);
  } else {
    pixels_per_unit_ = height / static_cast<double>(view.height_in_units);
    row_x = pixels_per_unit_ * right;
    row_y = pixels_per_unit_ * down;
    row_w = glm::dvec3(0);
    offset = glm::dvec3(centre_x, centre_y, 1);
    near_distance = 0;
  }
}

glm::dvec3 Camera::project(const glm::dvec3& point) const {
  const glm::dvec3 p = point - eye;
  return glm::dvec3(glm::dot(row_x, p), glm::dot(row_y, p), glm::dot(row_w, p)) + offset;
}

Ray Camera::pixel_ray(int x, int y) const {
  const glm::dvec3 across = (x + 0.5 - 0.5 * width) * right + (y + 0.5 - 0.5 * height) * down;
  if (perspective) return {eye, normalised(across + pixels_per_unit_ * forward)};
  return {eye + across / pixels_per_unit_, forward};
}

glm::dvec3 fibonacci_direction(int i, int n) {
  assert(i >= 0 && i < n);
  const double y = 1 - (2.0 * i + 1) / n;
  const double azimuth = i * std::numbers::pi * (3 - std::sqrt(5.0));
  const double around = std::sqrt(1 - y * y);
  return {std::sin(azimuth) * around, y, std::cos(azimuth) * around};
}

View default_view(const Box& bounds, const glm::vec3& eye, Projection projection) {
  const float radius = usable_radius(bounds);
  View view;
  view.eye = eye;
  view.at = bounds.centre();
  if (view.at == eye) view.at.z -= visible_step(eye, radius);
  view.projection = projection;
  view.height_in_units = 2 * radius;
  view.near_distance = 1e-4f * radius;
  return view;
}

std::vector<View> views_around(const Box& bounds, int n, float radii, Projection projection) {
  const double distance = static_cast<double>(radii) * static_cast<double>(usable_radius(bounds));
  std::vector<View> views;
  views.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const glm::dvec3 eye = glm::dvec3(bounds.centre()) + distance * fibonacci_direction(i, n);
    views.push_back(default_view(bounds, glm::vec3(eye), projection));
  }
  return views;
}

std::vector<View> cube_views(const Box& bounds, const glm::vec3& eye) {
  const float step = visible_step(eye, usable_radius(bounds));
  std::vector<View> views;
  for (int direction = 0; direction < 3; ++direction) {
    for (const float sign : {1.0f, -1.0f}) {
      View view = default_view(bounds, eye);
      view.at = eye;
      view.at[direction] += sign * step;
      view.vertical_fov_degrees = 90;
      views.push_back(view);
    }
  }
  return views;
}

std::vector<View> views_inside(const Box& bounds, int n) {
  const glm::dvec3 halfway = (glm::dvec3(bounds.highest) - glm::dvec3(bounds.lowest)) / 4.0;
  std::vector<View> views;
  views.reserve(6 * static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const glm::vec3 eye(glm::dvec3(bounds.centre()) + halfway * fibonacci_direction(i, n));
    for (const View& view : cube_views(bounds, eye)) views.push_back(view);
  }
  return views;
}

}  // namespace facetsort
