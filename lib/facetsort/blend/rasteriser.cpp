#include "facetsort/blend/rasteriser.h"

#include <tbb/parallel_reduce.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/tile_kernels.h"

namespace facetsort {
namespace {

using blend_internal::DepthRange;

constexpr std::size_t facets_per_task = 16384, pieces_per_task = 1024;
constexpr std::size_t pixels_per_tile = blend_internal::tile_size * blend_internal::tile_size;

static_assert(most_depth_samples == blend_internal::SampleMasks::most_samples);

// Of the facets drawn: vertices that none uses do not count.
DepthRange find_depth_range(const blend_internal::ProjectedMesh& projected, std::span<const std::uint32_t> facets) {
  // Where the near plane is at the eye, depth still ends somewhere.
  constexpr float least_share_of_farthest = 1e-6f;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  using Range = std::pair<double, double>;
  const Camera& camera = projected.camera;
  const auto distance = [&](std::uint32_t vertex) {
    return camera.perspective ? projected.vertices[vertex].w
                              : glm::dot(camera.forward, glm::dvec3(projected.mesh.positions[vertex]) - camera.eye);
  };
  const auto [low, high] = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, facets.size(), facets_per_task), Range(infinity, -infinity),
      [&](const tbb::blocked_range<std::size_t>& range, Range found) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          for (int corner = 0; corner < 3; ++corner) {
            const double at = distance(projected.mesh.triangles[facets[i]][corner]);
            found = {std::min(found.first, at), std::max(found.second, at)};
          }
        }
        return found;
      },
      [](const Range& a, const Range& b) { return Range(std::min(a.first, b.first), std::max(a.second, b.second)); });
  if (!(low <= high)) return {1, 1, camera.perspective};
  DepthRange range{static_cast<float>(low), static_cast<float>(high), camera.perspective};
  if (camera.perspective) {
    range.farthest = std::max(range.farthest, std::numeric_limits<float>::min());
    range.nearest = std::max({range.nearest, static_cast<float>(camera.near_distance),
                              least_share_of_farthest * range.farthest});
    range.farthest = std::max(range.farthest, range.nearest);
  }
  return range;
}

// What a thread needs for the tile it draws.
struct ThreadScratch {
  std::vector<blend_internal::KeptLayer> layers;
  std::vector<blend_internal::SampleVector> samples;
};

// The thread's place in its arena; 0 where it works alone.
std::size_t thread_place() {
  const int place = tbb::this_task_arena::current_thread_index();
  return place == tbb::task_arena::not_initialized ? 0 : static_cast<std::size_t>(place);
}

int passes_of(OrderIndependent method) {
  return method == OrderIndependent::moments || method == OrderIndependent::stochastic ? 2 : 1;
}

}  // namespace

std::vector<MeasuredCut> measure_cuts(const MeshView& mesh, const Pieces& pieces) {
  std::vector<MeasuredCut> measured(pieces.cuts.size());
  parallel_ranges(pieces.pieces.size(), pieces_per_task, [&](std::size_t begin, std::size_t end) {
    for (const Piece& piece : pieces.pieces.subspan(begin, end - begin)) {
      for (std::size_t i = piece.first_cut; i < piece.first_cut + piece.cut_count; ++i) {
        measured[i] = blend_internal::measured_cut(mesh, pieces, piece, i);
      }
    }
  });
  return measured;
}

struct Rasteriser::Scratch {
  blend_internal::ProjectedMesh projected;
  blend_internal::FacetBins bins;
  std::vector<blend_internal::PeeledTile> peeled_tiles;
  std::vector<blend_internal::DrawnTile> drawn_tiles;
  std::vector<ThreadScratch> threads;  // of the arena
  blend_internal::SampleMasks masks;
  std::size_t opaque_facets_drawn = 0;

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

  // And bins it, after what is opaque has been drawn.
  blend_internal::TileTask prepare(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                   std::span<const glm::vec4> colours, const glm::vec4& clear_colour,
                                   PixelFormat format, Image& image, const Pieces& pieces,
                                   std::span<const std::uint32_t> opaque = {}) {
    blend_internal::TileTask task = prepare(mesh, view, colours, clear_colour, format, image);
    opaque_facets_drawn = 0;
    if (opaque.empty()) {
      bins.build(projected, order, pieces);
      return task;
    }
    bins.place_mesh(projected);
    bins.sort_into_tiles(projected, opaque, {});
    drawn_tiles.resize(static_cast<std::size_t>(bins.tiles()));
    for_each_tile([&](int tile) {
      blend_internal::draw_opaque_tile(task, tile, drawn_tiles[static_cast<std::size_t>(tile)]);
    });
    opaque_facets_drawn = bins.front_facets() + bins.back_facets();
    task.opaque = drawn_tiles;
    bins.sort_into_tiles(projected, order, pieces);
    return task;
  }

