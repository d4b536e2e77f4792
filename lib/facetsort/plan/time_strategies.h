// Internal to plan: what a frame of a strategy takes here, and how many of its pixels are wrong.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "facetsort/blend/strategy.h"
#include "facetsort/blend/view.h"
#include "facetsort/plan/plan.h"

namespace facetsort::plan_internal {

struct TimedRenderer {
  TimedStrategy timed;
  std::optional<StrategyRenderer> renderer;  // ready to draw
  bool is_complete = true;                   // an exact order left nothing unordered
};

// The shortest of a few frames of each view, after one that allocates. Stops after the first view that takes longer
// than `most_ms`. Precondition: the strategy takes no number of buffers that are not in `presorted`.
TimedRenderer time_strategy(const MeshView& mesh, const Strategy& strategy, std::span<const View> views,
                            const PresortedInput& presorted, double most_ms);

// The reference pictures of some views, kept to judge several strategies by.
class WrongPixels {
 public:
  WrongPixels(const MeshView& mesh, std::span<const View> views);
  ~WrongPixels();

  // The largest share of a view's covered pixels that is wrong or can't be judged; of no more views once it is above
  // `most`.
  double worst_share(StrategyRenderer& renderer, double most);

 private:
  struct JudgedView;

  JudgedView& view(std::size_t index);

  MeshView mesh_;
  std::span<const View> views_;
  std::vector<JudgedView> judged_;  // the first of them
};

}  // namespace facetsort::plan_internal
