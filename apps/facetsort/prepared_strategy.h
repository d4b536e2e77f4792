// A strategy made ready for a mesh of the command line.
#pragma once

#include <optional>

#include "facetsort/blend/strategy.h"
#include "input_mesh.h"

namespace facetsort {

class PreparedStrategy {
 public:
  PreparedStrategy() = default;
  PreparedStrategy(const PreparedStrategy&) = delete;
  PreparedStrategy& operator=(const PreparedStrategy&) = delete;

  // Takes what the mesh's file has been presorted into, where that is what the strategy draws, and else presorts it.
  // The mesh must outlive this. Parallel in the caller's arena.
  void prepare(const InputMesh& input, const Strategy& strategy);
  // Until prepare() is called again.
  void release();

  bool is_ready() const { return renderer_.has_value(); }
  // Precondition: is_ready().
  StrategyRenderer& renderer() { return *renderer_; }
  double prepare_ms() const { return prepare_ms_; }  // that prepare() took

 private:
  std::optional<IndexBuffers> buffers_;
  std::optional<StrategyRenderer> renderer_;
  double prepare_ms_ = 0;
};

}  // namespace facetsort
