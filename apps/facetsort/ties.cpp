#include "ties.h"

#include <algorithm>
#include <limits>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t pixels_per_task = 4096;

bool has_tie(std::span<const Fragment> pixel, double gap) {
  // Depths fall along the list, so the gap to the neighbour decides; error bounds do not, so the lowest bound so far.
  double previous_depth = std::numeric_limits<double>::infinity(), lowest = previous_depth;
  for (const Fragment& fragment : pixel) {
    const double error = static_cast<double>(fragment.depth_error);
    if (previous_depth - fragment.depth <= gap || lowest <= fragment.depth + error) return true;
    previous_depth = fragment.depth;
    lowest = std::min(lowest, fragment.depth - error);
  }
  return false;
}

}  // namespace

std::vector<unsigned char> tied_pixels(const FragmentLists& lists, double gap) {
  std::vector<unsigned char> tied(static_cast<std::size_t>(lists.width) * static_cast<std::size_t>(lists.height));
  parallel_ranges(tied.size(), pixels_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t pixel = begin; pixel < end; ++pixel) tied[pixel] = has_tie(lists.pixel(pixel), gap);
  });
  return tied;
}

}  // namespace facetsort
