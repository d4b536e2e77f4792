// A strategy made ready for a mesh of the command line.
#pragma once

#include <optional>

#include "facetsort/blend/strategy.h"
#include "facetsort/blend/view.h"
#include "facetsort/plan/planned_renderer.h"
#include "input_mesh.h"

namespace facetsort {

class PreparedStrategy {
 public:
  PreparedStrategy() = default;
  PreparedStrategy(const PreparedStrategy&) = delete;
  PreparedStrategy& operator=(const PreparedStrategy&) = delete;

  // Takes what the mesh's file has been presorted into, where that is what the strategy draws, and else presorts it.
  // The mesh must outlive this. `view` is one of those to be drawn: of its size are the pictures by which a plan
  // is made. Parallel in the caller's arena.
  void prepare(const InputMesh& input, const Strategy& strategy, const View& view);
  // Until prepare() is called again.
  void release();

  bool is_ready() const { return renderer_.has_value() || planned_.has_value(); }
  // What a frame from a new eye needs before drawing. Precondition: is_ready().
  void order(const View& view);
  // Draws with the last order(). Precondition: is_ready().
  StrategyRenderer& renderer() { return planned_ ? planned_->renderer() : *renderer_; }
  double prepare_ms() const { return prepare_ms_; }  // that prepare() took

 private:
  std::optional<IndexBuffers> buffers_;
  std::optional<StrategyRenderer> renderer_;  // or
  std::optional<PlannedRenderer> planned_;
  double prepare_ms_ = 0;
};

}  // namespace facetsort
