// The software blend target: a tiled, vectorised rasteriser that blends facets in the order it is given.
#pragma once

#include <cstdint>
#include <limits>
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
enum class BlendMode {
  source_over,  // premultiplied
  additive,     // premultiplied colours are added, the target's alpha stays (Babylon.js ALPHA_ADD); needs no order
};

// One run over facets, with the fixed state of a graphics pipeline.
struct DrawPass {
  Cull cull = Cull::none;
  DepthTest depth_test = DepthTest::off;  // against float32 depth, cleared before the first pass
  bool depth_write = false;
  bool colour_write = true;
  BlendMode blend = BlendMode::source_over;

  bool operator==(const DrawPass&) const = default;
};

// Facets and pieces drawn with one state, in their order.
struct DrawBatch {
  std::span<const std::uint32_t> order;
  DrawPass pass;
  bool clear_depth = false;  // just before
};

// Order-independent transparency by passes over the geometry, each of which keeps the next layers of every pixel, until
// nothing is left in any. Layers at the same float32 depth of a pixel can't be told apart: all but one are lost.
enum class Peeling {
  front_to_back,   // a layer each pass (Everitt 2001, "Interactive Order-Independent Transparency"); of layers at one
                   // depth the first in the order is kept
  from_both_ends,  // two layers each pass (Bavoil and Myers 2008, "Order Independent Transparency with Dual Depth
                   // Peeling"); of layers at one depth the larger value of each channel is kept, by MAX blending
};

inline constexpr int no_pass_limit = std::numeric_limits<int>::max();

// Order-independent transparency in a fixed number of passes and fixed memory a pixel. The order decides nothing but how
// sums round, what is in front of layers at one depth, and which of more than K layers are merged. What is kept a pixel
// is float32 in both formats: rgba8 rounds once, at the end. The opacity of all layers together is always right.
enum class OrderIndependent {
  weighted,    // 1 pass: an average of the layers' colours, weighted by distance (McGuire and Bavoil 2013, "Weighted
               // Blended Order-Independent Transparency", equation 7 in units of a hundredth of the distance to the
               // mesh's farthest vertex); exact for one layer, and for layers of one straight colour
  moments,     // 2 passes: an average by the transmittance in front of each layer, found from 4 or 6 power moments of
               // absorbance over depth (Muenstermann et al. 2018, "Moment-Based Order-Independent Transparency", with
               // its constants); exact for 2 layers (6 moments: 3) of one alpha, but for a bias of a millionth
  layers,      // 1 pass: K layers a pixel, of more the farthest two merged (Salvi and Vaidyanathan 2014, "Multi-Layer
               // Alpha Blending"); exact for up to K layers
  stochastic,  // 2 passes: an average by the share of S depth samples a pixel before which each layer lies, covered at
               // random (Enderton et al. 2010, "Stochastic Transparency", alpha correction included); exact for one
               // layer, and right in the mean the nearer, the more samples
};
inline constexpr int most_kept_layers = 64, most_depth_samples = 64;

struct DrawStatistics {
  std::size_t facets_drawn = 0;  // facets and pieces that were not culled and may cover a pixel, over all passes
  int passes = 0;                // over the geometry
};

// For Pieces::measured, where pieces are drawn in several views: all of their cuts, 32 bytes each. Pictures are the
// same without. Parallel in the caller's task arena.
std::vector<MeasuredCut> measure_cuts(const MeshView& mesh, const Pieces& pieces);

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
  // Ends after `most_passes` that peel, at least 1, and loses what is left: the farthest layers, or the middle ones.
  // Peeling from both ends draws one more, the first, which only finds the ends: 5 give 10 layers, as in Babylon.js.
  // `opaque`: facets, none of the others, that a pass before all others draws, each pixel's nearest alone; what is
  // behind them is not drawn.
  DrawStatistics peel(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                      std::span<const glm::vec4> colours, Peeling peeling, const glm::vec4& clear_colour,
                      PixelFormat format, Image& image, const Pieces& pieces = {}, int most_passes = no_pass_limit,
                      std::span<const std::uint32_t> opaque = {});

  // The same without peeling. `count`: 4 or 6 moments; layers, up to most_kept_layers; samples, up to
  // most_depth_samples; of no meaning to weighted. `order`: facets alone. `opaque`: as of peel().
  DrawStatistics draw_order_independent(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                        std::span<const glm::vec4> colours, OrderIndependent method, int count,
                                        const glm::vec4& clear_colour, PixelFormat format, Image& image,
                                        std::span<const std::uint32_t> opaque = {});

 private:
  struct Scratch;
  std::unique_ptr<Scratch> scratch_;
};

}  // namespace facetsort
