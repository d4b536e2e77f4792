// Ids by descending float32 key: what Sorter sorts with.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace facetsort {

// Keeps its scratch from call to call. One thread at a time.
class KeySort {
 public:
  // Positions in `keys`, largest key first, equal keys by smaller position. No key is NaN; -0 comes after 0. The span is
  // valid until the next call.
  std::span<const std::uint32_t> sort(std::span<const float> keys);

  std::size_t memory_bytes() const {
    return order_.capacity() * sizeof(std::uint32_t) +
           (entries_.capacity() + scratch_.capacity()) * sizeof(std::uint64_t);
  }

 private:
  std::vector<std::uint64_t> entries_, scratch_;  // key bits and position
  std::vector<std::uint32_t> order_;
};

}  // namespace facetsort
