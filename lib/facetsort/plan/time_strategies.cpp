#include "facetsort/plan/time_strategies.h"

#include <algorithm>
#include <limits>

#include "facetsort/base/stopwatch.h"
#include "facetsort/check/picture_verdict.h"
#include "facetsort/facets/facets.h"

namespace facetsort::plan_internal {
namespace {

// Of each view; more while they are short, since what is short is easily disturbed.
constexpr int least_frames = 3, most_frames = 12;
constexpr double enough_ms = 20;
// A first frame as long as this is not drawn again: its allocations do not show.
constexpr double long_ms = 100;

template <typename Run>
double milliseconds_of(const Run& run) {
  Stopwatch stopwatch;
  run();
  return stopwatch.lap();
}

}  // namespace

TimedRenderer time_strategy(const MeshView& mesh, const Strategy& strategy, std::span<const View> views,
                            const PresortedInput& presorted, double most_ms) {
  TimedRenderer timed;
  timed.timed.strategy = strategy;
  timed.timed.prepare_ms = milliseconds_of([&] { timed.renderer.emplace(mesh, strategy, presorted); });
  Image image;
  double sum = 0;
  std::size_t seen = 0;
  for (const View& view : views) {
    const auto draw = [&] {
      timed.renderer->order(view);
      timed.renderer->draw(view, PixelFormat::rgba32f, image);
    };
    double shortest = milliseconds_of(draw), spent = 0;
    for (int frame = 0; frame < most_frames && shortest < long_ms; ++frame) {
      const bool is_enough = spent > enough_ms || shortest > most_ms;
      if (frame >= least_frames && is_enough) break;
      const double taken = milliseconds_of(draw);
      spent += taken;
      shortest = std::min(shortest, taken);
    }
    sum += shortest;
    ++seen;
    if (const std::optional<ExactStatistics> exact = timed.renderer->exact_statistics()) {
      timed.is_complete = timed.is_complete && exact->unordered_pairs == 0 && exact->crossing_pairs_uncut == 0;
    }
    if (shortest > most_ms) break;
  }
  timed.timed.frame_ms = sum / static_cast<double>(seen);
  return timed;
}

struct WrongPixels::JudgedView {
  FragmentLists lists;
  Image reference;
};

WrongPixels::WrongPixels(const MeshView& mesh, std::span<const View> views) : mesh_(mesh), views_(views) {}
WrongPixels::~WrongPixels() = default;

WrongPixels::JudgedView& WrongPixels::view(std::size_t index) {
  while (judged_.size() <= index) {
    JudgedView& judged = judged_.emplace_back();
    const View& next = views_[judged_.size() - 1];
    judged.lists = collect_fragments(mesh_, next);
    blend_lists(mesh_, next, judged.lists, PixelFormat::rgba32f, judged.reference);
  }
  return judged_[index];
}

double WrongPixels::worst_share(StrategyRenderer& renderer, double most) {
  const float radius = facet_bounds(mesh_).radius();
  const JudgeOptions options{.bounding_radius = radius > 0 ? static_cast<double>(radius) : 1.0};
  double worst = 0;
  Image image;
  for (std::size_t i = 0; i < views_.size() && worst <= most; ++i) {
    const JudgedView& judged = view(i);
    renderer.order(views_[i]);
    renderer.draw(views_[i], PixelFormat::rgba32f, image);
    const PictureVerdict verdict = judge_picture(mesh_, views_[i], judged.lists, judged.reference, image, options);
    if (verdict.covered_pixels == 0) continue;
    const double wrong = static_cast<double>(verdict.wrong_pixels + verdict.unjudged_pixels);
    worst = std::max(worst, wrong / static_cast<double>(verdict.covered_pixels));
  }
  return worst;
}

}  // namespace facetsort::plan_internal
