// A least-significant-digit radix sort: three counting passes of 11, 11 and 10 bits over (key, id), all three histograms
// counted first, the last pass leaving ids alone. Knuth, The Art of Computer Programming 3, 5.2.5; the order-preserving
// map from float32 bits to unsigned integers is Terdiman's ("Radix Sort Revisited", 2000) and Herf's ("Radix Tricks",
// 2001).
#include "facetsort/order/key_sort.h"

#include <array>
#include <bit>
#include <utility>

namespace facetsort {
namespace {

constexpr int digit_bits[3] = {11, 11, 10};
constexpr int digit_shift[3] = {0, 11, 22};
constexpr std::size_t buckets = 1u << 11;
using Histograms = std::array<std::array<std::uint32_t, buckets>, 3>;

std::uint32_t digit(std::uint32_t key, int pass) {
  return (key >> digit_shift[pass]) & ((1u << digit_bits[pass]) - 1u);
}

// Unsigned integers that ascend as the floats descend: the farthest facet gets the smallest.
std::uint32_t descending_bits(float key) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(key);
  return (bits & 0x80000000u) != 0 ? bits : ~bits & 0x7fffffffu;
}

}  // namespace

std::span<const std::uint32_t> KeySort::sort(std::span<const float> keys) {
  const std::size_t count = keys.size();
  entries_.resize(count);
  scratch_.resize(count);
  order_.resize(count);

  Histograms ends{};
  for (const float key : keys) {
    const std::uint32_t bits = descending_bits(key);
    for (int pass = 0; pass < 3; ++pass) ++ends[pass][digit(bits, pass)];
  }
  for (auto& histogram : ends) {
    std::uint32_t sum = 0;
    for (std::uint32_t& bucket : histogram) sum += std::exchange(bucket, sum);
  }

  for (std::size_t id = 0; id < count; ++id) {
    const std::uint32_t bits = descending_bits(keys[id]);
    entries_[ends[0][digit(bits, 0)]++] = std::uint64_t{bits} << 32 | id;
  }
  for (const std::uint64_t entry : entries_) {
    scratch_[ends[1][digit(static_cast<std::uint32_t>(entry >> 32), 1)]++] = entry;
  }
  for (const std::uint64_t entry : scratch_) {
    order_[ends[2][digit(static_cast<std::uint32_t>(entry >> 32), 2)]++] = static_cast<std::uint32_t>(entry);
  }
  return order_;
}

}  // namespace facetsort
