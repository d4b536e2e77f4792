// A filter in double with Shewchuk's bound (1997, "Adaptive Precision Floating-Point Arithmetic and Fast Robust
// Geometric Predicates"), then exactly: products of three float32 values are integers of 72 bits times a power of two,
// which are added in fixed point over the whole range of exponents (Kulisch 1971, the long accumulator).
#include "facetsort/order/eye_side.h"

#include <array>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <limits>

namespace facetsort::order_internal {
namespace {

// A finite float as an integer of 24 bits times 2^(exponent - 149).
struct Parts {
  std::uint64_t mantissa;
  unsigned exponent;
  bool is_negative;
};

Parts parts_of(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const unsigned exponent = bits >> 23 & 0xff;
  const std::uint32_t fraction = bits & 0x7fffff;
  // Denormal numbers have the exponent of the smallest normal ones, and no leading 1.
  return {exponent == 0 ? fraction : fraction | 0x800000u, exponent == 0 ? 0 : exponent - 1, (bits >> 31) != 0};
}

// A sum of products of three floats, in units of 2^-447, in two's complement. The largest product is below 2^384 =
// 2^831 units, so that 64 of them stay below 2^838.
class ProductSum {
 public:
  void add(const Parts& x, const Parts& y, const Parts& z, bool negated) {
    if (x.mantissa == 0 || y.mantissa == 0 || z.mantissa == 0) return;
    // 48 bits times 24, in two halves, that none of the products has more than 64 bits.
    const std::uint64_t xy = x.mantissa * y.mantissa;
    const std::uint64_t low = (xy & 0xffffffffu) * z.mantissa;
    const std::uint64_t high = (xy >> 32) * z.mantissa;
    const unsigned exponent = x.exponent + y.exponent + z.exponent;
    const bool is_negative = (x.is_negative != y.is_negative) != (z.is_negative != negated);
    add(low, exponent, is_negative);
    add(high, exponent + 32, is_negative);
  }

  int sign() const {
    if (words_.back() >> 63 != 0) return -1;
    for (const std::uint64_t word : words_) {
      if (word != 0) return 1;
    }
    return 0;
  }

 private:
  void add(std::uint64_t value, unsigned shift, bool is_negative) {
    const std::size_t word = shift / 64;
    const unsigned bits = shift % 64;
    const std::uint64_t low = value << bits, high = bits == 0 ? 0 : value >> (64 - bits);
    is_negative ? subtract_at(word, low, high) : add_at(word, low, high);
  }

  void add_at(std::size_t word, std::uint64_t low, std::uint64_t high) {
    words_[word] += low;
    std::uint64_t carry = words_[word] < low;
    for (std::size_t i = word + 1; i < words_.size() && (high | carry) != 0; ++i) {
      // The upper half of a shifted value is never all ones, so that this does not wrap.
      const std::uint64_t addend = high + carry;
      high = 0;
      words_[i] += addend;
      carry = words_[i] < addend;
    }
  }

  void subtract_at(std::size_t word, std::uint64_t low, std::uint64_t high) {
    std::uint64_t borrow = words_[word] < low;
    words_[word] -= low;
    for (std::size_t i = word + 1; i < words_.size() && (high | borrow) != 0; ++i) {
      const std::uint64_t subtrahend = high + borrow;
      high = 0;
      borrow = words_[i] < subtrahend;
      words_[i] -= subtrahend;
    }
  }

  std::array<std::uint64_t, 14> words_{};
};

using PointParts = std::array<Parts, 3>;

PointParts parts_of(const glm::vec3& p) {
  return {parts_of(p.x), parts_of(p.y), parts_of(p.z)};
}

// Adds det[u, v, w], or its negative.
void add_determinant(const PointParts& u, const PointParts& v, const PointParts& w, bool negated, ProductSum& sum) {
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    sum.add(u[j], v[k], w[i], negated);
    sum.add(u[k], v[j], w[i], !negated);
  }
}

int exact_eye_side(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye) {
  const PointParts pa = parts_of(a), pb = parts_of(b), pc = parts_of(c), pe = parts_of(glm::vec3(eye));
  // det[b - a, c - a, e - a], or with e in place of e - a, multiplied out.
  ProductSum sum;
  add_determinant(pb, pc, pe, false, sum);
  add_determinant(pa, pc, pe, true, sum);
  add_determinant(pb, pa, pe, true, sum);
  if (eye.w != 0) add_determinant(pb, pc, pa, true, sum);
  return sum.sign();
}

}  // namespace

int eye_side(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec4& eye) {
  assert(eye.w == 0 || eye.w == 1);
  const glm::dvec3 origin(a);
  const glm::dvec3 u = glm::dvec3(b) - origin, v = glm::dvec3(c) - origin;
  const glm::dvec3 w = eye.w == 0 ? glm::dvec3(eye) : glm::dvec3(eye) - origin;
  double value = 0, magnitude = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double left = u[j] * v[k], right = u[k] * v[j];
    value += w[i] * (left - right);
    magnitude += std::abs(w[i]) * (std::abs(left) + std::abs(right));
  }
  // Differences of floats, and products of three of them, neither overflow nor underflow in double: the bound holds
  // always, and where all products are zero, so is the value.
  constexpr double half_epsilon = std::numeric_limits<double>::epsilon() / 2;
  constexpr double bound = (7 + 56 * half_epsilon) * half_epsilon;
  if (std::abs(value) > bound * magnitude || magnitude == 0) return (value > 0) - (value < 0);
  return exact_eye_side(a, b, c, eye);
}

}  // namespace facetsort::order_internal
