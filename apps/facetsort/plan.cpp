// facetsort plan: what a mesh or scene needs for a right picture, and what it can do without.
#include "facetsort/plan/plan.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arguments.h"
#include "facetsort/plan/planned_renderer.h"
#include "facetsort/report/number_text.h"
#include "input_mesh.h"
#include "output.h"
#include "verbs.h"

namespace facetsort {
namespace {

constexpr int most_views = 1000, most_frames = 1'000'000'000, most_orbit_frames = 3600;

struct PlanVerbOptions {
  std::vector<std::string> meshes;
  double error_budget = 0;
  int frames = static_cast<int>(PlanOptions{}.frames);
  int views = PlanOptions{}.views;
  float radii = PlanOptions{}.radii;
  PictureSize size{PlanOptions{}.width, PlanOptions{}.height};
  double orbit_degrees = 0;  // a frame; 0: no orbit
  bool additive = false;
};

struct PlannedInput {
  std::string path;
  bool is_scene = false;
  Plan plan{};
  std::optional<PlannedStatistics> orbit{};
  double orbit_degrees = 0;  // all of it
};

// Of a camera that turns once around the mesh, or as far as it comes in most_orbit_frames.
PlannedStatistics orbit(PlannedRenderer& renderer, const InputMesh& input, const PlanVerbOptions& options) {
  const int frames = static_cast<int>(std::min(std::ceil(360 / options.orbit_degrees), double{most_orbit_frames}));
  const glm::vec3 centre = input.bounds.centre();
  const float distance = options.radii * static_cast<float>(input.radius);
  for (int frame = 0; frame < frames; ++frame) {
    const double angle = glm::radians(options.orbit_degrees * frame);
    const glm::vec3 direction = glm::normalize(glm::vec3(std::cos(angle), 0.3, std::sin(angle)));
    View view = default_view(input.bounds, centre + distance * direction);
    view.width = options.size.width;
    view.height = options.size.height;
    renderer.order(view);
  }
  return renderer.statistics();
}

PlannedInput plan_file(const std::string& path, const PlanVerbOptions& options) {
  const PlanOptions plan_options{.error_budget = options.error_budget,
                                 .additive = options.additive,
                                 .frames = static_cast<std::size_t>(options.frames),
                                 .views = options.views,
                                 .radii = options.radii,
                                 .width = options.size.width,
                                 .height = options.size.height};
  const InputMesh input = read_input_scene(path);
  PlannedInput planned{.path = path, .is_scene = input.scene.has_value()};
  std::optional<PlannedRenderer> renderer;
  if (options.orbit_degrees > 0) renderer.emplace(input.mesh.view(), plan_options, input.presorted_input());
  if (input.scene) {
    planned.plan = require(plan_scene(*input.scene, plan_options));
    if (renderer) planned.plan.whole = renderer->plan();  // that which the orbit is drawn by
  } else {
    planned.plan.whole =
        renderer ? renderer->plan() : plan_mesh(input.mesh.view(), plan_options, input.presorted_input());
    planned.plan.plan_ms = planned.plan.whole.plan_ms;
  }
  if (renderer) {
    planned.orbit = orbit(*renderer, input, options);
    planned.orbit_degrees = options.orbit_degrees * static_cast<double>(planned.orbit->frames);
  }
  return planned;
}

std::string certainty_name(Certainty certainty) {
  return certainty == Certainty::proved ? "proved" : "measured";
}

Json mesh_json(const MeshPlan& plan) {
  Json left_out = Json::array(), timed = Json::array();
  for (const LeftOut& left : plan.left_out) left_out.push_back({{"what", left.what}, {"why", left.why}});
  for (const TimedStrategy& strategy : plan.timed) {
    timed.push_back({{"strategy", strategy.strategy.name()},
                     {"certainty", certainty_name(strategy.certainty)},
                     {"frame_ms", strategy.frame_ms},
                     {"prepare_ms", strategy.prepare_ms},
                     {"worst_wrong_rate", strategy.worst_wrong}});
  }
  Json json{{"name", plan.name},
            {"facets", plan.facets},
            {"strategy", plan.strategy.name()},
            {"certainty", certainty_name(plan.certainty)},
            {"reason", plan.reason},
            {"culls_where_apart", plan.culls_where_apart},
            {"alphas", {plan.lowest_alpha, plan.highest_alpha}},
            {"layers_that_matter", plan.layers_that_matter ? Json(*plan.layers_that_matter) : Json(nullptr)},
            {"left_out", left_out},
            {"timed", timed},
            {"plan_ms", plan.plan_ms}};
  if (plan.geometry) {
    json["intersecting_pairs"] = plan.geometry->intersecting_pairs;
    json["convex_closed_components"] = plan.geometry->convex_closed_components;
  }
  return json;
}

Json input_json(const PlannedInput& input) {
  Json json{{"mesh", input.path}, {"plan", mesh_json(input.plan.whole)}, {"plan_ms", input.plan.plan_ms}};
  if (input.orbit) {
    json["orbit"] = {{"frames", input.orbit->frames}, {"kept", input.orbit->kept}, {"unsorted", input.orbit->unsorted}};
  }
  if (!input.is_scene) return json;
  json["blended_objects"] = input.plan.blended_objects;
  json["most_overlapping_objects"] = input.plan.most_overlapping;
  json["objects"] = Json::array();
  for (const MeshPlan& object : input.plan.objects) json["objects"].push_back(mesh_json(object));
  return json;
}

std::string needs_text(const MeshPlan& plan) {
  return plan.strategy.name() + ", " + certainty_name(plan.certainty) + ": " + plan.reason;
}

void print_input(const PlannedInput& input) {
  const MeshPlan& whole = input.plan.whole;
  Facts facts{{input.is_scene ? "scene" : "mesh", input.path}};
  facts.emplace_back("blended", count_text(whole.facets) + " facets, alphas from " +
                                    number_text(static_cast<double>(whole.lowest_alpha)) + " to " +
                                    number_text(static_cast<double>(whole.highest_alpha)));
  facts.emplace_back("needs", needs_text(whole));
  if (whole.culls_where_apart) {
    facts.emplace_back("", "separate_culling_pass, proved: from eyes that see its convex parts side by side");
  }
  for (const LeftOut& left : whole.left_out) facts.emplace_back("left out", left.what + ": " + left.why);
  if (whole.layers_that_matter) {
    facts.emplace_back("layers that show", "the nearest " + count_text(*whole.layers_that_matter));
  }
  if (input.is_scene) {
    facts.emplace_back("objects", count_text(input.plan.objects.size()) + ", " +
                                      count_text(input.plan.blended_objects) + " of them blended, at most " +
                                      count_text(input.plan.most_overlapping) +
                                      " in a group that may overlap on the screen");
    for (const MeshPlan& object : input.plan.objects) {
      facts.emplace_back("  " + printable(object.name), needs_text(object));
    }
  }
  if (input.orbit) {
    facts.emplace_back("frames", count_text(input.orbit->frames) + " of a turn of " +
                                     number_text(std::min(360.0, input.orbit_degrees)) +
                                     " degrees: the last order held in " + count_text(input.orbit->kept) +
                                     ", nothing had to be sorted in " + count_text(input.orbit->unsorted));
  }
  facts.emplace_back("planned in", milliseconds_text(input.plan.plan_ms) + " ms");
  print_facts(facts);
  print_text("\n");
}

ExitStatus run_plan(const PlanVerbOptions& options, const CommonOptions& common) {
  std::vector<PlannedInput> inputs;
  for (const std::string& path : options.meshes) inputs.push_back(plan_file(path, options));
  if (common.json) {
    Json list = Json::array();
    for (const PlannedInput& input : inputs) list.push_back(input_json(input));
    print_json({{"error_budget", options.error_budget},
                {"frames", options.frames},
                {"views", options.views},
                {"size", {options.size.width, options.size.height}},
                {"orbit_degrees", options.orbit_degrees > 0 ? Json(options.orbit_degrees) : Json(nullptr)},
                {"meshes", list}});
    return ExitStatus::done;
  }
  for (const PlannedInput& input : inputs) print_input(input);
  print_text("Times and measured shares: " + std::to_string(options.views) + " views of " +
             std::to_string(options.size.width) + "x" + std::to_string(options.size.height) + " pixels at " +
             number_text(static_cast<double>(options.radii)) + " bounding radii.\n");
  return ExitStatus::done;
}

}  // namespace

Verb add_plan(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<PlanVerbOptions>();
  CLI::App* command = program.add_subcommand(
      "plan", "What a mesh or scene needs for a right picture, why, how sure that is, and what can be left out");
  command
      ->add_option("MESH", options->meshes,
                   "PLY, OBJ, OFF, STL or presorted .fsort files; or scenes: glTF files, or folders")
      ->required()
      ->type_name("");
  add_budget_option(*command, options->error_budget);
  command->add_flag("--additive", options->additive, "Colours are to be added, not blended over each other");
  add_count_option(*command, "--frames", options->frames, most_frames,
                   "Frames to be drawn: what is made once has to save more than it takes");
  add_count_option(*command, "--views", options->views, most_views, "Views in which strategies are timed and measured");
  add_size_option(*command, options->size, "Pixels of each");
  add_radii_option(*command, options->radii);
  command
      ->add_option("--orbit", options->orbit_degrees,
                   "Also turn a camera around by so many degrees a frame; tells in how many frames auto kept its order")
      ->check(CLI::Range(1e-6, 180.0))
      ->type_name("DEGREES");
  command->footer("Example: facetsort plan meshes/hand_2k.ply --budget 0.001 --size 512");
  return {command, [options, &common] { return run_plan(*options, common); }};
}

}  // namespace facetsort
