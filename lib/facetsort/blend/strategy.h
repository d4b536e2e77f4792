// How a picture of a self-transparent mesh is made: the strategies that engines offer, and ours.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/rasteriser.h"
#include "facetsort/blend/view.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/method.h"
#include "facetsort/order/presorted_data.h"
#include "facetsort/order/sorter.h"
#include "facetsort/scene/scene_draw_order.h"

namespace facetsort {

enum class StrategyKind {
  unsorted,               // index order
  separate_culling_pass,  // back faces in index order, then front faces (Babylon.js separateCullingPass)
  double_sided,           // all facets in index order with back faces culled, then again with flipped winding: fronts
                          // first and backs last (Babylon.js DOUBLESIDE)
  depth_prepass,          // depth first, then colour where the depth is the nearest (Babylon.js needDepthPrePass)
  depth_write,            // index order with depth test and depth writing on (Three.js's default)
  facet_sort,             // facets ordered by a method: a depth key, or exactly, cut where they must be
  draw_order,             // whole objects of a scene, as an engine's rule orders and draws them (see DrawOrderRule)
  presorted_buffers,      // one of a few fixed orders of whole facets, by the direction of the eye (see IndexBuffers)
  depth_peeling,          // a layer a pass, from the front, until none is left (Everitt 2001; vtkDepthPeelingPass)
  dual_depth_peeling,     // two layers a pass, the nearest and the farthest left (Bavoil and Myers 2008;
                          // vtkDualDepthPeelingPass, Babylon.js useOrderIndependentTransparency)
  weighted_blended,       // see OrderIndependent, as for the next three
  moment_based,
  multi_layer,
  stochastic,
  additive,               // index order, colours added (see BlendMode): another picture than source-over's, which it is
                          // compared with all the same, to say how far from it
  premultiplied_over,     // index order: the picture of `unsorted`, under the name of what it trusts in: alphas so
                          // small that no order is needed (see order_error_bound())
  automatic,              // whichever a plan finds best (PlannedRenderer in plan/ draws it, StrategyRenderer does not)
  reference,              // every fragment of a pixel blended by its own depth
};

struct Strategy {
  StrategyKind kind = StrategyKind::unsorted;
  Method method = Method::centroid_distance;  // of facet_sort
  Precision precision = Precision::whole;     // of its depth keys
  DrawOrderRule rule = DrawOrderRule::galacean;  // of draw_order
  // Of presorted_buffers: how many; depth peeling: most passes that peel, 0 for as many as it takes; moment_based:
  // moments; multi_layer: layers a pixel; stochastic: samples a pixel.
  std::size_t number = 0;
  double error_budget = 0;  // of automatic: most of a view's pixels that may be wrong, as a share (see PlanOptions)

  static constexpr std::size_t most_buffers = 1000, most_passes = 1000;

  bool operator==(const Strategy&) const = default;
  // Whether each facet, or each piece of it, is drawn at one place of an order, so that inversions can be counted.
  bool draws_in_order() const;
  // Whether some fragments are left out on purpose, so that coverage can't be counted.
  bool discards_fragments() const;
  // "unsorted", "facet_sort:centroid_distance", "facet_sort:centroid_distance:quantised", "draw_order:three",
  // "presorted_buffers:10", "depth_peeling", "depth_peeling:5", "auto:0.001", ...
  std::string name() const;
};

// Every strategy that needs no number, no scene and no plan, in the order in which reports show them; `reference` last.
// But for additive and premultiplied_over: the first is another picture, and the second that of `unsorted` again.
std::vector<Strategy> all_strategies();
// What the names of the others look like, scenes' aside: "multi_layer:1..64", "moment_based:4|6", "auto", ...
std::vector<std::string> numbered_strategy_names();
// Knows every name() and, as method, its alias.
std::optional<Strategy> strategy_from_name(std::string_view name);

// A mesh as it was presorted before; either may be null. The arrays must outlive who takes it.
struct PresortedInput {
  const PresortedView* tree = nullptr;    // for facet_sort:presorted, which else presorts the mesh itself
  const IndexBuffers* buffers = nullptr;  // for presorted_buffers
};

// The facets before the first whose material is not blended, which strategies of a fixed number of passes order; all
// facets, where some after that are blended.
MeshView blended_facets(const MeshView& mesh);

// The scene that a mesh was merged of. It and the array must outlive who takes it.
struct SceneInput {
  const Scene* scene = nullptr;
  std::span<const MergedObject> objects;  // of it, those whose materials are blended before all others
};

// One frame of a strategy, its stages apart so that each can be timed: construct once a mesh, then for each view
// order() and draw(). Keeps its scratch. One thread at a time; parallel in the caller's task arena.
class StrategyRenderer {
 public:
  // The mesh's arrays must outlive it. Where facets that are not blended (AlphaMode) follow all that are, all
  // strategies but reference, which has its lists, and draw_order, which has its rule, first draw those, with depth,
  // and then order and draw the others, tested against that depth; otherwise those are taken for blended ones of
  // alpha 1.
  // Preconditions: presorted_buffers gets buffers of blended_facets(mesh), with directions; draw_order gets the scene
  // that this mesh was merged of; the strategy is not automatic.
  StrategyRenderer(const MeshView& mesh, const Strategy& strategy, const PresortedInput& presorted = {},
                   const SceneInput& scene = {});
  StrategyRenderer(StrategyRenderer&&) noexcept;
  StrategyRenderer& operator=(StrategyRenderer&&) noexcept;
  ~StrategyRenderer();

  // Per-frame work before drawing: the sort (nothing for most strategies).
  void order(const View& view);
  // Whether draw() may go on with the last order() in this view, as far as is known without ordering: from its eye and,
  // by objects, along its axis; with facets sorted, as Sorter or ExactSorter tells. False before the first.
  bool keeps_order(const View& view);
  // Draws with the last order(); colours are shaded inside (see shading.h).
  DrawStatistics draw(const View& view, PixelFormat format, Image& image);

  // Draws the number of times each pixel is covered, by the same passes, into the red channel (rgba32f).
  void draw_coverage(const View& view, Image& image);
  // Position of each fragment in the sequence in which facets and pieces are drawn for the last order(), or not_drawn,
  // parallel to lists.fragments (see fragment_ranks()). Only where draws_in_order().
  std::vector<std::uint32_t> ranks(const View& view, const FragmentLists& lists) const;

  const Strategy& strategy() const;
  // As the strategy says of itself, but that drawing with depth leaves out fragments.
  bool draws_in_order() const;
  bool discards_fragments() const;
  int passes() const;                  // over the geometry; of depth peeling, for the last draw()
  // What drawing keeps a pixel beside the picture, in float32 (facetsort's own tiles need it for a few at a time, a
  // graphics interface for all). Of reference: what the longest list of the last draw() takes.
  std::size_t bytes_per_pixel() const;
  std::size_t pieces() const;          // whole facets, and pieces of the others, for the last order()
  std::size_t triangles() const;       // that those are as plain triangles; counting them takes time where some are cut
  std::size_t prepared_bytes() const;  // held beyond the mesh, made at construction
  // Of the exact order, for the last order(); none of other strategies.
  std::optional<ExactStatistics> exact_statistics() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The reference picture from per-pixel lists already collected: fragments of each pixel blended farthest first, ties by
// smaller facet id first. Parallel in the caller's task arena.
void blend_lists(const MeshView& mesh, const View& view, const FragmentLists& lists, PixelFormat format, Image& image);

}  // namespace facetsort
