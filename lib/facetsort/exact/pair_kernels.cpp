#include "facetsort/exact/pair_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/exact/pair_kernels.cpp"
#include <hwy/foreach_target.h>  // must come before highway.h
#include <hwy/highway.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace facetsort::exact_internal::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, BoxBlock::size>;

template <class Tag, class Mask>
HWY_INLINE unsigned bits_of(Tag tag, Mask mask) {
  std::uint8_t bits[8];
  hn::StoreMaskBits(tag, mask, bits);
  return bits[0];
}

// Bit i: box i of the block overlaps `box` on the screen, and in the dimensions `beyond` it.
template <BoxDimension... beyond, class Block>
HWY_INLINE unsigned overlapping(const Block& block, const ScreenBox& box) {
  static_assert(((beyond < std::extent_v<decltype(block.lowest)>)&&...), "a dimension that the boxes do not have");
  const Floats tag;
  unsigned result = 0;
  for (std::size_t at = 0; at < Block::size; at += hn::Lanes(tag)) {
    const auto overlap_in = [&](BoxDimension d) HWY_ATTR {
      return hn::And(hn::Le(hn::Load(tag, block.lowest[d] + at), hn::Set(tag, box.highest[d])),
                     hn::Le(hn::Set(tag, box.lowest[d]), hn::Load(tag, block.highest[d] + at)));
    };
    auto all = overlap_in(across);
    for (const BoxDimension d : {down, diagonal, other_diagonal, beyond...}) all = hn::And(all, overlap_in(d));
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
    const auto any = hn::Or(
        hn::Or(hn::Eq(hn::Load(tag, block.slot[0] + at), wanted), hn::Eq(hn::Load(tag, block.slot[1] + at), wanted)),
        hn::Eq(hn::Load(tag, block.slot[2] + at), wanted));
    result |= bits_of(tag, any) << at;
  }
  return result;
}

// Pairs of patches yet to be compared, up to eight, those of one pair of elements in neighbouring lanes.
struct Candidates {
  std::uint32_t a[BoxBlock::size], b[BoxBlock::size];  // patches
  std::size_t count = 0;
  std::uint32_t a_element[BoxBlock::size], b_element[BoxBlock::size];  // of pairs
  unsigned lanes[BoxBlock::size];                                      // bits
  std::size_t pairs = 0;
};

// Corner k of eight patches, one in each lane.
struct Corners {
  alignas(64) Patch::Corner corner[4][BoxBlock::size];

  void load(std::span<const Patch> patches, const std::uint32_t (&used)[BoxBlock::size]) {
    for (std::size_t lane = 0; lane < BoxBlock::size; ++lane) {
      const Patch& patch = patches[used[lane]];
      for (int k = 0; k < 4; ++k) std::memcpy(&corner[k][lane], &patch.corner[k], sizeof(Patch::Corner));
    }
  }
};

