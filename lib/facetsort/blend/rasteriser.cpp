#include "facetsort/blend/rasteriser.h"

#include <atomic>
#include <cassert>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/tile_kernels.h"

namespace facetsort {

struct Rasteriser::Scratch {
  blend_internal::ProjectedMesh projected;
  blend_internal::FacetBins bins;
  std::vector<blend_internal::PeeledTile> peeled_tiles;
  std::vector<blend_internal::DrawnTile> drawn_tiles;

  // Resizes the image, and projects what is to be drawn.
  blend_internal::TileTask prepare(const MeshView& mesh, const View& view, std::span<const glm::vec4> colours,
                                   const glm::vec4& clear_colour, PixelFormat format, Image& image) {
    assert(colours.size() == mesh.facet_count() ||
           (colours.empty() && (!mesh.vertex_colours.empty() || !mesh.facet_materials.empty())));
    image.width = view.width;
    image.height = view.height;
    image.format = format;
    image.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
    projected.project(mesh, view);
    return {projected, bins, colours, clear_colour, format, image};
  }

  // And bins it.
  blend_internal::TileTask prepare(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                   std::span<const glm::vec4> colours, const glm::vec4& clear_colour,
                                   PixelFormat format, Image& image, const Pieces& pieces) {
    const blend_internal::TileTask task = prepare(mesh, view, colours, clear_colour, format, image);
    bins.build(projected, order, pieces);
    return task;
  }

  // Facets and pieces that a pass draws of what the bins have.
  std::size_t facets_drawn(const DrawPass& pass) const {
    return (pass.cull != Cull::back_faces ? bins.back_facets() : 0) +
           (pass.cull != Cull::front_faces ? bins.front_facets() : 0);
  }

  template <typename Body>
  void for_each_tile(const Body& body) const {
    parallel_ranges(static_cast<std::size_t>(bins.tiles()), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t tile = begin; tile < end; ++tile) body(static_cast<int>(tile));
    });
  }
};

Rasteriser::Rasteriser() : scratch_(std::make_unique<Scratch>()) {}
Rasteriser::Rasteriser(Rasteriser&&) noexcept = default;
Rasteriser& Rasteriser::operator=(Rasteriser&&) noexcept = default;
Rasteriser::~Rasteriser() = default;

DrawStatistics Rasteriser::draw(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                std::span<const glm::vec4> colours, std::span<const DrawPass> passes,
                                const glm::vec4& clear_colour, PixelFormat format, Image& image,
                                const Pieces& pieces) {
  const blend_internal::TileTask task =
      scratch_->prepare(mesh, view, order, colours, clear_colour, format, image, pieces);
  scratch_->for_each_tile([&](int tile) { blend_internal::draw_tile(task, passes, tile); });

  DrawStatistics statistics;
  statistics.passes = static_cast<int>(passes.size());
  for (const DrawPass& pass : passes) statistics.facets_drawn += scratch_->facets_drawn(pass);
  return statistics;
}

DrawStatistics Rasteriser::draw(const MeshView& mesh, const View& view, std::span<const DrawBatch> batches,
                                std::span<const glm::vec4> colours, const glm::vec4& clear_colour, PixelFormat format,
                                Image& image, const Pieces& pieces) {
  const blend_internal::TileTask task = scratch_->prepare(mesh, view, colours, clear_colour, format, image);
  scratch_->bins.place_mesh(scratch_->projected);
  std::vector<blend_internal::DrawnTile>& tiles = scratch_->drawn_tiles;
  const auto for_each_tile = [&](const auto& body) {
    scratch_->for_each_tile([&](int tile) { body(tile, tiles[static_cast<std::size_t>(tile)]); });
  };
  tiles.resize(static_cast<std::size_t>(scratch_->bins.tiles()));
  for_each_tile([&](int, blend_internal::DrawnTile& drawn) { blend_internal::start_drawing(task, drawn); });
  DrawStatistics statistics;
  statistics.passes = static_cast<int>(batches.size());
  for (const DrawBatch& batch : batches) {
    scratch_->bins.sort_into_tiles(scratch_->projected, batch.order, pieces);
    for_each_tile(
        [&](int tile, blend_internal::DrawnTile& drawn) { blend_internal::draw_pass(task, batch.pass, tile, drawn); });
    statistics.facets_drawn += scratch_->facets_drawn(batch.pass);
  }
  for_each_tile([&](int tile, blend_internal::DrawnTile& drawn) { blend_internal::finish_drawing(task, tile, drawn); });
  return statistics;
}

DrawStatistics Rasteriser::peel(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                std::span<const glm::vec4> colours, Peeling peeling, const glm::vec4& clear_colour,
                                PixelFormat format, Image& image, const Pieces& pieces) {
  const blend_internal::TileTask task =
      scratch_->prepare(mesh, view, order, colours, clear_colour, format, image, pieces);
  std::vector<blend_internal::PeeledTile>& tiles = scratch_->peeled_tiles;
  tiles.resize(static_cast<std::size_t>(scratch_->bins.tiles()));
  scratch_->for_each_tile(
      [&](int tile) { blend_internal::start_peeling(task, tiles[static_cast<std::size_t>(tile)]); });
  DrawStatistics statistics;
  std::atomic<bool> more = true;
  for (; more; ++statistics.passes) {
    more = false;
    scratch_->for_each_tile([&](int tile) {
      if (blend_internal::peel_tile(task, peeling, tile, tiles[static_cast<std::size_t>(tile)])) more = true;
    });
  }
  scratch_->for_each_tile([&](int tile) {
    blend_internal::finish_peeling(task, tile, tiles[static_cast<std::size_t>(tile)]);
  });
  statistics.facets_drawn = (scratch_->bins.front_facets() + scratch_->bins.back_facets()) *
                            static_cast<std::size_t>(statistics.passes);
  return statistics;
}

}  // namespace facetsort
