#include "facetsort/blend/strategy.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <system_error>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/coverage.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/source_over.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/facets/facets.h"

namespace facetsort {
namespace {

constexpr std::size_t pixels_per_task = 4096;

struct NamedKind {
  StrategyKind kind;
  std::string_view name;
};

// In the order in which reports show them.
constexpr NamedKind kinds[] = {
    {StrategyKind::unsorted, "unsorted"},
    {StrategyKind::double_sided, "double_sided"},
    {StrategyKind::separate_culling_pass, "separate_culling_pass"},
    {StrategyKind::depth_prepass, "depth_prepass"},
    {StrategyKind::depth_write, "depth_write"},
    {StrategyKind::facet_sort, "facet_sort"},
    {StrategyKind::presorted_buffers, "presorted_buffers"},
    {StrategyKind::depth_peeling, "depth_peeling"},
    {StrategyKind::dual_depth_peeling, "dual_depth_peeling"},
    {StrategyKind::reference, "reference"},
};

constexpr std::string_view separator = ":";  // of a kind from its method or number

// What the blend target is told to do for a kind; nothing for those that do not draw a fixed number of passes.
std::vector<DrawPass> draw_passes(StrategyKind kind) {
  const DrawPass plain;
  const DrawPass backs{.cull = Cull::front_faces}, fronts{.cull = Cull::back_faces};
  switch (kind) {
    case StrategyKind::unsorted:
    case StrategyKind::facet_sort:
    case StrategyKind::presorted_buffers:
      return {plain};
    case StrategyKind::separate_culling_pass:
      return {backs, fronts};
    case StrategyKind::double_sided:
      return {fronts, backs};
    case StrategyKind::depth_prepass:
      return {{.depth_test = DepthTest::less, .depth_write = true, .colour_write = false},
              {.depth_test = DepthTest::less_or_equal, .depth_write = true}};
    case StrategyKind::depth_write:
      return {{.depth_test = DepthTest::less_or_equal, .depth_write = true}};
    case StrategyKind::depth_peeling:
    case StrategyKind::dual_depth_peeling:
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

void resize_image(const View& view, PixelFormat format, Image& image) {
  image.width = view.width;
  image.height = view.height;
  image.format = format;
  image.pixels.resize(static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height));
}

std::optional<std::size_t> buffers_from_text(std::string_view text) {
  std::size_t buffers = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), buffers);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  return is_number && buffers >= 1 && buffers <= Strategy::most_buffers ? std::optional(buffers) : std::nullopt;
}

}  // namespace

bool Strategy::draws_in_order() const {
  return kind == StrategyKind::unsorted || kind == StrategyKind::separate_culling_pass ||
         kind == StrategyKind::double_sided || kind == StrategyKind::facet_sort ||
         kind == StrategyKind::presorted_buffers;
}

std::string Strategy::name() const {
  for (const NamedKind& named : kinds) {
    if (named.kind != kind) continue;
    std::string text(named.name);
    if (kind == StrategyKind::facet_sort) text.append(separator).append(method_name(method));
    if (kind == StrategyKind::presorted_buffers) text.append(separator).append(std::to_string(buffers));
    return text;
  }
  return {};
}

std::vector<Strategy> all_strategies() {
  std::vector<Strategy> strategies;
  for (const NamedKind& named : kinds) {
    if (named.kind == StrategyKind::facet_sort) {
      for (const Method method : all_methods()) strategies.push_back({named.kind, method});
    } else if (named.kind != StrategyKind::presorted_buffers) {
      strategies.push_back({.kind = named.kind});
    }
  }
  return strategies;
}

std::optional<Strategy> strategy_from_name(std::string_view name) {
  const std::size_t end = std::min(name.find(separator), name.size());
  const std::string_view detail = name.substr(std::min(end + separator.size(), name.size()));
  for (const NamedKind& named : kinds) {
    if (named.name != name.substr(0, end)) continue;
    if (named.kind == StrategyKind::presorted_buffers) {
      const std::optional<std::size_t> buffers = buffers_from_text(detail);
      if (!buffers) return std::nullopt;
      return Strategy{.kind = named.kind, .buffers = *buffers};
    }
    if (end == name.size()) return Strategy{.kind = named.kind};
    if (named.kind != StrategyKind::facet_sort) return std::nullopt;
    const std::optional<Method> method = method_from_name(detail);
    if (method) return Strategy{.kind = named.kind, .method = *method};
  }
  return std::nullopt;
}

