// All that is vectorised in blend, compiled once for each instruction set; the best that the processor has is used.
#include "facetsort/blend/facet_kernels.h"
#include "facetsort/blend/tile_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/blend/kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: foreach_target.h before highway.h.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include "facetsort/blend/colour_facets-inl.h"
#include "facetsort/blend/covered_rows-inl.h"
#include "facetsort/blend/draw_tile-inl.h"
#include "facetsort/blend/moment_based-inl.h"
#include "facetsort/blend/multi_layer-inl.h"
#include "facetsort/blend/opaque_tile-inl.h"
#include "facetsort/blend/peel_tile-inl.h"
#include "facetsort/blend/place_facets-inl.h"
#include "facetsort/blend/project_vertices-inl.h"
#include "facetsort/blend/stochastic-inl.h"
#include "facetsort/blend/weighted_blended-inl.h"

HWY_BEFORE_NAMESPACE();
namespace facetsort::blend_internal::HWY_NAMESPACE {

void CollectTile(const ProjectedMesh& projected, const FacetBins& bins, int tile,
                 std::vector<TileFragment>& fragments) {
  const int x0 = bins.tile_x(tile), y0 = bins.tile_y(tile);
  for (const BinEntry& entry : bins.tile(tile)) {
    for_covered_rows(projected, bins, entry, x0, y0, [&](int y, RowBits bits) {
      for (; bits != 0; bits &= bits - 1) {
        const int x = std::countr_zero(bits);
        const PixelDepth depth = depth_at_pixel(projected, entry.facet, entry.facing(), x0 + x, y0 + y);
        fragments.push_back(
            {entry.facet, static_cast<std::uint16_t>(y * tile_size + x), static_cast<float>(depth.error), depth.depth});
      }
    });
  }
}

}  // namespace facetsort::blend_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::blend_internal {

HWY_EXPORT(DrawTile);
HWY_EXPORT(StartDrawing);
HWY_EXPORT(DrawPassInTile);
HWY_EXPORT(FinishDrawing);
HWY_EXPORT(DrawOpaqueTile);
HWY_EXPORT(StartPeeling);
HWY_EXPORT(PeelTile);
HWY_EXPORT(FinishPeeling);
HWY_EXPORT(DrawWeightedBlended);
HWY_EXPORT(DrawMomentBased);
HWY_EXPORT(DrawMultiLayer);
HWY_EXPORT(DrawStochastic);
HWY_EXPORT(CollectTile);
HWY_EXPORT(ProjectVertices);
HWY_EXPORT(PlaceFacets);
HWY_EXPORT(ColourFacets);

void draw_tile(const TileTask& task, std::span<const DrawPass> passes, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawTile)(task, passes, tile);
}

void start_drawing(const TileTask& task, DrawnTile& drawn) {
  HWY_DYNAMIC_DISPATCH(StartDrawing)(task, drawn);
}

void draw_pass(const TileTask& task, const DrawPass& pass, int tile, DrawnTile& drawn) {
  HWY_DYNAMIC_DISPATCH(DrawPassInTile)(task, pass, tile, drawn);
}

void finish_drawing(const TileTask& task, int tile, const DrawnTile& drawn) {
  HWY_DYNAMIC_DISPATCH(FinishDrawing)(task, tile, drawn);
}

void draw_opaque_tile(const TileTask& task, int tile, DrawnTile& drawn) {
  HWY_DYNAMIC_DISPATCH(DrawOpaqueTile)(task, tile, drawn);
}

void start_peeling(const TileTask& task, int tile, PeeledTile& peeled) {
  HWY_DYNAMIC_DISPATCH(StartPeeling)(task, tile, peeled);
}

bool peel_tile(const TileTask& task, Peeling peeling, int tile, PeeledTile& peeled) {
  return HWY_DYNAMIC_DISPATCH(PeelTile)(task, peeling, tile, peeled);
}

void finish_peeling(const TileTask& task, int tile, PeeledTile& peeled) {
  HWY_DYNAMIC_DISPATCH(FinishPeeling)(task, tile, peeled);
}

void draw_weighted_blended(const TileTask& task, const DepthRange& range, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawWeightedBlended)(task, range, tile);
}

void draw_moment_based(const TileTask& task, const DepthRange& range, int moments, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawMomentBased)(task, range, moments, tile);
}

void draw_multi_layer(const TileTask& task, std::span<KeptLayer> layers, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawMultiLayer)(task, layers, tile);
}

void draw_stochastic(const TileTask& task, const SampleMasks& masks, std::span<SampleVector> depths, int tile) {
  HWY_DYNAMIC_DISPATCH(DrawStochastic)(task, masks, depths, tile);
}

void collect_tile(const ProjectedMesh& projected, const FacetBins& bins, int tile,
                  std::vector<TileFragment>& fragments) {
  HWY_DYNAMIC_DISPATCH(CollectTile)(projected, bins, tile, fragments);
}

void project_vertices(ProjectedMesh& projected, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(ProjectVertices)(projected, begin, end);
}

void place_facets(const ProjectedMesh& projected, std::size_t begin, std::size_t end, PlacedFacet* placed) {
  HWY_DYNAMIC_DISPATCH(PlaceFacets)(projected, begin, end, placed);
}

void colour_facets(const MeshView& mesh, const glm::vec4& homogeneous_eye, std::size_t begin, std::size_t end,
                   glm::vec4* colours) {
  HWY_DYNAMIC_DISPATCH(ColourFacets)(mesh, homogeneous_eye, begin, end, colours);
}

}  // namespace facetsort::blend_internal
#endif
