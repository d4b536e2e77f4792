#include "facetsort/check/picture_verdict.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <vector>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/shading.h"
#include "facetsort/blend/source_over.h"

namespace facetsort {
namespace {

constexpr std::size_t pixels_per_task = 1024;
// Orders of tied layers tried a pixel: seven layers at one depth, or twelve pairs of them.
constexpr std::size_t most_orders = 5040;

enum class Answer { right, wrong, unknown };

// Whether a pixel's colour can come of drawing its layers back to front, whichever way tied ones are taken.
class TieSearch {
 public:
  TieSearch(const MeshView& mesh, const View& view, PixelFormat format, double gap)
      : mesh_(mesh), camera_(view), eye_(view.homogeneous_eye()), blend_(format), gap_(gap) {}

  Answer search(std::span<const Fragment> fragments, int x, int y, const glm::vec4& colour) {
    find_groups(fragments);
    std::size_t orders = 1;
    for (std::size_t g = 0; g + 1 < group_begins_.size(); ++g) {
      for (std::size_t size = group_begins_[g + 1] - group_begins_[g]; size > 1; --size) {
        orders *= size;
        if (orders > most_orders) return Answer::unknown;
      }
    }
    if (orders == 1) return Answer::wrong;
    sources_.clear();
    for (const Fragment& fragment : fragments) {
      sources_.push_back(fragment_colour(mesh_, fragment.facet, camera_.pixel_ray(x, y), eye_));
    }
    order_.resize(fragments.size());
    std::iota(order_.begin(), order_.end(), std::size_t{0});
    return reaches(0, blend_.clear(background), colour) ? Answer::right : Answer::wrong;
  }

 private:
  // A group ends where all layers so far are beyond all that follow, by more than the gap and their rounding.
  void find_groups(std::span<const Fragment> fragments) {
    nearest_ends_.resize(fragments.size() + 1);
    nearest_ends_.back() = -std::numeric_limits<double>::infinity();
    for (std::size_t i = fragments.size(); i-- > 0;) {
      nearest_ends_[i] =
          std::max(nearest_ends_[i + 1], fragments[i].depth + static_cast<double>(fragments[i].depth_error));
    }
    group_begins_.assign(1, 0);
    double lowest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < fragments.size(); ++i) {
      lowest = std::min(lowest, fragments[i].depth - static_cast<double>(fragments[i].depth_error));
      const bool apart = fragments[i].depth - fragments[i + 1].depth > gap_ && lowest > nearest_ends_[i + 1];
      if (apart) group_begins_.push_back(i + 1);
    }
    group_begins_.push_back(fragments.size());
  }

  // Tries every order of each group from `group` on, over what is drawn so far.
  bool reaches(std::size_t group, const glm::vec4& below, const glm::vec4& colour) {
    if (group + 1 == group_begins_.size()) return !differs_visibly(colour, blend_.finish(below));
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(group_begins_[group]);
    const auto end = order_.begin() + static_cast<std::ptrdiff_t>(group_begins_[group + 1]);
    do {
      glm::vec4 blended = below;
      for (auto layer = begin; layer != end; ++layer) blended = blend_.over(sources_[*layer], blended);
      if (reaches(group + 1, blended, colour)) return true;
    } while (std::next_permutation(begin, end));
    return false;
  }

  MeshView mesh_;
  Camera camera_;
  glm::vec4 eye_;
  SourceOver blend_;
  double gap_;
  std::vector<double> nearest_ends_;  // the greatest depth, with its error, from a fragment on
  std::vector<std::size_t> group_begins_, order_;
  std::vector<glm::vec4> sources_;
};

}  // namespace

PictureVerdict judge_picture(const MeshView& mesh, const View& view, const FragmentLists& lists,
                             const Image& reference, const Image& picture, const JudgeOptions& options) {
  std::vector<unsigned char> covered(reference.pixels.size());
  std::atomic<std::size_t> covered_pixels = 0, wrong = 0, unjudged = 0;
  parallel_ranges(covered.size(), pixels_per_task, [&](std::size_t begin, std::size_t end) {
    TieSearch ties(mesh, view, reference.format, options.gap_radii * options.bounding_radius);
    for (std::size_t pixel = begin; pixel < end; ++pixel) {
      const std::span<const Fragment> fragments = lists.pixel(pixel);
      covered[pixel] = !fragments.empty();
      covered_pixels += covered[pixel];
      if (fragments.empty() || !differs_visibly(picture.pixels[pixel], reference.pixels[pixel])) continue;
      const int x = static_cast<int>(pixel) % view.width, y = static_cast<int>(pixel) / view.width;
      const Answer answer = ties.search(fragments, x, y, picture.pixels[pixel]);
      wrong += answer == Answer::wrong;
      unjudged += answer == Answer::unknown;
    }
  });
  const ImageError error = compare_images(picture, reference, covered);
  return {covered_pixels, wrong, unjudged, error.rmse, error.max_error};
}

}  // namespace facetsort
