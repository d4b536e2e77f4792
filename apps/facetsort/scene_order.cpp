#include "scene_order.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facetsort/facets/facets.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/timing.h"
#include "facetsort/scene/draw_costs.h"
#include "facetsort/scene/read_scene.h"
#include "facetsort/scene/scene_sorter.h"
#include "facetsort/scene/write_scene.h"
#include "failure.h"
#include "output.h"

namespace facetsort {
namespace {

struct OrderedScene {
  SceneStatistics statistics;
  std::size_t facets = 0, blended_objects = 0;
  std::size_t cut_facets = 0;  // drawn in several triangles, for which an order of whole facets has no room
  double prepare_ms = 0;
  std::vector<DrawCost> costs;
};

std::size_t count_repeated(std::span<const std::uint32_t> facets, std::size_t facet_count) {
  std::vector<std::uint8_t> seen(facet_count);  // once, or more often
  std::size_t repeated = 0;
  for (const std::uint32_t facet : facets) {
    repeated += seen[facet] == 1;
    seen[facet] = seen[facet] == 0 ? 1 : 2;
  }
  return repeated;
}

Json costs_json(const std::vector<DrawCost>& costs) {
  Json list = Json::array();
  for (const DrawCost& cost : costs) {
    list.push_back({{"choice", cost.choice},
                    {"draws", cost.draws},
                    {"draws_as_found", cost.draws_as_found},
                    {"triangles", cost.triangles},
                    {"groups", cost.groups},
                    {"order_ms", cost.order_ms}});
  }
  return list;
}

void print_ordered(const SceneOrderOptions& options, const CommonOptions& common, const OrderedScene& ordered) {
  const SceneStatistics& statistics = ordered.statistics;
  if (common.json) {
    return print_json({{"scene", options.input.string()},
                       {"blended_objects", ordered.blended_objects},
                       {"facets", ordered.facets},
                       {"method", method_name(options.method)},
                       {"prepare_ms", ordered.prepare_ms},
                       {"order_ms", statistics.sort_ms + statistics.group_runs_ms},
                       {"groups", statistics.groups},
                       {"draws", statistics.runs},
                       {"triangles", statistics.triangles},
                       {"cut_facets", ordered.cut_facets},
                       {"choices", costs_json(ordered.costs)},
                       {"output", options.output.string()}});
  }
  const std::string groups =
      statistics.groups > 1 ? ", in " + count_text(statistics.groups) + " groups sorted apart" : std::string();
  Facts facts{{"objects", count_text(ordered.blended_objects) + " blended, " + count_text(ordered.facets) + " facets" +
                              groups},
              {"method", std::string(method_name(options.method))},
              {"order", milliseconds_text(statistics.sort_ms + statistics.group_runs_ms) + " ms a frame, " +
                            milliseconds_text(ordered.prepare_ms) + " ms once a scene"},
              {"draws", count_text(statistics.runs) + " of one object each"}};
  for (const DrawCost& cost : ordered.costs) {
    facts.emplace_back("  by " + cost.choice, count_text(cost.draws) + " draws, " + count_text(cost.triangles) +
                                                  " triangles, " + milliseconds_text(cost.order_ms) + " ms");
  }
  if (ordered.cut_facets > 0) {
    facts.emplace_back("NOT EXACT", count_text(ordered.cut_facets) +
                                        " facets have to be cut, and stand whole where their last piece does");
  }
  facts.emplace_back("output", options.output.string());
  print_facts(facts);
}

}  // namespace

void order_scene(const SceneOrderOptions& options, const CommonOptions& common) {
  const Scene scene = require(read_scene(options.input));
  const std::vector<std::uint32_t> blended = blended_objects(scene);
  if (blended.empty()) throw Failure(options.input.string() + ": no object is blended: there is nothing to sort");
  SceneSorterOptions sorting{.method = options.method, .precision = Precision::whole};
  sorting.max_growth = options.max_growth.value_or(sorting.max_growth);
  OrderedScene ordered;
  ordered.blended_objects = blended.size();
  std::optional<SceneSorter> sorter;
  const auto prepare = [&] { sorter.emplace(require(SceneSorter::create(scene, blended, sorting))); };
  ordered.prepare_ms = time_median(prepare, 1).median_ms;
  const MergedMesh& merged = sorter->merged();
  ordered.facets = merged.mesh.triangles.size();

  const View view = make_view(options.view, facet_bounds(merged.mesh.view()));
  const SortView eye{view.homogeneous_eye(), view.forward()};
  sorter->sort(eye);  // prepares the groups
  ordered.prepare_ms += sorter->statistics().prepare_ms;
  const SceneOrder order = sorter->sort(eye);
  ordered.statistics = sorter->statistics();
  ordered.cut_facets = count_repeated(order.facets, ordered.facets);
  ordered.costs = require(draw_costs(scene, eye));
  require(write_scene(options.output, scene, object_orders(scene, merged, order.facets)));
  print_ordered(options, common, ordered);
}

}  // namespace facetsort
