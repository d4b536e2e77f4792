// Internal to order: facets in the order of quantised depths. Included by depth_kernels.cpp, once for each instruction
// set.
//
// Depth is cut into steps of one length. How many facets lie on each is counted, which says where each step begins in
// the order, and their ids go there in one pass over the mesh; a last pass over the order writes what is asked for. In
// a mesh in spatial order the steps of neighbours are near each other, so that counters and places of ids are in the
// cache whatever the mesh's size.
HWY_BEFORE_NAMESPACE();
namespace facetsort::order_internal::HWY_NAMESPACE {

// Steps are read four at a time: these loops wait for memory operations, not for arithmetic.
HWY_INLINE std::uint64_t four_steps(const std::uint16_t* from) {
  std::uint64_t four;
  std::memcpy(&four, from, sizeof four);
  return four;
}

HWY_INLINE std::size_t step_of_four(std::uint64_t four, int k) {
  return four >> 16 * (std::endian::native == std::endian::little ? k : 3 - k) & 0xffff;
}

HWY_INLINE hn::Vec<IntTag> steps_of(const BucketMap& map, FloatVec keys) {
  const FloatTag d;
  const IntTag di;
  // Floats from here on are integers, which their lowest bits hold.
  return hn::And(hn::BitCast(di, hn::Add(bucket_of(map, keys), hn::Set(d, 0x1p23f))), hn::Set(di, 0xffff));
}

// In whole vectors.
HWY_INLINE void steps_of_tile(const float* keys, std::size_t count, const BucketMap& map, std::uint16_t* steps) {
  const FloatTag d;
  const hn::Rebind<std::uint16_t, FloatTag> d16;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::StoreU(hn::DemoteTo(d16, steps_of(map, hn::Load(d, keys + i))), d16, steps + i);
  }
}

// From steps[first] on, in fours as far as there are some; where it ended.
HWY_INLINE std::size_t count_fours(const std::uint16_t* steps, std::size_t first, std::size_t end,
                                   std::uint32_t* counts) {
  for (; first + 4 <= end; first += 4) {
    const std::uint64_t four = four_steps(steps + first);
    for (int k = 0; k < 4; ++k) ++counts[step_of_four(four, k)];
  }
  return first;
}

// Steps and ids of the facets of a tile that are not culled; the number of them. Writes whole vectors, up to a tile.
HWY_INLINE std::size_t kept_steps_of_tile(const KeySource& source, const BucketMap& map, const BlockCulling& culling,
                                          std::size_t first, std::size_t count, std::uint16_t* steps,
                                          std::uint32_t* ids) {
  const FloatTag d;
  const IntTag di;
  const IdTag du;
  const hn::Rebind<std::uint16_t, FloatTag> d16;
  HWY_ALIGN float keys[tile_facets];
  signed_keys_of_tile(source, first, count, keys);
  if (!culling.tests_anything()) {
    steps_of_tile(keys, count, map, steps);
    for (std::size_t i = 0; i < count; i += hn::Lanes(du)) hn::StoreU(ids_from(first + i), du, ids + i);
    return count;
  }
  std::size_t kept = 0;
  cull_tile(source, culling, first, count, [&](std::size_t i, FloatMask keep) HWY_ATTR {
    const auto step = steps_of(map, hn::Load(d, keys + i));
    hn::StoreU(hn::DemoteTo(d16, hn::Compress(step, hn::RebindMask(di, keep))), d16, steps + kept);
    hn::StoreU(hn::Compress(ids_from(first + i), hn::RebindMask(du, keep)), du, ids + kept);
    kept += hn::CountTrue(d, keep);
  });
  return kept;
}

