// `auto`: draws a mesh by its plan, in each view with what is right there.
#pragma once

#include <cstddef>
#include <optional>

#include "facetsort/blend/strategy.h"
#include "facetsort/plan/convex_parts.h"
#include "facetsort/plan/plan.h"

namespace facetsort {

struct PlannedStatistics {
  std::size_t frames = 0;    // ordered
  std::size_t kept = 0;      // of those, with the last one's order (see StrategyRenderer::keeps_order())
  std::size_t unsorted = 0;  // of those, in which nothing had to be sorted
};

// Use as StrategyRenderer: order(), then renderer().draw() with the same view. One thread at a time.
class PlannedRenderer {
 public:
  // Preconditions: those of plan_mesh(), and the mesh's arrays and `presorted` outlive this.
  explicit PlannedRenderer(const MeshView& mesh, const PlanOptions& options = {}, const PresortedInput& presorted = {});

  void order(const View& view);
  // Lets the next order() do all of its work: for timing.
  void forget_view() { has_order_ = false; }

  // With what the last order() found right: the plan's strategy, or back faces before front faces.
  StrategyRenderer& renderer() { return uses_culling_ ? *culling_ : *planned_; }
  const StrategyRenderer& renderer() const { return uses_culling_ ? *culling_ : *planned_; }
  const MeshPlan& plan() const { return plan_; }
  const PlannedStatistics& statistics() const { return statistics_; }

 private:
  MeshPlan plan_;
  ConvexParts parts_;
  std::optional<StrategyRenderer> planned_, culling_;
  bool uses_culling_ = false, has_order_ = false;
  PlannedStatistics statistics_;
};

}  // namespace facetsort
