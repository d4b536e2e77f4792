// Internal to exact: integer arithmetic on floating-point numbers. Finite floating-point numbers are integers times a
// power of two, so after scaling every input by one common power the signs of polynomials follow from integer
// arithmetic alone: no fractions, no divisors.
#pragma once

#include <algorithm>
#include <bit>
#include <boost/multiprecision/cpp_int.hpp>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <initializer_list>
#include <limits>

namespace facetsort::exact_internal {

// Numbers up to 512 bits live on the stack, which covers coordinates whose magnitudes span some 2^100; wider ones
// allocate.
using Integer =
    boost::multiprecision::number<boost::multiprecision::cpp_int_backend<
                                      512, 0, boost::multiprecision::signed_magnitude, boost::multiprecision::unchecked,
                                      std::allocator<boost::multiprecision::limb_type>>,
                                  boost::multiprecision::et_off>;

struct IntegerVector {
  Integer x, y, z;
};

// value = mantissa * 2^exponent with an odd mantissa; zero has no exponent that matters.
struct Dyadic {
  std::int64_t mantissa = 0;
  int exponent = std::numeric_limits<int>::max();

  explicit Dyadic(double value) {
    assert(std::isfinite(value));
    constexpr int fraction_bits = 52;
    constexpr int lowest_exponent = -1074;  // of the smallest denormal double
    const std::uint64_t bits = std::bit_cast<std::uint64_t>(value);
    const int biased_exponent = static_cast<int>(bits >> fraction_bits & 0x7ff);
    std::uint64_t magnitude = bits & ((std::uint64_t{1} << fraction_bits) - 1);
    if (biased_exponent != 0) magnitude |= std::uint64_t{1} << fraction_bits;
    if (magnitude == 0) return;
    const int zeros = std::countr_zero(magnitude);
    mantissa = static_cast<std::int64_t>(magnitude >> zeros);
    if (std::signbit(value)) mantissa = -mantissa;
    exponent = lowest_exponent + std::max(biased_exponent, 1) - 1 + zeros;
  }
};

// The largest e such that every value is an integer times 2^e; 0 when all are zero.
inline int common_exponent(std::initializer_list<double> values) {
  int lowest = std::numeric_limits<int>::max();
  for (const double value : values) lowest = std::min(lowest, Dyadic(value).exponent);
  return lowest == std::numeric_limits<int>::max() ? 0 : lowest;
}

inline int common_exponent(std::initializer_list<glm::dvec3> vectors) {
  int lowest = std::numeric_limits<int>::max();
  for (const glm::dvec3& v : vectors) {
    for (int i = 0; i < 3; ++i) lowest = std::min(lowest, Dyadic(v[i]).exponent);
  }
  return lowest == std::numeric_limits<int>::max() ? 0 : lowest;
}

// value / 2^exponent. Precondition: that is an integer.
inline Integer scaled_integer(double value, int exponent) {
  const Dyadic dyadic(value);
  Integer integer = dyadic.mantissa;
  if (dyadic.mantissa != 0) integer <<= dyadic.exponent - exponent;
  return integer;
}

inline IntegerVector scaled_integers(const glm::dvec3& v, int exponent) {
  return {scaled_integer(v.x, exponent), scaled_integer(v.y, exponent), scaled_integer(v.z, exponent)};
}

inline IntegerVector operator-(const IntegerVector& a, const IntegerVector& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

inline Integer dot(const IntegerVector& a, const IntegerVector& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

inline IntegerVector cross(const IntegerVector& a, const IntegerVector& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

inline int sign(const Integer& value) {
  return value.sign();
}

inline int sign(double value) {
  return (value > 0) - (value < 0);
}

// Counted for exact_fallbacks().
inline thread_local unsigned long long fallback_count = 0;

}  // namespace facetsort::exact_internal
