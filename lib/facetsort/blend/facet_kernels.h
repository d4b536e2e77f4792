// Internal to blend: what is done to every vertex and facet of a mesh for a view, vectorised, for the best instruction
// set at run time.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

#include "facetsort/blend/coverage.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::blend_internal {

// How it is decided which pixels a facet or piece covers.
enum class Coverage : std::uint32_t {
  none,         // it covers no pixel's centre
  known,        // it is small, and its pixels are listed
  grid,         // all corners are on the grid: by edge functions of grid points, where those are certain
  homogeneous,  // by homogeneous edge functions: pieces of larger facets, and facets off the grid or of doubtful facing
};

// The first `count` columns, or rows, of a square; 0 <= count <= 8.
inline PixelSquare first_columns(int count) {
  return 0x0101010101010101u * ((1u << count) - 1u);
}
inline PixelSquare first_rows(int count) {
  return count == square_size ? ~PixelSquare{0} : (PixelSquare{1} << (square_size * count)) - 1;
}

// A facet in a picture: 16 bytes, as it is looked up in the order in which facets are drawn. A picture's sides are less
// than 2^30.
struct PlacedFacet {
  std::uint32_t x : 30, coverage : 2;  // the first column and row of the box that holds its pixels
  std::uint32_t y : 30, is_front : 1, crosses_near : 1;
  std::uint64_t pixels;  // Coverage::known: a PixelSquare; otherwise the box's width - 1, and above it its height - 1

  int facing() const { return is_front ? 1 : -1; }
  Coverage how() const { return static_cast<Coverage>(coverage); }
  PixelBox box() const;

  static PlacedFacet nothing() { return {0, 0, 0, 0, 0, 0}; }
  static PlacedFacet with_pixels(int x, int y, int facing, PixelSquare square);
  static PlacedFacet with_box(Coverage how, const PixelBox& box, int facing);
};

// How far an edge function of grid points may be from the true one, in square pixels. With S for the sum of the facet's
// extents and d for a unit of the grid, corners that are off by up to d change the cross product of an edge and the way
// from its start to a pixel in the facet's box by at most 4 d S. Float adds less than 2^-19 S^2, by at most 20
// roundings of terms whose sum is below S^2.
inline constexpr float grid_error_of_extents = 0x1p-14f, grid_error_of_square = 0x1p-19f;
inline constexpr float grid_extents_slack = 0x1p-10f;  // added to S, covers terms in the square of d
inline float grid_error(float extents) {
  extents += grid_extents_slack;
  return extents * (grid_error_of_extents + extents * grid_error_of_square);
}

// Facets that a kernel works on at a time: corners are first gathered, then all is done in whole vectors.
inline constexpr std::size_t facets_per_block = 64;

// Writes vertices and grid points from `begin` to before `end`; all else of `projected` must be there.
void project_vertices(ProjectedMesh& projected, std::size_t begin, std::size_t end);

// Places the facets with ids from `begin` to before `end`.
void place_facets(const ProjectedMesh& projected, std::size_t begin, std::size_t end, PlacedFacet* placed);

// What headlight() and default_facet_colour() are made of.
inline constexpr float ambient_light = 0.25f, diffuse_light = 0.75f;
inline constexpr float default_hue_step = 6.0f / 0x1p16f;

// facet_colour() of the facets with ids from `begin` to before `end`, to the bit.
void colour_facets(const MeshView& mesh, const glm::vec4& homogeneous_eye, std::size_t begin, std::size_t end,
                   glm::vec4* colours);

inline PixelBox PlacedFacet::box() const {
  PixelBox box{static_cast<int>(x), static_cast<int>(y), static_cast<int>(x), static_cast<int>(y), crosses_near != 0};
  if (how() == Coverage::known) {
    PixelSquare columns = pixels | pixels >> 32;
    columns |= columns >> 16;
    columns |= columns >> 8;
    box.x1 += 63 - std::countl_zero(columns & first_rows(1));
    box.y1 += (63 - std::countl_zero(pixels)) / square_size;
  } else {
    box.x1 += static_cast<int>(pixels & 0xffffffffu);
    box.y1 += static_cast<int>(pixels >> 32);
  }
  return box;
}

inline PlacedFacet PlacedFacet::with_pixels(int x, int y, int facing, PixelSquare square) {
  constexpr std::uint32_t coordinate = 0x3fffffffu;
  return {static_cast<std::uint32_t>(x) & coordinate,
          static_cast<std::uint32_t>(Coverage::known),
          static_cast<std::uint32_t>(y) & coordinate,
          facing > 0,
          false,
          square};
}

inline PlacedFacet PlacedFacet::with_box(Coverage how, const PixelBox& box, int facing) {
  const auto width_less_one = static_cast<std::uint32_t>(box.x1 - box.x0);
  const auto height_less_one = static_cast<std::uint32_t>(box.y1 - box.y0);
  PlacedFacet placed = with_pixels(box.x0, box.y0, facing, width_less_one | std::uint64_t{height_less_one} << 32);
  placed.coverage = static_cast<std::uint32_t>(how) & 3u;
  placed.crosses_near = box.crosses_near;
  return placed;
}

}  // namespace facetsort::blend_internal
