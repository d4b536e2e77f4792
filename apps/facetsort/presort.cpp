// facetsort presort: all the work once, an order for any eye afterwards.
#include "facetsort/exact/presort.h"

#include <sys/resource.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "arguments.h"
#include "facetsort/exact/exact_sorter.h"
#include "facetsort/order/presorted_mesh.h"
#include "facetsort/presort/index_buffers.h"
#include "facetsort/presort/write_gltf.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/timing.h"
#include "input_mesh.h"
#include "order_file.h"
#include "output.h"
#include "progress.h"
#include "verbs.h"

namespace facetsort {
namespace {

constexpr int most_effort = 1000;

struct PresortVerbOptions {
  std::vector<std::string> meshes;
  std::filesystem::path output;
  int effort = 1;  // of a tree
  std::optional<double> max_growth;
  int buffers = 0;  // 0: a tree, unless max_error is given
  std::optional<double> max_error;
  bool with_culling = false, cut_crossing = false;

  bool makes_buffers() const { return buffers > 0 || max_error.has_value(); }
};

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void interrupt(int) {
  interrupted = true;
}

// While this is there, a first interrupt cancels the work, and a second one ends the program.
class InterruptGuard {
 public:
  InterruptGuard() {
    struct sigaction action {};
    action.sa_handler = interrupt;
    action.sa_flags = static_cast<int>(SA_RESETHAND);
    sigaction(SIGINT, &action, &before_);
  }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard() { sigaction(SIGINT, &before_, nullptr); }

 private:
  struct sigaction before_ {};
};

// Shows how far the work is, and passes an interrupt on to it, until it is gone.
class Watch {
 public:
  Watch(const std::string& what, PresortProgress& work)
      : thread_([this, what, &work](const std::stop_token& stop) { run(stop, what, work); }) {}

 private:
  void run(const std::stop_token& stop, const std::string& what, PresortProgress& work) {
    Progress progress(1);
    while (!stop.stop_requested()) {
      const auto all = static_cast<double>(work.all.load());
      if (all > 0) progress.reach(static_cast<double>(work.done.load()) / all);
      progress.show(what);
      if (interrupted) work.cancelled = true;
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, stop, std::chrono::milliseconds(100), [] { return false; });
    }
  }

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::jthread thread_;
};

std::size_t peak_memory_bytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
}

// What became of one mesh.
struct Outcome {
  std::string mesh, output;
  std::size_t facets = 0;
  PresortStatistics statistics;         // of a tree
  std::optional<IndexBuffers> buffers;  // or these
  double presort_ms = 0, write_ms = 0;
  std::uintmax_t file_bytes = 0;
  std::size_t peak_bytes = 0;  // of the program, up to here
  bool misses_max_error = false;

  double growth() const {
    return facets == 0 ? 1 : static_cast<double>(statistics.triangles) / static_cast<double>(facets);
  }
};

Presorted presort_input(const InputMesh& input, const PresortVerbOptions& options) {
  PresortOptions presort_options{.effort = static_cast<std::size_t>(options.effort)};
  presort_options.max_growth = options.max_growth.value_or(presort_options.max_growth);
  PresortProgress progress;
  std::optional<Presorted> presorted;
  {
    const Watch watch(input.name, progress);
    presorted = presort(input.mesh.view(), presort_options, &progress);
  }
  if (interrupted) throw Failure(input.path.string() + ": interrupted; nothing was written for it");
  if (!presorted) {
    throw Failure(input.path.string() + ": --max-growth " + number_text(presort_options.max_growth) +
                  " is not enough for this mesh");
  }
  return std::move(*presorted);
}

IndexBuffers make_buffers(const InputMesh& input, const MeshView& mesh, const PresortVerbOptions& options) {
  IndexBuffersOptions buffer_options{.most_buffers = Strategy::most_buffers,
                                     .max_error = options.max_error,
                                     .with_culling = options.with_culling};
  if (options.buffers > 0) buffer_options.most_buffers = static_cast<std::size_t>(options.buffers);
  Progress progress(1);
  buffer_options.progress = [&](double share) {
    progress.reach(share);
    progress.show(input.name);
    return !interrupted;
  };
  IndexBuffers buffers = make_index_buffers(mesh, buffer_options);
  if (interrupted) throw Failure(input.path.string() + ": interrupted; nothing was written for it");
  return buffers;
}

