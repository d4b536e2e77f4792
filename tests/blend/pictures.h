// Views, colours and comparisons that tests of pictures share.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <glm/glm.hpp>

#include "facetsort/blend/image.h"
#include "facetsort/blend/view.h"
#include "facetsort/facets/facets.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

inline constexpr glm::vec3 red(1, 0, 0), green(0, 1, 0), blue(0, 0, 1);

inline View sized(View view, int width, int height) {
  view.width = width;
  view.height = height;
  return view;
}

// From 2.5 radii of the mesh's bounding sphere, askew to the axes.
inline View view_of(const Mesh& mesh, Projection projection = Projection::perspective, int size = 128) {
  const Box box = facet_bounds(mesh.view());
  const glm::vec3 eye = box.centre() + 2.5f * box.radius() * glm::vec3(0.48f, 0.36f, 0.8f);
  return sized(default_view(box, eye, projection), size, size);
}

// Vertex colours and alphas that differ over the mesh.
inline Mesh with_vertex_colours(Mesh mesh) {
  for (const glm::vec3& position : mesh.positions) {
    const glm::vec3 wave = 0.5f + 0.5f * glm::sin(position * 5.0f);
    mesh.vertex_colours.emplace_back(wave, 0.2f + 0.6f * wave.x);
  }
  return mesh;
}

inline void expect_colour(const Image& image, const glm::vec4& expected, float tolerance = 1e-5f) {
  ASSERT_FALSE(image.pixels.empty());
  for (const glm::vec4& pixel : image.pixels) {
    for (int k = 0; k < 4; ++k) ASSERT_NEAR(pixel[k], expected[k], tolerance) << "channel " << k;
  }
}

// Pixels that differ by more than the tolerance in some channel.
inline std::size_t pixels_off(const Image& a, const Image& b, float tolerance = 1e-4f) {
  std::size_t off = 0;
  for (std::size_t pixel = 0; pixel < a.pixels.size(); ++pixel) {
    const glm::vec4 difference = glm::abs(a.pixels[pixel] - b.pixels[pixel]);
    off += std::max({difference.r, difference.g, difference.b, difference.a}) > tolerance;
  }
  return off;
}

}  // namespace facetsort