struct StrategyRenderer::State {
  MeshView mesh;
  Strategy strategy;
  std::vector<DrawPass> passes;
  std::optional<Sorter> sorter;
  std::optional<ExactSorter> exact_sorter;
  const IndexBuffers* buffers = nullptr;
  glm::vec3 centre{0};                     // from which their directions are
  std::vector<std::uint32_t> index_order;  // of the strategies that do not sort
  std::span<const std::uint32_t> order;
  std::vector<glm::vec4> colours;
  Rasteriser rasteriser;
  int passes_drawn = 1;

  Pieces pieces() const { return exact_sorter ? exact_sorter->pieces() : Pieces{}; }

  // With the given colours, whatever the strategy (but reference) does.
  DrawStatistics draw(const View& view, std::span<const glm::vec4> facet_colours, const glm::vec4& clear_colour,
                      PixelFormat format, Image& image) {
    if (const std::optional<Peeling> peeling = peeling_of(strategy.kind)) {
      return rasteriser.peel(mesh, view, order, facet_colours, *peeling, clear_colour, format, image);
    }
    return rasteriser.draw(mesh, view, order, facet_colours, passes, clear_colour, format, image, pieces());
  }
};

StrategyRenderer::StrategyRenderer(const MeshView& mesh, const Strategy& strategy, const PresortedInput& presorted)
    : state_(std::make_unique<State>()) {
  state_->mesh = mesh;
  state_->strategy = strategy;
  state_->passes = draw_passes(strategy.kind);
  if (strategy.kind == StrategyKind::facet_sort && strategy.method == Method::presorted && presorted.tree != nullptr) {
    state_->exact_sorter.emplace(*presorted.tree);
  } else if (strategy.kind == StrategyKind::facet_sort && is_exact(strategy.method)) {
    state_->exact_sorter.emplace(mesh, ExactOptions{.from = order_from(strategy.method)});
  } else if (strategy.kind == StrategyKind::facet_sort) {
    state_->sorter.emplace(mesh, SorterOptions{.method = strategy.method, .precision = Precision::whole});
  } else if (strategy.kind == StrategyKind::presorted_buffers) {
    state_->buffers = presorted.buffers;
    state_->centre = facet_bounds(mesh).centre();
  } else if (strategy.kind != StrategyKind::reference) {
    state_->index_order.resize(mesh.facet_count());
    std::iota(state_->index_order.begin(), state_->index_order.end(), 0u);
    state_->order = state_->index_order;
  }
}

StrategyRenderer::StrategyRenderer(StrategyRenderer&&) noexcept = default;
StrategyRenderer& StrategyRenderer::operator=(StrategyRenderer&&) noexcept = default;
StrategyRenderer::~StrategyRenderer() = default;

void StrategyRenderer::order(const View& view) {
  const SortView sort_view{view.homogeneous_eye(), view.forward()};
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
}

DrawStatistics StrategyRenderer::draw(const View& view, PixelFormat format, Image& image) {
  State& state = *state_;
  if (state.strategy.kind == StrategyKind::reference) {
    const FragmentLists lists = collect_fragments(state.mesh, view);
    blend_lists(state.mesh, view, lists, format, image);
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

int StrategyRenderer::passes() const {
  const State& state = *state_;
  return state.passes.empty() ? state.passes_drawn : static_cast<int>(state.passes.size());
}

std::size_t StrategyRenderer::pieces() const {
  return state_->exact_sorter ? state_->order.size() : state_->mesh.facet_count();
}

std::size_t StrategyRenderer::triangles() const {
  return state_->exact_sorter ? state_->exact_sorter->statistics().triangles : state_->mesh.facet_count();
}

std::size_t StrategyRenderer::prepared_bytes() const {
  if (state_->exact_sorter) return state_->exact_sorter->prepared_bytes();
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
