// The per-frame sort in few instructions a facet.
//
// Keys cost less to compute than to store: they are computed again wherever they are needed, a tile at a time. Sorting
// is one counting pass over two bins an entry, after which few entries share a bin, and one insertion pass over
// the nearly sorted entries (MacLaren, "Internal Sorting by Radix Plus Sifting", 1966). Entries are 64-bit integers,
// key above id, so that one comparison settles ties too.
#include "facetsort/order/depth_kernels.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "facetsort/order/depth_kernels.cpp"
#include <hwy/foreach_target.h>
// Highway's own order: foreach_target.h before highway.h.
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace facetsort::order_internal::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// A tile is a block: whole vectors for every instruction set, and all of it in the first-level cache.
constexpr std::size_t tile_facets = block_facets;
using FloatTag = hn::CappedTag<float, tile_facets>;
using IntTag = hn::RebindToSigned<FloatTag>;
using IdTag = hn::RebindToUnsigned<FloatTag>;
using FloatVec = hn::Vec<FloatTag>;
using FloatMask = hn::Mask<FloatTag>;

// Room for whole vectors written from any place in a tile.
constexpr std::size_t padded_tile = 2 * tile_facets;

struct Tile {
  HWY_ALIGN float keys[padded_tile];
  HWY_ALIGN std::uint32_t ids[padded_tile];
  HWY_ALIGN std::int32_t buckets[padded_tile];
};

// Up to a tile of an array, in whole vectors: the array itself, or a copy where it ends before.
template <typename T>
HWY_INLINE const T* whole_vectors(const T* from, std::size_t count, T* copy) {
  if (count == tile_facets) return from;
  std::memcpy(copy, from, count * sizeof(T));
  std::memset(static_cast<void*>(copy + count), 0, (tile_facets - count) * sizeof(T));
  return copy;
}

// Points of a tile, readable in whole vectors.
struct TilePoints {
  HWY_ALIGN float copies[3][tile_facets];
  const float *x, *y, *z;

  HWY_INLINE TilePoints(const KeySource::Points& points, std::size_t first, std::size_t count)
      : x(whole_vectors(points.x + first, count, copies[0])),
        y(whole_vectors(points.y + first, count, copies[1])),
        z(whole_vectors(points.z + first, count, copies[2])) {}
};

// Multiplications and additions apart: fused ones would round otherwise than on processors that have none.
template <KeyForm::Kind kind>
HWY_INLINE void keys_of_points(const KeyForm& form, const TilePoints& points, std::size_t count, float* keys) {
  const FloatTag d;
  const FloatVec zero = hn::Zero(d), linear = hn::Set(d, form.linear);
  const glm::vec3& first = kind == KeyForm::Kind::distance ? form.eye : form.constant;
  const FloatVec fx = hn::Set(d, first.x), fy = hn::Set(d, first.y), fz = hn::Set(d, first.z);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const FloatVec x = hn::LoadU(d, points.x + i), y = hn::LoadU(d, points.y + i), z = hn::LoadU(d, points.z + i);
    FloatVec key;
    if constexpr (kind == KeyForm::Kind::distance) {
      const FloatVec dx = hn::Sub(x, fx), dy = hn::Sub(y, fy), dz = hn::Sub(z, fz);
      key = hn::Add(hn::Add(hn::Mul(dx, dx), hn::Mul(dy, dy)), hn::Mul(dz, dz));
    } else {
      key = hn::Add(hn::Add(hn::Mul(x, hn::Add(fx, hn::Mul(linear, x))), hn::Mul(y, hn::Add(fy, hn::Mul(linear, y)))),
                    hn::Mul(z, hn::Add(fz, hn::Mul(linear, z))));
    }
    // + 0 turns -0 into 0: equal depths must have equal bits.
    hn::Store(hn::Add(key, zero), d, keys + i);
  }
}

HWY_INLINE void keys_of_one_point(const KeySource& source, int point, std::size_t first, std::size_t count,
                                  float* keys) {
  const TilePoints points(source.points[point], first, count);
  if (source.form.kind == KeyForm::Kind::distance) {
    keys_of_points<KeyForm::Kind::distance>(source.form, points, count, keys);
  } else {
    keys_of_points<KeyForm::Kind::polynomial>(source.form, points, count, keys);
  }
}

// In whole vectors: writes up to tile_facets keys.
HWY_INLINE void keys_of_tile(const KeySource& source, std::size_t first, std::size_t count, float* keys) {
  const FloatTag d;
  keys_of_one_point(source, 0, first, count, keys);
  if (source.combine == Combine::none) return;
  HWY_ALIGN float others[tile_facets];
  for (int point = 1; point < 3; ++point) {
    keys_of_one_point(source, point, first, count, others);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
      const FloatVec a = hn::Load(d, keys + i), b = hn::Load(d, others + i);
      hn::Store(source.combine == Combine::nearest ? hn::Min(a, b) : hn::Max(a, b), d, keys + i);
    }
  }
}

