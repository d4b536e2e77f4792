#include "facetsort/order/crc32.h"

#include <gtest/gtest.h>

#include <random>
#include <string_view>
#include <vector>

#include "order/fsort_bytes.h"
#include "support/instruction_sets.h"
#include "support/threads.h"

namespace facetsort {
namespace {

using order_internal::crc32;

std::vector<std::byte> random_bytes(std::size_t count) {
  std::mt19937 random(5);
  std::vector<std::byte> bytes(count);
  for (std::byte& byte : bytes) byte = static_cast<std::byte>(random());
  return bytes;
}

// The check value that catalogues of such codes give.
TEST(Crc32, IsTheOneOfZlib) {
  constexpr std::string_view digits = "123456789";
  for_each_instruction_set([&] { EXPECT_EQ(crc32(std::as_bytes(std::span(digits))), 0xcbf43926u); });
}

TEST(Crc32, OfAnyLengthAndPlaceIsTheSameForAllInstructionSets) {
  const std::vector<std::byte> bytes = random_bytes(700);
  for_each_instruction_set([&] {
    for (std::size_t begin = 0; begin < 17; ++begin) {
      for (std::size_t size = 0; begin + size <= bytes.size(); size += size < 300 ? 1 : 37) {
        const auto part = std::span(bytes).subspan(begin, size);
        ASSERT_EQ(crc32(part), plain_crc32(part)) << begin << ' ' << size;
      }
    }
  });
}

TEST(Crc32, GoesOnFromWhatCameBefore) {
  const std::vector<std::byte> bytes = random_bytes(900000);
  const std::uint32_t whole = plain_crc32(bytes);
  for (const std::size_t split :
       {std::size_t{0}, std::size_t{1}, std::size_t{100}, std::size_t{300001}, bytes.size()}) {
    const std::uint32_t before = crc32(std::span(bytes).first(split));
    EXPECT_EQ(crc32(std::span(bytes).subspan(split), before), whole) << split;
  }
}

TEST(Crc32, IsTheSameForAnyThreadCount) {
  const std::vector<std::byte> bytes = random_bytes(3000001);
  const std::uint32_t expected = plain_crc32(bytes);
  for (const int threads : {1, 2, 3, 8}) EXPECT_EQ(with_threads(threads, [&] { return crc32(bytes); }), expected);
}

}  // namespace
}  // namespace facetsort
