// The verbs of the program: each adds its options to the command line and gives what to run when it was named.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "failure.h"

namespace facetsort {

// What every verb takes.
struct CommonOptions {
  bool json = false;         // one JSON document on standard output and nothing else there
  int threads = 0;           // 0: one a hardware thread
  std::string command_line;  // as typed, quoted for a shell
};

struct Verb {
  CLI::App* command;
  std::function<ExitStatus()> run;  // throws Failure; runs in a task arena of the threads asked for
};

// `common` is filled in before `run` is called, and must outlive it.
Verb add_inspect(CLI::App& program, const CommonOptions& common);
Verb add_order(CLI::App& program, const CommonOptions& common);
Verb add_presort(CLI::App& program, const CommonOptions& common);
Verb add_blend(CLI::App& program, const CommonOptions& common);
Verb add_check(CLI::App& program, const CommonOptions& common);
Verb add_compare(CLI::App& program, const CommonOptions& common);
Verb add_plan(CLI::App& program, const CommonOptions& common);
Verb add_stability(CLI::App& program, const CommonOptions& common);

}  // namespace facetsort
