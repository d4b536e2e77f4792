#include "facetsort/plan/planned_renderer.h"

#include <utility>

#include "facetsort/plan/planned_mesh.h"

namespace facetsort {

PlannedRenderer::PlannedRenderer(const MeshView& mesh, const PlanOptions& options, const PresortedInput& presorted) {
  plan_internal::PlannedMesh planned = plan_internal::make_plan(mesh, options, presorted, true);
  plan_ = std::move(planned.plan);
  planned_ = std::move(planned.renderer);
  if (!planned_) planned_.emplace(mesh, plan_.strategy, presorted);
  if (!plan_.culls_where_apart) return;
  parts_ = std::move(planned.parts);
  culling_.emplace(mesh, Strategy{.kind = StrategyKind::separate_culling_pass});
}

void PlannedRenderer::order(const View& view) {
  ++statistics_.frames;
  if (has_order_ && renderer().keeps_order(view)) {
    ++statistics_.kept;
    return;
  }
  uses_culling_ = culling_ && parts_.are_apart_from(view.homogeneous_eye());
  renderer().order(view);
  const StrategyKind kind = renderer().strategy().kind;
  statistics_.unsorted += kind != StrategyKind::facet_sort && kind != StrategyKind::presorted_buffers;
  has_order_ = true;
}

}  // namespace facetsort
