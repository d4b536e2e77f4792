#include "prepared_strategy.h"

#include "facetsort/presort/index_buffers.h"
#include "facetsort/report/timing.h"

namespace facetsort {

void PreparedStrategy::prepare(const InputMesh& input, const Strategy& strategy) {
  const auto prepare = [&] {
    PresortedInput presorted = input.presorted_input();
    const bool needs_buffers = strategy.kind == StrategyKind::presorted_buffers;
    const bool has_buffers = presorted.buffers != nullptr && presorted.buffers->buffer_count == strategy.number &&
                             !presorted.buffers->needs_culling;
    if (needs_buffers && !has_buffers) {
      buffers_ = make_index_buffers(input.mesh.view(), {.most_buffers = strategy.number});
      presorted.buffers = &*buffers_;
    }
    renderer_.emplace(input.mesh.view(), strategy, presorted);
  };
  prepare_ms_ = time_median(prepare, 1).median_ms;
}

void PreparedStrategy::release() {
  renderer_.reset();
  buffers_.reset();
}

}  // namespace facetsort
