#include "facetsort/blend/strategy.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/blend/coverage.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/source_over.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/facets/facets.h"

namespace facetsort {
namespace {

constexpr std::size_t pixels_per_task = 4096;

// What the blend target is told to do for a kind; nothing for those that do not draw a fixed number of passes.
std::vector<DrawPass> draw_passes(StrategyKind kind) {
  const DrawPass plain;
  const DrawPass backs{.cull = Cull::front_faces}, fronts{.cull = Cull::back_faces};
  switch (kind) {
    case StrategyKind::unsorted:
    case StrategyKind::facet_sort:
    case StrategyKind::presorted_buffers:
    case StrategyKind::premultiplied_over:
      return {plain};
    case StrategyKind::additive:
      return {{.blend = BlendMode::additive}};
    case StrategyKind::separate_culling_pass:
      return {backs, fronts};
    case StrategyKind::double_sided:
      return {fronts, backs};
    case StrategyKind::depth_prepass:
      return {{.depth_test = DepthTest::less, .depth_write = true, .colour_write = false},
              {.depth_test = DepthTest::less_or_equal, .depth_write = true}};
    case StrategyKind::depth_write:
      return {{.depth_test = DepthTest::less_or_equal, .depth_write = true}};
    case StrategyKind::draw_order:
    case StrategyKind::depth_peeling:
    case StrategyKind::dual_depth_peeling:
    case StrategyKind::weighted_blended:
    case StrategyKind::moment_based:
    case StrategyKind::multi_layer:
    case StrategyKind::stochastic:
    case StrategyKind::automatic:
    case StrategyKind::reference:
      break;
  }
  return {};
}

std::optional<Peeling> peeling_of(StrategyKind kind) {
  if (kind == StrategyKind::depth_peeling) return Peeling::front_to_back;
  if (kind == StrategyKind::dual_depth_peeling) return Peeling::from_both_ends;
  return std::nullopt;
}

std::optional<OrderIndependent> order_independent(StrategyKind kind) {
  switch (kind) {
    case StrategyKind::weighted_blended:
      return OrderIndependent::weighted;
    case StrategyKind::moment_based:
      return OrderIndependent::moments;
    case StrategyKind::multi_layer:
      return OrderIndependent::layers;
    case StrategyKind::stochastic:
      return OrderIndependent::stochastic;
    default:
      return std::nullopt;
  }
}

// Of facets that are not blended.
constexpr DrawPass opaque_pass{.depth_test = DepthTest::less, .depth_write = true};

// Facets before the first that is not blended; all, where one after that is.
std::size_t count_blended(const MeshView& mesh) {
  const auto is_blended = [&](std::uint32_t material) {
    return mesh.materials[material].alpha_mode == AlphaMode::blend;
  };
  const std::span<const std::uint32_t> materials = mesh.facet_materials;
  if (materials.empty()) return mesh.facet_count();
  const auto end = std::find_if_not(materials.begin(), materials.end(), is_blended);
  if (std::any_of(end, materials.end(), is_blended)) return mesh.facet_count();
  return static_cast<std::size_t>(end - materials.begin());
}

SceneCamera scene_camera(const View& view) {
  SceneCamera camera;
  camera.eye = view.eye;
  camera.at = view.at;
  camera.up = view.up;
  camera.perspective = view.projection == Projection::perspective;
  camera.vertical_fov_degrees = static_cast<double>(view.vertical_fov_degrees);
  camera.height_in_units = static_cast<double>(view.height_in_units);
  camera.near_distance = static_cast<double>(view.near_distance);
  return camera;
}

DrawPass pass_of(const ObjectDraw& draw) {
  DrawPass pass;
  pass.cull = draw.faces == Faces::back ? Cull::front_faces : draw.faces == Faces::front ? Cull::back_faces : Cull::none;
  pass.depth_test = draw.depth_test ? DepthTest::less_or_equal : DepthTest::off;
  pass.depth_write = draw.depth_write;
  pass.colour_write = draw.colour_write;
  return pass;
}

// Of what is kept a pixel.
constexpr std::size_t value_bytes = sizeof(float), colour_bytes = 4 * value_bytes;

void resize_image(const View& view, PixelFormat format, Image& image) {
  image.width = view.width;
  image.height = view.height;
  image.format = format;
  image.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
}

}  // namespace

MeshView blended_facets(const MeshView& mesh) {
  const std::size_t count = count_blended(mesh);
  MeshView blended = mesh;
  blended.triangles = mesh.triangles.first(count);
  if (!mesh.facet_colours.empty()) blended.facet_colours = mesh.facet_colours.first(count);
  if (!mesh.facet_materials.empty()) blended.facet_materials = mesh.facet_materials.first(count);
  return blended;
}

struct StrategyRenderer::State {
  MeshView mesh;
  Strategy strategy;
  std::vector<DrawPass> passes;
  std::optional<Sorter> sorter;
  std::optional<ExactSorter> exact_sorter;
  std::vector<MeasuredCut> measured_cuts;  // of the pieces there are before a view is seen
  const IndexBuffers* buffers = nullptr;
  glm::vec3 centre{0};                     // from which their directions are
  bool needs_index_order = false;          // as its order
  std::vector<std::uint32_t> index_order;  // of the strategies that do not sort, and of what is not sorted
  std::span<const std::uint32_t> order;
  std::optional<SortView> last_view;     // of order()
  std::size_t blended = 0;               // facets; those that are not come after them
  SceneInput scene;                      // of draw_order
  std::optional<SceneDrawOrder> object_order;
  // The order and its pieces' cuts by ids of the whole mesh, where only a part of it is ordered.
  std::vector<std::uint32_t> drawn;
  std::vector<Cut> drawn_cuts;
  std::vector<DrawBatch> batches;        // where what is drawn has several states
  std::vector<glm::vec4> colours;
  Rasteriser rasteriser;
  int passes_drawn = 1;
  std::size_t longest_list = 0;  // of the last reference drawn