// Screen::compare() of pairs, for patches of `count` corners: 3 where all are triangles. Appends those that are neither
// certainly apart nor certainly in the order that is `allowed`: +1, the first behind; -1, the second; 0, the one with
// the larger key.
template <int count>
HWY_NOINLINE void compare_candidates(const Screenful& screen, Candidates& candidates, int allowed,
                                     std::vector<ElementPair>& pairs) {
  using Slots = hn::RebindToUnsigned<Floats>;
  using Vec = hn::Vec<Floats>;
  using Mask = hn::Mask<Floats>;
  const Floats tag;
  const Slots slot_tag;
  for (std::size_t lane = candidates.count; lane < BoxBlock::size; ++lane) {
    candidates.a[lane] = candidates.a[0];
    candidates.b[lane] = candidates.b[0];
  }
  Corners a_corners, b_corners;
  a_corners.load(screen.patches, candidates.a);
  b_corners.load(screen.patches, candidates.b);

  unsigned apart_lanes = 0, overlapping_lanes = 0, a_behind_lanes = 0, b_behind_lanes = 0;
  const auto margin = hn::Set(tag, screen.rounding);
  const auto none = hn::FirstN(tag, 0);
  const auto infinite = hn::Set(tag, std::numeric_limits<float>::max());
  for (std::size_t at = 0; at < BoxBlock::size; at += hn::Lanes(tag)) {
    Vec ax[4], ay[4], an[4], bx[4], by[4], bn[4];
    hn::Vec<Slots> a_slot[4], b_slot[4];
    const auto load = [&](const Corners& corners, Vec* x, Vec* y, Vec* n, hn::Vec<Slots>* slot) HWY_ATTR {
      for (int i = 0; i < count; ++i) {
        Vec s;
        hn::LoadInterleaved4(tag, &corners.corner[i][at].x, x[i], y[i], n[i], s);
        slot[i] = hn::BitCast(slot_tag, s);
      }
    };
    load(a_corners, ax, ay, an, a_slot);
    load(b_corners, bx, by, bn, b_slot);
    // Relative to a corner, and how far apart corners of the two are at most.
    const auto local = [&](Vec* of_a, Vec* of_b) HWY_ATTR {
      const Vec origin = of_a[0];
      Vec lowest = hn::Zero(tag), highest = hn::Zero(tag);
      of_a[0] = hn::Zero(tag);
      for (int i = 0; i < count; ++i) {
        if (i > 0) of_a[i] = hn::Sub(of_a[i], origin);
        of_b[i] = hn::Sub(of_b[i], origin);
        lowest = hn::Min(lowest, hn::Min(of_a[i], of_b[i]));
        highest = hn::Max(highest, hn::Max(of_a[i], of_b[i]));
      }
      return hn::Sub(highest, lowest);
    };
    const auto reach_on_screen = hn::Add(margin, hn::Add(local(ax, bx), local(ay, by)));
    const auto reach = hn::Add(reach_on_screen, local(an, bn));
    const auto edge_bound = hn::Mul(hn::Mul(hn::Set(tag, 4.0f), margin), reach_on_screen);

    Mask shared[4][4], a_shared[4], b_shared[4];
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) {
        shared[i][j] = hn::RebindMask(tag, hn::Eq(a_slot[i], b_slot[j]));
        a_shared[i] = j == 0 ? shared[i][j] : hn::Or(a_shared[i], shared[i][j]);
        b_shared[j] = i == 0 ? shared[i][j] : hn::Or(b_shared[j], shared[i][j]);
      }
    }

    // Whether some edge of one has all of the other on its outer side. Corners that they share lie on the edge.
    Mask apart = none, overlap_sure = hn::Not(none);
    const auto test_edges = [&](const Vec* px, const Vec* py, const hn::Vec<Slots>* p_slot, const Vec* qx,
                                const Vec* qy, const auto& is_shared) HWY_ATTR {
      for (int i = 0; i < count; ++i) {
        const int to = (i + 1) % count;
        const auto ex = hn::Sub(px[to], px[i]), ey = hn::Sub(py[to], py[i]);
        const auto offset = hn::MulSub(ey, px[i], hn::Mul(ex, py[i]));
        Vec outward = infinite;  // of the innermost corner
        for (int j = 0; j < count; ++j) {
          const auto on_edge = hn::Or(is_shared(i, j), is_shared(to, j));
          const auto of_corner = hn::MulAdd(ex, qy[j], hn::NegMulAdd(ey, qx[j], offset));
          outward = hn::Min(outward, hn::IfThenElse(on_edge, infinite, of_corner));
        }
        Mask all_outside = hn::Gt(outward, edge_bound), any_inside = hn::Lt(outward, hn::Neg(edge_bound));
        if (count == 4 && i == 2) {  // of a triangle this is no edge
          const auto is_edge = hn::RebindMask(tag, hn::Ne(p_slot[2], p_slot[3]));
          all_outside = hn::And(all_outside, is_edge);
          any_inside = hn::Or(any_inside, hn::Not(is_edge));
        }
        apart = hn::Or(apart, all_outside);
        overlap_sure = hn::And(overlap_sure, any_inside);
      }
    };
    test_edges(ax, ay, a_slot, bx, by, [&](int i, int j) HWY_ATTR { return shared[i][j]; });
    test_edges(bx, by, b_slot, ax, ay, [&](int i, int j) HWY_ATTR { return shared[j][i]; });

    // Sides of the other's corners; those that are shared are in the plane.
    Mask near = none, far = none;
    const auto test_side = [&](const Vec* px, const Vec* py, const Vec* pn, const Vec* qx, const Vec* qy, const Vec* qn,
                               const Mask* is_shared) HWY_ATTR {
      const int last = count - 1;
      const auto ux = hn::Sub(px[2], px[0]), uy = hn::Sub(py[2], py[0]), un = hn::Sub(pn[2], pn[0]);
      const auto vx = hn::Sub(px[last], px[1]), vy = hn::Sub(py[last], py[1]), vn = hn::Sub(pn[last], pn[1]);
      const auto nx = hn::MulSub(un, vy, hn::Mul(uy, vn));
      const auto ny = hn::MulSub(ux, vn, hn::Mul(un, vx));
      const auto nn = hn::MulSub(uy, vx, hn::Mul(ux, vy));
      const auto su = hn::Add(margin, hn::Add(hn::Abs(ux), hn::Add(hn::Abs(uy), hn::Abs(un))));
      const auto sv = hn::Add(margin, hn::Add(hn::Abs(vx), hn::Add(hn::Abs(vy), hn::Abs(vn))));
      const auto product = hn::Mul(su, sv), six = hn::Mul(hn::Set(tag, 6.0f), margin);
      // Of the coordinates that enter, and of products of three differences.
      const auto bound = hn::MulAdd(six, hn::MulAdd(hn::Add(su, sv), reach, product),
                                    hn::Mul(hn::Mul(hn::Set(tag, 0x1p-19f), product), reach));
      const auto offset = hn::MulAdd(nx, px[0], hn::MulAdd(ny, py[0], hn::Mul(nn, pn[0])));
      Vec lowest = infinite, highest = hn::Neg(infinite);
      for (int j = 0; j < count; ++j) {
        const auto value = hn::MulAdd(nx, qx[j], hn::MulAdd(ny, qy[j], hn::MulSub(nn, qn[j], offset)));
        lowest = hn::Min(lowest, hn::IfThenElse(is_shared[j], infinite, value));
        highest = hn::Max(highest, hn::IfThenElse(is_shared[j], hn::Neg(infinite), value));
      }
      // Where all are shared, nothing is known.
      near = hn::And(hn::Gt(lowest, bound), hn::Gt(highest, bound));
      far = hn::And(hn::Lt(highest, hn::Neg(bound)), hn::Lt(lowest, hn::Neg(bound)));
    };
    test_side(ax, ay, an, bx, by, bn, b_shared);
    const auto b_near = near, b_far = far;
    test_side(bx, by, bn, ax, ay, an, a_shared);
    const auto known = hn::Or(b_near, b_far);
    const auto a_behind = hn::Or(b_near, hn::AndNot(known, far));
    const auto b_behind = hn::Or(b_far, hn::AndNot(known, near));

    apart_lanes |= bits_of(tag, apart) << at;
    overlapping_lanes |= bits_of(tag, overlap_sure) << at;
    a_behind_lanes |= bits_of(tag, a_behind) << at;
    b_behind_lanes |= bits_of(tag, b_behind) << at;
  }
  for (std::size_t i = 0; i < candidates.pairs; ++i) {
    const std::uint32_t a = candidates.a_element[i], b = candidates.b_element[i];
    const int wanted = allowed != 0 ? -allowed : (screen.keys[a] < screen.keys[b]) - (screen.keys[a] > screen.keys[b]);
    const unsigned lanes = candidates.lanes[i];
    // Parts do not cross: what holds where two of their patches overlap holds for all of them.
    const unsigned surely = lanes & overlapping_lanes;
    const int behind = (lanes & ~(apart_lanes | a_behind_lanes)) == 0   ? 1
                       : (lanes & ~(apart_lanes | b_behind_lanes)) == 0 ? -1
                       : (surely & a_behind_lanes) != 0                 ? 1
                       : (surely & b_behind_lanes) != 0                 ? -1
                                                                        : 0;
    if ((lanes & ~apart_lanes) == 0 || (behind != 0 && behind == -wanted)) continue;
    pairs.push_back({a, b, {surely != 0 ? Seen::overlapping : Seen::either, static_cast<std::int8_t>(behind)}});
  }
  candidates.count = candidates.pairs = 0;
}

