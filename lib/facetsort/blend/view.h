// Cameras: what the user says (View), what the stages compute with (Camera), and the sets of views that comparisons use.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/facets/facets.h"

namespace facetsort {

enum class Projection { perspective, orthographic };

// Coordinates in the mesh's space and units. Float, so that what the sort sees and what is drawn is the same eye.
struct View {
  glm::vec3 eye{0, 0, 3};
  glm::vec3 at{0, 0, 0};
  glm::vec3 up{0, 1, 0};  // need not be perpendicular to the view; 0,0,1 stands in where it is along the view
  Projection projection = Projection::perspective;
  float vertical_fov_degrees = 45;  // perspective: (0, 180)
  float height_in_units = 2;        // orthographic: height of the picture in the mesh's units
  float near_distance = 1e-4f;      // along the camera axis; nearer fragments are not drawn (perspective only)
  int width = 512, height = 512;    // pixels

  // What a sort needs: (eye, 1) in perspective; (eye - at, 0), the direction towards the viewer, in orthographic.
  glm::vec4 homogeneous_eye() const;
  // Unit vector from the eye into the picture.
  glm::vec3 forward() const;
};

// Checks what every stage takes for granted of a view; the fault is bad_argument. Refused: an eye, target or up that is
// not finite, an eye at its target, a field of view outside (0, 180), a height that is not above 0, a negative near
// distance, a picture of no or of more than 2^30 pixels.
Status validate(const View& view);

// A ray through a pixel centre, in double: points are origin + t * direction; t is the distance from the eye
// (perspective) or from the plane through the eye across the view (orthographic) when direction is a unit vector.
struct Ray {
  glm::dvec3 origin;
  glm::dvec3 direction;  // unit
};

// The projection to homogeneous pixels: a point p has (X, Y, W) = (dot(row_x, p - eye), dot(row_y, p - eye),
// dot(row_w, p - eye)) + offset, and appears at pixel coordinates (X / W, Y / W) where W > 0, x to the right, y down,
// pixel (i, j) having its centre at (i + 1/2, j + 1/2). W is the distance along the camera axis in perspective and 1
// in orthographic views.
struct Camera {
  // Precondition: validate(view) is ok.
  explicit Camera(const View& view);

  glm::dvec3 eye;
  glm::dvec3 right, down, forward;  // orthonormal up to rounding
  glm::dvec3 row_x, row_y, row_w, offset;
  double near_distance;             // 0 in orthographic views: nothing is cut off
  bool perspective;
  int width, height;

  glm::dvec3 project(const glm::dvec3& point) const;
  Ray pixel_ray(int x, int y) const;

 private:
  double pixels_per_unit_;  // at distance 1 (perspective) or anywhere (orthographic)
};

// Point i of n on the Fibonacci sphere: y = 1 - (2 i + 1) / n, azimuth = i * pi * (3 - sqrt 5),
// (sin(azimuth) * sqrt(1 - y^2), y, cos(azimuth) * sqrt(1 - y^2)).
glm::dvec3 fibonacci_direction(int i, int n);

// A view of `bounds` from `eye` with the project's defaults: at the box's centre, up 0,1,0, 45 degrees, 512 x 512,
// near plane at 1e-4 radii, orthographic height 2 radii. An eye at the centre looks down -z; a box that is a point
// counts as one of radius 1.
View default_view(const Box& bounds, const glm::vec3& eye, Projection projection = Projection::perspective);

// n eyes on the Fibonacci sphere at `radii` bounding radii from the box's centre, each looking at it.
std::vector<View> views_around(const Box& bounds, int n, float radii, Projection projection);

// Six views of 90 degrees from one eye, down the axes +x, -x, +y, -y, +z, -z: all that an eye inside a mesh sees.
std::vector<View> cube_views(const Box& bounds, const glm::vec3& eye);

// The cube_views() of n eyes within the box: points of the Fibonacci sphere, halfway from the centre to the faces.
std::vector<View> views_inside(const Box& bounds, int n);

}  // namespace facetsort
