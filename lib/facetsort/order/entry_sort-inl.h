// Internal to order: entries sorted to the last bit of their keys. Included by depth_kernels.cpp, once for each
// instruction set.
//
// One counting pass over two bins an entry, after which few entries share a bin, and one insertion pass over the nearly
// sorted entries (MacLaren, "Internal Sorting by Radix Plus Sifting", 1966). Entries are 64-bit integers, key above id,
// so that one comparison settles ties too.
HWY_BEFORE_NAMESPACE();
namespace facetsort::order_internal::HWY_NAMESPACE {

// As signed integers, bits of positive floats ascend with the float; those of negative ones with all but the sign
// inverted. Inverting everything then makes them descend.
template <typename D, typename V>
HWY_INLINE V descending_bits(D d, V bits) {
  return hn::Not(hn::Xor(bits, hn::And(hn::ShiftRight<31>(bits), hn::Set(d, 0x7fffffff))));
}

// 64-bit integers that ascend as keys descend and then as ids ascend; in whole vectors.
HWY_INLINE void merge_keys_and_ids(const float* keys, const std::uint32_t* ids, std::size_t count,
                                   std::int64_t* merged) {
  // Interleaving is by 128 bits: with shorter vectors the order stays.
  const hn::CappedTag<float, 4> d;
  const hn::RebindToSigned<decltype(d)> di;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const auto descending = descending_bits(di, hn::BitCast(di, hn::LoadU(d, keys + i)));
#if HWY_TARGET == HWY_SCALAR
    merged[i] = static_cast<std::int64_t>(hn::GetLane(descending)) * (std::int64_t{1} << 32) | ids[i];
#else
    const auto id = hn::BitCast(di, hn::LoadU(hn::RebindToUnsigned<decltype(d)>(), ids + i));
    // The id comes first in memory: it is the lower half, as the processors with vectors are little-endian.
    std::int32_t* to = reinterpret_cast<std::int32_t*>(merged + i);
    hn::StoreU(hn::InterleaveLower(di, id, descending), di, to);
    hn::StoreU(hn::InterleaveUpper(di, id, descending), di, to + hn::Lanes(d));
#endif
  }
}

// Counts become the sums of those before them. Gives a number that the largest count does not exceed, below the next
// power of two. Whole vectors of eight.
HWY_INLINE std::uint32_t exclusive_sums(std::uint16_t* bins, std::size_t count) {
#if HWY_TARGET == HWY_SCALAR
  std::uint32_t most = 0;
  std::uint16_t sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    most |= bins[i];
    sum = static_cast<std::uint16_t>(sum + std::exchange(bins[i], sum));
  }
  return most;
#else
  const hn::CappedTag<std::uint16_t, 8> d;
  auto before = hn::Zero(d), most = hn::Zero(d);
  for (std::size_t i = 0; i < count; i += 8) {
    const auto counts = hn::LoadU(d, bins + i);
    most = hn::Or(most, counts);
    auto sums = hn::Add(counts, hn::ShiftLeftLanes<1>(d, counts));
    sums = hn::Add(sums, hn::ShiftLeftLanes<2>(d, sums));
    sums = hn::Add(sums, hn::ShiftLeftLanes<4>(d, sums));
    hn::StoreU(hn::Add(hn::Sub(sums, counts), before), d, bins + i);
    before = hn::Add(before, hn::Broadcast<7>(sums));
  }
  HWY_ALIGN std::uint16_t lanes[8];
  hn::Store(most, d, lanes);
  return std::accumulate(lanes, lanes + 8, std::uint32_t{0}, std::bit_or<>());
#endif
}

HWY_INLINE std::size_t id_of(std::int64_t entry) {
  return static_cast<std::uint32_t>(entry);
}

HWY_INLINE void write(const std::int64_t* sorted, std::size_t count, const Output& output) {
  const std::uint32_t* corners = output.corners;
  if (output.indices_32 != nullptr) {
    std::uint32_t* to = output.indices_32;
    unrolled(count, [&](std::size_t k) HWY_ATTR {
      const std::uint32_t* from = corners + 3 * id_of(sorted[k]);
      std::uint64_t first_two;
      std::memcpy(&first_two, from, sizeof first_two);
      const std::uint32_t last = from[2];
      std::memcpy(to + 3 * k, &first_two, sizeof first_two);
      to[3 * k + 2] = last;
    });
  }
  if (output.indices_16 != nullptr) {
    std::uint16_t* to = output.indices_16;
    unrolled(count, [&](std::size_t k) HWY_ATTR {
      const std::uint32_t* from = corners + 3 * id_of(sorted[k]);
      for (int corner = 0; corner < 3; ++corner) to[3 * k + corner] = static_cast<std::uint16_t>(from[corner]);
    });
  }
  if (output.ids != nullptr) {
    unrolled(count, [&](std::size_t k) HWY_ATTR { output.ids[k] = static_cast<std::uint32_t>(sorted[k]); });
  }
}