HWY_INLINE void flip_sign(std::size_t count, float* keys) {
  const FloatTag d;
  // 0 - key, not -key: it has no -0 either.
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::Store(hn::Sub(hn::Zero(d), hn::Load(d, keys + i)), d, keys + i);
  }
}

// The planes that cut a block's box: -1 where the box lies outside of one.
HWY_INLINE int cutting_planes(const KeySource& source, const FacetBlock& block, glm::vec4* cutting) {
  // Roundings of dot products of box corners (at most sqrt(12) long) with unit normals.
  constexpr float rounding = 16 * 3.5f * 0x1p-24f;
  int count = 0;
  for (int i = 0; i < source.plane_count; ++i) {
    const glm::vec4& plane = source.planes[i];
    const glm::vec3 normal(plane);
    const glm::vec3 inner = glm::mix(block.lowest, block.highest, glm::greaterThan(normal, glm::vec3(0)));
    const glm::vec3 outer = glm::mix(block.highest, block.lowest, glm::greaterThan(normal, glm::vec3(0)));
    const float slack = rounding + glm::abs(plane.w) * 0x1p-22f;
    if (glm::dot(normal, inner) + plane.w < -slack) return -1;
    if (glm::dot(normal, outer) + plane.w < slack) cutting[count++] = plane;
  }
  return count;
}

// Leaves those facets of a tile that are not culled, and gives their number. The tile lies in one block.
HWY_INLINE std::size_t cull_tile(const KeySource& source, std::size_t first, std::size_t count, Tile& tile) {
  const FloatTag d;
  const IntTag di;
  glm::vec4 planes[most_clip_planes];
  int plane_count = 0;
  float reach = 0;
  if (source.plane_count != 0) {
    const FacetBlock& block = source.blocks[first / block_facets];
    plane_count = cutting_planes(source, block, planes);
    if (plane_count < 0) return 0;
    reach = block.reach;
  }
  const bool facing = source.facing.x != nullptr;
  if (!facing && plane_count == 0) return count;

  const TilePoints points(source.culled_by, first, count);
  HWY_ALIGN std::int16_t copies[3][tile_facets];
  const std::int16_t *nx = copies[0], *ny = copies[1], *nz = copies[2];
  if (facing) {
    nx = whole_vectors(source.facing.x + first, count, copies[0]);
    ny = whole_vectors(source.facing.y + first, count, copies[1]);
    nz = whole_vectors(source.facing.z + first, count, copies[2]);
  }
  const hn::Rebind<std::int16_t, FloatTag> d16;
  const auto component = [&](const std::int16_t* from)
                             HWY_ATTR { return hn::ConvertTo(d, hn::PromoteTo(di, hn::LoadU(d16, from))); };
  const FloatVec scale = hn::Set(d, source.facing.scale);
  const FloatVec ex = hn::Set(d, source.facing.eye.x), ey = hn::Set(d, source.facing.eye.y),
                 ez = hn::Set(d, source.facing.eye.z);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const FloatVec x = hn::LoadU(d, points.x + i), y = hn::LoadU(d, points.y + i), z = hn::LoadU(d, points.z + i);
    FloatMask keep = hn::FirstN(d, count - i);
    if (facing) {
      const FloatVec dx = hn::Sub(ex, hn::Mul(scale, x)), dy = hn::Sub(ey, hn::Mul(scale, y)),
                     dz = hn::Sub(ez, hn::Mul(scale, z));
      const FloatVec product = hn::Add(hn::Add(hn::Mul(component(nx + i), dx), hn::Mul(component(ny + i), dy)),
                                       hn::Mul(component(nz + i), dz));
      // A normal's components are off by half a step each; the rest bounds the roundings of points, eye and product.
      const FloatVec reach_of_rounding = hn::Add(hn::Add(hn::Abs(dx), hn::Abs(dy)), hn::Abs(dz));
      const FloatVec error = hn::Add(hn::Mul(hn::Set(d, 0.6f), reach_of_rounding), hn::Set(d, 0.25f));
      keep = hn::And(keep, hn::Ge(hn::Add(product, error), hn::Zero(d)));
    }
    for (int p = 0; p < plane_count; ++p) {
      const FloatVec value = hn::Add(hn::Add(hn::Mul(hn::Set(d, planes[p].x), x), hn::Mul(hn::Set(d, planes[p].y), y)),
                                     hn::Mul(hn::Set(d, planes[p].z), z));
      const float slack = reach + 32 * 3.5f * 0x1p-24f + glm::abs(planes[p].w) * 0x1p-22f;
      keep = hn::And(keep, hn::Ge(value, hn::Set(d, -planes[p].w - slack)));
    }
    // Neighbours mostly face the same way. Where they don't, without a branch a facet.
    if (hn::AllFalse(d, keep)) continue;
    if (hn::AllTrue(d, keep)) {
      hn::StoreU(hn::Load(d, tile.keys + i), d, tile.keys + kept);
      hn::StoreU(hn::Load(IdTag(), tile.ids + i), IdTag(), tile.ids + kept);
      kept += hn::Lanes(d);
      continue;
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, keep, bits);
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
      tile.keys[kept] = tile.keys[i + lane];
      tile.ids[kept] = tile.ids[i + lane];
      kept += bits[lane / 8] >> (lane % 8) & 1;
    }
  }
  return kept;
}

