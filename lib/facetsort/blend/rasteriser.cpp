#include "facetsort/blend/rasteriser.h"

#include <cassert>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/tile_kernels.h"

namespace facetsort {

struct Rasteriser::Scratch {
  blend_internal::ProjectedMesh projected;
  blend_internal::FacetBins bins;
};

Rasteriser::Rasteriser() : scratch_(std::make_unique<Scratch>()) {}
Rasteriser::Rasteriser(Rasteriser&&) noexcept = default;
Rasteriser& Rasteriser::operator=(Rasteriser&&) noexcept = default;
Rasteriser::~Rasteriser() = default;

DrawStatistics Rasteriser::draw(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                std::span<const glm::vec4> colours, std::span<const DrawPass> passes,
                                const glm::vec4& clear_colour, PixelFormat format, Image& image) {
  assert(colours.size() == mesh.facet_count() || (colours.empty() && !mesh.vertex_colours.empty()));
  image.width = view.width;
  image.height = view.height;
  image.format = format;
  image.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));

  scratch_->projected.project(mesh, view);
  const blend_internal::FacetBins& bins = scratch_->bins;
  scratch_->bins.build(scratch_->projected, order);

  const blend_internal::DrawTask task{scratch_->projected, colours, passes, clear_colour, format, image};
  parallel_ranges(static_cast<std::size_t>(bins.tiles()), 1, [&](std::size_t begin, std::size_t end) {
    for (int tile = static_cast<int>(begin); tile < static_cast<int>(end); ++tile) {
      blend_internal::draw_tile(task, bins.tile(tile), tile % bins.columns() * blend_internal::tile_size,
                                tile / bins.columns() * blend_internal::tile_size);
    }
  });

  DrawStatistics statistics;
  for (const DrawPass& pass : passes) {
    if (pass.cull != Cull::back_faces) statistics.facets_drawn += bins.back_facets();
    if (pass.cull != Cull::front_faces) statistics.facets_drawn += bins.front_facets();
  }
  return statistics;
}

}  // namespace facetsort
