#include "facetsort/scene/gltf_accessor.h"

#include <algorithm>
#include <cstring>
#include <limits>

namespace facetsort::scene_internal {
namespace {

template <typename T>
T load(const unsigned char* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

std::uint32_t load_unsigned(const unsigned char* from, int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return *from;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load<std::uint16_t>(from);
    default:
      return load<std::uint32_t>(from);
  }
}

bool is_unsigned(int component_type) {
  return component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
         component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// Bytes of a component; 0 where glTF has no such type.
std::size_t bytes_of_component(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

// 0 for matrices, which nothing that is read here has.
int components_of(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    default:
      return 0;
  }
}

}  // namespace

Accessor::Accessor(const tinygltf::Model& model, int index, const std::string& place) {
  if (index < 0 || static_cast<std::size_t>(index) >= model.accessors.size()) {
    throw SceneError{Fault::index_out_of_range, place + " names accessor " + std::to_string(index) + " of " +
                                                    std::to_string(model.accessors.size())};
  }
  const tinygltf::Accessor& accessor = model.accessors[static_cast<std::size_t>(index)];
  const std::string here = place + ", accessor " + std::to_string(index);
  component_type_ = accessor.componentType;
  component_bytes_ = bytes_of_component(component_type_);
  components_ = components_of(accessor.type);
  normalised_ = accessor.normalized;
  count_ = accessor.count;
  if (component_bytes_ == 0 || components_ == 0) {
    throw SceneError{Fault::malformed, here + ": numbers of a type that it can't have"};
  }
  if (count_ == 0 || count_ >= std::numeric_limits<std::uint32_t>::max()) {
    throw SceneError{Fault::malformed, here + ": a count of " + std::to_string(count_)};
  }
  const std::size_t element_bytes = component_bytes_ * static_cast<std::size_t>(components_);
  if (accessor.bufferView >= 0) {
    dense_ = part_of(model, accessor.bufferView, accessor.byteOffset, element_bytes, count_, here);
  } else {
    // Zeros need no bytes in the file: a count would cost nothing to write, and memory to believe.
    constexpr std::size_t most_zeros = std::size_t{1} << 24;
    if (!accessor.sparse.isSparse || count_ > most_zeros) {
      throw SceneError{Fault::malformed, here + ": " + std::to_string(count_) + " elements without a buffer view"};
    }
  }
  if (accessor.sparse.isSparse) read_sparse(model, accessor, here);
}

Accessor::Part Accessor::part_of(const tinygltf::Model& model, int view, std::size_t offset, std::size_t element_bytes,
                                 std::size_t count, const std::string& place) {
  const std::span<const unsigned char> bytes = bytes_of_view(model, view, place);
  const std::size_t given = model.bufferViews[static_cast<std::size_t>(view)].byteStride;
  const std::size_t stride = given == 0 ? element_bytes : given;
  if (stride < element_bytes) {
    throw SceneError{Fault::malformed, place + ": elements of " + std::to_string(element_bytes) + " bytes, " +
                                           std::to_string(stride) + " apart"};
  }
  // The count is below 2^32 and the stride, as tinygltf sees to it, below 2^8: no overflow.
  const std::size_t needed = (count - 1) * stride + element_bytes;
  if (offset > bytes.size() || needed > bytes.size() - offset) {
    throw SceneError{Fault::truncated, place + ": " + std::to_string(count) + " elements end after buffer view " +
                                           std::to_string(view) + ", which has " + std::to_string(bytes.size()) +
                                           " bytes"};
  }
  return {bytes.data() + offset, stride};
}

void Accessor::read_sparse(const tinygltf::Model& model, const tinygltf::Accessor& accessor, const std::string& place) {
  const auto& sparse = accessor.sparse;
  const std::string here = place + ", sparse";
  const int index_type = sparse.indices.componentType;
  if (sparse.count < 1 || static_cast<std::size_t>(sparse.count) > count_ || sparse.indices.byteOffset < 0 ||
      sparse.values.byteOffset < 0 || !is_unsigned(index_type)) {
    throw SceneError{Fault::malformed, here + ": a count, offset or type that it can't have"};
  }
  const auto count = static_cast<std::size_t>(sparse.count);
  const std::size_t element_bytes = component_bytes_ * static_cast<std::size_t>(components_);
  const std::size_t index_bytes = bytes_of_component(index_type);
  const Part indices = part_of(model, sparse.indices.bufferView, static_cast<std::size_t>(sparse.indices.byteOffset),
                               index_bytes, count, here);
  const Part values = part_of(model, sparse.values.bufferView, static_cast<std::size_t>(sparse.values.byteOffset),
                              element_bytes, count, here);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t element = load_unsigned(indices.first + i * indices.stride, index_type);
    if (element >= count_ || (i > 0 && element <= sparse_.back().first)) {
      throw SceneError{Fault::index_out_of_range, here + ": index " + std::to_string(element) + " at place " +
                                                      std::to_string(i) + ": not above the last or not below " +
                                                      std::to_string(count_)};
    }
    sparse_.emplace_back(element, values.first + i * values.stride);
  }
}

bool Accessor::has_indices() const {
  return components_ == 1 && is_unsigned(component_type_) && !normalised_ && sparse_.empty();
}

std::uint32_t Accessor::index(std::size_t i) const {
  return load_unsigned(dense_.first + i * dense_.stride, component_type_);
}

double Accessor::number(std::size_t i, int component) const {
  const unsigned char* element = dense_.first == nullptr ? nullptr : dense_.first + i * dense_.stride;
  if (!sparse_.empty()) {
    const auto found = std::lower_bound(sparse_.begin(), sparse_.end(), i,
                                        [](const auto& entry, std::size_t wanted) { return entry.first < wanted; });
    if (found != sparse_.end() && found->first == i) element = found->second;
  }
  if (element == nullptr) return 0;
  const unsigned char* from = element + static_cast<std::size_t>(component) * component_bytes_;
  const auto scaled = [&](double value, double largest) {
    return normalised_ ? std::max(value / largest, -1.0) : value;
  };
  switch (component_type_) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return scaled(load<std::int8_t>(from), 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return scaled(*from, 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return scaled(load<std::int16_t>(from), 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return scaled(load<std::uint16_t>(from), 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load<std::uint32_t>(from);
    default:
      return static_cast<double>(load<float>(from));
  }
}

}  // namespace facetsort::scene_internal
