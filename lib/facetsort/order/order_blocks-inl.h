// Internal to order: orders of blocks. Included by depth_kernels.cpp, once for each instruction set.
//
// Signs of planes in float, in doubt exactly; places of triangles from the sizes of subtrees, without branches.
HWY_BEFORE_NAMESPACE();
namespace facetsort::order_internal::HWY_NAMESPACE {

using PlaneTag = hn::CappedTag<float, 8>;  // a byte of sides
using PlaneVec = hn::Vec<PlaneTag>;

// Bounds the rounding of dot(normal, E) + offset * w in float: components of normal and eye up to 1, offsets up to 3,
// each rounded once, four products and three sums, are off by less than 36 * 2^-24.
constexpr float rounding = 0x1p-18f;

struct EyeVectors {
  PlaneVec x, y, z, w;
};

HWY_INLINE EyeVectors eye_of(const FrameEye& eye) {
  const PlaneTag d;
  const glm::vec4 e(eye.in_frame);
  return {hn::Set(d, e.x), hn::Set(d, e.y), hn::Set(d, e.z), hn::Set(d, e.w)};
}

HWY_INLINE PlaneVec distances(const PlaneArrays& planes, std::size_t i, const EyeVectors& eye) {
  const PlaneTag d;
  const PlaneVec xy =
      hn::Add(hn::Mul(hn::LoadU(d, planes.x.data() + i), eye.x), hn::Mul(hn::LoadU(d, planes.y.data() + i), eye.y));
  const PlaneVec zw = hn::Add(hn::Mul(hn::LoadU(d, planes.z.data() + i), eye.z),
                              hn::Mul(hn::LoadU(d, planes.offset.data() + i), eye.w));
  return hn::Add(xy, zw);
}

template <typename Mask>
HWY_INLINE unsigned bits_of(const Mask& mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(PlaneTag(), mask, bytes);
  return bytes[0];
}

// Those that float leaves in doubt.
HWY_NOINLINE void decide_exactly(const PlaneSource& source, std::size_t first, std::size_t count, const FrameEye& eye,
                                 std::uint8_t* sides) {
  const PlaneTag d;
  const EyeVectors e = eye_of(eye);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto in_doubt = hn::And(hn::Le(hn::Abs(distances(source.planes, first + i, e)), hn::Set(d, rounding)),
                                  hn::FirstN(d, count - i));
    for (unsigned bits = bits_of(in_doubt); bits != 0; bits &= bits - 1) {
      const std::size_t plane = i + static_cast<std::size_t>(std::countr_zero(bits));
      const glm::uvec3& corners = source.nodes[source.planes.node[first + plane]].plane;
      const int side =
          eye_side(source.positions[corners.x], source.positions[corners.y], source.positions[corners.z], eye.eye);
      const unsigned bit = 1u << plane % 8;
      const unsigned others = sides[plane / 8] & ~bit;
      sides[plane / 8] = static_cast<std::uint8_t>(side >= 0 ? others | bit : others);
    }
  }
}

// Of planes [first, first + count), into `sides`, which is zero. Gives by how much distance_between() a later eye has
// to be less to be on the same sides; 0 or less where that can't be said.
HWY_INLINE float find_sides(const PlaneSource& source, std::size_t first, std::size_t count, const FrameEye& eye,
                            const EyeVectors& e, std::uint8_t* sides) {
  const PlaneTag d;
  PlaneVec least = hn::Set(d, std::numeric_limits<float>::infinity());
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const PlaneVec value = distances(source.planes, first + i, e);
    const auto mask = hn::FirstN(d, count - i);
    least = hn::Min(least, hn::IfThenElse(mask, hn::Abs(value), least));
    const unsigned bits = bits_of(hn::And(hn::Gt(value, hn::Zero(d)), mask));
    sides[i / 8] = static_cast<std::uint8_t>(sides[i / 8] | bits << i % 8);
  }
  const float smallest = hn::GetLane(hn::MinOfLanes(d, least));
  if (smallest <= rounding) decide_exactly(source, first, count, eye, sides);
  // Beyond this distance's rounding, that of what is compared with it.
  return smallest - 4 * rounding;
}

void FindSides(const PlaneSource& source, const FrameEye& eye, std::span<std::uint8_t> sides) {
  std::fill(sides.begin(), sides.end(), std::uint8_t{0});
  find_sides(source, 0, source.planes.size(), eye, eye_of(eye), sides.data());
}

