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
using Doubles = hn::CappedTag<double, BoxBlock::size>;

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
  const hn::CappedTag<std::uint32_t, BoxBlock::size> tag;
  unsigned result = 0;
  const auto wanted = hn::Set(tag, slot);
  for (std::size_t at = 0; at < BoxBlock::size; at += hn::Lanes(tag)) {
    const auto any = hn::Or(hn::Or(hn::Eq(hn::Load(tag, block.slot[0] + at), wanted),
                                   hn::Eq(hn::Load(tag, block.slot[1] + at), wanted)),
                            hn::Eq(hn::Load(tag, block.slot[2] + at), wanted));
    result |= bits_of(tag, any) << at;
  }
  return result;
}

// One triangle, in every lane.
struct Row {
  double slot[3], x[3], y[3], nearness[3], facing;

  Row(const TriangleBlock& block, std::size_t lane) : facing(block.facing[lane]) {
    for (int i = 0; i < 3; ++i) {
      slot[i] = block.slot[i][lane];
      x[i] = block.x[i][lane];
      y[i] = block.y[i][lane];
      nearness[i] = block.nearness[i][lane];
    }
  }
};

// Bits of lanes.
struct Comparison {
  unsigned apart = 0, overlapping = 0;
  unsigned row_behind = 0, row_in_front = 0;  // if they overlap
};