// Keys and ids of the facets of a tile that are not culled; the number of them.
HWY_INLINE std::size_t entries_of_tile(const KeySource& source, std::size_t first, std::size_t count, Tile& tile) {
  const IdTag d;
  keys_of_tile(source, first, count, tile.keys);
  if (source.sign < 0) flip_sign(count, tile.keys);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    hn::Store(hn::Iota(d, static_cast<std::uint32_t>(first + i)), d, tile.ids + i);
  }
  return source.culls() ? cull_tile(source, first, count, tile) : count;
}

// Calls body(first, count) for the tiles of [begin, end), none of which crosses the border of a block.
template <typename Body>
HWY_INLINE void for_tiles(std::size_t begin, std::size_t end, const Body& body) {
  while (begin < end) {
    const std::size_t count = std::min(tile_facets - begin % tile_facets, end - begin);
    body(begin, count);
    begin += count;
  }
}

HWY_INLINE FloatVec bucket_of(const BucketMap& map, FloatVec key) {
  const FloatTag d;
  const FloatVec bucket = hn::Mul(hn::Sub(hn::Set(d, map.highest), key), hn::Set(d, map.scale));
  return hn::Min(hn::Max(bucket, hn::Zero(d)), hn::Set(d, map.last));
}

// Facets that are neighbours in memory are mostly neighbours in space, and then in one bucket: a vector at a time.
// whole(i, bucket) takes a vector of entries from i on, one(i, bucket) a single one.
template <typename Whole, typename One>
HWY_INLINE void for_buckets(const float* keys, std::size_t count, const BucketMap& map, std::int32_t* buckets,
                            const Whole& whole, const One& one) {
  const FloatTag d;
  const IntTag di;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto bucket = hn::ConvertTo(di, bucket_of(map, hn::LoadU(d, keys + i)));
    const std::int32_t first = hn::GetLane(bucket);
    if (hn::AllTrue(di, hn::Eq(bucket, hn::Set(di, first)))) {
      whole(i, first);
    } else {
      hn::Store(bucket, di, buckets);
      for (std::size_t lane = 0; lane < lanes; ++lane) one(i + lane, buckets[lane]);
    }
  }
  for (; i < count; ++i) {
    // The same roundings as in vectors.
    const float bucket = (map.highest - keys[i]) * map.scale;
    one(i, static_cast<std::int32_t>(std::min(std::max(bucket, 0.0f), map.last)));
  }
}

HWY_INLINE void count_tile(const float* keys, std::size_t count, const BucketMap& map, std::int32_t* buckets,
                           std::uint32_t* counts) {
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(FloatTag()));
  for_buckets(
      keys, count, map, buckets, [&](std::size_t, std::int32_t bucket) HWY_ATTR { counts[bucket] += lanes; },
      [&](std::size_t, std::int32_t bucket) HWY_ATTR { ++counts[bucket]; });
}

HWY_INLINE void partition_tile(const float* keys, const std::uint32_t* ids, std::size_t count, const BucketMap& map,
                               std::int32_t* buckets, std::uint32_t* cursors, const Entries& to) {
  const FloatTag d;
  const IdTag du;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  for_buckets(
      keys, count, map, buckets,
      [&](std::size_t i, std::int32_t bucket) HWY_ATTR {
        const std::uint32_t at = cursors[bucket];
        hn::StoreU(hn::LoadU(d, keys + i), d, to.keys + at);
        hn::StoreU(hn::LoadU(du, ids + i), du, to.ids + at);
        cursors[bucket] = at + lanes;
      },
      [&](std::size_t i, std::int32_t bucket) HWY_ATTR {
        const std::uint32_t at = cursors[bucket]++;
        to.keys[at] = keys[i];
        to.ids[at] = ids[i];
      });
}

