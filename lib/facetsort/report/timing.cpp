#include "facetsort/report/timing.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace facetsort {
namespace {

// `sorted` at `share` of the way from its first to its last element.
double quantile(const std::vector<double>& sorted, double share) {
  const double position = share * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return std::lerp(sorted[below], sorted[above], position - static_cast<double>(below));
}

}  // namespace

Timing median_and_spread(std::vector<double> milliseconds) {
  assert(!milliseconds.empty());
  std::sort(milliseconds.begin(), milliseconds.end());
  return {quantile(milliseconds, 0.5), quantile(milliseconds, 0.75) - quantile(milliseconds, 0.25)};
}

}  // namespace facetsort