// Compares the pairs of boxes that overlap, in batches of eight.
class PairFilter {
 public:
  PairFilter(const Screenful& screen, int allowed, std::vector<ElementPair>& pairs)
      : screen_(screen), allowed_(allowed), pairs_(pairs) {}

  HWY_INLINE void add(std::uint32_t element, std::uint32_t other) {
    if (screen_.patches.empty()) {
      pairs_.push_back({element, other, {Seen::not_compared, 0}});
      return;
    }
    const Patch &a = screen_.patches[element], &b = screen_.patches[other];
    if (a.is_one() && b.is_one()) {
      Candidates& candidates = a.is_triangle() && b.is_triangle() ? triangles_ : others_;
      add_lane(candidates, element, other);
      end_pair(candidates, element, other, 1);
    } else {
      add_several(element, other);
    }
  }

  void finish() {
    if (triangles_.count != 0) compare(triangles_);
    if (others_.count != 0) compare(others_);
  }

 private:
  static HWY_INLINE void add_lane(Candidates& candidates, std::uint32_t a_patch, std::uint32_t b_patch) {
    candidates.a[candidates.count] = a_patch;
    candidates.b[candidates.count++] = b_patch;
  }

  HWY_INLINE void end_pair(Candidates& candidates, std::uint32_t a, std::uint32_t b, std::size_t lanes) {
    candidates.a_element[candidates.pairs] = a;
    candidates.b_element[candidates.pairs] = b;
    candidates.lanes[candidates.pairs++] = ((1u << lanes) - 1) << (candidates.count - lanes);
    if (candidates.count == BoxBlock::size) compare(candidates);
  }

