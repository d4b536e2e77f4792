// Internal to blend: which samples of a pixel a fragment covers, in stochastic transparency.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace facetsort::blend_internal {

// Random, and the same for the same facet, pixel and alpha: on any machine, in any order. Over facets and pixels each
// sample is covered with probability alpha.
class SampleMasks {
 public:
  static constexpr int most_samples = 64;

  // 1 to most_samples. Allocates where the number changes.
  void set_samples(int samples);
  int samples() const { return samples_; }

  // Bit s stands for sample s. (x, y) is the pixel of the picture. floor(alpha S + u) samples, u uniform in [0, 1).
  std::uint64_t covered(std::uint32_t facet, int x, int y, float alpha) const;

 private:
  int samples_ = 0;
  std::vector<std::uint64_t> masks_;  // for each number of samples covered, from 0 on, some random subsets of that size
};

}  // namespace facetsort::blend_internal