void presort_into_buffers(const InputMesh& input, const std::filesystem::path& output,
                          const PresortVerbOptions& options, Outcome& outcome) {
  Mesh cut;
  if (options.cut_crossing) {
    ExactOptions exact;
    exact.max_growth = options.max_growth.value_or(exact.max_growth);
    cut = mesh_of(input.mesh, ExactSorter(input.mesh.view(), exact).triangles());
  }
  const MeshView mesh = options.cut_crossing ? cut.view() : input.mesh.view();
  outcome.statistics.triangles = mesh.facet_count();
  outcome.presort_ms = time_median([&] { outcome.buffers = make_buffers(input, mesh, options); }, 1).median_ms;
  outcome.misses_max_error = options.max_error && outcome.buffers->mean_inverted_rate > *options.max_error;
  const auto write = [&] {
    if (extension_of(output) == ".fsort") {
      PresortedView no_tree;
      no_tree.mesh = mesh;
      require(write_presorted(output, no_tree, &*outcome.buffers));
    } else {
      require(write_gltf(output, mesh, *outcome.buffers));
    }
  };
  outcome.write_ms = time_median(write, 1).median_ms;
}

void presort_into_tree(const InputMesh& input, const std::filesystem::path& output, const PresortVerbOptions& options,
                       Outcome& outcome) {
  std::optional<Presorted> presorted;
  outcome.presort_ms = time_median([&] { presorted = presort_input(input, options); }, 1).median_ms;
  outcome.statistics = presorted->statistics;
  outcome.write_ms = time_median([&] { require(write_presorted(output, presorted->data.view())); }, 1).median_ms;
}

Outcome presort_file(const std::string& path, const std::filesystem::path& output, const PresortVerbOptions& options) {
  const InputMesh input = read_input_mesh(path);
  Outcome outcome;
  outcome.mesh = path;
  outcome.output = output.string();
  outcome.facets = input.mesh.triangles.size();
  if (options.makes_buffers()) {
    presort_into_buffers(input, output, options, outcome);
  } else {
    presort_into_tree(input, output, options, outcome);
  }
  outcome.file_bytes = std::filesystem::file_size(output);
  outcome.peak_bytes = peak_memory_bytes();
  return outcome;
}

Json outcome_json(const Outcome& outcome) {
  const PresortStatistics& s = outcome.statistics;
  Json json = {{"mesh", outcome.mesh}, {"facets", outcome.facets}};
  if (outcome.buffers) {
    json["buffers"] = outcome.buffers->buffer_count;
    json["directions"] = outcome.buffers->directions.size();
    json["needs_culling"] = outcome.buffers->needs_culling;
    json["mean_inverted_rate"] = outcome.buffers->mean_inverted_rate;
    json["worst_inverted_rate"] = outcome.buffers->worst_inverted_rate;
    json["misses_max_error"] = outcome.misses_max_error;
  } else {
    json["crossing_pairs"] = s.crossing_pairs;
    json["crossing_cuts"] = s.crossing_cuts;
    json["tree_cuts"] = s.tree_cuts;
    json["nodes"] = s.nodes;
    json["pieces"] = s.pieces;
    json["part_ms"] = s.part_ms;
    json["tree_ms"] = s.tree_ms;
    json["triangulate_ms"] = s.triangulate_ms;
  }
  json["triangles_out"] = s.triangles;
  json["growth"] = outcome.growth();
  json["presort_ms"] = outcome.presort_ms;
  json["write_ms"] = outcome.write_ms;
  json["file_bytes"] = outcome.file_bytes;
  json["peak_memory_bytes"] = outcome.peak_bytes;
  json["output"] = outcome.output;
  return json;
}

std::string megabytes_text(double bytes) {
  return fixed_text(bytes / 1e6, 1) + " MB";
}

Facts outcome_facts(const Outcome& outcome) {
  const PresortStatistics& s = outcome.statistics;
  Facts facts{{"mesh", outcome.mesh}, {"facets", count_text(outcome.facets)}};
  if (outcome.buffers) {
    const IndexBuffers& buffers = *outcome.buffers;
    facts.emplace_back("buffers", count_text(buffers.buffer_count) + " of " + count_text(s.triangles) +
                                      " triangles for " + count_text(buffers.directions.size()) + " directions" +
                                      (buffers.needs_culling ? ", drawn without back faces" : ""));
    facts.emplace_back("inverted", percent_text(buffers.mean_inverted_rate) + " % of the pixels in the mean, " +
                                       percent_text(buffers.worst_inverted_rate) + " % in the worst view");
    if (outcome.misses_max_error) facts.emplace_back("NOT REACHED", "--max-error, by no number of buffers up to this");
  } else {
    facts.emplace_back("crossing", count_text(s.crossing_pairs) + " pairs of facets, parted by " +
                                       count_text(s.crossing_cuts) + " cuts");
    facts.emplace_back("tree", count_text(s.nodes) + " planes, " + count_text(s.tree_cuts) + " cuts");
    facts.emplace_back("drawn", count_text(s.pieces) + " pieces, " + count_text(s.triangles) + " triangles: growth " +
                                    fixed_text(outcome.growth(), 3));
  }
  facts.emplace_back("times", milliseconds_text(outcome.presort_ms) + " ms to presort, " +
                                  milliseconds_text(outcome.write_ms) + " ms to write");
  facts.emplace_back("memory", megabytes_text(static_cast<double>(outcome.peak_bytes)) + " at most");
  facts.emplace_back("output", outcome.output + ", " + megabytes_text(static_cast<double>(outcome.file_bytes)));
  return facts;
}

