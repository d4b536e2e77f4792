// Carry-less multiplication folds 64 bytes at a time into a remainder (Gopal et al. 2009, "Fast CRC Computation for
// Generic Polynomials Using PCLMULQDQ Instruction"); where the processor has none, eight tables do eight bytes at a
// time (Kounavis and Berry 2005, "A Systematic Approach to Building High Performance Software-Based CRC Generators").
//
// Polynomials over two elements, as CRC-32 writes them: the highest bit of a word is the coefficient of x^0.
#include "facetsort/order/crc32.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <array>
#include <bit>
#include <cstring>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/order/crc32.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: foreach_target.h before highway.h.
#include <hwy/highway.h>

#ifndef FACETSORT_ORDER_CRC32_ONCE
#define FACETSORT_ORDER_CRC32_ONCE
namespace facetsort::order_internal {

constexpr std::uint32_t crc_one = 0x80000000u;
constexpr std::uint32_t crc_polynomial = 0xedb88320u;

constexpr std::uint32_t crc_times_x(std::uint32_t a) {
  return a >> 1 ^ ((a & 1) != 0 ? crc_polynomial : 0);
}

constexpr std::uint32_t crc_power_of_x(int exponent) {
  std::uint32_t power = crc_one;
  for (int i = 0; i < exponent; ++i) power = crc_times_x(power);
  return power;
}

using CrcTables = std::array<std::array<std::uint32_t, 256>, 8>;

// Table i: what a byte adds to the remainder when i more bytes have followed it.
constexpr CrcTables crc_tables() {
  CrcTables tables{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    tables[0][byte] = byte;
    for (int bit = 0; bit < 8; ++bit) tables[0][byte] = crc_times_x(tables[0][byte]);
  }
  for (std::size_t i = 1; i < tables.size(); ++i) {
    for (std::size_t byte = 0; byte < 256; ++byte) {
      const std::uint32_t before = tables[i - 1][byte];
      tables[i][byte] = before >> 8 ^ tables[0][before & 0xff];
    }
  }
  return tables;
}

// The remainder after further bytes; CRC-32 begins and ends with its complement.
inline std::uint32_t remainder_by_tables(std::uint32_t remainder, const unsigned char* bytes, std::size_t count) {
  static constexpr CrcTables tables = crc_tables();
  if constexpr (std::endian::native == std::endian::little) {
    for (; count >= 8; bytes += 8, count -= 8) {
      std::uint64_t word;
      std::memcpy(&word, bytes, sizeof word);
      word ^= remainder;
      remainder = 0;
      for (std::size_t i = 0; i < 8; ++i) remainder ^= tables[7 - i][word >> 8 * i & 0xff];
    }
  }
  for (; count > 0; ++bytes, --count) remainder = remainder >> 8 ^ tables[0][(remainder ^ *bytes) & 0xff];
  return remainder;
}

}  // namespace facetsort::order_internal
#endif

HWY_BEFORE_NAMESPACE();
namespace facetsort::order_internal {
namespace HWY_NAMESPACE {

#if (HWY_ARCH_X86 && HWY_TARGET <= HWY_SSE4) || (HWY_ARCH_ARM_A64 && HWY_TARGET <= HWY_NEON)

namespace hn = hwy::HWY_NAMESPACE;
using Block = hn::CappedTag<std::uint64_t, 2>;

// What the two halves of a block are multiplied with to move it ahead by that many bits. A product of 64 by 64 bits
// stands one bit too low in 128, which takes one off each exponent.
template <int bits>
HWY_INLINE hn::Vec<Block> Mover() {
  alignas(16) static constexpr std::uint64_t halves[2] = {std::uint64_t{crc_power_of_x(bits + 63)} << 32,
                                                          std::uint64_t{crc_power_of_x(bits - 1)} << 32};
  return hn::Load(Block(), halves);
}

HWY_INLINE hn::Vec<Block> Fold(hn::Vec<Block> ahead, hn::Vec<Block> mover, hn::Vec<Block> block) {
  return hn::Xor(block, hn::Xor(hn::CLMulLower(ahead, mover), hn::CLMulUpper(ahead, mover)));
}

std::uint32_t Remainder(std::uint32_t remainder, const unsigned char* bytes, std::size_t count) {
  constexpr std::size_t stride = 64;
  if (count < 2 * stride) return remainder_by_tables(remainder, bytes, count);
  const Block d;
  const hn::Repartition<std::uint8_t, Block> d8;
  const auto load = [&](std::size_t i) { return hn::BitCast(d, hn::LoadU(d8, bytes + 16 * i)); };
  alignas(16) const std::uint64_t first[2] = {remainder, 0};
  auto a = hn::Xor(load(0), hn::Load(d, first)), b = load(1), c = load(2), e = load(3);
  bytes += stride;
  count -= stride;
  const auto by_stride = Mover<8 * stride>();
  for (; count >= stride; bytes += stride, count -= stride) {
    a = Fold(a, by_stride, load(0));
    b = Fold(b, by_stride, load(1));
    c = Fold(c, by_stride, load(2));
    e = Fold(e, by_stride, load(3));
  }
  const auto by_block = Mover<128>();
  const auto folded = Fold(Fold(Fold(a, by_block, b), by_block, c), by_block, e);
  alignas(16) unsigned char last[16];
  hn::Store(hn::BitCast(d8, folded), d8, last);
  return remainder_by_tables(remainder_by_tables(0, last, sizeof last), bytes, count);
}

#else

std::uint32_t Remainder(std::uint32_t remainder, const unsigned char* bytes, std::size_t count) {
  return remainder_by_tables(remainder, bytes, count);
}

#endif

}  // namespace HWY_NAMESPACE
}  // namespace facetsort::order_internal
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::order_internal {

HWY_EXPORT(Remainder);

namespace {

constexpr std::size_t bytes_per_task = std::size_t{1} << 18;

std::uint32_t product(std::uint32_t a, std::uint32_t b) {
  std::uint32_t sum = 0;
  for (; a != 0; a <<= 1, b = crc_times_x(b)) sum ^= (a & crc_one) != 0 ? b : 0;
  return sum;
}

struct CrcOfPart {
  std::uint32_t crc;
  std::size_t bytes;
};

// Of one part and the next.
CrcOfPart join(const CrcOfPart& part, const CrcOfPart& next) {
  std::uint32_t shift = crc_one;  // x to the power of the next part's bits
  std::uint32_t square = crc_power_of_x(8);
  for (std::size_t bytes = next.bytes; bytes != 0; bytes >>= 1, square = product(square, square)) {
    if ((bytes & 1) != 0) shift = product(shift, square);
  }
  return {product(part.crc, shift) ^ next.crc, part.bytes + next.bytes};
}

}  // namespace

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  const auto add = [&](std::size_t begin, std::size_t end, const CrcOfPart& part) {
    const auto* const first = reinterpret_cast<const unsigned char*>(bytes.data()) + begin;
    return CrcOfPart{~HWY_DYNAMIC_DISPATCH(Remainder)(~part.crc, first, end - begin), part.bytes + (end - begin)};
  };
  if (bytes.size() <= bytes_per_task) return add(0, bytes.size(), {before, 0}).crc;
  const CrcOfPart whole = tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, bytes.size(), bytes_per_task), CrcOfPart{0, 0},
      [&](const tbb::blocked_range<std::size_t>& range, const CrcOfPart& part) {
        return add(range.begin(), range.end(), part);
      },
      join);
  return join({before, 0}, whole).crc;
}

}  // namespace facetsort::order_internal
#endif
