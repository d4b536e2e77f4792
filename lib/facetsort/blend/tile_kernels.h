// Internal to blend: what is done to one tile of the picture, vectorised, for the best instruction set at run time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/bins.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/rasteriser.h"

namespace facetsort::blend_internal {

struct DrawTask {
  const ProjectedMesh& projected;
  std::span<const glm::vec4> colours;  // premultiplied, a facet; empty: the mesh's vertex colours
  std::span<const DrawPass> passes;
  glm::vec4 clear_colour;
  PixelFormat format;
  Image& image;
};

// Draws the tile whose upper left pixel is (x0, y0): clears, runs every pass over `entries`, writes the image's part.
void draw_tile(const DrawTask& task, std::span<const BinEntry> entries, int x0, int y0);

// A fragment in a tile, pixel = y * tile_size + x.
struct TileFragment {
  std::uint32_t facet;
  std::uint16_t pixel;
  float depth_error;
  double depth;
};

// Appends the tile's fragments in the order of `entries`. Fragments nearer than the near plane are left out, as in
// draw_tile.
void collect_tile(const ProjectedMesh& projected, std::span<const BinEntry> entries, int x0, int y0,
                  std::vector<TileFragment>& fragments);

}  // namespace facetsort::blend_internal