  Pieces pieces() const {
    if (!exact_sorter) return {};
    Pieces pieces = exact_sorter->pieces();
    pieces.measured = measured_cuts;
    if (has_batches()) pieces.cuts = drawn_cuts;
    return pieces;
  }

  // With the given colours, whatever the strategy (but reference) does.
  DrawStatistics draw(const View& view, std::span<const glm::vec4> facet_colours, const glm::vec4& clear_colour,
                      PixelFormat format, Image& image) {
    if (const std::optional<Peeling> peeling = peeling_of(strategy.kind)) {
      const int most_passes = strategy.number == 0 ? no_pass_limit : static_cast<int>(strategy.number);
      return rasteriser.peel(mesh, view, order, facet_colours, *peeling, clear_colour, format, image, {}, most_passes,
                             not_blended());
    }
    if (const std::optional<OrderIndependent> method = order_independent(strategy.kind)) {
      return rasteriser.draw_order_independent(mesh, view, order, facet_colours, *method,
                                               static_cast<int>(strategy.number), clear_colour, format, image,
                                               not_blended());
    }
    if (has_batches()) {
      assert(!batches.empty());  // order() makes them
      return rasteriser.draw(mesh, view, batches, facet_colours, clear_colour, format, image, pieces());
    }
    return rasteriser.draw(mesh, view, order, facet_colours, passes, clear_colour, format, image, pieces());
  }

  bool has_batches() const { return strategy.kind == StrategyKind::draw_order || (!passes.empty() && has_opaque()); }

  // To be drawn before all others, with depth.
  bool has_opaque() const {
    return strategy.kind != StrategyKind::reference && strategy.kind != StrategyKind::draw_order &&
           blended < mesh.facet_count();
  }
  std::span<const std::uint32_t> not_blended() const {
    return has_opaque() ? std::span(index_order).subspan(blended) : std::span<const std::uint32_t>();
  }

