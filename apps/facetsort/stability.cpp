// facetsort stability: one condition after the other driven to its extremes, and what each method makes of it.
#include "facetsort/report/stability.h"

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/report/machine.h"
#include "output.h"
#include "progress.h"
#include "stability_measure.h"
#include "stability_sweeps.h"
#include "staging_folder.h"
#include "verbs.h"

namespace facetsort {
namespace {

// Fewer pixels than this and a sweep that divides them sees next to nothing.
constexpr int fewest_pixels = 16, most_pixels = 4096;
constexpr const char *json_name = "stability.json", *csv_name = "stability.csv", *page_name = "stability.html";

struct StabilityOptions {
  std::vector<const Sweep*> sweeps;
  std::vector<StabilityMethod> methods = all_stability_methods();
  int size = 192;
  std::string output;
};

std::vector<const Sweep*> every_sweep() {
  std::vector<const Sweep*> sweeps;
  for (const Sweep& sweep : all_sweeps()) sweeps.push_back(&sweep);
  return sweeps;
}

// "a, b, c": the names of what `items` has.
template <typename Items, typename NameOf>
std::string names_of(const Items& items, const NameOf& name_of) {
  std::string names;
  for (const auto& item : items) names.append(names.empty() ? "" : ", ").append(name_of(item));
  return names;
}

std::string sweep_names() {
  return names_of(all_sweeps(), [](const Sweep& sweep) { return std::string(sweep.name); });
}

std::string method_names() {
  return names_of(all_stability_methods(), [](const StabilityMethod& method) { return method.name(); });
}

// In the order given, each once.
template <typename Item>
void add_once(std::vector<Item>& items, const Item& item) {
  if (std::find(items.begin(), items.end(), item) == items.end()) items.push_back(item);
}

std::vector<const Sweep*> parse_sweeps(const std::string& text) {
  std::vector<const Sweep*> sweeps;
  for (const std::string& name : CLI::detail::split(text, ',')) {
    const auto sweep =
        std::find_if(all_sweeps().begin(), all_sweeps().end(), [&](const Sweep& s) { return s.name == name; });
    if (sweep == all_sweeps().end()) {
      throw CLI::ValidationError("--sweeps", "no sweep is named '" + name + "'; there are " + sweep_names());
    }
    add_once(sweeps, &*sweep);
  }
  return sweeps;
}

std::vector<StabilityMethod> parse_methods(const std::string& text) {
  std::vector<StabilityMethod> methods;
  const std::vector<StabilityMethod> known = all_stability_methods();
  for (const std::string& name : CLI::detail::split(text, ',')) {
    const auto method =
        std::find_if(known.begin(), known.end(), [&](const StabilityMethod& m) { return m.name() == name; });
    if (method == known.end()) {
      throw CLI::ValidationError("--methods", "no method is named '" + name + "'; there are " + method_names());
    }
    add_once(methods, *method);
  }
  return methods;
}

StabilitySweep run_sweep(const Sweep& sweep, const StabilityOptions& options, Progress& progress) {
  StabilitySweep result{std::string(sweep.name),
                        std::string(sweep.title),
                        std::string(sweep.unit),
                        std::string(sweep.description),
                        {},
                        sweep.mildest};
  for (const SweepStop& stop : sweep.stops) {
    progress.show(result.title + ", " + (stop.place.empty() ? number_text(stop.value) : std::string(stop.place)));
    result.points.push_back(measure_stability(sweep.scene(stop, options.size), options.methods));
    result.points.back().value = stop.value;
    result.points.back().place = stop.place;
    progress.add(1);
  }
  return result;
}

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ExitStatus run_stability(const StabilityOptions& options, const CommonOptions& common) {
  StagingFolder folder(options.output);
  Stability stability;
  stability.machine = describe_machine();
  stability.command = common.command_line;
  stability.date = utc_time();
  stability.width = stability.height = options.size;
  stability.views = static_cast<int>(sweep_views);
  for (const StabilityMethod& method : options.methods) stability.methods.push_back(method.name());
  {
    double points = 0;
    for (const Sweep* sweep : options.sweeps) points += static_cast<double>(sweep->stops.size());
    Progress progress(points);
    for (const Sweep* sweep : options.sweeps) stability.sweeps.push_back(run_sweep(*sweep, options, progress));
  }

  require(write_stability_json(folder.path() / json_name, stability));
  require(write_stability_csv(folder.path() / csv_name, stability));
  require(write_stability_page(folder.path() / page_name, stability));
  const std::string json = common.json ? file_text(folder.path() / json_name) : "";
  folder.publish();
  if (common.json) {
    print_text(json);
  } else {
    print_stability(std::cout, stability);
    print_text("\nThe page: " + printable((std::filesystem::path(options.output) / page_name).string()) + "\n");
  }
  return ExitStatus::done;
}

}  // namespace

Verb add_stability(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<StabilityOptions>();
  options->sweeps = every_sweep();
  CLI::App* command = program.add_subcommand(
      "stability",
      "Where each method breaks when one condition is driven to its extremes: stability.json, .csv, .html");
  command
      ->add_option_function<std::string>(
          "--sweeps", [options](const std::string& text) { options->sweeps = parse_sweeps(text); },
          "Any of " + sweep_names() + " [all]")
      ->type_name("A,B,...");
  command
      ->add_option_function<std::string>(
          "--methods", [options](const std::string& text) { options->methods = parse_methods(text); },
          "Any of " + method_names() + " [all]")
      ->type_name("A,B,...");
  command->add_option("--size", options->size, "Width and height of the pictures; fewer where there are many layers")
      ->check(CLI::Range(fewest_pixels, most_pixels))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--out", options->output, "Folder of the report; made where it is missing")
      ->required()
      ->type_name("DIR");
  command->footer("Example: facetsort stability --sweeps origin_distance,scale --out report");
  return {command, [options, &common] { return run_stability(*options, common); }};
}

}  // namespace facetsort