// Screen::compare(), for a triangle and those of a block.
HWY_INLINE Comparison compare_lanes(const Row& row, const TriangleBlock& block, double rounding) {
  const Doubles tag;
  Comparison result;
  const double error = 4 * rounding;
  const auto none = hn::FirstN(tag, 0);
  const auto margin = hn::Set(tag, error);
  for (std::size_t at = 0; at < BoxBlock::size; at += hn::Lanes(tag)) {
    // Vectors of row's corners and of the lanes'.
    hn::Vec<Doubles> ax[3], ay[3], an[3], bx[3], by[3], bn[3];
    hn::Mask<Doubles> shared[3][3];
    for (int i = 0; i < 3; ++i) {
      ax[i] = hn::Set(tag, row.x[i]);
      ay[i] = hn::Set(tag, row.y[i]);
      an[i] = hn::Set(tag, row.nearness[i]);
      bx[i] = hn::Load(tag, block.x[i] + at);
      by[i] = hn::Load(tag, block.y[i] + at);
      bn[i] = hn::Load(tag, block.nearness[i] + at);
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        shared[i][j] = hn::Eq(hn::Set(tag, row.slot[i]), hn::Load(tag, block.slot[j] + at));
      }
    }
    const auto a_facing = hn::Set(tag, row.facing), b_facing = hn::Load(tag, block.facing + at);

    hn::Mask<Doubles> apart = none, overlap_sure = hn::Not(none);
    const auto test_edges = [&](const auto& px, const auto& py, const auto& facing, const auto& qx, const auto& qy,
                                const auto& is_shared) HWY_ATTR {
      for (int i = 0; i < 3; ++i) {
        const int to = (i + 1) % 3;
        const auto ex = hn::Mul(facing, hn::Sub(px[to], px[i])), ey = hn::Mul(facing, hn::Sub(py[to], py[i]));
        const auto edge = hn::Add(hn::Add(hn::Abs(ex), hn::Abs(ey)), margin);
        hn::Mask<Doubles> all_outside = hn::Not(none), any_inside = none;
        for (int j = 0; j < 3; ++j) {
          const auto on_edge = hn::Or(is_shared(i, j), is_shared(to, j));
          const auto rx = hn::Sub(qx[j], px[i]), ry = hn::Sub(qy[j], py[i]);
          const auto outward = hn::Sub(hn::Mul(ex, ry), hn::Mul(ey, rx));
          const auto bound = hn::Mul(margin, hn::Add(edge, hn::Add(hn::Abs(rx), hn::Abs(ry))));
          all_outside = hn::And(all_outside, hn::Or(on_edge, hn::Gt(outward, bound)));
          any_inside = hn::Or(any_inside, hn::AndNot(on_edge, hn::Lt(outward, hn::Neg(bound))));
        }
        apart = hn::Or(apart, all_outside);
        overlap_sure = hn::And(overlap_sure, any_inside);
      }
    };
    test_edges(ax, ay, a_facing, bx, by, [&](int i, int j) HWY_ATTR { return shared[i][j]; });
    test_edges(bx, by, b_facing, ax, ay, [&](int i, int j) HWY_ATTR { return shared[j][i]; });

    // Sides of the other's corners; those that are shared are in the plane.
    hn::Mask<Doubles> near = none, far = none;
    const auto test_side = [&](const auto& px, const auto& py, const auto& pn, const auto& facing, const auto& qx,
                               const auto& qy, const auto& qn, const auto& is_shared) HWY_ATTR {
      const auto ux = hn::Sub(px[1], px[0]), uy = hn::Sub(py[1], py[0]), un = hn::Sub(pn[1], pn[0]);
      const auto vx = hn::Sub(px[2], px[0]), vy = hn::Sub(py[2], py[0]), vn = hn::Sub(pn[2], pn[0]);
      const auto minus = hn::Neg(facing);
      const auto nx = hn::Mul(minus, hn::Sub(hn::Mul(uy, vn), hn::Mul(un, vy)));
      const auto ny = hn::Mul(minus, hn::Sub(hn::Mul(un, vx), hn::Mul(ux, vn)));
      const auto nn = hn::Mul(minus, hn::Sub(hn::Mul(ux, vy), hn::Mul(uy, vx)));
      const auto su = hn::Add(margin, hn::Add(hn::Abs(ux), hn::Add(hn::Abs(uy), hn::Abs(un))));
      const auto sv = hn::Add(margin, hn::Add(hn::Abs(vx), hn::Add(hn::Abs(vy), hn::Abs(vn))));
      const auto product = hn::Mul(su, sv);
      const auto twice = hn::Add(margin, margin), relative = hn::Set(tag, 0x1p-48);
      near = far = hn::Not(none);
      hn::Mask<Doubles> all_shared = hn::Not(none);
      for (int j = 0; j < 3; ++j) {
        const auto in_plane = hn::Or(is_shared(0, j), hn::Or(is_shared(1, j), is_shared(2, j)));
        const auto wx = hn::Sub(qx[j], px[0]), wy = hn::Sub(qy[j], py[0]), wn = hn::Sub(qn[j], pn[0]);
        const auto sw = hn::Add(margin, hn::Add(hn::Abs(wx), hn::Add(hn::Abs(wy), hn::Abs(wn))));
        const auto value = hn::Add(hn::Mul(nx, wx), hn::Add(hn::Mul(ny, wy), hn::Mul(nn, wn)));
        const auto rounding_of_points = hn::Mul(twice, hn::Add(product, hn::Mul(hn::Add(su, sv), sw)));
        const auto bound = hn::Add(rounding_of_points, hn::Mul(relative, hn::Mul(product, sw)));
        near = hn::And(near, hn::Or(in_plane, hn::Gt(value, bound)));
        far = hn::And(far, hn::Or(in_plane, hn::Lt(value, hn::Neg(bound))));
        all_shared = hn::And(all_shared, in_plane);
      }
      near = hn::AndNot(all_shared, near);
      far = hn::AndNot(all_shared, far);
    };
    test_side(ax, ay, an, a_facing, bx, by, bn, [&](int i, int j) HWY_ATTR { return shared[i][j]; });
    const auto b_near = near, b_far = far;
    test_side(bx, by, bn, b_facing, ax, ay, an, [&](int i, int j) HWY_ATTR { return shared[j][i]; });
    const auto known = hn::Or(b_near, b_far);
    const auto row_behind = hn::Or(b_near, hn::AndNot(known, far));
    const auto row_in_front = hn::Or(b_far, hn::AndNot(known, near));

    result.apart |= bits_of(tag, apart) << at;
    result.overlapping |= bits_of(tag, overlap_sure) << at;
    result.row_behind |= bits_of(tag, row_behind) << at;
    result.row_in_front |= bits_of(tag, row_in_front) << at;
  }
  return result;
}

