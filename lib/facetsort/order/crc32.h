// Internal to order: the CRC-32 of zlib, PNG and Ethernet, which most languages have in their libraries.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace facetsort::order_internal {

// Of the bytes that gave `before`, followed by `bytes`. Parallel in the caller's task arena; allocates nothing.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

}  // namespace facetsort::order_internal