  // Those that are not blended, with depth, and the passes over the others, tested against it.
  void batch_passes() {
    // Ids of pieces and of planes that are no facets' follow those of facets.
    const auto others = static_cast<std::uint32_t>(mesh.facet_count() - blended);
    const auto in_mesh = [&](std::uint32_t id) { return id < blended ? id : id + others; };
    drawn.resize(order.size());
    std::transform(order.begin(), order.end(), drawn.begin(), in_mesh);
    if (exact_sorter) {
      const std::span<const Cut> cuts = exact_sorter->pieces().cuts;
      drawn_cuts.assign(cuts.begin(), cuts.end());
      for (Cut& cut : drawn_cuts) cut.plane = in_mesh(cut.plane);
    }
    batches = {{not_blended(), opaque_pass}};
    for (DrawPass pass : passes) {
      if (pass.depth_test == DepthTest::off) pass.depth_test = DepthTest::less_or_equal;
      batches.push_back({drawn, pass});
    }
  }

  void batch_objects(const View& view) {
    batches.clear();
    for (const ObjectDraw& draw : object_order->find(strategy.rule, scene_camera(view))) {
      const MergedObject& object = scene.objects[draw.item];
      batches.push_back(
          {std::span(index_order).subspan(object.first_facet, object.facet_count), pass_of(draw), draw.clear_depth});
    }
    join_batches();
  }

  // Objects that follow each other in the mesh and are drawn so, with one state.
  void join_batches() {
    std::size_t kept = 0;
    for (const DrawBatch& batch : batches) {
      DrawBatch* last = kept > 0 ? &batches[kept - 1] : nullptr;
      if (last != nullptr && last->pass == batch.pass && !batch.clear_depth &&
          last->order.data() + last->order.size() == batch.order.data()) {
        last->order = {last->order.data(), last->order.size() + batch.order.size()};
      } else {
        batches[kept++] = batch;
      }
    }
    batches.resize(kept);
  }
};

StrategyRenderer::StrategyRenderer(const MeshView& mesh, const Strategy& strategy, const PresortedInput& presorted,
                                   const SceneInput& scene)
    : state_(std::make_unique<State>()) {
  assert(strategy.kind != StrategyKind::automatic);
  state_->mesh = mesh;
  state_->strategy = strategy;
  state_->passes = draw_passes(strategy.kind);
  state_->scene = scene;
  state_->blended = count_blended(mesh);
  const MeshView sorted = state_->has_opaque() ? blended_facets(mesh) : mesh;
  if (strategy.kind == StrategyKind::facet_sort && strategy.method == Method::presorted && presorted.tree != nullptr) {
    state_->exact_sorter.emplace(*presorted.tree);
  } else if (strategy.kind == StrategyKind::facet_sort && is_exact(strategy.method)) {
    state_->exact_sorter.emplace(sorted, ExactOptions{.from = order_from(strategy.method)});
  } else if (strategy.kind == StrategyKind::facet_sort) {
    state_->sorter.emplace(sorted, SorterOptions{.method = strategy.method, .precision = strategy.precision});
  } else if (strategy.kind == StrategyKind::presorted_buffers) {
    state_->buffers = presorted.buffers;
    state_->centre = facet_bounds(mesh).centre();
  } else if (strategy.kind != StrategyKind::reference) {
    state_->needs_index_order = true;
  }
  if (state_->exact_sorter) state_->measured_cuts = measure_cuts(sorted, state_->exact_sorter->pieces());
  if (strategy.kind == StrategyKind::draw_order) state_->object_order.emplace(*scene.scene, scene.objects);
  if (state_->needs_index_order || state_->has_opaque() || strategy.kind == StrategyKind::draw_order) {
    state_->index_order.resize(mesh.facet_count());
    std::iota(state_->index_order.begin(), state_->index_order.end(), 0u);
  }
  if (state_->needs_index_order) state_->order = std::span(state_->index_order).first(sorted.facet_count());
}

StrategyRenderer::StrategyRenderer(StrategyRenderer&&) noexcept = default;
StrategyRenderer& StrategyRenderer::operator=(StrategyRenderer&&) noexcept = default;
StrategyRenderer::~StrategyRenderer() = default;

void StrategyRenderer::order(const View& view) {
  const SortView sort_view{view.homogeneous_eye(), view.forward()};
  state_->last_view = sort_view;
  if (state_->sorter) {
    state_->sorter->forget_view();  // what a frame from a new eye costs is of interest
    state_->order = state_->sorter->sort(sort_view);
  }
  if (state_->exact_sorter) state_->order = state_->exact_sorter->sort(sort_view);
  if (state_->buffers != nullptr) {
    const glm::vec3 eye(sort_view.eye);
    const glm::vec3 to_viewer = sort_view.eye.w == 0 ? eye : eye - state_->centre;
    state_->order = state_->buffers->buffer(nearest_buffer(*state_->buffers, to_viewer));
  }
  if (state_->strategy.kind == StrategyKind::draw_order) {
    state_->batch_objects(view);
  } else if (state_->has_batches()) {
    state_->batch_passes();
  }
}

bool StrategyRenderer::keeps_order(const View& view) {
  State& state = *state_;
  if (!state.last_view) return false;
  const SortView now{view.homogeneous_eye(), view.forward()};
  if (state.exact_sorter) return state.exact_sorter->keeps_order(now);
  if (state.sorter) return state.sorter->is_sorted_for(now);
  return state.last_view->eye == now.eye && (!state.object_order || state.last_view->forward == now.forward);
}

DrawStatistics StrategyRenderer::draw(const View& view, PixelFormat format, Image& image) {
  State& state = *state_;
  if (state.strategy.kind == StrategyKind::reference) {
    const FragmentLists lists = collect_fragments(state.mesh, view);
    blend_lists(state.mesh, view, lists, format, image);
    state.longest_list = 0;
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      state.longest_list = std::max(state.longest_list, lists.pixel(pixel).size());
    }
    return {.facets_drawn = lists.facets_drawn, .passes = 1};
  }
  if (has_one_colour_per_facet(state.mesh)) facet_colours(state.mesh, view.homogeneous_eye(), state.colours);
  const DrawStatistics statistics = state.draw(view, state.colours, background, format, image);
  state.passes_drawn = statistics.passes;
  return statistics;
}

