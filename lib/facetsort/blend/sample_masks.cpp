#include "facetsort/blend/sample_masks.h"

#include <algorithm>
#include <cassert>
#include <numeric>
#include <utility>

namespace facetsort::blend_internal {
namespace {

// Subsets of each size. A subset is rotated, too, so that two fragments of a pixel hardly ever cover the same one.
constexpr std::size_t subsets_of_a_size = 256;

// The finaliser of MurmurHash3 (Appleby 2011), 64-bit: every bit of the input changes half of the bits of the hash.
std::uint64_t hash(std::uint64_t value) {
  value = (value ^ (value >> 33)) * 0xff51afd7ed558ccdu;
  value = (value ^ (value >> 33)) * 0xc4ceb9fe1a85ec53u;
  return value ^ (value >> 33);
}

// Bits [0, samples) rotated; samples are at most 64.
std::uint64_t rotated(std::uint64_t mask, unsigned samples, unsigned by) {
  if (by == 0) return mask;
  const std::uint64_t all = samples == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << samples) - 1;
  return ((mask << by) | (mask >> (samples - by))) & all;
}

}  // namespace

void SampleMasks::set_samples(int samples) {
  assert(samples >= 1 && samples <= most_samples);
  if (samples == samples_) return;
  samples_ = samples;
  const auto count = static_cast<std::size_t>(samples);
  masks_.assign((count + 1) * subsets_of_a_size, 0);
  std::uint64_t drawn = 0;  // random numbers
  for (std::size_t size = 0; size <= count; ++size) {
    for (std::size_t subset = 0; subset < subsets_of_a_size; ++subset) {
      // The first of a shuffle (Fisher and Yates 1938).
      std::size_t order[most_samples];
      std::iota(order, order + count, std::size_t{0});
      for (std::size_t i = 0; i < size; ++i) {
        std::swap(order[i], order[i + hash(++drawn) % (count - i)]);
        masks_[size * subsets_of_a_size + subset] |= std::uint64_t{1} << order[i];
      }
    }
  }
}

std::uint64_t SampleMasks::covered(std::uint32_t facet, int x, int y, float alpha) const {
  const std::uint64_t pixel = static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint32_t>(x);
  const std::uint64_t random = hash(hash(pixel + 1) + facet);
  const float uniform = static_cast<float>(random >> 40) * 0x1p-24f;
  const float wanted = std::clamp(alpha, 0.0f, 1.0f) * static_cast<float>(samples_) + uniform;
  const auto size = std::min(static_cast<std::size_t>(wanted), static_cast<std::size_t>(samples_));
  const auto count = static_cast<unsigned>(samples_);
  return rotated(masks_[size * subsets_of_a_size + random % subsets_of_a_size], count,
                 static_cast<unsigned>(random >> 8 & 0xffff) % count);
}

}  // namespace facetsort::blend_internal