  // Of passes over all of the order, and of that over what is opaque, which is the first.
  DrawStatistics statistics(int passes, bool has_opaque) const {
    const std::size_t facets = bins.front_facets() + bins.back_facets();
    return {.facets_drawn = facets * static_cast<std::size_t>(passes) + opaque_facets_drawn,
            .passes = passes + (has_opaque ? 1 : 0)};
  }

  // Facets and pieces that a pass draws of what the bins have.
  std::size_t facets_drawn(const DrawPass& pass) const {
    return (pass.cull != Cull::back_faces ? bins.back_facets() : 0) +
           (pass.cull != Cull::front_faces ? bins.front_facets() : 0);
  }

  // For every thread that may come: none allocates while it draws.
  template <typename Resize>
  void make_room(const Resize& resize) {
    threads.resize(static_cast<std::size_t>(tbb::this_task_arena::max_concurrency()));
    for (ThreadScratch& thread : threads) resize(thread);
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
    for_each_tile([&](int tile, blend_internal::DrawnTile& drawn) {
      if (batch.clear_depth) std::fill(std::begin(drawn.depths.pixel), std::end(drawn.depths.pixel), INFINITY);
      blend_internal::draw_pass(task, batch.pass, tile, drawn);
    });
    statistics.facets_drawn += scratch_->facets_drawn(batch.pass);
  }
  for_each_tile([&](int tile, blend_internal::DrawnTile& drawn) { blend_internal::finish_drawing(task, tile, drawn); });
  return statistics;
}

DrawStatistics Rasteriser::peel(const MeshView& mesh, const View& view, std::span<const std::uint32_t> order,
                                std::span<const glm::vec4> colours, Peeling peeling, const glm::vec4& clear_colour,
                                PixelFormat format, Image& image, const Pieces& pieces, int most_passes,
                                std::span<const std::uint32_t> opaque) {
  assert(most_passes >= 1);
  const blend_internal::TileTask task =
      scratch_->prepare(mesh, view, order, colours, clear_colour, format, image, pieces, opaque);
  // The first pass from both ends peels nothing.
  if (peeling == Peeling::from_both_ends && most_passes < no_pass_limit) ++most_passes;
  std::vector<blend_internal::PeeledTile>& tiles = scratch_->peeled_tiles;
  tiles.resize(static_cast<std::size_t>(scratch_->bins.tiles()));
  scratch_->for_each_tile(
      [&](int tile) { blend_internal::start_peeling(task, tile, tiles[static_cast<std::size_t>(tile)]); });
  int passes = 0;
  std::atomic<bool> more = true;
  for (; more && passes < most_passes; ++passes) {
    more = false;
    scratch_->for_each_tile([&](int tile) {
      if (blend_internal::peel_tile(task, peeling, tile, tiles[static_cast<std::size_t>(tile)])) more = true;
    });
  }
  scratch_->for_each_tile([&](int tile) {
    blend_internal::finish_peeling(task, tile, tiles[static_cast<std::size_t>(tile)]);
  });
  return scratch_->statistics(passes, !opaque.empty());
}

DrawStatistics Rasteriser::draw_order_independent(const MeshView& mesh, const View& view,
                                                  std::span<const std::uint32_t> order,
                                                  std::span<const glm::vec4> colours, OrderIndependent method,
                                                  int count, const glm::vec4& clear_colour, PixelFormat format,
                                                  Image& image, std::span<const std::uint32_t> opaque) {
  const blend_internal::TileTask task =
      scratch_->prepare(mesh, view, order, colours, clear_colour, format, image, {}, opaque);
  switch (method) {
    case OrderIndependent::weighted: {
      const DepthRange range = find_depth_range(scratch_->projected, order);
      scratch_->for_each_tile([&](int tile) { blend_internal::draw_weighted_blended(task, range, tile); });
      break;
    }
    case OrderIndependent::moments: {
      assert(count == 4 || count == 6);
      const DepthRange range = find_depth_range(scratch_->projected, order);
      scratch_->for_each_tile([&](int tile) { blend_internal::draw_moment_based(task, range, count, tile); });
      break;
    }
    case OrderIndependent::layers: {
      assert(count >= 1 && count <= most_kept_layers);
      scratch_->make_room([&](ThreadScratch& thread) {
        thread.layers.resize(pixels_per_tile * static_cast<std::size_t>(count));
      });
      scratch_->for_each_tile([&](int tile) {
        blend_internal::draw_multi_layer(task, scratch_->threads[thread_place()].layers, tile);
      });
      break;
    }
    case OrderIndependent::stochastic: {
      assert(count >= 1 && count <= most_depth_samples);
      constexpr int at_once = blend_internal::samples_per_vector;
      scratch_->masks.set_samples(count);
      scratch_->make_room([&](ThreadScratch& thread) {
        thread.samples.resize(pixels_per_tile * static_cast<std::size_t>((count + at_once - 1) / at_once));
      });
      scratch_->for_each_tile([&](int tile) {
        blend_internal::draw_stochastic(task, scratch_->masks, scratch_->threads[thread_place()].samples, tile);
      });
      break;
    }
  }
  return scratch_->statistics(passes_of(method), !opaque.empty());
}

}  // namespace facetsort
