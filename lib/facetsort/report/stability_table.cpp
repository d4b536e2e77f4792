// The stability sweeps for a terminal.
#include <algorithm>
#include <ostream>
#include <string>

#include "facetsort/report/join.h"
#include "facetsort/report/stability.h"
#include "facetsort/report/stability_findings.h"
#include "facetsort/report/summary.h"

namespace facetsort {
namespace {

using Cells = std::vector<std::string>;

std::string first_points_text(const std::vector<PointRange>& ranges, const StabilitySweep& sweep) {
  std::string text;
  for (const std::size_t point : first_points(ranges, sweep.mildest)) {
    text += join(text.empty() ? "" : ", ", point_text(sweep.points[point]));
  }
  return text.empty() ? "-" : text;
}

Cells sweep_line(const StabilitySweep& sweep, std::size_t methods) {
  const SweepFindings findings = find_breaks(sweep, methods);
  Cells line{sweep.name};
  for (const auto& ranges : findings.broken) line.push_back(first_points_text(ranges, sweep));
  line.push_back(first_points_text(findings.lists_stop, sweep));
  line.push_back(first_points_text(findings.embree_stop, sweep));
  return line;
}

// A name on two lines, so that columns stay narrow.
std::pair<std::string, std::string> heading(const std::string& name) {
  const std::size_t underscore = name.find('_');
  if (underscore == std::string::npos) return {"", name};
  return {name.substr(0, underscore), name.substr(underscore + 1)};
}

void print_lines(std::ostream& out, const std::vector<Cells>& lines) {
  std::vector<std::size_t> widths(lines.front().size(), 0);
  for (const Cells& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  for (const Cells& line : lines) {
    std::string text = line[0] + std::string(widths[0] - line[0].size(), ' ');
    for (std::size_t i = 1; i < line.size(); ++i) text += std::string(widths[i] + 2 - line[i].size(), ' ') + line[i];
    out << text << "\n";
  }
}

}  // namespace

void print_stability(std::ostream& out, const Stability& stability) {
  std::vector<Cells> lines{{""}, {"sweep"}};
  for (const std::string& method : stability.methods) {
    const auto [above, below] = heading(method);
    lines[0].push_back(above);
    lines[1].push_back(below);
  }
  lines[0].insert(lines[0].end(), {"lists", "Embree"});
  lines[1].insert(lines[1].end(), {"stop", "stops"});
  for (const StabilitySweep& sweep : stability.sweeps) lines.push_back(sweep_line(sweep, stability.methods.size()));
  print_lines(out, lines);
  out << "\nThe mildest value at which over " << right_enough_percent
      << " % of the pixels or rays are inverted; - where none is. Two where it gets\n"
         "worse both ways. A referee stops where rounding leaves over "
      << static_cast<int>(100 * most_unjudged) << " % of what it sees open: nothing is counted there.\n";
}

}  // namespace facetsort
