// The comparison for a terminal.
#include <algorithm>
#include <ostream>
#include <string>

#include "facetsort/report/join.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/summary.h"
#include "facetsort/report/write_report.h"

namespace facetsort {
namespace {

constexpr std::size_t number_width = 12;

// Names come from files: a control character could drive the terminal.
std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string padded_left(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, text.size()), ' ') + text;
}

std::string padded_right(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, text.size()), ' ');
}

std::string rate_text(const RateSummary& rate) {
  if (rate.mean) return percent_text(*rate.mean);
  return rate.not_judged ? "not judged" : "-";
}

std::string mesh_heading(const MeshSummary& mesh) {
  std::string heading = printable(mesh.name) + ": " + count_text(mesh.facets) + " facets";
  if (mesh.most_layers > 0) {
    heading +=
        ", " + fixed_text(mesh.mean_layers, 1) + " layers on average, " + count_text(mesh.most_layers) + " at most";
  }
  return heading;
}

std::string recommendation_text(const MeshResults& results) {
  if (!results.recommendation) return "  no strategy could be judged\n";
  if (results.recommendation->is_right_enough) return "";
  return join("  no strategy stays under ", right_enough_percent, " % wrong pixels here; * is the most right\n");
}

std::string overall_text(const Summary& summary) {
  if (!summary.recommendation) return "";
  const std::string& name = summary.recommendation->strategy;
  const auto overall = std::find_if(summary.overall.begin(), summary.overall.end(),
                                    [&](const OverallResults& results) { return results.strategy == name; });
  return join("Over all: ", printable(name), "\n  under ", right_enough_percent, " % wrong pixels on ",
              count_text(overall->right_meshes), " of ", count_text(overall->judged_meshes), " meshes, ",
              percent_text(*overall->mean_error), " % in the mean, ", milliseconds_text(overall->median_frame_ms),
              " ms a frame\n");
}

}  // namespace

void print_summary(std::ostream& out, const Comparison& comparison) {
  const Summary summary = summarise(comparison);
  std::size_t name_width = 8;
  for (const std::string& strategy : summary.strategies) name_width = std::max(name_width, strategy.size());
  out << padded_right("  strategy", name_width + 2);
  for (const char* heading : {"inverted %", "wrong %", "order ms", "blend ms"})
    out << padded_left(heading, number_width);
  out << "\n";
  for (const MeshResults& results : summary.meshes) {
    out << "\n" << mesh_heading(results.mesh) << "\n";
    for (const StrategySummary& strategy : results.strategies) {
      const bool taken = results.recommendation && results.recommendation->strategy == strategy.strategy;
      out << (taken ? "* " : "  ") << padded_right(printable(strategy.strategy), name_width)
          << padded_left(rate_text(strategy.inverted), number_width)
          << padded_left(rate_text(strategy.wrong), number_width)
          << padded_left(milliseconds_text(strategy.order.median_ms), number_width)
          << padded_left(milliseconds_text(strategy.blend.median_ms), number_width) << "\n";
    }
    out << recommendation_text(results);
  }
  out << "\n* take this: the fastest under " << right_enough_percent
      << " % wrong pixels (within 10 % is as fast), or the most right.\n"
      << "Rates are means, times medians, over the views.\n"
      << overall_text(summary);
}

}  // namespace facetsort
