// facetsort: puts the facets of self-transparent meshes in back-to-front order, checks orders, compares strategies.
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/report/machine.h"
#include "failure.h"
#include "output.h"
#include "verbs.h"

namespace facetsort {
namespace {

constexpr int most_threads = 1024;
constexpr std::size_t help_column = 30;

void add_common_options(CLI::App& command, CommonOptions& common) {
  command.add_flag("--json", common.json, "One JSON document on standard output and nothing else there");
  add_count_option(command, "--threads", common.threads, most_threads, "Threads to run on [one a hardware thread]");
}

ExitStatus fail(const std::string& message) {
  print_failure(message);
  return ExitStatus::failed;
}

std::string verb_names(const std::vector<Verb>& verbs) {
  std::string names;
  for (const Verb& verb : verbs) names += (names.empty() ? "" : ", ") + verb.command->get_name();
  return names;
}

// An arena may have more threads than the machine, or fewer; the global limit also holds for what Embree starts.
ExitStatus run_on_threads(const Verb& verb, int threads) {
  std::optional<tbb::global_control> limit;
  if (threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  }
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  return arena.execute(verb.run);
}

ExitStatus run(int argc, char** argv) {
  CommonOptions common;
  common.command_line = quoted_command_line(argc, argv);
  CLI::App program(
      "Puts the triangles of self-transparent meshes in back-to-front order, proves how right an order is, "
      "and says what it costs.",
      "facetsort");
  program.set_version_flag("--version", "facetsort " FACETSORT_VERSION);
  program.get_formatter()->column_width(help_column);
  program.require_subcommand(0, 1);  // none, and what stands in its place, are told below
  program.footer(
      "facetsort VERB --help tells a verb's options and has an example.\n"
      "Exit status: 0 done; 1 the answer is no; 2 bad usage or bad input, with one line that says which.");
  const std::vector<Verb> verbs = {add_inspect(program, common),  add_order(program, common),
                                   add_presort(program, common),  add_blend(program, common),
                                   add_check(program, common),    add_compare(program, common),
                                   add_plan(program, common),     add_stability(program, common)};
  for (const Verb& verb : verbs) add_common_options(*verb.command, common);

  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help_or_version) {
    program.exit(help_or_version);
    return ExitStatus::done;
  } catch (const CLI::ParseError& error) {
    return fail(error.what());
  }
  const auto named = [](const Verb& verb) { return verb.command->parsed(); };
  const auto verb = std::find_if(verbs.begin(), verbs.end(), named);
  if (verb == verbs.end()) return fail("a verb is needed: " + verb_names(verbs) + "; see facetsort --help");
  return run_on_threads(*verb, common.threads);
}

ExitStatus run_and_report(int argc, char** argv) {
  try {
    const ExitStatus status = run(argc, argv);
    if (!std::cout.flush()) return fail("standard output cannot be written");
    return status;
  } catch (const Failure& failure) {
    return fail(failure.what());
  } catch (const std::bad_alloc&) {
    return fail("out of memory");
  } catch (const std::exception& error) {
    return fail(error.what());
  }
}

}  // namespace
}  // namespace facetsort

int main(int argc, char** argv) {
  return static_cast<int>(facetsort::run_and_report(argc, argv));
}