  void add_several(std::uint32_t element, std::uint32_t other) {
    const Patch &a = screen_.patches[element], &b = screen_.patches[other];
    const std::uint32_t a_first = a.is_one() ? element : a.first_of_several();
    const std::uint32_t b_first = b.is_one() ? other : b.first_of_several();
    const std::uint32_t a_count = a.is_one() ? 1 : a.number_of_several();
    const std::uint32_t b_count = b.is_one() ? 1 : b.number_of_several();
    const std::size_t lanes = std::size_t{a_count} * b_count;
    if (a.is_unknown() || b.is_unknown() || lanes > BoxBlock::size) {
      pairs_.push_back({element, other, {Seen::not_compared, 0}});
      return;
    }
    if (others_.count + lanes > BoxBlock::size) compare(others_);
    for (std::uint32_t i = 0; i < a_count; ++i) {
      for (std::uint32_t j = 0; j < b_count; ++j) add_lane(others_, a_first + i, b_first + j);
    }
    end_pair(others_, element, other, lanes);
  }

  void compare(Candidates& candidates) {
    if (&candidates == &triangles_) {
      compare_candidates<3>(screen_, candidates, allowed_, pairs_);
    } else {
      compare_candidates<4>(screen_, candidates, allowed_, pairs_);
    }
  }

  const Screenful& screen_;
  int allowed_;
  std::vector<ElementPair>& pairs_;
  Candidates triangles_, others_;
};

