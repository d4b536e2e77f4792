// facetsort compare: every strategy on every mesh, error beside run time, as a report.
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/report/difference_image.h"
#include "facetsort/report/image_file.h"
#include "facetsort/report/machine.h"
#include "facetsort/report/plots.h"
#include "facetsort/report/write_report.h"
#include "input_mesh.h"
#include "measure.h"
#include "output.h"
#include "progress.h"
#include "staging_folder.h"
#include "verbs.h"

namespace facetsort {
namespace {

constexpr int most_views = 10000, most_repeats = 10000;
constexpr const char* pictures_folder = "pictures";

struct CompareOptions {
  std::vector<std::string> meshes;
  std::vector<Strategy> strategies;  // none: all that need no number
  int views = 4, repeats = 5;
  PictureSize size;
  float radii = 2.5f;
  bool orthographic = false;
  int inside = 0;  // eyes; none: around the mesh
  PixelFormat format = PixelFormat::rgba32f;
  std::string output;
};

// In the order given, each once.
std::vector<Strategy> parse_strategies(const std::string& text) {
  std::vector<Strategy> strategies;
  for (const std::string& name : CLI::detail::split(text, ',')) {
    const Strategy strategy = parse_strategy("--strategies", name);
    if (std::find(strategies.begin(), strategies.end(), strategy) == strategies.end()) strategies.push_back(strategy);
  }
  return strategies;
}

std::vector<Strategy> strategies_for(const InputMesh& mesh, const CompareOptions& options) {
  if (!options.strategies.empty()) return options.strategies;
  std::vector<Strategy> strategies = all_strategies();
  if (!mesh.scene) return strategies;
  for (const DrawOrderRule rule : all_draw_order_rules()) {
    strategies.push_back({.kind = StrategyKind::draw_order, .rule = rule});
  }
  return strategies;
}

// All of them, before any work is done: one bad file among several is met at once.
std::vector<InputMesh> read_meshes(const std::vector<std::string>& paths) {
  std::vector<InputMesh> meshes;
  for (const std::string& path : paths) {
    InputMesh mesh = read_input_scene(path);
    for (const InputMesh& other : meshes) {
      if (other.name != mesh.name) continue;
      throw Failure(path + ": another mesh of the comparison is named '" + mesh.name + "' too: " + other.path.string());
    }
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

// The page's plots come last, after minutes of work: better to know at once that they can be drawn.
void require_plots() {
  Plot plot{"", "wrong pixels", {{1, 0.5, "", {7, "#000000"}, false}}};
  require(draw_plots(std::array{std::move(plot)}));
}

std::vector<View> mesh_views(const InputMesh& mesh, const CompareOptions& options) {
  std::vector<View> views =
      options.inside > 0 ? views_inside(mesh.bounds, options.inside)
                         : views_around(mesh.bounds, options.views, options.radii,
                                        options.orthographic ? Projection::orthographic : Projection::perspective);
  for (View& view : views) {
    view.width = options.size.width;
    view.height = options.size.height;
    const Status status = validate(view);
    if (!status.ok()) throw Failure(mesh.path.string() + ": " + status.message);
  }
  return views;
}

int view_count(const CompareOptions& options) {
  return options.inside > 0 ? 6 * options.inside : options.views;
}

// About what time a row is proportional to: facets are set up and sorted, pixels are shaded and compared.
double row_work(const InputMesh& mesh, const CompareOptions& options) {
  return static_cast<double>(mesh.mesh.triangles.size()) + 0.1 * options.size.width * options.size.height;
}

// A strategy's name without the colon, which some file systems refuse.
std::string picture_stem(const Row& row) {
  std::string stem = row.mesh + "." + row.strategy;
  std::replace(stem.begin(), stem.end(), ':', '.');
  return stem;
}

ReportPicture write_pictures(const std::filesystem::path& folder, const MeasuredStrategy& measured,
                             const Image& reference) {
  const Row& row = measured.row;
  const std::filesystem::path pictures(pictures_folder);
  ReportPicture entry{row.mesh, row.strategy, (pictures / (picture_stem(row) + ".png")).string(), ""};
  if (row.strategy == Strategy{.kind = StrategyKind::reference}.name()) {
    require(write_image(folder / entry.picture, measured.picture));
    return entry;
  }
  entry.difference = (pictures / (picture_stem(row) + ".difference.png")).string();
  Status picture, difference;
  tbb::parallel_invoke(
      [&] { picture = write_image(folder / entry.picture, measured.picture); },
      [&] { difference = write_image(folder / entry.difference, difference_image(measured.picture, reference)); });
  require(picture);
  require(difference);
  return entry;
}

// Rows, pictures and summary of one mesh.
void compare_on_mesh(const InputMesh& mesh, const CompareOptions& options, const std::filesystem::path& folder,
                     Progress& progress, Comparison& comparison) {
  const EmbreeReferee referee = require(EmbreeReferee::create(mesh.mesh.view()));
  MeshSummary summary;
  summary.name = mesh.name;
  summary.facets = mesh.mesh.triangles.size();
  std::size_t fragments = 0, covered_pixels = 0;
  Agreement agreement;

  const std::vector<View> views = mesh_views(mesh, options);
  const std::vector<Strategy> strategies = strategies_for(mesh, options);
  std::vector<PreparedStrategy> prepared(strategies.size());
  for (int index = 0; index < view_count(options); ++index) {
    const std::string where =
        mesh.name + ", view " + std::to_string(index + 1) + " of " + std::to_string(views.size()) + ", ";
    progress.show(where + "referees");
    const RefereedView refereed = referee_view(mesh, referee, views[static_cast<std::size_t>(index)], options.format);
    fragments += refereed.lists.fragments.size();
    for (std::size_t pixel = 0; pixel < refereed.reference.pixels.size(); ++pixel) {
      const std::size_t layers = refereed.lists.pixel(pixel).size();
      covered_pixels += layers > 0;
      summary.most_layers = std::max(summary.most_layers, layers);
    }
    const Agreement in_view = compare_referees(mesh, refereed);
    agreement.judged += in_view.judged;
    agreement.agreeing += in_view.agreeing;

    for (std::size_t i = 0; i < strategies.size(); ++i) {
      const Strategy& strategy = strategies[i];
      progress.show(where + strategy.name());
      MeasuredStrategy measured =
          measure_strategy(mesh, strategy, refereed, static_cast<std::size_t>(options.repeats), prepared[i]);
      measured.row.view = index;
      if (index == 0) comparison.pictures.push_back(write_pictures(folder, measured, refereed.reference));
      comparison.rows.push_back(std::move(measured.row));
      progress.add(row_work(mesh, options));
    }
  }
  if (covered_pixels > 0) {
    summary.mean_layers = static_cast<double>(fragments) / static_cast<double>(covered_pixels);
  }
  if (agreement.judged > 0) {
    summary.embree_agreement = static_cast<double>(agreement.agreeing) / static_cast<double>(agreement.judged);
  }
  comparison.meshes.push_back(summary);
}

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

ExitStatus run_compare(const CompareOptions& options, const CommonOptions& common) {
  const std::vector<InputMesh> meshes = read_meshes(options.meshes);
  require_plots();
  StagingFolder folder(options.output);
  std::filesystem::create_directory(folder.path() / pictures_folder);

  Comparison comparison;
  comparison.machine = describe_machine();
  comparison.command = common.command_line;
  comparison.date = utc_time();
  comparison.width = options.size.width;
  comparison.height = options.size.height;
  comparison.views = view_count(options);
  comparison.has_stability_page = std::filesystem::exists(std::filesystem::path(options.output) / "stability.html");
  {
    double work = 0;
    for (const InputMesh& mesh : meshes) {
      work += row_work(mesh, options) * static_cast<double>(strategies_for(mesh, options).size()) * view_count(options);
    }
    Progress progress(work);
    for (const InputMesh& mesh : meshes) compare_on_mesh(mesh, options, folder.path(), progress, comparison);
  }

  require(write_json(folder.path() / "results.json", comparison));
  require(write_csv(folder.path() / "results.csv", comparison));
  require(write_page(folder.path() / "index.html", comparison));
  const std::string json = common.json ? file_text(folder.path() / "results.json") : "";
  folder.publish();
  if (common.json) {
    print_text(json);
  } else {
    print_summary(std::cout, comparison);
    print_text("\nThe page: " + printable((std::filesystem::path(options.output) / "index.html").string()) + "\n");
  }
  return ExitStatus::done;
}

}  // namespace

Verb add_compare(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<CompareOptions>();
  CLI::App* command = program.add_subcommand(
      "compare", "Every strategy on every mesh, its error beside its run time: results.json, results.csv, index.html");
  command->add_option("MESH", options->meshes, "PLY, OBJ, OFF, STL or presorted .fsort files; or scenes: glTF files, or folders")
      ->required()
      ->type_name("");
  command
      ->add_option_function<std::string>(
          "--strategies", [options](const std::string& text) { options->strategies = parse_strategies(text); },
          "Any of " + strategy_names() + " [all]")
      ->type_name("A,B,...");
  CLI::Option* views = add_count_option(*command, "--views", options->views, most_views, "Eyes around each mesh");
  add_size_option(*command, options->size, "Pixels of the pictures");
  CLI::Option* radii = add_radii_option(*command, options->radii);
  CLI::Option* ortho =
      command->add_flag("--ortho", options->orthographic, "Orthographic, two bounding radii high [perspective]");
  add_count_option(*command, "--inside", options->inside, most_views,
                   "Eyes within each mesh's box instead, each with six views of 90 degrees")
      ->excludes(views)
      ->excludes(radii)
      ->excludes(ortho);
  add_format_option(*command, options->format);
  add_count_option(
      *command, "--repeats", options->repeats, most_repeats,
      "Timed frames of each strategy in each view, after one that is not; fewer where they take over a second");
  command->add_option("--out", options->output, "Folder of the report; made where it is missing")
      ->required()
      ->type_name("DIR");
  command->footer("Example: facetsort compare meshes/*.ply --views 8 --out report");
  return {command, [options, &common] { return run_compare(*options, common); }};
}

}  // namespace facetsort
