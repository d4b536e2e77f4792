// Internal to scene: the numbers of a glTF accessor, wherever and however they are stored.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/scene/gltf_file.h"

namespace facetsort::scene_internal {

// Construction checks everything, so that reading needs no check: offsets and counts lie within buffers, those of the
// sparse part too. The model must outlive it.
class Accessor {
 public:
  // `place` names who asks, for messages. Throws SceneError.
  Accessor(const tinygltf::Model& model, int index, const std::string& place);

  std::size_t count() const { return count_; }
  int components() const { return components_; }
  bool has_indices() const;  // one unsigned integer each, neither normalised nor sparse
  // Integers that are normalised come out in -1 to 1, others as they are.
  double number(std::size_t i, int component) const;
  // Precondition: has_indices().
  std::uint32_t index(std::size_t i) const;

 private:
  struct Part {
    const unsigned char* first = nullptr;  // null: zeros
    std::size_t stride = 0;
  };
  static Part part_of(const tinygltf::Model& model, int view, std::size_t offset, std::size_t element_bytes,
                      std::size_t count, const std::string& place);
  void read_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor, const std::string& place);

  std::size_t count_ = 0;
  int components_ = 0, component_type_ = 0;
  std::size_t component_bytes_ = 0;
  bool normalised_ = false;
  Part dense_;
  std::vector<std::pair<std::uint32_t, const unsigned char*>> sparse_;  // elements that stand elsewhere, ascending
};

}  // namespace facetsort::scene_internal