// No bin holds as many: so far, and no farther, insertion moves an entry. A power of two, as exclusive_sums() wants.
constexpr std::size_t too_many_in_bin = 64;

// Moves sorted[i] to its place among those before it, which are in order.
HWY_INLINE void insert(std::int64_t* sorted, std::size_t i) {
  const std::int64_t entry = sorted[i];
  do {
    sorted[i] = sorted[i - 1];
    --i;
  } while (i > 0 && sorted[i - 1] > entry);
  sorted[i] = entry;
}

// Puts right what is out of order, and writes out what can't change any more while it is in the cache. One entry is
// carried along and exchanged for a smaller one without a branch, which would often be mispredicted: that settles bins
// of two, and most of three.
HWY_INLINE void insert_and_write(std::int64_t* sorted, std::size_t count, const Output& output) {
  std::size_t written = 0;
  std::int64_t carried = sorted[0], largest = std::numeric_limits<std::int64_t>::min();
  for (std::size_t begin = 1; begin < count; begin += too_many_in_bin) {
    const std::size_t end = std::min(count, begin + too_many_in_bin);
    for (std::size_t i = begin; i < end; ++i) {
      // Values, not std::min's references, which compilers make branches of.
      const std::int64_t entry = sorted[i], smaller = entry < carried ? entry : carried;
      carried = entry < carried ? carried : entry;
      sorted[i - 1] = smaller;
      if (HWY_LIKELY(smaller >= largest)) {
        largest = smaller;
      } else {
        insert(sorted, i - 1);
      }
    }
    write(sorted + written, begin - 1 - written, output + written);
    written = begin - 1;
  }
  // None that was written is larger than the one still carried.
  sorted[count - 1] = carried;
  write(sorted + written, count - written, output + written);
}

bool SortEntries(const Entries& from, std::size_t count, const KeyRange& range, std::int64_t* sorted,
                 std::uint16_t* bins, const Output& output) {
  const FloatTag d;
  const IntTag di;
  const std::size_t bin_total = bin_count(count);
  const BucketMap map = bucket_map(range.lowest, range.highest, bin_total);
  std::memset(bins, 0, bin_total * sizeof(std::uint16_t));
  Tile tile;
  HWY_ALIGN float key_copy[tile_facets];
  HWY_ALIGN std::uint32_t id_copy[tile_facets];
  const auto bins_of_tile = [&](const float* keys, std::size_t size) HWY_ATTR {
    for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
      hn::Store(hn::ConvertTo(di, bucket_of(map, hn::LoadU(d, keys + i))), di, tile.buckets + i);
    }
  };
  for (std::size_t first = 0; first < count; first += tile_facets) {
    const std::size_t size = std::min(tile_facets, count - first);
    bins_of_tile(whole_vectors(from.keys + first, size, key_copy), size);
    // Now, while ids still ascend: in this order memory gives them up fastest.
    if (output.is_from_memory) prefetch_triangles(output.corners, from.ids + first, size);
    unrolled(size, [&](std::size_t i) HWY_ATTR { ++bins[tile.buckets[i]]; });
  }
  if (exclusive_sums(bins, bin_total) >= too_many_in_bin) return false;

  HWY_ALIGN std::int64_t merged[tile_facets];
  for (std::size_t first = 0; first < count; first += tile_facets) {
    const std::size_t size = std::min(tile_facets, count - first);
    const float* keys = whole_vectors(from.keys + first, size, key_copy);
    bins_of_tile(keys, size);
    merge_keys_and_ids(keys, whole_vectors(from.ids + first, size, id_copy), size, merged);
    unrolled(size, [&](std::size_t i) HWY_ATTR { sorted[bins[tile.buckets[i]]++] = merged[i]; });
  }
  insert_and_write(sorted, count, output);
  return true;
}

void SortUnevenEntries(const Entries& from, std::size_t count, std::int64_t* sorted, const Output& output) {
  HWY_ALIGN float key_copy[tile_facets];
  HWY_ALIGN std::uint32_t id_copy[tile_facets];
  HWY_ALIGN std::int64_t merged[tile_facets];
  for (std::size_t first = 0; first < count; first += tile_facets) {
    const std::size_t size = std::min(tile_facets, count - first);
    merge_keys_and_ids(whole_vectors(from.keys + first, size, key_copy), whole_vectors(from.ids + first, size, id_copy),
                       size, merged);
    std::memcpy(sorted + first, merged, size * sizeof(std::int64_t));
  }
  std::sort(sorted, sorted + count);
  write(sorted, count, output);
}

}  // namespace facetsort::order_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