void ComputeKeys(const KeySource& source, std::size_t begin, std::size_t end, float* keys) {
  Tile tile;
  for_tiles(begin, end, [&](std::size_t first, std::size_t count) HWY_ATTR {
    keys_of_tile(source, first, count, tile.keys);
    std::memcpy(keys + (first - begin), tile.keys, count * sizeof(float));
  });
}

std::size_t Collect(const KeySource& source, std::size_t begin, std::size_t end, const Entries& to) {
  const IdTag d;
  Tile tile;
  std::size_t total = 0;
  for_tiles(begin, end, [&](std::size_t first, std::size_t count) HWY_ATTR {
    const std::size_t kept = entries_of_tile(source, first, count, tile);
    if (count == tile_facets) {
      // In whole vectors: what lies behind those kept is still to be written, or to be left over.
      for (std::size_t i = 0; i < kept; i += hn::Lanes(d)) {
        hn::StoreU(hn::Load(FloatTag(), tile.keys + i), FloatTag(), to.keys + total + i);
        hn::StoreU(hn::Load(d, tile.ids + i), d, to.ids + total + i);
      }
    } else {
      for (std::size_t i = 0; i < kept; ++i) {
        to.keys[total + i] = tile.keys[i];
        to.ids[total + i] = tile.ids[i];
      }
    }
    total += kept;
  });
  return total;
}

void CountFacets(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                 std::uint32_t* counts) {
  Tile tile;
  for_tiles(begin, end, [&](std::size_t first, std::size_t count) HWY_ATTR {
    count_tile(tile.keys, entries_of_tile(source, first, count, tile), map, tile.buckets, counts);
  });
}

void PartitionFacets(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                     std::uint32_t* cursors, const Entries& to) {
  Tile tile;
  for_tiles(begin, end, [&](std::size_t first, std::size_t count) HWY_ATTR {
    const std::size_t kept = entries_of_tile(source, first, count, tile);
    partition_tile(tile.keys, tile.ids, kept, map, tile.buckets, cursors, to);
  });
}

void CountEntries(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* counts) {
  Tile tile;
  count_tile(from.keys, count, map, tile.buckets, counts);
}

void PartitionEntries(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* cursors,
                      const Entries& to) {
  Tile tile;
  partition_tile(from.keys, from.ids, count, map, tile.buckets, cursors, to);
}

KeyRange RangeOfKeys(const float* keys, std::size_t count) {
  const FloatTag d;
  const std::size_t lanes = hn::Lanes(d);
  KeyRange range{keys[0], keys[0]};
  std::size_t i = 0;
  if (count >= lanes) {
    FloatVec lowest = hn::LoadU(d, keys), highest = lowest;
    for (i = lanes; i + lanes <= count; i += lanes) {
      const FloatVec key = hn::LoadU(d, keys + i);
      lowest = hn::Min(lowest, key);
      highest = hn::Max(highest, key);
    }
    range = {hn::GetLane(hn::MinOfLanes(d, lowest)), hn::GetLane(hn::MaxOfLanes(d, highest))};
  }
  for (; i < count; ++i) range = {std::min(range.lowest, keys[i]), std::max(range.highest, keys[i])};
  return range;
}

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

// Four at a time: the loops below are too short for the compiler to think of it.
template <typename Body>
HWY_INLINE void unrolled(std::size_t count, const Body& body) {
  std::size_t i = 0;
  for (; i + 4 <= count; i += 4) {
    body(i);
    body(i + 1);
    body(i + 2);
    body(i + 3);
  }
  for (; i < count; ++i) body(i);
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
    if (output.prefetches) {
      // Now, while ids still ascend: in this order memory gives them up fastest.
      const std::uint32_t* ids = from.ids + first;
      unrolled(size, [&](std::size_t i) HWY_ATTR { hwy::Prefetch(output.corners + 3 * std::size_t{ids[i]}); });
    }
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

BucketMap bucket_map(float lowest, float highest, std::size_t buckets) {
  const float count = static_cast<float>(buckets);
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

void write_entries(const std::uint32_t* ids, std::size_t count, const Output& output) {
  for (std::size_t k = 0; k < count; ++k) {
    const std::uint32_t id = ids[k];
    for (int corner = 0; corner < 3; ++corner) {
      if (output.indices_32 != nullptr)
        output.indices_32[3 * k + corner] = output.corners[3 * std::size_t{id} + corner];
      if (output.indices_16 != nullptr) {
        output.indices_16[3 * k + corner] = static_cast<std::uint16_t>(output.corners[3 * std::size_t{id} + corner]);
      }
    }
    if (output.ids != nullptr) output.ids[k] = id;
  }
}

}  // namespace facetsort::order_internal
#endif