// Calls visit(block) for the blocks of levels[0] from `first` on whose boxes overlap `box` on the screen and in
// `dimension`, in ascending order.
template <BoxDimension dimension, class Visit>
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
    unsigned mask = overlapping<dimension>(levels[node.level][node.block], box);
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
  const ScreenBox leaf_box =
      levels.size() > 1 ? levels[1][leaf / BoxBlock::size].box(leaf % BoxBlock::size) : ScreenBox{};
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
  PairFilter filter(screen, 0, pairs);
  for_each_block<in_depth>(levels, leaf_box, leaf, [&](std::size_t other) {
    unsigned rows = 0xffu;
    if (other != leaf)
      rows = overlapping<in_depth>(block, levels[1][other / BoxBlock::size].box(other % BoxBlock::size));
    for (; rows != 0; rows &= rows - 1) {
      const unsigned i = static_cast<unsigned>(std::countr_zero(rows));
      unsigned mask = overlapping<in_depth>(levels[0][other], boxes[i]);
      if (other == leaf) mask &= 0xfeu << i;
      if (mask == 0) continue;
      found += static_cast<std::size_t>(std::popcount(mask));
      for (int k = 0; k < 3; ++k) {
        if (flat[k][i]) mask &= ~having_corner(screen.slots[other], corners.slot[k][i]);
      }
      for (; mask != 0; mask &= mask - 1) {
        filter.add(static_cast<std::uint32_t>(leaf * BoxBlock::size + i),
                   static_cast<std::uint32_t>(other * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask))));
      }
    }
  });
  filter.finish();
  return found;
}

void CollectPassed(const Screenful& screen, std::uint32_t element, const ScreenBox& box, const PassedRanks& passed,
                   std::vector<ElementPair>& pairs) {
  PairFilter filter(screen, 1, pairs);
  for_each_block<of_key>(screen.boxes, box, 0, [&](std::size_t block) {
    for (unsigned mask = overlapping<of_key>(screen.boxes[0][block], box); mask != 0; mask &= mask - 1) {
      const auto other =
          static_cast<std::uint32_t>(block * BoxBlock::size + static_cast<unsigned>(std::countr_zero(mask)));
      if (passed.contain(other)) filter.add(element, other);
    }
  });
  filter.finish();
}

// The edges of an outline, one in each lane, for points relative to an origin: outward(p) > 0 on the outer side.
struct EdgeLanes {
  using Four = hn::CappedTag<float, 4>;

  alignas(16) float x[4], y[4], offset[4];
  alignas(16) std::uint32_t from[4], to[4], line[4];

  HWY_INLINE EdgeLanes(const OutlineIds& ids, const OutlinePlaces& places, float facing, float origin_x,
                       float origin_y) {
    for (int i = 0; i < 4; ++i) {
      const int next = (i + 1) % 4;
      x[i] = facing * (places.x[next] - places.x[i]);
      y[i] = facing * (places.y[next] - places.y[i]);
      offset[i] = y[i] * (places.x[i] - origin_x) - x[i] * (places.y[i] - origin_y);
      from[i] = ids.slot[i];
      to[i] = ids.slot[next];
      line[i] = ids.edge[i];
    }
  }
};

