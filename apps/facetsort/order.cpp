// facetsort order: the draw order of a mesh for one view, as a file.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/order/sorter.h"
#include "facetsort/report/exact_measures.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/timing.h"
#include "input_mesh.h"
#include "order_file.h"
#include "output.h"
#include "scene_order.h"
#include "verbs.h"
#include "view_options.h"

namespace facetsort {
namespace {

// Sorts timed after the first, which allocates.
constexpr std::size_t timed_sorts = 5;

struct OrderOptions {
  std::string mesh, output;
  ViewOptions view;
  Method method = Method::centroid_distance;
  std::optional<double> max_growth;
};

// What every method tells.
struct OrderCost {
  Timing prepare, sort;
};

Json cost_json(const OrderOptions& options, std::size_t facets, const OrderCost& cost) {
  return {{"mesh", options.mesh},
          {"facets", facets},
          {"method", method_name(options.method)},
          {"prepare_ms", cost.prepare.median_ms},
          {"order_ms", cost.sort.median_ms},
          {"order_ms_spread", cost.sort.spread_ms},
          {"output", options.output}};
}

Facts cost_facts(const OrderOptions& options, std::size_t facets, const OrderCost& cost) {
  return {{"facets", count_text(facets)},
          {"method", std::string(method_name(options.method))},
          {"order", milliseconds_text(cost.sort.median_ms) + " ms a frame, " +
                        milliseconds_text(cost.prepare.median_ms) + " ms once a mesh"},
          {"output", options.output}};
}

// The last sort of `sorter`, a Sorter or an ExactSorter, is of `eye`.
template <typename AnySorter>
Timing time_sorts(AnySorter& sorter, const SortView& eye) {
  sorter.sort(eye);
  const auto sort_anew = [&] {
    if constexpr (requires { sorter.forget_view(); }) sorter.forget_view();
    sorter.sort(eye);
  };
  return time_median(sort_anew, timed_sorts);
}

void order_by_key(const OrderOptions& options, const CommonOptions& common, const InputMesh& input,
                  const SortView& eye) {
  const SorterOptions by_whole_keys{.method = options.method, .precision = Precision::whole};
  std::optional<Sorter> sorter;
  OrderCost cost;
  cost.prepare = time_median([&] { sorter.emplace(input.mesh.view(), by_whole_keys); }, 1);
  cost.sort = time_sorts(*sorter, eye);
  const std::span<const std::uint32_t> order = sorter->sort(eye);
  write_order(options.output, input.mesh, order);
  if (common.json) {
    print_json(cost_json(options, order.size(), cost));
  } else {
    print_facts(cost_facts(options, order.size(), cost));
  }
}

// A list of ids says nothing of parts: refuses orders that have some. `order`: draw ids.
void write_whole_facets(const OrderOptions& options, const Mesh& mesh, std::span<const std::uint32_t> order,
                        const Pieces& pieces) {
  std::vector<std::uint32_t> cut_facets;
  for (const std::uint32_t id : order) {
    if (id >= mesh.triangles.size()) cut_facets.push_back(pieces.facet_of(id, mesh.triangles.size()));
  }
  std::sort(cut_facets.begin(), cut_facets.end());
  const auto cut = std::unique(cut_facets.begin(), cut_facets.end()) - cut_facets.begin();
  if (cut > 0) {
    throw Failure(options.output + ": " + std::to_string(cut) + (cut == 1 ? " facet" : " facets") +
                  " cut; write a .ply");
  }
  write_order(options.output, mesh, order);
}

double growth(const ExactStatistics& statistics, std::size_t facets) {
  return static_cast<double>(statistics.triangles) / static_cast<double>(facets);
}

// In the manner of a solver's log. A file does not tell how its tree came to be.
void add_exact_facts(const ExactStatistics& s, std::size_t facets, double max_growth, bool from_file, Facts& facts) {
  if (!from_file) {
    facts.emplace_back("crossing", count_text(s.crossing_pairs) + " pairs of facets, parted by " +
                                       count_text(s.prepared_cuts) + " cuts once a mesh");
  }
  if (from_file) {
    facts.emplace_back("tree", count_text(s.tree_nodes) + " planes");
  } else if (s.tree_nodes > 0) {
    facts.emplace_back("tree", count_text(s.tree_nodes) + " planes, " + count_text(s.tree_cuts) +
                                   " cuts once a mesh, " + count_text(s.rejoined_cuts) + " of them rejoined; " +
                                   count_text(s.predicate_fallbacks) + " decided by integers");
  } else {
    facts.emplace_back("pairs", count_text(s.candidate_pairs) + " candidates; depth breaks " +
                                    count_text(s.constraints) + " constraints, mended by " + count_text(s.searches) +
                                    " searches; " + count_text(s.predicate_fallbacks) + " decided by integers");
    facts.emplace_back("cycles", count_text(s.components) + " of " + count_text(s.pieces_in_cycles) +
                                     " pieces in all, the largest of " + count_text(s.largest_component) +
                                     ", broken by " + count_text(s.view_cuts) + " cuts");
  }
  facts.emplace_back("drawn", count_text(s.pieces) + " pieces, " + count_text(s.triangles) + " triangles: growth " +
                                  fixed_text(growth(s, facets), 3));
  facts.emplace_back("times", "project " + milliseconds_text(s.project_ms) + ", pairs " +
                                  milliseconds_text(s.pairs_ms) + ", order " + milliseconds_text(s.order_ms) +
                                  ", cut " + milliseconds_text(s.cut_ms) + " ms");
  if (s.crossing_pairs_uncut + s.unordered_pairs > 0) {
    facts.emplace_back("NOT EXACT", "--max-growth " + number_text(max_growth) + " left " +
                                        count_text(s.crossing_pairs_uncut) + " crossing pairs uncut and " +
                                        count_text(s.unordered_pairs) + " pairs out of order");
  }
}

void order_exactly(const OrderOptions& options, const CommonOptions& common, const InputMesh& input,
                   const SortView& eye) {
  const std::size_t facets = input.mesh.triangles.size();
  ExactOptions exact{.from = order_from(options.method)};
  exact.max_growth = options.max_growth.value_or(exact.max_growth);
  std::optional<ExactSorter> sorter;
  OrderCost cost;
  const PresortedView* tree = options.method == Method::presorted ? input.presorted_input().tree : nullptr;
  const bool from_file = tree != nullptr;
  const auto prepare = [&] {
    if (from_file) {
      sorter.emplace(*tree);
    } else {
      sorter.emplace(input.mesh.view(), exact);
    }
  };
  cost.prepare = time_median(prepare, 1);
  cost.sort = time_sorts(*sorter, eye);
  if (extension_of(options.output) == ".ply") {
    write_triangles(options.output, input.mesh, sorter->triangles());
  } else {
    write_whole_facets(options, input.mesh, sorter->sort(eye), sorter->pieces());
  }
  const ExactStatistics& statistics = sorter->statistics();
  if (common.json) {
    Json document = cost_json(options, facets, cost);
    document["growth"] = growth(statistics, facets);
    document["exact"] = exact_json<Json>(statistics);
    print_json(document);
  } else {
    Facts facts = cost_facts(options, facets, cost);
    add_exact_facts(statistics, facets, exact.max_growth, from_file, facts);
    print_facts(facts);
  }
}

ExitStatus run_order(const OrderOptions& options, const CommonOptions& common) {
  require_output_file(options.output, {".u32", ".ply", ".glb", ".gltf"});
  if (options.max_growth && !is_exact(options.method)) {
    throw Failure("--max-growth is an option of the exact methods: nothing else cuts");
  }
  if (is_gltf(options.output)) {
    order_scene({options.mesh, options.output, options.view, options.method, options.max_growth}, common);
    return ExitStatus::done;
  }
  if (is_scene(options.mesh)) throw Failure(options.mesh + ": a scene, whose order needs a .glb or .gltf as output");
  const InputMesh input = read_input_mesh(options.mesh);
  const View view = make_view(options.view, input.bounds);
  const SortView eye{view.homogeneous_eye(), view.forward()};
  if (is_exact(options.method)) {
    order_exactly(options, common, input, eye);
  } else {
    order_by_key(options, common, input, eye);
  }
  return ExitStatus::done;
}

}  // namespace

Verb add_order(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<OrderOptions>();
  CLI::App* command = program.add_subcommand("order", "The draw order of a mesh's facets for one view, farthest first");
  command
      ->add_option("MESH", options->mesh,
                   "PLY, OBJ, OFF, STL or presorted .fsort file; or a scene: a glTF file, or a folder")
      ->required()
      ->type_name("");
  add_view_options(*command, options->view);
  add_method_option(*command, options->method);
  add_growth_option(*command, options->max_growth);
  command
      ->add_option("-o,--output", options->output,
                   "OUT.u32: little-endian 32-bit facet ids, where no facet is cut; OUT.ply: the triangles in draw "
                   "order, each with the id of its facet as `source`; OUT.glb or OUT.gltf: the scene, the facets of its "
                   "blended objects sorted together, each object's in that order")
      ->required()
      ->type_name("OUT");
  command->footer("Example: facetsort order meshes/teapot_1k.ply --eye 30,20,40 --method exact -o teapot.ply");
  return {command, [options, &common] { return run_order(*options, common); }};
}

}  // namespace facetsort