void StrategyRenderer::draw_coverage(const View& view, Image& image) {
  State& state = *state_;
  if (state.strategy.kind == StrategyKind::reference) {
    const FragmentLists lists = collect_fragments(state.mesh, view);
    resize_image(view, PixelFormat::rgba32f, image);
    for (std::size_t pixel = 0; pixel < image.pixels.size(); ++pixel) {
      image.pixels[pixel] = glm::vec4(static_cast<float>(lists.pixel(pixel).size()), 0, 0, 0);
    }
    return;
  }
  // Premultiplied source-over with alpha 0 adds: each fragment counts 1 in red.
  const std::vector<glm::vec4> ones(state.mesh.facet_count(), glm::vec4(1, 0, 0, 0));
  if (order_independent(state.strategy.kind)) {
    // Each of its passes covers what one plain pass does, but what it blends there are no counts.
    const DrawPass plain[] = {{}};
    state.rasteriser.draw(state.mesh, view, state.order, ones, plain, glm::vec4(0), PixelFormat::rgba32f, image);
    return;
  }
  state.draw(view, ones, glm::vec4(0), PixelFormat::rgba32f, image);
}

std::vector<std::uint32_t> StrategyRenderer::ranks(const View& view, const FragmentLists& lists) const {
  const State& state = *state_;
  if (state.passes.size() == 1) return fragment_ranks(state.mesh, view, lists, state.order, state.pieces());

  // Passes over whole facets that cull: each draws some.
  std::vector<std::uint32_t> drawn;
  drawn.reserve(state.order.size());
  blend_internal::ProjectedMesh projected;
  projected.project(state.mesh, view);
  for (const DrawPass& pass : state.passes) {
    for (const std::uint32_t facet : state.order) {
      // A facet seen edge-on covers nothing: it may go with either side.
      const bool front = blend_internal::facet_facing(projected, facet) >= 0;
      if (front == (pass.cull == Cull::back_faces)) drawn.push_back(facet);
    }
  }
  return fragment_ranks(state.mesh, view, lists, drawn);
}

