#include "prepared_strategy.h"

#include "facetsort/presort/index_buffers.h"
#include "facetsort/report/timing.h"
#include "failure.h"

namespace facetsort {

void PreparedStrategy::prepare(const InputMesh& input, const Strategy& strategy, const View& view) {
  if (strategy.kind == StrategyKind::draw_order && !input.scene) {
    throw Failure(input.path.string() + ": " + strategy.name() + " orders the objects of a scene, and this is a mesh");
  }
  const auto prepare = [&] {
    PresortedInput presorted = input.presorted_input();
    const bool needs_buffers = strategy.kind == StrategyKind::presorted_buffers;
    const bool has_buffers = presorted.buffers != nullptr && presorted.buffers->buffer_count == strategy.number &&
                             !presorted.buffers->needs_culling;
    if (needs_buffers && !has_buffers) {
      buffers_ = make_index_buffers(blended_facets(input.mesh.view()), {.most_buffers = strategy.number});
      presorted.buffers = &*buffers_;
    }
    if (strategy.kind == StrategyKind::automatic) {
      planned_.emplace(input.mesh.view(),
                       PlanOptions{.error_budget = strategy.error_budget, .width = view.width, .height = view.height},
                       presorted);
      return;
    }
    renderer_.emplace(input.mesh.view(), strategy, presorted, input.scene_input());
  };
  prepare_ms_ = time_median(prepare, 1).median_ms;
}

void PreparedStrategy::order(const View& view) {
  if (!planned_) return renderer_->order(view);
  planned_->forget_view();
  planned_->order(view);
}

void PreparedStrategy::release() {
  planned_.reset();
  renderer_.reset();
  buffers_.reset();
}

}  // namespace facetsort
