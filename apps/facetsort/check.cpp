// facetsort check: whether a draw order is right for a view, by two referees.
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/check/embree_referee.h"
#include "facetsort/check/verdict.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/summary.h"
#include "input_mesh.h"
#include "order_faults.h"
#include "order_file.h"
#include "output.h"
#include "ties.h"
#include "verbs.h"
#include "vertex_rounding.h"
#include "view_options.h"

namespace facetsort {
namespace {

struct CheckOptions {
  std::string mesh, order;
  ViewOptions view;
};

// What both referees say of an order that holds the mesh. Facets are those of the mesh that was drawn: where the order
// has parts of facets, its own triangles, and their ids are their places in it.
struct Judgement {
  Verdict lists;
  std::size_t tied_pixels = 0;
  RayHits hits;
  std::optional<Verdict> embree;         // empty: not judged, too many of its rays are in doubt
  std::optional<PartCoverage> coverage;  // of an order with parts; whole facets cover what they cover

  bool is_right() const {
    return lists.inverted_pixels == 0 && (!embree || embree->inverted_pixels == 0) &&
           (!coverage || coverage->miscovered_pixels == 0);
  }
};

// `lists` are all fragments of the mesh drawn. `finish_lists` is called on them and on Embree's hits before those are
// judged.
template <typename FinishLists>
Judgement judge_drawn(const MeshView& drawn, const std::vector<std::uint32_t>& rank, const View& view, double radius,
                      FragmentLists& lists, const FinishLists& finish_lists) {
  const JudgeOptions options{.bounding_radius = radius};
  Judgement judgement;
  finish_lists(lists);
  judgement.lists = judge_order(lists, rank, options);
  for (const unsigned char tied : tied_pixels(lists, options.gap_radii * radius)) judgement.tied_pixels += tied;

  const EmbreeReferee referee = require(EmbreeReferee::create(drawn));
  judgement.hits = require(referee.cast(view));
  RayHits& hits = judgement.hits;
  finish_lists(hits.lists);
  if (static_cast<double>(hits.unjudged_rays) <= most_unjudged * static_cast<double>(hits.rays)) {
    judgement.embree = judge_order(hits.lists, rank, options);
  }
  return judgement;
}

Judgement judge_permutation(const InputMesh& input, const View& view, const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> rank(order.size());
  for (std::uint32_t place = 0; place < order.size(); ++place) rank[order[place]] = place;
  FragmentLists lists = collect_fragments(input.mesh.view(), view);
  return judge_drawn(input.mesh.view(), rank, view, input.radius, lists, [](FragmentLists&) {});
}

// The triangles as they are drawn, in the file's order.
Judgement judge_parts(const InputMesh& input, const View& view, const OrderFile& order) {
  const MeshView drawn = order.mesh->view();
  const PartedMesh parted(input.mesh.view(), drawn, order.ids);
  std::vector<std::uint32_t> rank(drawn.facet_count());
  std::iota(rank.begin(), rank.end(), 0u);
  FragmentLists lists = collect_fragments(drawn, view);
  const PartCoverage coverage = parted.compare_coverage(view, collect_fragments(input.mesh.view(), view), lists);
  Judgement judgement = judge_drawn(drawn, rank, view, input.radius, lists,
                                    [&](FragmentLists& drawn_lists) { parted.widen_depth_errors(view, drawn_lists); });
  judgement.coverage = coverage;
  return judgement;
}

double rate(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

Json faults_json(const OrderFaults& faults) {
  const auto fault = [](std::size_t count, auto first) -> Json {
    return {{"count", count}, {"first", count > 0 ? Json(first) : Json(nullptr)}};
  };
  return {{"out_of_range", fault(faults.out_of_range, faults.first_out_of_range)},
          {"repeated", fault(faults.repeated, faults.first_repeated)},
          {"missing", fault(faults.missing, faults.first_missing)},
          {"wrong_corners", fault(faults.wrong_corners, faults.first_wrong_corners)},
          {"wrong_cover", fault(faults.wrong_cover, faults.first_wrong_cover)}};
}

// `sources`: the facet of each triangle drawn, or empty where those are the facets.
Json verdict_json(const Verdict& verdict, int width, std::span<const std::uint32_t> sources) {
  Json worst = nullptr;
  if (verdict.inverted_pixels > 0) {
    const auto columns = static_cast<std::size_t>(width);
    const auto facet_of = [&](std::uint32_t drawn) { return sources.empty() ? drawn : sources[drawn]; };
    worst = {{"pixel", {verdict.worst_pixel % columns, verdict.worst_pixel / columns}},
             {"far_facet", facet_of(verdict.worst_far_facet)},
             {"near_facet", facet_of(verdict.worst_near_facet)}};
    if (!sources.empty()) {
      worst["far_triangle"] = verdict.worst_far_facet;
      worst["near_triangle"] = verdict.worst_near_facet;
    }
  }
  return {{"covered_pixels", verdict.covered_pixels},
          {"inverted_pixels", verdict.inverted_pixels},
          {"inverted_rate", rate(verdict.inverted_pixels, verdict.covered_pixels)},
          {"inverted_pairs", verdict.inverted_pairs},
          {"worst_backtrack", verdict.worst_backtrack},
          {"worst", worst}};
}

Json judgement_json(const Judgement& judgement, int width, std::span<const std::uint32_t> sources) {
  Json lists = verdict_json(judgement.lists, width, sources);
  lists["tied_pixels"] = judgement.tied_pixels;
  const RayHits& hits = judgement.hits;
  Json embree = {{"rays", hits.rays},
                 {"unjudged_rays", hits.unjudged_rays},
                 {"unjudged_edge", hits.unjudged_edge},
                 {"unjudged_grazing", hits.unjudged_grazing},
                 {"unjudged_near_plane", hits.unjudged_near_plane},
                 {"verdict", judgement.embree ? verdict_json(*judgement.embree, width, sources) : Json(nullptr)}};
  Json coverage = nullptr;
  if (judgement.coverage) {
    coverage = {{"miscovered_pixels", judgement.coverage->miscovered_pixels},
                {"excused_pixels", judgement.coverage->excused_pixels}};
  }
  return {{"pixel_lists", lists}, {"embree", embree}, {"coverage", coverage}};
}

Facts fault_facts(const OrderFaults& faults, std::size_t facets) {
  Facts facts;
  const auto add = [&facts](const std::string& name, std::size_t count, const std::string& first) {
    if (count > 0) facts.emplace_back(name, count_text(count) + ", first: " + first);
  };
  add("ids out of range", faults.out_of_range,
      std::to_string(faults.first_out_of_range) + " (facets are 0 to " + std::to_string(facets - 1) + ")");
  add("repeated ids", faults.repeated, std::to_string(faults.first_repeated));
  add("missing facets", faults.missing, std::to_string(faults.first_missing));
  add("not in the facet named", faults.wrong_corners,
      "triangle " + std::to_string(faults.first_wrong_corners) + " of the order");
  add("facets not covered once", faults.wrong_cover, std::to_string(faults.first_wrong_cover));
  return facts;
}

std::string verdict_text(const Verdict& verdict, const std::string& unit) {
  return count_text(verdict.inverted_pixels) + " of " + count_text(verdict.covered_pixels) + unit + " inverted (" +
         percent_text(rate(verdict.inverted_pixels, verdict.covered_pixels)) + " %), " +
         count_text(verdict.inverted_pairs) + " pairs";
}

std::string worst_text(const Verdict& verdict, int width, std::span<const std::uint32_t> sources) {
  const auto drawn_text = [&](std::uint32_t drawn) {
    if (sources.empty()) return "facet " + std::to_string(drawn);
    return "triangle " + std::to_string(drawn) + " (of facet " + std::to_string(sources[drawn]) + ")";
  };
  const auto columns = static_cast<std::size_t>(width);
  return "pixel " + std::to_string(verdict.worst_pixel % columns) + "," +
         std::to_string(verdict.worst_pixel / columns) + ": " + drawn_text(verdict.worst_far_facet) +
         " is drawn after " + drawn_text(verdict.worst_near_facet) + ", which is nearer by " +
         number_text(verdict.worst_backtrack) + " bounding radii";
}

void print_judgement(const Judgement& judgement, int width, std::span<const std::uint32_t> sources) {
  const RayHits& hits = judgement.hits;
  Facts facts{{"pixel lists", verdict_text(judgement.lists, " covered pixels") + "; layers tie in " +
                                  count_text(judgement.tied_pixels)}};
  if (judgement.lists.inverted_pixels > 0) facts.emplace_back("worst", worst_text(judgement.lists, width, sources));
  const std::string unjudged = count_text(hits.unjudged_rays) + " of " + count_text(hits.rays) +
                               " rays in doubt: " + count_text(hits.unjudged_edge) + " at an edge, " +
                               count_text(hits.unjudged_grazing) + " grazing, " + count_text(hits.unjudged_near_plane) +
                               " at the near plane";
  if (judgement.embree) {
    facts.emplace_back("Embree", verdict_text(*judgement.embree, " rays") + "; " + unjudged);
    if (judgement.embree->inverted_pixels > 0)
      facts.emplace_back("worst", worst_text(*judgement.embree, width, sources));
  } else {
    facts.emplace_back("Embree", "not judged; " + unjudged);
  }
  if (judgement.coverage) {
    facts.emplace_back("coverage", count_text(judgement.coverage->miscovered_pixels) + " pixels miscovered; " +
                                       count_text(judgement.coverage->excused_pixels) +
                                       " more differ by the rounding of new vertices");
  }
  if (!judgement.is_right()) {
    facts.emplace_back("order", "not right for this view");
  } else if (judgement.lists.covered_pixels == 0) {
    facts.emplace_back("order", "nothing to judge: no facet covers a pixel of this view");
  } else {
    facts.emplace_back("order", "right for this view");
  }
  print_facts(facts);
}

ExitStatus run_check(const CheckOptions& options, const CommonOptions& common) {
  const InputMesh input = read_input_mesh(options.mesh);
  const View view = make_view(options.view, input.bounds);
  const OrderFile order = read_order(options.order);
  const OrderContents contents = inspect_order(order, input.mesh);
  const OrderFaults& faults = contents.faults;

  std::optional<Judgement> judgement;
  std::span<const std::uint32_t> sources;
  if (contents.is_permutation()) {
    judgement = judge_permutation(input, view, order.ids);
  } else if (faults.none()) {
    judgement = judge_parts(input, view, order);
    sources = order.ids;
  }
  const bool right = judgement && judgement->is_right();
  if (common.json) {
    Json document = {{"mesh", options.mesh},
                     {"order", options.order},
                     {"facets", input.mesh.triangles.size()},
                     {"triangles", order.ids.size()},
                     {"right", right},
                     {"permutation", contents.is_permutation()},
                     {"facets_in_parts", contents.facets_in_parts},
                     {"faults", faults_json(faults)}};
    document.update(judgement ? judgement_json(*judgement, view.width, sources)
                              : Json{{"pixel_lists", nullptr}, {"embree", nullptr}, {"coverage", nullptr}});
    print_json(document);
  } else if (judgement) {
    print_judgement(*judgement, view.width, sources);
  } else {
    Facts facts = fault_facts(faults, input.mesh.triangles.size());
    facts.emplace_back("order", contents.facets_in_parts == 0
                                    ? "not a permutation of the mesh's facets"
                                    : "does not draw each of the mesh's facets once, whole or in parts");
    print_facts(facts);
  }
  return right ? ExitStatus::done : ExitStatus::answer_is_no;
}

}  // namespace

Verb add_check(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* command = program.add_subcommand(
      "check",
      "Whether a draw order has every facet once, whole or in parts, and no far one after a nearer one; exit status 1 "
      "where not");
  command->add_option("MESH", options->mesh, "PLY, OBJ, OFF, STL or presorted .fsort file")->required()->type_name("");
  command->add_option("--order", options->order, "The order, a .u32 or .ply as `facetsort order` writes it")
      ->required()
      ->type_name("OUT");
  add_view_options(*command, options->view);
  add_size_option(*command, options->view.size, "Pixels, and rays of the referees");
  command->footer("Example: facetsort check meshes/teapot_1k.ply --order teapot.u32 --eye 30,20,40");
  return {command, [options, &common] { return run_check(*options, common); }};
}

}  // namespace facetsort
