// What vectors hold.
#pragma once

#include <cstddef>
#include <type_traits>

namespace facetsort {

// Bytes that the vectors have room for.
template <typename... Vectors>
std::size_t bytes_of(const Vectors&... vectors) {
  return ((vectors.capacity() * sizeof(typename std::decay_t<Vectors>::value_type)) + ...);
}

}  // namespace facetsort
