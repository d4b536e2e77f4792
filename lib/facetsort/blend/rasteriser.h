// The software blend target: a tiled, vectorised rasteriser that blends facets in the order it is given.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "facetsort/blend/image.h"
#include "facetsort/blend/view.h"
#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

enum class Cull { none, back_faces, front_faces };
enum class DepthTest { off, less, less_or_equal };

// One run over facets, with the fixed state of a graphics pipeline.
struct DrawPass {
  Cull cull = Cull::none;
  DepthTest depth_test = DepthTest::off;  // against float32 depth, cleared before the first pass
  bool depth_write = false;
  bool colour_write = true;  // premultiplied source-over
};

// Facets and pieces drawn with one state, in their order.
struct DrawBatch {
  std::span<const std::uint32_t> order;
  DrawPass pass;
};

// Order-independent transparency by passes over the geometry, each of which keeps the next layers of every pixel, until
// nothing is left in any. Layers at the same float32 depth of a pixel can't be told apart: all but one are lost.
enum class Peeling {
  front_to_back,   // a layer each pass (Everitt 2001, "Interactive Order-Independent Transparency"); of layers at one
                   // depth the first in the order is kept
  from_both_ends,  // two layers each pass (Bavoil and Myers 2008, "Order Independent Transparency with Dual Depth
                   // Peeling"); of layers at one depth the larger value of each channel is kept, by MAX blending
};

struct DrawStatistics {
  std::size_t facets_drawn = 0;  // facets and pieces that were not culled and may cover a pixel, over all passes
  int passes = 0;                // over the geometry
};

// Draws meshes into pictures. Coverage is exact and watertight: a facet covers a pixel if and only if the ray through
// the pixel's centre meets it, edges and corners by the top-left rule, so facets that share an edge cover each pixel
// exactly once, and so do the pieces of a facet (homogeneous edge functions as in Olano and Greer 1997, "Triangle Scan
// Conversion using 2D Homogeneous Coordinates", so no facet is clipped or snapped to a grid; a filter in float, then in
// double, then exact integers). Within a pixel facets are blended in the order given; the picture is the same for any
// thread count and instruction set. Keeps its scratch: drawing again allocates nothing once the largest frame was seen,
// but for what exact integers of extreme magnitude take.
//
// One thread at a time; works in parallel in the caller's task arena.
class Rasteriser {
 public:
  Rasteriser();
  Rasteriser(Rasteriser&&) noexcept;
  Rasteriser& operator=(Rasteriser&&) noexcept;
  ~Rasteriser();

  // Clears `image` to `clear_colour` (premultiplied), of the view's size and `format`, and runs the passes.
  // `order`: draw ids (see Pieces) in draw order: facets and, where there are any, pieces of them; all or some;
  // repeated ids are drawn again.
  // `colours`: premultiplied colour of each facet by id (see facet_colours), or empty to shade each fragment (see
  // fragment_colour), which a mesh without colours and materials can't. Facets of single-sided materials are not drawn
  // where they are seen from behind; neither colour nor depth is written where a material leaves a fragment out.
  DrawStatistics draw(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                      std::span<const glm::vec4> colours, std::span<const DrawPass> passes,
                      const glm::vec4& clear_colour, PixelFormat format, Image& image, const Pieces& pieces = {});

  // The same, batch after batch, over one depth buffer. The spans must hold still until it returns.
  DrawStatistics draw(const MeshView& mesh, const View& view, std::span<const DrawBatch> batches,
                      std::span<const glm::vec4> colours, const glm::vec4& clear_colour, PixelFormat format,
                      Image& image, const Pieces& pieces = {});

  // The same by depth peeling; the order only decides between layers at one depth. Every pass draws all of the picture,
  // as a graphics interface's passes do, however few of its pixels have layers left; only projecting is done once.
  // statistics.passes is what it took, the pass included that finds nothing. rgba8 rounds each layer, and each blend.
  DrawStatistics peel(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                      std::span<const glm::vec4> colours, Peeling peeling, const glm::vec4& clear_colour,
                      PixelFormat format, Image& image, const Pieces& pieces = {});

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace facetsort