// Whether some edge has all of another outline on its outer side: apart; overlapping where none has, as far as it is
// certain. Corners that are known to lie on an edge's line are on neither side.
HWY_INLINE Seen::Overlap overlap_by_edges(const EdgeLanes& edges, const OutlineIds& ids, const OutlinePlaces& places,
                                          float origin_x, float origin_y, float bound) {
  const EdgeLanes::Four tag;
  const hn::RebindToUnsigned<EdgeLanes::Four> id_tag;
  bool some_apart = false, all_inside = true;
  for (std::size_t at = 0; at < 4; at += hn::Lanes(tag)) {
    const auto x = hn::Load(tag, edges.x + at), y = hn::Load(tag, edges.y + at);
    const auto offset = hn::Load(tag, edges.offset + at), outer = hn::Set(tag, bound), inner = hn::Set(tag, -bound);
    const auto from = hn::Load(id_tag, edges.from + at), to = hn::Load(id_tag, edges.to + at);
    const auto line = hn::Load(id_tag, edges.line + at);
    auto outside = hn::RebindMask(tag, hn::Ne(from, to));  // the last corner of a triangle comes twice
    auto inside = hn::Not(outside);
    for (int k = 0; k < 4; ++k) {
      const auto slot = hn::Set(id_tag, ids.slot[k]);
      const auto on_line = hn::RebindMask(tag, hn::Or(hn::Or(hn::Eq(from, slot), hn::Eq(to, slot)),
                                                      hn::Or(hn::Eq(line, hn::Set(id_tag, ids.after[k])),
                                                             hn::Eq(line, hn::Set(id_tag, ids.before[k])))));
      const auto outward = hn::MulAdd(x, hn::Set(tag, places.y[k] - origin_y),
                                      hn::NegMulAdd(y, hn::Set(tag, places.x[k] - origin_x), offset));
      outside = hn::And(outside, hn::Or(on_line, hn::Gt(outward, outer)));
      inside = hn::Or(inside, hn::AndNot(on_line, hn::Lt(outward, inner)));
    }
    some_apart = some_apart || !hn::AllFalse(tag, outside);
    all_inside = all_inside && hn::AllTrue(tag, inside);
  }
  return some_apart ? Seen::apart : all_inside ? Seen::overlapping : Seen::either;
}

// What is certain of the overlap of one element with others.
class OverlapFilter {
 public:
  HWY_INLINE OverlapFilter(const Outlines& outlines, std::uint32_t element) : outlines_(outlines), element_(element) {
    if (!outlines.places.empty() && !has_several(element)) single_.emplace(edges_of(element, element));
  }

  HWY_INLINE Seen::Overlap operator()(std::uint32_t other) const {
    if (outlines_.places.empty()) return Seen::not_compared;
    const float span = outlines_.span[element_] + outlines_.span[other];
    const float bound = 4 * outlines_.rounding * (outlines_.rounding + span);
    if (single_ && !has_several(other)) return compare(*single_, element_, other, other, bound);
    return compare_several(other, bound);
  }

 private:
  bool has_several(std::uint32_t element) const {
    return outlines_.first_extra[element] != outlines_.first_extra[element + 1];
  }

  // Of outline `outline` of an element, relative to the first corner of this one's own.
  HWY_INLINE EdgeLanes edges_of(std::uint32_t element, std::uint32_t outline) const {
    return EdgeLanes(outlines_.ids[outline], outlines_.places[outline], outlines_.facing[element], origin_x(),
                     origin_y());
  }
  float origin_x() const { return outlines_.places[element_].x[0]; }
  float origin_y() const { return outlines_.places[element_].y[0]; }

  HWY_INLINE Seen::Overlap compare(const EdgeLanes& edges, std::uint32_t outline, std::uint32_t other,
                                   std::uint32_t other_outline, float bound) const {
    const Seen::Overlap by_own = overlap_by_edges(edges, outlines_.ids[other_outline], outlines_.places[other_outline],
                                                  origin_x(), origin_y(), bound);
    if (by_own == Seen::apart) return by_own;
    const Seen::Overlap by_other = overlap_by_edges(edges_of(other, other_outline), outlines_.ids[outline],
                                                    outlines_.places[outline], origin_x(), origin_y(), bound);
    return by_other == Seen::overlapping ? by_own : by_other;
  }

