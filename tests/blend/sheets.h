// Layers worked out by hand: triangles that cover all of a small picture, seen from +z.
#pragma once

#include <glm/glm.hpp>
#include <numeric>
#include <span>
#include <vector>

#include "facetsort/blend/rasteriser.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

// The eye's height over z = 0.
inline constexpr float sheets_eye = 10;

inline View sheets_view(int width = 5, int height = 3, Projection projection = Projection::perspective) {
  View view;
  view.eye = {0, 0, sheets_eye};
  view.projection = projection;
  view.width = width;
  view.height = height;
  return view;
}

// Facet i at distance distances[i] from the eye.
inline Mesh sheets(std::span<const float> distances) {
  Mesh mesh;
  for (const float distance : distances) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const glm::vec2& corner : {glm::vec2(-500, -500), glm::vec2(1500, -500), glm::vec2(-500, 1500)}) {
      mesh.positions.emplace_back(corner, sheets_eye - distance);
    }
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

// A facet of a picture of sheets.
struct Sheet {
  float distance;
  glm::vec3 straight;
  float alpha;

  glm::vec4 premultiplied() const { return {straight * alpha, alpha}; }
};

inline std::vector<glm::vec4> colours_of(std::span<const Sheet> layers) {
  std::vector<glm::vec4> colours;
  for (const Sheet& sheet : layers) colours.push_back(sheet.premultiplied());
  return colours;
}

inline Mesh mesh_of(std::span<const Sheet> layers) {
  std::vector<float> distances;
  for (const Sheet& sheet : layers) distances.push_back(sheet.distance);
  return sheets(distances);
}

inline std::vector<std::uint32_t> index_order(std::size_t facets) {
  std::vector<std::uint32_t> order(facets);
  std::iota(order.begin(), order.end(), 0u);
  return order;
}

// Drawn in the order in which they are listed.
inline Image draw_sheets(std::span<const Sheet> layers, const View& view, OrderIndependent method, int count,
                         const glm::vec4& clear_colour = {0, 0, 0, 1}, PixelFormat format = PixelFormat::rgba32f) {
  const Mesh mesh = mesh_of(layers);
  Image image;
  Rasteriser().draw_order_independent(mesh.view(), view, index_order(layers.size()), colours_of(layers), method, count,
                                      clear_colour, format, image);
  return image;
}

}  // namespace facetsort