// Where each mesh goes: to the one file named, or into the folder.
std::vector<std::filesystem::path> output_files(const PresortVerbOptions& options) {
  if (options.meshes.size() == 1 && options.output.has_filename() && !std::filesystem::is_directory(options.output)) {
    if (options.makes_buffers()) {
      require_output_file(options.output, {".fsort", ".glb", ".gltf"});
    } else {
      require_output_file(options.output, {".fsort"});
    }
    return {options.output};
  }
  std::vector<std::filesystem::path> files;
  for (const std::string& mesh : options.meshes) {
    std::filesystem::path file = options.output / std::filesystem::path(mesh).stem();
    file += ".fsort";
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (files[i] == file) throw Failure(mesh + ": " + options.meshes[i] + " would become " + file.string() + " too");
    }
    files.push_back(std::move(file));
  }
  std::error_code error;
  std::filesystem::create_directories(options.output, error);
  if (error) throw Failure(options.output.string() + ": cannot make this folder: " + error.message());
  return files;
}

ExitStatus run_presort(const PresortVerbOptions& options, const CommonOptions& common) {
  if (!options.makes_buffers() && (options.with_culling || options.cut_crossing)) {
    throw Failure("--with-culling and --cut are options of --buffers and --max-error");
  }
  if (options.makes_buffers() && options.effort > 1) throw Failure("--effort is an option of trees, not of buffers");
  if (options.makes_buffers() && options.max_growth && !options.cut_crossing) {
    throw Failure("--max-growth is an option of trees and of --cut: nothing else cuts");
  }
  const std::vector<std::filesystem::path> files = output_files(options);
  const InterruptGuard guard;
  Json documents = Json::array();
  ExitStatus status = ExitStatus::done;
  for (std::size_t i = 0; i < files.size(); ++i) {
    Outcome outcome;
    try {
      outcome = presort_file(options.meshes[i], files[i], options);
    } catch (const Failure& failure) {  // each mesh is on its own
      print_failure(failure.what());
      status = ExitStatus::failed;
      if (interrupted) break;
      continue;
    }
    if (outcome.misses_max_error && status == ExitStatus::done) status = ExitStatus::answer_is_no;
    if (common.json) {
      documents.push_back(outcome_json(outcome));
    } else {
      if (i > 0) print_text("\n");
      print_facts(outcome_facts(outcome));
    }
  }
  if (common.json && !documents.empty()) print_json(documents);
  return status;
}

}  // namespace

Verb add_presort(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<PresortVerbOptions>();
  CLI::App* command = program.add_subcommand(
      "presort", "Does all the work once: a file from which an exact order for any eye is read without sorting");
  command->add_option("MESH", options->meshes, "PLY, OBJ, OFF, STL or .fsort files, each presorted by itself")
      ->required()
      ->type_name("");
  add_count_option(*command, "--effort", options->effort, most_effort,
                   "How many planes are tried at each node of the tree: more time, fewer cuts [1]");
  add_growth_option(*command, options->max_growth);
  add_count_option(*command, "--buffers", options->buffers, static_cast<int>(Strategy::most_buffers),
                   "Plain index buffers in place of a tree, for engines that draw them as they are: so many, made for "
                   "all directions with as few inverted pixels as can be");
  add_error_option(*command, options->max_error);
  command->add_flag("--with-culling", options->with_culling, "For engines that leave out facets seen from behind");
  command->add_flag("--cut", options->cut_crossing, "Cut facets that cross before their buffers are made");
  command
      ->add_option("-o,--output", options->output,
                   "OUT.fsort; with index buffers OUT.glb or OUT.gltf too; or, and always with several meshes, a "
                   "folder (OUT/), in which each becomes NAME.fsort")
      ->required()
      ->type_name("OUT");
  command->footer("Example: facetsort presort meshes/teapot_1k.ply meshes/hand_2k.ply -o presorted");
  return {command, [options, &common] { return run_presort(*options, common); }};
}

}  // namespace facetsort
