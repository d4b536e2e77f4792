#include "facetsort/exact/part_sample.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/exact/part_sample.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <cmath>
#include <vector>

#ifndef FACETSORT_EXACT_PART_SAMPLE_ONCE
#define FACETSORT_EXACT_PART_SAMPLE_ONCE
namespace facetsort::exact_internal {
using Places = double[PartSample::most_corners][3][PartSample::most_parts];
using RoughPlaces = float[PartSample::most_corners][3][PartSample::rough_parts];
}  // namespace facetsort::exact_internal
#endif

HWY_BEFORE_NAMESPACE();
namespace facetsort::exact_internal::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

// In the frame of the sample, whose coordinates are up to 1/2. Rough ones are off by a few 2^-24.
constexpr double in_plane_below = 0x1p-40;
constexpr float roughly_in_plane_below = 0x1p-20f;

// No fused multiply-add: the same bits for every instruction set.
template <typename Real, std::size_t places>
SideCounts CountSides(const Real (&coordinates)[PartSample::most_corners][3][places], std::size_t corners,
                      std::size_t begin, std::size_t end, const glm::vec<3, Real>& normal, Real offset, Real in_plane) {
  const hn::CappedTag<Real, 64 / sizeof(Real)> tag;
  const auto x = hn::Set(tag, normal.x), y = hn::Set(tag, normal.y), z = hn::Set(tag, normal.z);
  const auto d = hn::Set(tag, offset);
  const auto above = hn::Set(tag, in_plane), below = hn::Set(tag, -in_plane);
  SideCounts counts;
  for (std::size_t i = begin; i < end; i += hn::Lanes(tag)) {
    const auto value = [&](std::size_t corner) HWY_ATTR {
      const auto& place = coordinates[corner];
      const auto sum =
          hn::Add(hn::Add(hn::Mul(x, hn::Load(tag, place[0] + i)), hn::Mul(y, hn::Load(tag, place[1] + i))),
                  hn::Mul(z, hn::Load(tag, place[2] + i)));
      return hn::Sub(sum, d);
    };
    auto lowest = value(0), highest = lowest, nearest = hn::Abs(lowest);
    for (std::size_t corner = 1; corner < corners; ++corner) {
      const auto next = value(corner);
      lowest = hn::Min(lowest, next);
      highest = hn::Max(highest, next);
      nearest = hn::Min(nearest, hn::Abs(next));
    }
    const auto some = hn::FirstN(tag, std::min(hn::Lanes(tag), end - i));
    const auto in_front = hn::And(some, hn::Gt(highest, above)), at_back = hn::And(some, hn::Lt(lowest, below));
    const auto cut = hn::And(in_front, at_back);
    counts.front += static_cast<std::uint32_t>(hn::CountTrue(tag, in_front));
    counts.back += static_cast<std::uint32_t>(hn::CountTrue(tag, at_back));
    counts.cut += static_cast<std::uint32_t>(hn::CountTrue(tag, cut));
    counts.cut_at_corner += static_cast<std::uint32_t>(hn::CountTrue(tag, hn::And(cut, hn::Le(nearest, above))));
  }
  return counts;
}

SideCounts CountPlaces(const Places& places, std::size_t corners, std::size_t begin, std::size_t end,
                       const glm::dvec3& normal, double offset) {
  return CountSides(places, corners, begin, end, normal, offset, in_plane_below);
}

SideCounts CountRoughPlaces(const RoughPlaces& places, std::size_t corners, std::size_t begin, std::size_t end,
                            const glm::vec3& normal, float offset) {
  return CountSides(places, corners, begin, end, normal, offset, roughly_in_plane_below);
}

}  // namespace facetsort::exact_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::exact_internal {

HWY_EXPORT(CountPlaces);
HWY_EXPORT(CountRoughPlaces);

namespace {

// What it costs to have a node, to take a part through one, and to cut one through a corner, in cuts: costlier nodes mean
// flatter trees with more cuts. Without a cost for parts, planes that divide few of many from the rest but cut none look
// good, and on large smooth meshes the time would grow with the square of the facets.
constexpr double cost_of_node = 0.2, cost_of_part = 0.0003, cost_at_corner = 0.75;

// How much dearer a plane has to look on some of the parts to be given up.
constexpr double far_above = 1.3;

// How much dearer than the least that a plane without cuts can cost is not worth looking for a better one.
constexpr double hard_to_beat = 1.5;

// Fewer are judged at once.
constexpr std::size_t fewest_rough_parts = 16;

// Natural logarithms, rounded to what every mathematics library agrees on.
const std::vector<double>& logarithms() {
  static const std::vector<double> table = [] {
    std::vector<double> logarithm(PartSample::most_parts * 2 + 1);
    for (std::size_t i = 1; i < logarithm.size(); ++i) {
      logarithm[i] = static_cast<float>(std::log(static_cast<double>(i)));
    }
    return logarithm;
  }();
  return table;
}

}  // namespace