// A byte for each plane in place of a bit: 1 where the eye is in front.
struct SideBytes {
  alignas(8) std::uint8_t in_front[most_block_nodes];

  SideBytes(const BlockSides& sides, std::size_t count) {
    for (std::size_t i = 0; i < count; i += 8) {
      // Each byte keeps another of the eight bits, which then carries into its uppermost.
      const std::uint64_t bits = std::uint64_t{sides[i / 8]} * 0x0101010101010101 & 0x8040201008040201;
      const std::uint64_t bytes = (bits + 0x7f7f7f7f7f7f7f7f) >> 7 & 0x0101010101010101;
      for (int k = 0; k < 8; ++k) in_front[i + k] = static_cast<std::uint8_t>(bytes >> 8 * k);
    }
  }
};

// The triangles that are drawn, of `order`, which they replace.
HWY_INLINE std::uint8_t cull(const PresortedBlocks& blocks, const Block& block, const SideBytes& sides,
                             std::uint8_t* order) {
  const Facing* facings = blocks.facings.data() + block.first_triangle;
  const Spot* spots = blocks.spots.data() + block.first_spot;
  std::size_t kept = 0;
  for (std::size_t k = 0, count = block.triangle_count; k < count; ++k) {
    const std::uint8_t t = order[k];
    const bool is_front = sides.in_front[spots[t].slot] != 0;
    order[kept] = t;
    kept += (facings[t] == Facing::always) | (is_front == (facings[t] == Facing::front));
  }
  return static_cast<std::uint8_t>(kept);
}

// From the root down, each node hands its subtrees the places where they begin: what is beyond its plane comes first,
// then what is in it, then what is before it. Without branches: which side comes first can't be foreseen.
template <bool culls>
HWY_INLINE void order_block(const PresortedBlocks& blocks, std::size_t b, const BlockOrders& orders) {
  const Block block = blocks.blocks[b];
  const SideBytes sides(orders.states[b].sides, block.plane_count);
  std::uint8_t places[no_slot + 1];
  places[0] = 0;
  const Branch* branches = blocks.branches.data() + block.first_branch;
  for (std::size_t k = 0; k < block.branch_count; ++k) {
    const Branch& branch = branches[k];
    const std::size_t in_front = sides.in_front[culls ? branch.slot : k];
    const unsigned begin = places[branch.slot];
    const unsigned own = begin + branch.sizes[in_front];
    places[branch.slot] = static_cast<std::uint8_t>(own);
    places[branch.slots[in_front]] = static_cast<std::uint8_t>(begin);
    places[branch.slots[in_front + 1]] = static_cast<std::uint8_t>(own + branch.own_size);
  }
  std::uint8_t* order = orders.orders + block.first_spot;
  const Spot* spots = blocks.spots.data() + block.first_spot;
  places[end_slot] = block.triangle_count;
  for (std::size_t t = 0; t < block.triangle_count; t += triangles_at_a_time) {
    for (std::size_t i = t; i < t + triangles_at_a_time; ++i) {
      order[std::size_t{places[spots[i].slot]} + spots[i].place] = static_cast<std::uint8_t>(i);
    }
  }
  orders.kept[b] = culls ? cull(blocks, block, sides, order) : block.triangle_count;
}

void OrderBlock(const PresortedBlocks& blocks, std::size_t b, const BlockOrders& orders) {
  blocks.facings.empty() ? order_block<false>(blocks, b, orders) : order_block<true>(blocks, b, orders);
}

BlockChanges OrderBlocks(const PresortedBlocks& blocks, const PlaneSource& source, std::size_t begin, std::size_t end,
                         const FrameEye& eye, double way, const BlockOrders& orders) {
  const EyeVectors e = eye_of(eye);
  BlockChanges changes;
  for (std::size_t b = begin; b < end; ++b) {
    BlockOrders::State& state = orders.states[b];
    const Block& block = blocks.blocks[b];
    if (way < state.valid_until || block.plane_count == 0) continue;
    BlockSides sides{};
    const float margin = find_sides(source, block.first_plane, block.plane_count, eye, e, sides.data());
    state.valid_until = static_cast<float>(way) + margin;
    if (sides == state.sides) continue;
    state.sides = sides;
    const std::uint8_t kept = orders.kept[b];
    OrderBlock(blocks, b, orders);
    changes.orders = true;
    changes.counts = changes.counts || kept != orders.kept[b];
  }
  return changes;
}

}  // namespace facetsort::order_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
