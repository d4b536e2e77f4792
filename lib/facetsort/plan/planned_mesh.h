// Internal to plan: a plan with what was made ready on the way to it.
#pragma once

#include <optional>

#include "facetsort/blend/strategy.h"
#include "facetsort/plan/convex_parts.h"
#include "facetsort/plan/plan.h"

namespace facetsort::plan_internal {

struct PlannedMesh {
  MeshPlan plan;
  ConvexParts parts;                         // where plan.culls_where_apart
  std::optional<StrategyRenderer> renderer;  // of plan.strategy, where it was timed
};

// `with_times`: else the cheapest by rule of thumb of what is right for sure, and nothing is drawn.
PlannedMesh make_plan(const MeshView& mesh, const PlanOptions& options, const PresortedInput& presorted,
                      bool with_times);

}  // namespace facetsort::plan_internal
