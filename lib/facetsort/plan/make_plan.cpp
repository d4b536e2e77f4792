// The rules, the cheapest first: what colours and materials prove, then what the shape proves, then what was measured.
#include <algorithm>
#include <cstdio>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/base/stopwatch.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/facets/facets.h"
#include "facetsort/order/sorter.h"
#include "facetsort/plan/appearance.h"
#include "facetsort/plan/planned_mesh.h"
#include "facetsort/plan/time_strategies.h"

namespace facetsort::plan_internal {
namespace {

constexpr double half_display_step = 0.5 / 255;

// Rules of thumb for what is not worth being timed, from the meshes in meshes/: to build a tree took 0.03 to 0.11 ms a
// facet, and an exact order from pairs was the fastest of the right ones on no mesh of more facets than this.
constexpr double presort_ms_per_facet = 0.08;
constexpr std::size_t most_facets_from_pairs = 5000;
// Drawing the pieces that its planes cut took 1.2 to 3 times as long as drawing whole facets where few of them crossed,
// and 13 to 16 times where there was a crossing pair to every sixth or third facet. Of what may be saved so, only a
// part is counted on; where it takes no longer than a plan does anyway, it is tried.
constexpr double presorted_growth = 1.5, growth_by_pairs = 20, hoped_saving = 0.2, cheap_presort_ms = 100;

// A strategy that takes so many times as long in a view is timed in no other.
constexpr double hopeless = 2;

constexpr Strategy exact_order{.kind = StrategyKind::facet_sort, .method = Method::exact};
constexpr Strategy presorted_order{.kind = StrategyKind::facet_sort, .method = Method::presorted};

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

std::string name_of(const Strategy& strategy) {
  return strategy.name();
}

// Whether all facets lie in one plane: then none hides another.
bool is_coplanar(const MeshView& mesh) {
  std::size_t facet = 0;
  const auto corner = [&](int i) { return mesh.corner(facet, i); };
  while (facet < mesh.facet_count() && collinear(corner(0), corner(1), corner(2))) ++facet;
  if (facet == mesh.facet_count()) return true;  // nothing has area
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (orientation(corner(0), corner(1), corner(2), mesh.positions[triangle[i]]) != 0) return false;
    }
  }
  return true;
}

std::vector<View> views_to_time(const MeshView& mesh, const PlanOptions& options) {
  std::vector<View> views = views_around(facet_bounds(mesh), options.views, options.radii, Projection::perspective);
  for (View& view : views) {
    view.width = options.width;
    view.height = options.height;
  }
  std::erase_if(views, [](const View& view) { return !validate(view).ok(); });
  return views;
}

class Planner {
 public:
  Planner(const MeshView& mesh, const PlanOptions& options, const PresortedInput& presorted)
      : mesh_(mesh), blended_(blended_facets(mesh)), options_(options), presorted_(presorted) {
    plan().facets = blended_.facet_count();
  }

  // Each says whether it found all that the mesh needs.
  bool by_colours();
  bool by_shape();
  void by_rule_of_thumb();
  void by_times();

  PlannedMesh planned;

 private:
  MeshPlan& plan() { return planned.plan; }
  void leave_out(std::string what, std::string why) { plan().left_out.push_back({std::move(what), std::move(why)}); }
  void leave_out_sorting() {
    leave_out("sorting", "the order of facets decides nothing that shows");
    leave_out("cuts and presorting", "nothing is sorted");
  }
  void choose(const Strategy& strategy, std::string reason) {
    plan().strategy = strategy;
    plan().reason = std::move(reason);
  }
  bool is_within_bound(std::size_t layers, const std::string& why_no_more);
  // How many of the nearest layers are enough, or nothing where a pixel can't keep so many.
  std::optional<std::size_t> layers_to_keep() const;
  void time(const Strategy& strategy);
  void time_measured(WrongPixels& wrong);
  bool is_presorting_worth_it(double floor_ms);
  void take(TimedRenderer&& timed);
  void explain_cuts();

  double best_ms() const { return best_ ? best_->timed.frame_ms : std::numeric_limits<double>::infinity(); }

  MeshView mesh_, blended_;
  PlanOptions options_;
  PresortedInput presorted_;
  Appearance appearance_;
  std::vector<View> views_;
  std::optional<TimedRenderer> best_;
};

bool Planner::is_within_bound(std::size_t layers, const std::string& why_no_more) {
  const double error = order_error(appearance_, layers);
  if (!(error <= half_display_step)) return false;
  choose({.kind = StrategyKind::premultiplied_over}, "no order of " + why_no_more + " with alphas of at most " +
                                                         text_of(static_cast<double>(appearance_.highest_alpha)) +
                                                         " differs from another by more than " + text_of(255 * error) +
                                                         " display steps");
  leave_out_sorting();
  return true;
}