// Appends the pairs of the row with the lanes in the mask.
HWY_INLINE void append_pairs(const Screenful& screen, std::uint32_t element, std::size_t other, unsigned mask,
                             std::vector<ElementPair>& pairs) {
  const std::size_t own = element / BoxBlock::size, own_lane = element % BoxBlock::size;
  unsigned polygons = 0xffu;
  Comparison comparison;
  if (!screen.triangles.empty() && screen.slots[own].slot[0][own_lane] != SlotBlock::no_slot) {
    polygons = having_corner(screen.slots[other], SlotBlock::no_slot);
    if ((mask & ~polygons) != 0) {
      comparison = compare_lanes(Row(screen.triangles[own], own_lane), screen.triangles[other], screen.rounding);
    }
  }
  mask &= polygons | ~comparison.apart;
  for (; mask != 0; mask &= mask - 1) {
    const auto lane = static_cast<unsigned>(std::countr_zero(mask));
    const unsigned bit = 1u << lane;
    Seen seen{Seen::not_compared, 0};
    if ((polygons & bit) == 0) {
      seen.overlap = (comparison.overlapping & bit) != 0 ? Seen::overlapping : Seen::either;
      seen.behind = static_cast<std::int8_t>(((comparison.row_behind & bit) != 0) - ((comparison.row_in_front & bit) != 0));
    }
    pairs.push_back({element, static_cast<std::uint32_t>(other * BoxBlock::size + lane), seen});
  }
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

std::size_t CollectPairs(const Screenful& screen, std::size_t leaf, std::vector<ElementPair>& pairs) {
  const BoxLevels levels = screen.boxes;
  const BoxBlock& block = levels[0][leaf];
  const SlotBlock& corners = screen.slots[leaf];
  const ScreenBox leaf_box = levels.size() > 1 ? levels[1][leaf / BoxBlock::size].box(leaf % BoxBlock::size)
                                               : ScreenBox{};
  ScreenBox boxes[BoxBlock::size];
  bool flat[3][BoxBlock::size];
  for (std::size_t i = 0; i < BoxBlock::size; ++i) {
    boxes[i] = block.box(i);
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t slot = corners.slot[k][i];
      flat[k][i] = slot != SlotBlock::no_slot && screen.flat_fan[slot] != 0;
    }
  }
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
        if (flat[k][i]) mask &= ~having_corner(screen.slots[other], corners.slot[k][i]);
      }
      if (mask != 0) append_pairs(screen, static_cast<std::uint32_t>(leaf * BoxBlock::size + i), other, mask, pairs);
    }
  });
  return found;
}

void CollectOverlapping(const Screenful& screen, std::uint32_t element, const ScreenBox& box,
                        std::span<const unsigned char> skip, std::vector<ElementPair>& pairs) {
  for_each_block(screen.boxes, box, 0, [&](std::size_t other) {
    unsigned mask = overlapping(screen.boxes[0][other], box);
    for (unsigned left = mask; left != 0; left &= left - 1) {
      const auto lane = static_cast<unsigned>(std::countr_zero(left));
      if (skip[other * BoxBlock::size + lane] != 0) mask ^= 1u << lane;
    }
    if (other == element / BoxBlock::size) mask &= ~(1u << element % BoxBlock::size);
    if (mask != 0) append_pairs(screen, element, other, mask, pairs);
  });
}

}  // namespace facetsort::exact_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::exact_internal {

HWY_EXPORT(CollectPairs);
HWY_EXPORT(CollectOverlapping);

std::size_t collect_pairs(const Screenful& screen, std::size_t leaf, std::vector<ElementPair>& pairs) {
  return HWY_DYNAMIC_DISPATCH(CollectPairs)(screen, leaf, pairs);
}

void collect_overlapping(const Screenful& screen, std::uint32_t element, const ScreenBox& box,
                         std::span<const unsigned char> skip, std::vector<ElementPair>& pairs) {
  HWY_DYNAMIC_DISPATCH(CollectOverlapping)(screen, element, box, skip, pairs);
}

}  // namespace facetsort::exact_internal
#endif
