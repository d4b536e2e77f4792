#include "facetsort/report/machine.h"

#include <tbb/task_arena.h>

#include <ctime>
#include <fstream>
#include <string_view>
#include <utility>

namespace facetsort {
namespace {

// With its widest vector instructions of those that kernels are built for: names of processors tell little.
std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  std::string name, flags;
  for (std::string line; (name.empty() || flags.empty()) && std::getline(file, line);) {
    const std::size_t colon = line.find(": ");
    if (colon == std::string::npos) continue;
    if (line.starts_with("model name")) name = line.substr(colon + 2);
    if (line.starts_with("flags")) flags = line.substr(colon + 1) + ' ';
  }
  if (name.empty()) return "processor unknown";
  for (const auto& [flag, instructions] : {std::pair{" avx512dq ", "AVX-512"}, std::pair{" avx2 ", "AVX2"}}) {
    if (flags.find(flag) != std::string::npos) return name + " (" + instructions + ")";
  }
  return name;
}

std::string compiler_name() {
#if defined(__clang__)
  return "Clang " __clang_version__;
#else
  return "GCC " __VERSION__;
#endif
}

std::string quoted(std::string_view argument) {
  constexpr std::string_view plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!argument.empty() && argument.find_first_not_of(plain) == std::string_view::npos) return std::string(argument);
  std::string text = "'";
  for (const char c : argument) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

}  // namespace

std::string describe_machine() {
  const int threads = tbb::this_task_arena::max_concurrency();
  return processor_name() + ", " + std::to_string(threads) + (threads == 1 ? " thread, " : " threads, ") +
         compiler_name();
}

std::string utc_time() {
  const std::time_t now = std::time(nullptr);
  std::tm fields{};
  gmtime_r(&now, &fields);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &fields);
  return text;
}

std::string quoted_command_line(int argc, const char* const* argv) {
  std::string line;
  for (int i = 0; i < argc; ++i) {
    if (i > 0) line += ' ';
    line += quoted(argv[i]);
  }
  return line;
}

}  // namespace facetsort