bool Planner::by_colours() {
  if (blended_.facet_count() == 0) {
    choose({.kind = StrategyKind::unsorted}, "no facet is blended: a depth buffer is all it takes");
    leave_out_sorting();
    return true;
  }
  appearance_ = find_appearance(mesh_);
  plan().lowest_alpha = appearance_.lowest_alpha;
  plan().highest_alpha = appearance_.highest_alpha;
  plan().layers_that_matter = layers_that_matter(appearance_);
  if (options_.additive) {
    choose({.kind = StrategyKind::additive}, "colours are added: every order gives the same picture");
    leave_out_sorting();
    return true;
  }
  if (appearance_.highest_alpha <= 0) {
    choose({.kind = StrategyKind::unsorted}, "all alphas are 0: nothing shows");
    leave_out_sorting();
    return true;
  }
  if (plan().layers_that_matter == 1u) {
    choose({.kind = StrategyKind::depth_write}, "blended, but opaque: what lies behind a layer of alpha " +
                                                    text_of(static_cast<double>(appearance_.lowest_alpha)) +
                                                    " changes less than half a display step");
    leave_out_sorting();
    return true;
  }
  return is_within_bound(blended_.facet_count(), "its " + counted(blended_.facet_count(), "facet"));
}

bool Planner::by_shape() {
  if (is_coplanar(blended_)) {
    choose({.kind = StrategyKind::unsorted}, "all facets lie in one plane: none hides another");
    leave_out_sorting();
    return true;
  }
  plan().geometry = inspect_geometry(blended_);
  planned.parts = ConvexParts::find(blended_, *plan().geometry);
  const std::size_t parts = planned.parts.count();
  if (parts == 0) return false;
  const std::string convex = "closed, wound outwards and convex";
  if (parts == 1 && appearance_.all_single_sided) {
    choose({.kind = StrategyKind::unsorted}, convex + ", and only seen from outside: one layer a pixel");
    leave_out_sorting();
    return true;
  }
  if (is_within_bound(2 * parts, "the at most " + counted(2 * parts, "layer") + " of convex parts")) return true;
  if (parts == 1) {
    choose({.kind = StrategyKind::separate_culling_pass},
           convex + ": every ray meets one facet from behind and, before it, one from the front");
    leave_out_sorting();
    return true;
  }
  plan().culls_where_apart = true;
  return false;
}

std::optional<std::size_t> Planner::layers_to_keep() const {
  const std::size_t parts = planned.parts.count();
  std::size_t most = blended_.facet_count();
  if (parts > 0) most = std::min(most, 2 * parts);
  // Beyond those that matter one more is kept: it holds what the farthest were merged into.
  if (planned.plan.layers_that_matter) most = std::min(most, *planned.plan.layers_that_matter + 1);
  if (most > std::size_t{most_kept_layers}) return std::nullopt;
  return most;
}

void Planner::explain_cuts() {
  const std::size_t pairs = plan().geometry->intersecting_pairs;
  if (plan().strategy.kind == StrategyKind::multi_layer) {
    leave_out("sorting", "each pixel keeps its nearest layers by depth");
    if (pairs > 0) leave_out("cuts of " + counted(pairs, "intersecting pair"), "depths are compared a pixel");
  } else if (pairs == 0) {
    leave_out("cuts of intersecting facets", "no two facets meet but in what they share");
  }
}

void Planner::by_rule_of_thumb() {
  const std::optional<std::size_t> layers = layers_to_keep();
  if (layers) {
    choose({.kind = StrategyKind::multi_layer, .number = *layers},
           "the nearest " + counted(*layers, "layer") + " are all that shows, whatever the order; nothing was timed");
  } else {
    choose(exact_order, "no bound says that some order of whole facets is good enough; nothing was timed");
  }
  explain_cuts();
}

void Planner::take(TimedRenderer&& timed) {
  plan().timed.push_back(timed.timed);
  if (timed.is_complete && timed.timed.frame_ms < best_ms()) best_ = std::move(timed);
}

void Planner::time(const Strategy& strategy) {
  take(time_strategy(mesh_, strategy, views_, presorted_, hopeless * best_ms()));
}

bool Planner::is_presorting_worth_it(double floor_ms) {
  if (presorted_.tree != nullptr || !best_) return true;
  const double pairs = static_cast<double>(plan().geometry->intersecting_pairs);
  const double facets = static_cast<double>(blended_.facet_count()), build_ms = presort_ms_per_facet * facets;
  const double growth = presorted_growth + growth_by_pairs * pairs / facets;
  const double saving_ms = best_ms() - (build_ms < cheap_presort_ms ? 1.0 : growth) * floor_ms;
  if (saving_ms <= 0) {
    leave_out("presorting", "drawing its pieces, expected to take " + text_of(growth) +
                                " times as long as whole facets, would take longer");
    return false;
  }
  const double worth_ms = hoped_saving * saving_ms * static_cast<double>(options_.frames);
  if (build_ms < worth_ms) return true;
  leave_out("presorting", "it takes about " + text_of(build_ms) + " ms once, and may save " + text_of(saving_ms) +
                              " ms in each of " + counted(options_.frames, "frame"));
  return false;
}

