#include "facetsort/exact/pair_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/exact/pair_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <bit>

HWY_BEFORE_NAMESPACE();
namespace facetsort::exact_internal::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, BoxBlock::size>;
using Slots = hn::CappedTag<std::uint32_t, BoxBlock::size>;

template <class Tag, class Mask>
HWY_INLINE unsigned bits_of(Tag tag, Mask mask) {
  std::uint8_t bits[8];
  hn::StoreMaskBits(tag, mask, bits);
  return bits[0];
}

// Bit i: box i of the block overlaps `box`.
HWY_INLINE unsigned overlapping(const BoxBlock& block, const ScreenBox& box) {
  const Floats tag;
  unsigned result = 0;
  for (std::size_t at = 0; at < BoxBlock::size; at += hn::Lanes(tag)) {
    auto all = hn::Le(hn::Load(tag, block.lowest[0] + at), hn::Set(tag, box.highest[0]));
    all = hn::And(all, hn::Le(hn::Set(tag, box.lowest[0]), hn::Load(tag, block.highest[0] + at)));
    for (std::size_t d = 1; d < box_dimensions; ++d) {
      all = hn::And(all, hn::Le(hn::Load(tag, block.lowest[d] + at), hn::Set(tag, box.highest[d])));
      all = hn::And(all, hn::Le(hn::Set(tag, box.lowest[d]), hn::Load(tag, block.highest[d] + at)));
    }
    result |= bits_of(tag, all) << at;
  }
  return result;
}

// Bit i: triangle i of the block has the slot for a corner.
HWY_INLINE unsigned having_corner(const SlotBlock& block, std::uint32_t slot) {
  const Slots tag;
  unsigned result = 0;
  for (std::size_t at = 0; at < BoxBlock::size; at += hn::Lanes(tag)) {
    const auto wanted = hn::Set(tag, slot);
    const auto any = hn::Or(hn::Or(hn::Eq(hn::Load(tag, block.slot[0] + at), wanted),
                                   hn::Eq(hn::Load(tag, block.slot[1] + at), wanted)),
                            hn::Eq(hn::Load(tag, block.slot[2] + at), wanted));
    result |= bits_of(tag, any) << at;
  }
  return result;
}

// Calls visit(block) for the blocks of levels[0] from `first` on whose boxes overlap `box`, in ascending order.
template <class Visit>
HWY_INLINE void for_each_block(BoxLevels levels, const ScreenBox& box, std::size_t first, const Visit& visit) {
  if (levels.size() == 1) return visit(std::size_t{0});
  struct Node {
    std::size_t level, block;
  };
  constexpr std::size_t deepest = 8 * 12;  // 8 children a level, and 12 levels hold 2^36 elements
  Node stack[deepest];
  std::size_t depth = 0;
  stack[depth++] = {levels.size() - 1, 0};
  while (depth > 0) {
    const Node node = stack[--depth];
    unsigned mask = overlapping(levels[node.level][node.block], box);
    const std::size_t below = node.level - 1;  // the level whose blocks the boxes of this one bound
    const std::size_t first_child = first >> 3 * below;
    if (below == 0) {
      for (; mask != 0; mask &= mask - 1) {
        const std::size_t child = node.block * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask));
        if (child >= first_child) visit(child);
      }
      continue;
    }
    while (mask != 0) {
      const unsigned last = 31u - static_cast<unsigned>(std::countl_zero(mask));
      mask ^= 1u << last;
      const std::size_t child = node.block * BoxBlock::size + last;
      if (child >= first_child) stack[depth++] = {below, child};
    }
  }
}

std::size_t CollectPairs(BoxLevels levels, std::span<const SlotBlock> slots, std::span<const unsigned char> flat_fan,
                         std::size_t leaf, std::vector<ElementPair>& pairs) {
  const BoxBlock& block = levels[0][leaf];
  const SlotBlock& corners = slots[leaf];
  ScreenBox leaf_box = levels.size() > 1 ? levels[1][leaf / BoxBlock::size].box(leaf % BoxBlock::size) : ScreenBox{};
  ScreenBox boxes[BoxBlock::size];
  for (std::size_t i = 0; i < BoxBlock::size; ++i) boxes[i] = block.box(i);
  std::size_t found = 0;
  for_each_block(levels, leaf_box, leaf, [&](std::size_t other) {
    unsigned rows = 0xffu;
    if (other != leaf) rows = overlapping(block, levels[1][other / BoxBlock::size].box(other % BoxBlock::size));
    for (; rows != 0; rows &= rows - 1) {
      const unsigned i = static_cast<unsigned>(std::countr_zero(rows));
      unsigned mask = overlapping(levels[0][other], boxes[i]);
      if (other == leaf) mask &= 0xfeu << i;
      if (mask == 0) continue;
      found += static_cast<std::size_t>(std::popcount(mask));
      for (int k = 0; k < 3; ++k) {
        const std::uint32_t slot = corners.slot[k][i];
        if (slot < flat_fan.size() && flat_fan[slot] != 0) mask &= ~having_corner(slots[other], slot);
      }
      for (; mask != 0; mask &= mask - 1) {
        pairs.push_back({static_cast<std::uint32_t>(leaf * BoxBlock::size + i),
                         static_cast<std::uint32_t>(other * BoxBlock::size +
                                                    static_cast<unsigned>(std::countr_zero(mask)))});
      }
    }
  });
  return found;
}

void CollectOverlapping(BoxLevels levels, const ScreenBox& box, std::vector<std::uint32_t>& elements) {
  for_each_block(levels, box, 0, [&](std::size_t leaf) {
    for (unsigned mask = overlapping(levels[0][leaf], box); mask != 0; mask &= mask - 1) {
      elements.push_back(
          static_cast<std::uint32_t>(leaf * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask))));
    }
  });
}

}  // namespace facetsort::exact_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::exact_internal {

HWY_EXPORT(CollectPairs);
HWY_EXPORT(CollectOverlapping);

std::size_t collect_pairs(BoxLevels levels, std::span<const SlotBlock> slots, std::span<const unsigned char> flat_fan,
                          std::size_t leaf, std::vector<ElementPair>& pairs) {
  return HWY_DYNAMIC_DISPATCH(CollectPairs)(levels, slots, flat_fan, leaf, pairs);
}

void collect_overlapping(BoxLevels levels, const ScreenBox& box, std::vector<std::uint32_t>& elements) {
  HWY_DYNAMIC_DISPATCH(CollectOverlapping)(levels, box, elements);
}

}  // namespace facetsort::exact_internal
#endif