  HWY_NOINLINE Seen::Overlap compare_several(std::uint32_t other, float bound) const {
    const auto outlines_of = [&](std::uint32_t element) {
      const auto elements = static_cast<std::uint32_t>(outlines_.facing.size());
      const std::uint32_t first = outlines_.first_extra[element], last = outlines_.first_extra[element + 1];
      return first == last ? std::pair{element, element + 1} : std::pair{elements + first, elements + last};
    };
    const auto [first, last] = outlines_of(element_);
    const auto [other_first, other_last] = outlines_of(other);
    Seen::Overlap result = Seen::apart;
    for (std::uint32_t i = first; i < last; ++i) {
      const EdgeLanes edges = edges_of(element_, i);
      for (std::uint32_t k = other_first; k < other_last; ++k) {
        const Seen::Overlap found = compare(edges, i, other, k, bound);
        if (found == Seen::overlapping) return found;
        if (found == Seen::either) result = found;
      }
    }
    return result;
  }

  const Outlines& outlines_;
  const std::uint32_t element_;
  std::optional<EdgeLanes> single_;
};

// The bits of a block of eight, each of which stands for `each` places, that have some from `begin` to `end`.
HWY_INLINE unsigned in_range(std::size_t block, std::size_t each, std::size_t begin, std::size_t end) {
  const std::size_t first = block * 8 * each;
  const unsigned from = begin > first ? 0xffu << ((begin - first) / each) : 0xffu;
  const unsigned to = end < first + 8 * each ? (1u << ((end - first + each - 1) / each)) - 1 : 0xffu;
  return from & to;
}

std::size_t CollectInRow(const Outlines& outlines, const RowView& row, std::uint32_t element, const ScreenBox& box,
                         std::size_t begin, std::size_t end, std::vector<Candidate>& candidates) {
  const OverlapFilter filter(outlines, element);
  for (std::size_t block = begin / 512; block * 512 < end; ++block) {
    for (unsigned mask = overlapping(row.sixty_fours[block], box) & in_range(block, 64, begin, end); mask != 0;
         mask &= mask - 1) {
      const std::size_t sixty_four = block * 8 + static_cast<unsigned>(std::countr_zero(mask));
      for (unsigned eights = overlapping(row.eights[sixty_four], box) & in_range(sixty_four, 8, begin, end);
           eights != 0; eights &= eights - 1) {
        const std::size_t eight = sixty_four * 8 + static_cast<unsigned>(std::countr_zero(eights));
        for (unsigned places = overlapping(row.places[eight], box) & in_range(eight, 1, begin, end); places != 0;
             places &= places - 1) {
          const std::size_t place = eight * 8 + static_cast<unsigned>(std::countr_zero(places));
          for (std::uint32_t other = row.first_at[place]; other != RowView::none; other = row.next[other]) {
            const Seen::Overlap overlap = filter(other);
            if (overlap != Seen::apart) candidates.push_back({other, overlap});
          }
          if (!candidates.empty()) return place + 1;
        }
      }
    }
  }
  return end;
}

}  // namespace facetsort::exact_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace facetsort::exact_internal {

HWY_EXPORT(CollectPairs);
HWY_EXPORT(CollectPassed);
HWY_EXPORT(CollectInRow);

std::size_t collect_pairs(const Screenful& screen, std::size_t leaf, std::vector<ElementPair>& pairs) {
  return HWY_DYNAMIC_DISPATCH(CollectPairs)(screen, leaf, pairs);
}

void collect_passed(const Screenful& screen, std::uint32_t element, const ScreenBox& box, const PassedRanks& passed,
                    std::vector<ElementPair>& pairs) {
  HWY_DYNAMIC_DISPATCH(CollectPassed)(screen, element, box, passed, pairs);
}

std::size_t collect_in_row(const Outlines& outlines, const RowView& row, std::uint32_t element, const ScreenBox& box,
                           std::size_t begin, std::size_t end, std::vector<Candidate>& candidates) {
  return HWY_DYNAMIC_DISPATCH(CollectInRow)(outlines, row, element, box, begin, end, candidates);
}

}  // namespace facetsort::exact_internal
#endif
