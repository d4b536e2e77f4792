#include "stability_measure.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/check/picture_verdict.h"
#include "facetsort/check/verdict.h"
#include "facetsort/facets/facets.h"
#include "failure.h"
#include "ties.h"

namespace facetsort {
namespace {

// The computation's own error bound alone decides which pairs are judged: no gap, and so no radius either.
constexpr JudgeOptions rounding_alone{.bounding_radius = 1, .gap_radii = 0};

// The centroid sort as it is usually written: absolute coordinates and squared distances, all in float32. It stands for
// what a careful key saves, so nothing in it may be improved. `eye` as in SortView.
std::vector<std::uint32_t> naive_centroid_order(const MeshView& mesh, const glm::vec4& eye) {
  std::vector<float> keys;
  keys.reserve(mesh.facet_count());
  for (std::size_t facet = 0; facet < mesh.facet_count(); ++facet) {
    const glm::vec3 centroid = (mesh.corner(facet, 0) + mesh.corner(facet, 1) + mesh.corner(facet, 2)) / 3.0f;
    const glm::vec3 to_centroid = centroid - glm::vec3(eye);
    keys.push_back(eye.w == 0 ? -glm::dot(centroid, glm::vec3(eye)) : glm::dot(to_centroid, to_centroid));
  }
  std::vector<std::uint32_t> order(mesh.facet_count());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return keys[a] > keys[b]; });
  return order;
}

// What both referees know of a view.
struct SweptView {
  View view;
  FragmentLists lists;
  RayHits hits;
  Image reference;
};

SweptView referee_view(const MeshView& mesh, const EmbreeReferee& referee, const View& view) {
  SweptView swept{view, collect_fragments(mesh, view), require(referee.cast(view)), {}};
  blend_lists(mesh, view, swept.lists, PixelFormat::rgba32f, swept.reference);
  return swept;
}

// Pixels in which some pair of fragments can't be told apart: their depths differ by no more than their rounding.
std::size_t open_pixels(const FragmentLists& lists) {
  const std::vector<unsigned char> tied = tied_pixels(lists, 0);
  return static_cast<std::size_t>(std::count(tied.begin(), tied.end(), 1));
}

void add_reach(const SweptView& swept, StabilityPoint& point) {
  for (std::size_t pixel = 0; pixel + 1 < swept.lists.offsets.size(); ++pixel) {
    point.lists.seen += !swept.lists.pixel(pixel).empty();
  }
  point.lists.unjudged += open_pixels(swept.lists);
  point.embree.seen += swept.hits.rays;
  point.embree.unjudged += swept.hits.unjudged_rays + open_pixels(swept.hits.lists);
}

// The same steps for our methods and for the naive one: find an order, judge it, and draw in it.
class Contender {
 public:
  Contender(const MeshView& mesh, const StabilityMethod& method) : mesh_(mesh) {
    if (method.method) renderer_.emplace(mesh, Strategy{StrategyKind::facet_sort, *method.method});
  }

  void order(const View& view) {
    if (renderer_) {
      renderer_->order(view);
    } else {
      order_ = naive_centroid_order(mesh_, view.homogeneous_eye());
    }
  }

  // The next two are of the last order(), for the same view.
  std::size_t inverted_pixels(const View& view, const FragmentLists& lists) const {
    const std::vector<std::uint32_t> ranks =
        renderer_ ? renderer_->ranks(view, lists) : fragment_ranks(mesh_, view, lists, order_);
    return judge_drawing(lists, ranks, rounding_alone).inverted_pixels;
  }
  const Image& draw(const View& view) {
    if (renderer_) {
      renderer_->draw(view, PixelFormat::rgba32f, picture_);
    } else {
      facet_colours(mesh_, view.homogeneous_eye(), colours_);
      rasteriser_.draw(mesh_, view, order_, colours_, std::array{DrawPass{}}, background, PixelFormat::rgba32f,
                       picture_);
    }
    return picture_;
  }

 private:
  MeshView mesh_;
  std::optional<StrategyRenderer> renderer_;  // empty for the naive method
  std::vector<std::uint32_t> order_;          // of the naive method
  std::vector<glm::vec4> colours_;
  Rasteriser rasteriser_;
  Image picture_;
};

MethodErrors judge_method(const MeshView& mesh, const std::vector<SweptView>& views, const StabilityMethod& method,
                          const StabilityPoint& point) {
  const bool judged = point.lists.judges(), judged_by_embree = point.embree.judges();
  MethodErrors errors;
  if (judged) errors.inverted_pixels = errors.wrong_pixels = 0;
  if (judged_by_embree) errors.inverted_rays = 0;
  if (!judged && !judged_by_embree) return errors;
  Contender contender(mesh, method);
  for (const SweptView& swept : views) {
    contender.order(swept.view);
    if (judged_by_embree) *errors.inverted_rays += contender.inverted_pixels(swept.view, swept.hits.lists);
    if (!judged) continue;
    *errors.inverted_pixels += contender.inverted_pixels(swept.view, swept.lists);
    *errors.wrong_pixels +=
        judge_picture(mesh, swept.view, swept.lists, swept.reference, contender.draw(swept.view), rounding_alone)
            .wrong_pixels;
  }
  return errors;
}

}  // namespace

std::string StabilityMethod::name() const {
  return std::string(method ? method_name(*method) : naive_centroid_name);
}

std::vector<StabilityMethod> all_stability_methods() {
  std::vector<StabilityMethod> methods{{}};
  for (const Strategy& strategy : all_strategies()) {
    if (strategy.kind == StrategyKind::facet_sort) methods.push_back({strategy.method});
  }
  return methods;
}

StabilityPoint measure_stability(const SweepScene& scene, const std::vector<StabilityMethod>& methods) {
  const MeshView mesh = scene.mesh.view();
  const EmbreeReferee referee = require(EmbreeReferee::create(mesh));
  StabilityPoint point;
  point.facets = mesh.facet_count();
  std::vector<SweptView> views;
  for (const View& view : scene.views) {
    require(validate(view));
    views.push_back(referee_view(mesh, referee, view));
    add_reach(views.back(), point);
  }
  for (const StabilityMethod& method : methods) point.methods.push_back(judge_method(mesh, views, method, point));
  return point;
}

}  // namespace facetsort