const Strategy& StrategyRenderer::strategy() const {
  return state_->strategy;
}

bool StrategyRenderer::draws_in_order() const {
  return state_->strategy.draws_in_order() && !state_->has_opaque();
}

bool StrategyRenderer::discards_fragments() const {
  return state_->strategy.discards_fragments() || state_->has_batches() || state_->has_opaque();
}

int StrategyRenderer::passes() const {
  const State& state = *state_;
  return state.passes.empty() || state.has_batches() ? state.passes_drawn : static_cast<int>(state.passes.size());
}

std::size_t StrategyRenderer::bytes_per_pixel() const {
  const State& state = *state_;
  const std::size_t depth_bytes = state.has_opaque() ? value_bytes : 0;  // of what is opaque
  switch (state.strategy.kind) {
    case StrategyKind::depth_prepass:
    case StrategyKind::depth_write:
    case StrategyKind::draw_order:
      return value_bytes;
    case StrategyKind::depth_peeling:  // layers so far; this pass's layer, and its and the last one's depth
      return depth_bytes + 2 * colour_bytes + 2 * value_bytes;
    case StrategyKind::dual_depth_peeling:  // the same at both ends
      return depth_bytes + 2 * (2 * colour_bytes + 2 * value_bytes);
    case StrategyKind::weighted_blended:  // the sum, and the transmittance
      return depth_bytes + colour_bytes + value_bytes;
    case StrategyKind::moment_based:  // the sum, the absorbance, which is the transmittance, and its moments
      return depth_bytes + colour_bytes + (1 + state.strategy.number) * value_bytes;
    case StrategyKind::multi_layer:
      return depth_bytes + state.strategy.number * (colour_bytes + value_bytes);
    case StrategyKind::stochastic:  // depths, the sum, and the transmittance
      return depth_bytes + state.strategy.number * value_bytes + colour_bytes + value_bytes;
    case StrategyKind::reference:
      return state.longest_list * sizeof(Fragment);
    default:
      return depth_bytes;
  }
}

std::size_t StrategyRenderer::pieces() const {
  return state_->exact_sorter ? state_->order.size() : state_->mesh.facet_count();
}

std::size_t StrategyRenderer::triangles() const {
  return state_->exact_sorter ? state_->exact_sorter->statistics().triangles : state_->mesh.facet_count();
}

std::size_t StrategyRenderer::prepared_bytes() const {
  if (state_->exact_sorter) return state_->exact_sorter->prepared_bytes() + bytes_of(state_->measured_cuts);
  if (state_->buffers != nullptr) {
    const IndexBuffers& buffers = *state_->buffers;
    return buffers.facets.size() * sizeof(buffers.facets[0]) +
           buffers.directions.size() * (sizeof(buffers.directions[0]) + sizeof(buffers.buffer_of_direction[0]));
  }
  return state_->sorter ? state_->sorter->prepared_bytes() : 0;
}

std::optional<ExactStatistics> StrategyRenderer::exact_statistics() const {
  if (!state_->exact_sorter) return std::nullopt;
  return state_->exact_sorter->statistics();
}

void blend_lists(const MeshView& mesh, const View& view, const FragmentLists& lists, PixelFormat format, Image& image) {
  resize_image(view, format, image);
  const glm::vec4 eye = view.homogeneous_eye();
  const Camera camera(view);
  const SourceOver blend(format);
  std::vector<glm::vec4> colours;
  if (has_one_colour_per_facet(mesh)) facet_colours(mesh, eye, colours);
  parallel_ranges(image.pixels.size(), pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      glm::vec4 blended = blend.clear(background);
      const int x = static_cast<int>(pixel) % image.width, y = static_cast<int>(pixel) / image.width;
      for (const Fragment& fragment : lists.pixel(pixel)) {
        const glm::vec4 source = colours.empty() ? fragment_colour(mesh, fragment.facet, camera.pixel_ray(x, y), eye)
                                                 : colours[fragment.facet];
        blended = blend.over(source, blended);
      }
      image.pixels[pixel] = blend.finish(blended);
    }
  });
}

}  // namespace facetsort