void PartSample::begin(std::size_t all, const glm::dvec3& lowest, const glm::dvec3& highest) {
  all_ = static_cast<double>(all);
  log_all_ = static_cast<float>(std::log(all_));
  origin_ = (lowest + highest) / 2.0;
  const glm::dvec3 extent = highest - lowest;
  const double largest = std::max({extent.x, extent.y, extent.z});
  scale_ = largest > 0 ? 1 / largest : 1;
  count_ = 0;
  corners_ = 3;
}

void PartSample::add(std::span<const glm::dvec3> part) {
  if (part.size() > 3) corners_ = most_corners;
  for (std::size_t i = 0; i < most_corners; ++i) {
    const std::size_t corner =
        part.size() <= most_corners ? std::min(i, part.size() - 1) : i * part.size() / most_corners;
    const glm::dvec3 place = (part[corner] - origin_) * scale_;
    for (int axis = 0; axis < 3; ++axis) {
      coordinates_[i][axis][count_] = place[axis];
      if (count_ < rough_parts) rough_[i][axis][count_] = static_cast<float>(place[axis]);
    }
  }
  ++count_;
}

double PartSample::cost_of(const SideCounts& counts, std::size_t seen) const {
  const std::vector<double>& logarithm = logarithms();
  const auto in_plane = static_cast<std::uint32_t>(seen) - counts.front - counts.back + counts.cut;
  if (in_plane == 0 && (counts.front == counts.cut || counts.back == counts.cut)) return INFINITY;
  const double scale = all_ / static_cast<double>(seen);
  const std::uint32_t all = counts.front + counts.back + in_plane;
  double gain = counts.front * (logarithm[all] - logarithm[counts.front]) * (counts.front > 0) +
                counts.back * (logarithm[all] - logarithm[counts.back]) * (counts.back > 0);
  if (in_plane > 0) gain += in_plane * (logarithm[all] - logarithm[seen] + log_all_);
  const double cuts = counts.cut - (1 - cost_at_corner) * counts.cut_at_corner;
  return gain > 0 ? (cuts * scale + cost_of_node + cost_of_part * all_) / (gain * scale) : INFINITY;
}

double PartSample::cost(const glm::dvec3& normal, const glm::dvec3& origin, double least) const {
  const double length = glm::length(normal);
  if (!(length > 0)) return INFINITY;
  const glm::dvec3 unit = normal * (1 / length);
  const double offset = glm::dot(unit, (origin - origin_) * scale_);
  const auto is_far_above_least = [&](const SideCounts& some, std::size_t seen) {
    const double found = cost_of(some, seen);
    return found > far_above * least && found < INFINITY;
  };
  SideCounts rough;
  const std::size_t roughly = count_ < fewest_rough_parts ? 0 : std::min(count_, rough_parts);
  for (std::size_t seen = 0, step = 64; seen < roughly; step *= 2) {
    const std::size_t until = roughly < 2 * step ? roughly : step;
    rough += HWY_DYNAMIC_DISPATCH(CountRoughPlaces)(rough_, corners_, seen, until, glm::vec3(unit),
                                                    static_cast<float>(offset));
    seen = until;
    if (is_far_above_least(rough, seen)) return INFINITY;
  }
  SideCounts counts;
  for (std::size_t seen = 0, next = 2 * rough_parts; seen < count_; next *= 2) {
    const std::size_t until = count_ < 2 * next ? count_ : next;
    counts += HWY_DYNAMIC_DISPATCH(CountPlaces)(coordinates_, corners_, seen, until, unit, offset);
    seen = until;
    if (seen < count_ && is_far_above_least(counts, seen)) return INFINITY;
  }
  return cost_of(counts, count_);
}

bool PartSample::is_hard_to_beat(double cost) const {
  constexpr double log_2 = 0.693147180559945309417;
  return cost * all_ * log_2 < hard_to_beat * (cost_of_node + cost_of_part * all_);
}

}  // namespace facetsort::exact_internal
#endif  // HWY_ONCE
