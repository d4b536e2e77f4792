// The loops of the per-frame sort and of the reader of presorted meshes in few instructions a facet, for every
// instruction set. Keys cost less to compute than to store: they are computed again wherever they are needed, a tile at
// a time.
#include "facetsort/order/depth_kernels.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#include "facetsort/order/eye_side.h"
#include "facetsort/order/presorted_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/order/depth_kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: foreach_target.h before highway.h.
#include <hwy/highway.h>

// These use Highway, and the first.
#include "facetsort/order/facet_keys-inl.h"

#include "facetsort/order/entry_sort-inl.h"
#include "facetsort/order/order_blocks-inl.h"
#include "facetsort/order/step_sort-inl.h"

#if HWY_ONCE
namespace facetsort::order_internal {

HWY_EXPORT(ComputeKeys);
HWY_EXPORT(Collect);
HWY_EXPORT(CountFacets);
HWY_EXPORT(PartitionFacets);
HWY_EXPORT(CountEntries);
HWY_EXPORT(PartitionEntries);
HWY_EXPORT(RangeOfKeys);
HWY_EXPORT(SortEntries);
HWY_EXPORT(SortUnevenEntries);
HWY_EXPORT(KeysOf);
HWY_EXPORT(CountSteps);
HWY_EXPORT(SumSteps);
HWY_EXPORT(PlaceIds);
HWY_EXPORT(WriteOrder);
HWY_EXPORT(FindSides);
HWY_EXPORT(OrderBlock);
HWY_EXPORT(OrderBlocks);

BucketMap bucket_map(float lowest, float highest, std::size_t buckets) {
  const float count = static_cast<float>(buckets);
  if (!(lowest < highest)) return {highest, 0, count - 1};
  // Where keys differ by next to nothing the quotient is no float.
  return {highest, std::min(count / (highest - lowest), std::numeric_limits<float>::max()), count - 1};
}

Output Output::operator+(std::size_t facets) const {
  Output moved = *this;
  if (indices_32 != nullptr) moved.indices_32 += 3 * facets;
  if (indices_16 != nullptr) moved.indices_16 += 3 * facets;
  if (ids != nullptr) moved.ids += facets;
  return moved;
}

std::size_t bin_count(std::size_t entries) {
  // Whole vectors of eight. Fewer bins make more insertions, more make more sums: two an entry measured best.
  return (entries * 2 + 8) / 8 * 8;
}

void compute_keys(const KeySource& source, std::size_t begin, std::size_t end, float* keys) {
  HWY_DYNAMIC_DISPATCH(ComputeKeys)(source, begin, end, keys);
}

std::size_t collect(const KeySource& source, std::size_t begin, std::size_t end, const Entries& to) {
  return HWY_DYNAMIC_DISPATCH(Collect)(source, begin, end, to);
}

void count_buckets(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                   std::uint32_t* counts) {
  HWY_DYNAMIC_DISPATCH(CountFacets)(source, map, begin, end, counts);
}

void partition(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
               std::uint32_t* cursors, const Entries& to) {
  HWY_DYNAMIC_DISPATCH(PartitionFacets)(source, map, begin, end, cursors, to);
}

void count_buckets(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* counts) {
  HWY_DYNAMIC_DISPATCH(CountEntries)(from, count, map, counts);
}

void partition(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* cursors,
               const Entries& to) {
  HWY_DYNAMIC_DISPATCH(PartitionEntries)(from, count, map, cursors, to);
}

KeyRange key_range(const float* keys, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(RangeOfKeys)(keys, count);
}

bool sort_entries(const Entries& from, std::size_t count, const KeyRange& range, std::int64_t* sorted,
                  std::uint16_t* bins, const Output& output) {
  return HWY_DYNAMIC_DISPATCH(SortEntries)(from, count, range, sorted, bins, output);
}

void sort_uneven_entries(const Entries& from, std::size_t count, std::int64_t* sorted, const Output& output) {
  HWY_DYNAMIC_DISPATCH(SortUnevenEntries)(from, count, sorted, output);
}

void keys_of(const KeySource& source, const std::uint32_t* ids, std::size_t count, float* keys) {
  HWY_DYNAMIC_DISPATCH(KeysOf)(source, ids, count, keys);
}

std::size_t count_steps(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                        std::uint16_t* steps, std::uint32_t* ids, std::uint32_t* counts) {
  return HWY_DYNAMIC_DISPATCH(CountSteps)(source, map, begin, end, steps, ids, counts);
}

std::uint32_t sum_steps(std::uint32_t* counts, std::size_t parts, std::size_t steps) {
  return HWY_DYNAMIC_DISPATCH(SumSteps)(counts, parts, steps);
}

void place_ids(const StepIds& from, std::uint32_t* cursors, std::uint32_t* order) {
  HWY_DYNAMIC_DISPATCH(PlaceIds)(from, cursors, order);
}

void write_order(const std::uint32_t* ids, std::size_t count, const Output& output) {
  HWY_DYNAMIC_DISPATCH(WriteOrder)(ids, count, output);
}

void find_sides(const PlaneSource& source, const FrameEye& eye, std::span<std::uint8_t> sides) {
  HWY_DYNAMIC_DISPATCH(FindSides)(source, eye, sides);
}

void order_block(const PresortedBlocks& blocks, std::size_t b, const BlockOrders& orders) {
  HWY_DYNAMIC_DISPATCH(OrderBlock)(blocks, b, orders);
}

BlockChanges order_blocks(const PresortedBlocks& blocks, const PlaneSource& source, std::size_t begin, std::size_t end,
                  const FrameEye& eye, double way, const BlockOrders& orders) {
  return HWY_DYNAMIC_DISPATCH(OrderBlocks)(blocks, source, begin, end, eye, way, orders);
}

}  // namespace facetsort::order_internal
#endif
