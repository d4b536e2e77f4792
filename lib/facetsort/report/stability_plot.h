// The plot of a stability sweep as SVG inside a page: error against the condition, a line a method. Internal to report.
//
// Drawn here and not by gnuplot: exact zeros have a row a method, so that methods that are all right do not hide one
// another; points that a referee can't judge are marked as such; places that are no number stand left of the axis.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "facetsort/report/stability.h"

namespace facetsort {

// How many looks there are; method i has look i modulo this in every plot and legend.
inline constexpr std::size_t stability_looks = 8;

// To be placed once in the page, before any plot or legend: the shapes of the marks as SVG symbols "look-0" ..., and
// the style of plots, with a class "look-0" ... for each method's colour.
std::string stability_marks();
extern const char* const stability_plot_style;

// A mark for a legend or a table.
std::string stability_mark(std::size_t method);

std::string stability_plot(const StabilitySweep& sweep, const std::vector<std::string>& methods);

}  // namespace facetsort
