// Plots of error against run time, drawn by gnuplot as SVG that goes inside a page. Internal to report.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "facetsort/base/status.h"

namespace facetsort {

// How a strategy is marked in every plot and legend.
struct Mark {
  int symbol = 7;      // gnuplot's point type, 1 to 15
  std::string colour;  // "#rrggbb", to be legible on white and on near black
};

struct PlotPoint {
  double milliseconds = 0;
  double rate = 0;      // 0 is shown on a line of its own under the logarithmic axis
  std::string tooltip;  // plain text
  Mark mark;
  bool background = false;  // small and faint, behind the others
};

struct Plot {
  std::string description;  // for those who do not see it; plain text
  std::string rate_label;   // of the vertical axis; letters, spaces and commas only
  std::vector<PlotPoint> points;
};

struct DrawnPlots {
  // The shapes of the marks, to be placed once in the page, before any plot or legend: "gpPt" and the symbol - 1.
  std::string definitions;
  std::vector<std::string> svgs;  // one a plot: <svg> elements
};

// Runs gnuplot (found on PATH) once, in a private temporary folder that is gone afterwards. No text but rate_label
// reaches its script. Both axes are logarithmic; times and rates below what they can show (1 ns; 1e-9) are moved there.
// Preconditions: at least one plot, and each has a point.
Result<DrawnPlots> draw_plots(std::span<const Plot> plots);

}  // namespace facetsort