std::size_t CountSteps(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                       std::uint16_t* steps, std::uint32_t* ids, std::uint32_t* counts) {
  // Where a loop over what is left of a tile ends can't be foreseen: such loops go over many tiles.
  constexpr std::size_t counted_at_once = 16 * tile_facets;
  HWY_ALIGN std::uint16_t tile_steps[tile_facets];
  std::size_t total = 0, counted = 0;
  // Whole tiles: what lies behind those kept is to be written yet, or is left over.
  const auto has_room = [&] HWY_ATTR { return total + tile_facets <= end - begin; };
  const auto add = [&](std::size_t kept) HWY_ATTR {
    total += kept;
    if (total - counted >= counted_at_once) counted = count_fours(steps, counted, total, counts);
  };
  if (source.culls()) {
    HWY_ALIGN std::uint32_t tile_ids[tile_facets];
    for_culled_tiles(
        source, begin, end, [&](std::size_t first, std::size_t count, const BlockCulling& culling) HWY_ATTR {
          if (has_room()) {
            return add(kept_steps_of_tile(source, map, culling, first, count, steps + total, ids + total));
          }
          const std::size_t kept = kept_steps_of_tile(source, map, culling, first, count, tile_steps, tile_ids);
          std::memcpy(steps + total, tile_steps, kept * sizeof(std::uint16_t));
          std::memcpy(ids + total, tile_ids, kept * sizeof(std::uint32_t));
          add(kept);
        });
  } else {
    HWY_ALIGN float keys[tile_facets];
    for_tiles(begin, end, [&](std::size_t first, std::size_t count) HWY_ATTR {
      signed_keys_of_tile(source, first, count, keys);
      if (has_room()) {
        steps_of_tile(keys, count, map, steps + total);
      } else {
        steps_of_tile(keys, count, map, tile_steps);
        std::memcpy(steps + total, tile_steps, count * sizeof(std::uint16_t));
      }
      add(count);
    });
  }
  counted = count_fours(steps, counted, total, counts);
  for (; counted < total; ++counted) ++counts[steps[counted]];
  return total;
}

#if HWY_TARGET != HWY_SCALAR
// Half a vector of 8, or all of one of 4, is a block, within which lanes shift.
using CountTag = hn::CappedTag<std::uint32_t, 8>;
using CountVec = hn::Vec<CountTag>;

HWY_INLINE CountVec inclusive_sums(CountVec counts) {
  const CountTag d;
  CountVec sums = hn::Add(counts, hn::ShiftLeftLanes<1>(d, counts));
  sums = hn::Add(sums, hn::ShiftLeftLanes<2>(d, sums));
  if constexpr (hn::MaxLanes(d) == 8) {
    sums = hn::Add(sums, hn::ConcatLowerLower(d, hn::Broadcast<3>(sums), hn::Zero(d)));
  }
  return sums;
}

HWY_INLINE CountVec last_lane(CountVec sums) {
  const CountVec last = hn::Broadcast<3>(sums);
  if constexpr (hn::MaxLanes(CountTag()) == 8) return hn::ConcatUpperUpper(CountTag(), last, last);
  return last;
}
#endif

std::uint32_t SumSteps(std::uint32_t* counts, std::size_t parts, std::size_t steps) {
#if HWY_TARGET == HWY_SCALAR
  std::uint32_t sum = 0, most = 0;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::uint32_t before = sum;
    for (std::size_t part = 0; part < parts; ++part) sum += std::exchange(counts[part * steps + step], sum);
    most = std::max(most, sum - before);
  }
  return most;
#else
  const CountTag d;
  CountVec before = hn::Zero(d), most = hn::Zero(d);
  for (std::size_t step = 0; step < steps; step += hn::Lanes(d)) {
    CountVec total = hn::LoadU(d, counts + step);
    for (std::size_t part = 1; part < parts; ++part) total = hn::Add(total, hn::LoadU(d, counts + part * steps + step));
    most = hn::Max(most, total);
    const CountVec sums = inclusive_sums(total);
    CountVec place = hn::Add(hn::Sub(sums, total), before);
    for (std::size_t part = 0; part < parts; ++part) {
      std::uint32_t* of_part = counts + part * steps + step;
      const CountVec count = hn::LoadU(d, of_part);
      hn::StoreU(place, d, of_part);
      place = hn::Add(place, count);
    }
    before = hn::Add(before, last_lane(sums));
  }
  return hn::GetLane(hn::MaxOfLanes(d, most));
#endif
}

template <typename IdAt>
HWY_INLINE void place_ids(const StepIds& from, const IdAt& id_at, std::uint32_t* cursors, std::uint32_t* order) {
  const std::uint16_t* steps = from.steps;
  std::size_t i = 0;
  const auto place_four = [&] HWY_ATTR {
    const std::uint64_t four = four_steps(steps + i);
    std::uint32_t places[4];
    for (int k = 0; k < 4; ++k) {
      std::uint32_t& cursor = cursors[step_of_four(four, k)];
      places[k] = cursor;
      cursor = places[k] + 1;
    }
    for (int k = 0; k < 4; ++k) order[places[k]] = id_at(i + k);
  };
  if (from.prefetches) {
    // Places come from memory in time if they are asked for so many ahead.
    constexpr std::size_t ahead = 128;
    for (; i + ahead + 4 <= from.count; i += 4) {
      const std::uint64_t four = four_steps(steps + i + ahead);
      for (int k = 0; k < 4; ++k) hwy::Prefetch(order + cursors[step_of_four(four, k)]);
      place_four();
    }
  }
  for (; i + 4 <= from.count; i += 4) place_four();
  for (; i < from.count; ++i) order[cursors[steps[i]]++] = id_at(i);
}