// Strategies that are not always right, measured where they are not slower than what is.
void Planner::time_measured(WrongPixels& wrong) {
  std::vector<Strategy> strategies{{.kind = StrategyKind::unsorted},
                                   {.kind = StrategyKind::separate_culling_pass},
                                   {.kind = StrategyKind::facet_sort, .method = Method::centroid_distance},
                                   {.kind = StrategyKind::facet_sort, .method = Method::farthest_vertex}};
  const std::size_t facets = blended_.facet_count();
  if (key_bits(Precision::quantised, facets) < key_bits(Precision::whole, facets)) {
    for (const Method method : {Method::centroid_distance, Method::farthest_vertex}) {
      strategies.push_back(
          {.kind = StrategyKind::facet_sort, .method = method, .precision = Precision::quantised});
    }
  }
  if (presorted_.buffers != nullptr && !presorted_.buffers->needs_culling) {
    strategies.push_back({.kind = StrategyKind::presorted_buffers, .number = presorted_.buffers->buffer_count});
  }
  const double most = options_.error_budget / 2;
  for (const Strategy& strategy : strategies) {
    StrategyRenderer renderer(mesh_, strategy, presorted_);
    const double share = wrong.worst_share(renderer, most);
    if (share > most) {
      leave_out(name_of(strategy), text_of(100 * share) + " % of a view's pixels are wrong");
      continue;
    }
    TimedRenderer timed = time_strategy(mesh_, strategy, views_, presorted_, hopeless * best_ms());
    timed.timed.certainty = Certainty::measured;
    timed.timed.worst_wrong = share;
    take(std::move(timed));
  }
}

void Planner::by_times() {
  views_ = views_to_time(mesh_, options_);
  if (views_.empty()) return by_rule_of_thumb();
  // What it takes to draw the facets at all.
  const double floor_ms =
      time_strategy(mesh_, {.kind = StrategyKind::unsorted}, views_, {}, std::numeric_limits<double>::infinity())
          .timed.frame_ms;
  if (const std::optional<std::size_t> layers = layers_to_keep()) {
    time({.kind = StrategyKind::multi_layer, .number = *layers});
  } else {
    leave_out("layers kept a pixel",
              "alphas are too small for " + std::to_string(most_kept_layers) + " layers to hide the rest");
  }
  if (!best_ || blended_.facet_count() <= most_facets_from_pairs) time(exact_order);
  if (is_presorting_worth_it(floor_ms)) time(presorted_order);
  if (!best_) return by_rule_of_thumb();
  if (options_.error_budget > 0) {
    WrongPixels wrong(mesh_, views_);
    time_measured(wrong);
  }

  const TimedStrategy& chosen = best_->timed;
  std::string reason = "the fastest that is right: " + text_of(chosen.frame_ms) +
                       " ms a frame, where drawing unsorted takes " + text_of(floor_ms);
  if (chosen.strategy.kind == StrategyKind::multi_layer) {
    reason += "; the nearest " + counted(chosen.strategy.number, "layer") + " of a pixel are all that shows";
  }
  if (chosen.strategy.precision == Precision::quantised) {
    const std::string bits = std::to_string(key_bits(Precision::quantised, blended_.facet_count()));
    reason += "; keys of " + bits + " bits are enough";
    leave_out("whole keys", "those of " + bits + " bits keep the budget and take less time to sort");
  }
  if (chosen.certainty == Certainty::measured) {
    reason += "; " + text_of(100 * chosen.worst_wrong) + " % of the pixels wrong in the worst of " +
              counted(views_.size(), "view") + " of " + std::to_string(options_.width) + "x" +
              std::to_string(options_.height);
  }
  choose(chosen.strategy, std::move(reason));
  plan().certainty = chosen.certainty;
  for (const TimedStrategy& timed : plan().timed) {
    if (timed.strategy == chosen.strategy) continue;
    leave_out(name_of(timed.strategy), text_of(timed.frame_ms) + " ms a frame");
  }
  planned.renderer = std::move(best_->renderer);
  explain_cuts();
}

}  // namespace

PlannedMesh make_plan(const MeshView& mesh, const PlanOptions& options, const PresortedInput& presorted,
                      bool with_times) {
  Stopwatch stopwatch;
  Planner planner(mesh, options, presorted);
  if (!planner.by_colours() && !planner.by_shape()) {
    with_times ? planner.by_times() : planner.by_rule_of_thumb();
  }
  planner.planned.plan.plan_ms = stopwatch.lap();
  return std::move(planner.planned);
}

}  // namespace facetsort::plan_internal
