// Internal to blend: what is done to one tile of the picture, vectorised, for the best instruction set at run time.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/bins.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/sample_masks.h"

namespace facetsort::blend_internal {

// One value a pixel of a tile, and four.
struct alignas(64) TilePlane {
  float pixel[tile_size * tile_size];
};
struct TileColours {
  TilePlane channel[4];
};

// What is drawn so far in one tile; colours in units of the format.
struct DrawnTile {
  TileColours colours;
  TilePlane depths;
};

struct TileTask {
  const ProjectedMesh& projected;
  const FacetBins& bins;
  std::span<const glm::vec4> colours;  // premultiplied, a facet; empty: the mesh's vertex colours
  glm::vec4 clear_colour;
  PixelFormat format;
  Image& image;
  // By tile, what draw_opaque_tile() has drawn there: the others draw over it, and not behind it. Empty: nothing.
  std::span<const DrawnTile> opaque = {};
};

// Clears one tile, runs every pass over what the bins have there, and writes the image's part.
void draw_tile(const TileTask& task, std::span<const DrawPass> passes, int tile);

// The same as draw_tile, a pass at a time: before the first; one over what the bins have there; after the last.
void start_drawing(const TileTask& task, DrawnTile& drawn);
void draw_pass(const TileTask& task, const DrawPass& pass, int tile, DrawnTile& drawn);
void finish_drawing(const TileTask& task, int tile, const DrawnTile& drawn);

// Clears one tile and draws the nearest of what the bins have there, depths being ScreenDepth.
void draw_opaque_tile(const TileTask& task, int tile, DrawnTile& drawn);

// What depth peeling has found in one tile so far; colours in units of the format.
struct PeeledTile {
  TileColours front;          // layers peeled from the front, blended
  TileColours back;           // layers peeled from the back, blended over what is opaque, or the clear colour
  TilePlane nearest, farthest;  // layers strictly between these are left
};

// Before the first pass.
void start_peeling(const TileTask& task, int tile, PeeledTile& peeled);
// One pass over what the bins have in a tile. Returns whether another one is needed.
bool peel_tile(const TileTask& task, Peeling peeling, int tile, PeeledTile& peeled);
// After the last pass: writes the image's part.
void finish_peeling(const TileTask& task, int tile, PeeledTile& peeled);

// The mesh's nearest and farthest vertex along the camera axis; in perspective no nearer than the near plane.
struct DepthRange {
  float nearest, farthest;
  bool perspective;

  // A distance along the camera axis as a depth buffer has it: see ScreenDepth.
  float screen_depth(float distance) const { return perspective ? -1 / distance : distance; }
};

void draw_weighted_blended(const TileTask& task, const DepthRange& range, int tile);

// `moments`: 4 or 6.
void draw_moment_based(const TileTask& task, const DepthRange& range, int moments, int tile);

// A fragment, or several blended, that multi-layer alpha blending keeps.
struct KeptLayer {
  float depth;  // see ScreenDepth
  glm::vec4 colour;
};
// `layers`: scratch, for as many layers a pixel as it has room for in all of a tile's, at most most_kept_layers.
void draw_multi_layer(const TileTask& task, std::span<KeptLayer> layers, int tile);

// Depths of some of the samples of a pixel.
inline constexpr int samples_per_vector = 16;
struct alignas(64) SampleVector {
  float depth[samples_per_vector];
};
// `depths`: scratch, for all the samples of each of a tile's pixels.
void draw_stochastic(const TileTask& task, const SampleMasks& masks, std::span<SampleVector> depths, int tile);

// A fragment in a tile, pixel = y * tile_size + x.
struct TileFragment {
  std::uint32_t facet;
  std::uint16_t pixel;
  float depth_error;
  double depth;
};

// Appends the tile's fragments in the order of the bins. Fragments nearer than the near plane are left out, as in
// draw_tile.
void collect_tile(const ProjectedMesh& projected, const FacetBins& bins, int tile,
                  std::vector<TileFragment>& fragments);

}  // namespace facetsort::blend_internal