void PlaceIds(const StepIds& from, std::uint32_t* cursors, std::uint32_t* order) {
  if (from.ids == nullptr) {
    const std::uint32_t first_id = from.first_id;
    const auto in_a_row = [first_id](std::size_t i) HWY_ATTR { return first_id + static_cast<std::uint32_t>(i); };
    place_ids(from, in_a_row, cursors, order);
  } else {
    const std::uint32_t* ids = from.ids;
    place_ids(
        from, [ids](std::size_t i) HWY_ATTR { return ids[i]; }, cursors, order);
  }
}

#if HWY_TARGET != HWY_SCALAR
using IndexTag = hn::CappedTag<std::uint32_t, 4>;

struct StoreVector {
  template <typename V>
  HWY_INLINE void operator()(V vector, std::uint32_t* to) const {
    hn::StoreU(vector, IndexTag(), to);
  }
};
// Past the caches.
struct StreamVector {
  template <typename V>
  HWY_INLINE void operator()(V vector, std::uint32_t* to) const {
    hn::Stream(vector, IndexTag(), to);
  }
};

// Four triangles are three vectors: fewer, wider stores than corner by corner.
template <typename Store>
HWY_INLINE void write_four_triangles(const std::uint32_t* ids, const std::uint32_t* corners, std::uint32_t* to,
                                     const Store& store) {
  const IndexTag d;
  const hn::Half<IndexTag> pair;
  const std::uint32_t* from[4];
  for (int k = 0; k < 4; ++k) from[k] = corners + 3 * std::size_t{ids[k]};
  const auto pair_of = [&](std::uint32_t first, std::uint32_t second)
                           HWY_ATTR { return hn::InterleaveLower(pair, hn::Set(pair, first), hn::Set(pair, second)); };
  store(hn::Combine(d, pair_of(from[0][2], from[1][0]), hn::LoadU(pair, from[0])), to);
  store(hn::Combine(d, hn::LoadU(pair, from[2]), hn::LoadU(pair, from[1] + 1)), to + 4);
  store(hn::Combine(d, hn::LoadU(pair, from[3] + 1), pair_of(from[2][2], from[3][0])), to + 8);
}

// Writes all but the last few, from memory; their number. Triangles come in time if they are asked for so many ahead, a
// few at a time: a core waits for no more than some twenty lines at once.
template <typename Store>
HWY_INLINE std::size_t write_from_memory(const std::uint32_t* ids, std::size_t count, const Output& output,
                                         const Store& store) {
  constexpr std::size_t ahead = 256;
  std::size_t k = 0;
  for (; k + ahead + 4 <= count; k += 4) {
    prefetch_triangles(output.corners, ids + k + ahead, 4);
    write_four_triangles(ids + k, output.corners, output.indices_32 + 3 * k, store);
  }
  return k;
}
#endif

HWY_INLINE void write_indices(const std::uint32_t* ids, std::size_t count, const Output& output) {
  const std::uint32_t* corners = output.corners;
  std::uint32_t* to = output.indices_32;
  std::size_t k = 0;
#if HWY_TARGET != HWY_SCALAR
  if (output.is_from_memory) {
    if (reinterpret_cast<std::uintptr_t>(to) % sizeof(hn::Vec<IndexTag>) == 0) {
      k = write_from_memory(ids, count, output, StreamVector());
      hwy::FlushStream();
    } else {
      k = write_from_memory(ids, count, output, StoreVector());
    }
  }
  for (; k + 4 <= count; k += 4) write_four_triangles(ids + k, corners, to + 3 * k, StoreVector());
#endif
  for (; k < count; ++k) {
    for (int corner = 0; corner < 3; ++corner) to[3 * k + corner] = corners[3 * std::size_t{ids[k]} + corner];
  }
}

void WriteOrder(const std::uint32_t* ids, std::size_t count, const Output& output) {
  if (output.indices_32 != nullptr) write_indices(ids, count, output);
  if (output.indices_16 != nullptr) {
    for (std::size_t k = 0; k < count; ++k) {
      for (int corner = 0; corner < 3; ++corner) {
        output.indices_16[3 * k + corner] =
            static_cast<std::uint16_t>(output.corners[3 * std::size_t{ids[k]} + corner]);
      }
    }
  }
  if (output.ids != nullptr && output.ids != ids) std::memcpy(output.ids, ids, count * sizeof(std::uint32_t));
}

}  // namespace facetsort::order_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
