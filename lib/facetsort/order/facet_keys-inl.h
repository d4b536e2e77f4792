// Internal to order: keys of facets, in tiles, and entries in buckets of depth. Included by depth_kernels.cpp, once for
// each instruction set.
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

// Four at a time: the loops here are too short for the compiler to think of it.
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

// One triangle in eight lies in two lines of the cache.
HWY_INLINE void prefetch_triangles(const std::uint32_t* corners, const std::uint32_t* ids, std::size_t count) {
  // A plain loop: compilers drop calls of functions that do nothing but this.
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t* triangle = corners + 3 * std::size_t{ids[i]};
    hwy::Prefetch(triangle);
    hwy::Prefetch(triangle + 2);
  }
}

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
  // Of facets anywhere in the mesh.
  HWY_INLINE TilePoints(const KeySource::Points& points, const std::uint32_t* ids, std::size_t count)
      : x(copies[0]), y(copies[1]), z(copies[2]) {
    std::memset(static_cast<void*>(copies), 0, sizeof copies);
    for (std::size_t i = 0; i < count; ++i) {
      copies[0][i] = points.x[ids[i]];
      copies[1][i] = points.y[ids[i]];
      copies[2][i] = points.z[ids[i]];
    }
  }
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

// `facets` is the first id of a tile, or a list of ids.
template <typename Facets>
HWY_INLINE void keys_of_one_point(const KeySource& source, int point, Facets facets, std::size_t count, float* keys) {
  const TilePoints points(source.points[point], facets, count);
  if (source.form.kind == KeyForm::Kind::distance) {
    keys_of_points<KeyForm::Kind::distance>(source.form, points, count, keys);
  } else {
    keys_of_points<KeyForm::Kind::polynomial>(source.form, points, count, keys);
  }
}

// In whole vectors: writes up to tile_facets keys.
template <typename Facets>
HWY_INLINE void keys_of_tile(const KeySource& source, Facets facets, std::size_t count, float* keys) {
  const FloatTag d;
  keys_of_one_point(source, 0, facets, count, keys);
  if (source.combine == Combine::none) return;
  HWY_ALIGN float others[tile_facets];
  for (int point = 1; point < 3; ++point) {
    keys_of_one_point(source, point, facets, count, others);
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

HWY_INLINE void signed_keys_of_tile(const KeySource& source, std::size_t first, std::size_t count, float* keys) {
  keys_of_tile(source, first, count, keys);
  if (source.sign < 0) flip_sign(count, keys);
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

enum class Seen { from_behind, from_front, both };

HWY_INLINE Seen seen_of_block(const FacingTest& test, const NormalCone& cone) {
  const glm::vec3 to_eye = test.eye - test.scale * cone.centre;
  const float along = glm::dot(cone.axis, to_eye), radius = test.scale * cone.radius;
  // More than the test of a facet allows for (see cull_tile()), whose normals are at least 32767 long.
  const float far = glm::abs(to_eye.x) + glm::abs(to_eye.y) + glm::abs(to_eye.z) + radius;
  const float slack = radius + 1e-4f * far + 1e-5f;
  // Seen from behind the axis, no direction of the cone has a larger product with to_eye than this and `aside`; seen
  // from in front of it, none a smaller one than the difference. (Not by Pythagoras: that would cancel near the axis.)
  const float product = along * cone.cosine;
  const glm::vec3 across = (to_eye - along * cone.axis) * cone.sine;
  const float aside_squared = glm::dot(across, across);
  const float beyond = glm::abs(product) - slack;
  if (!(beyond > 0) || beyond * beyond <= aside_squared) return Seen::both;
  return product < 0 ? Seen::from_behind : Seen::from_front;
}

// What is to be tested of the facets of one block.
struct BlockCulling {
  bool leaves_out_all, tests_facing;
  int plane_count = 0;
  glm::vec4 planes[most_clip_planes];
  float reach = 0;

  HWY_INLINE BlockCulling(const KeySource& source, std::size_t block, Seen seen)
      : leaves_out_all(seen == Seen::from_behind), tests_facing(seen == Seen::both) {
    if (source.plane_count == 0 || leaves_out_all) return;
    plane_count = cutting_planes(source, source.blocks[block], planes);
    leaves_out_all = plane_count < 0;
    reach = source.blocks[block].reach;
  }
  bool tests_anything() const { return tests_facing || plane_count > 0; }
};

// For each vector of a tile's facets, from `i` on, take(i, which of them are not culled). The tile lies in one block.
template <typename Take>
HWY_INLINE void cull_tile(const KeySource& source, const BlockCulling& culling, std::size_t first, std::size_t count,
                          const Take& take) {
  const FloatTag d;
  const IntTag di;
  const TilePoints points(source.culled_by, first, count);
  HWY_ALIGN std::int16_t copies[3][tile_facets];
  const std::int16_t *nx = copies[0], *ny = copies[1], *nz = copies[2];
  if (culling.tests_facing) {
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
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const FloatVec x = hn::LoadU(d, points.x + i), y = hn::LoadU(d, points.y + i), z = hn::LoadU(d, points.z + i);
    FloatMask keep = hn::FirstN(d, count - i);
    if (culling.tests_facing) {
      const FloatVec dx = hn::Sub(ex, hn::Mul(scale, x)), dy = hn::Sub(ey, hn::Mul(scale, y)),
                     dz = hn::Sub(ez, hn::Mul(scale, z));
      const FloatVec product = hn::Add(hn::Add(hn::Mul(component(nx + i), dx), hn::Mul(component(ny + i), dy)),
                                       hn::Mul(component(nz + i), dz));
      // A normal's components are off by half a step each; the rest bounds the roundings of points, eye and product.
      const FloatVec reach_of_rounding = hn::Add(hn::Add(hn::Abs(dx), hn::Abs(dy)), hn::Abs(dz));
      const FloatVec error = hn::Add(hn::Mul(hn::Set(d, 0.6f), reach_of_rounding), hn::Set(d, 0.25f));
      keep = hn::And(keep, hn::Ge(hn::Add(product, error), hn::Zero(d)));
    }
    for (int p = 0; p < culling.plane_count; ++p) {
      const glm::vec4& plane = culling.planes[p];
      const FloatVec value = hn::Add(hn::Add(hn::Mul(hn::Set(d, plane.x), x), hn::Mul(hn::Set(d, plane.y), y)),
                                     hn::Mul(hn::Set(d, plane.z), z));
      const float slack = culling.reach + 32 * 3.5f * 0x1p-24f + glm::abs(plane.w) * 0x1p-22f;
      keep = hn::And(keep, hn::Ge(value, hn::Set(d, -plane.w - slack)));
    }
    take(i, keep);
  }
}

// A vector of ids in a row. (Iota of what is not known beforehand is slow: it writes lane by lane to memory.)
HWY_INLINE hn::Vec<IdTag> ids_from(std::size_t first) {
  const IdTag d;
  return hn::Add(hn::Iota(d, 0), hn::Set(d, static_cast<std::uint32_t>(first)));
}

// Keys and ids of the facets of a tile that are not culled; the number of them.
HWY_INLINE std::size_t entries_of_tile(const KeySource& source, const BlockCulling& culling, std::size_t first,
                                       std::size_t count, Tile& tile) {
  const FloatTag d;
  const IdTag du;
  if (culling.leaves_out_all) return 0;
  signed_keys_of_tile(source, first, count, tile.keys);
  if (!culling.tests_anything()) {
    for (std::size_t i = 0; i < count; i += hn::Lanes(du)) hn::Store(ids_from(first + i), du, tile.ids + i);
    return count;
  }
  std::size_t kept = 0;
  cull_tile(source, culling, first, count, [&](std::size_t i, FloatMask keep) HWY_ATTR {
    // In registers, and then stored whole: instructions that store some lanes alone are slow on some processors.
    hn::StoreU(hn::Compress(hn::Load(d, tile.keys + i), keep), d, tile.keys + kept);
    hn::StoreU(hn::Compress(ids_from(first + i), hn::RebindMask(du, keep)), du, tile.ids + kept);
    kept += hn::CountTrue(d, keep);
  });
  return kept;
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

// Calls body(first, count, culling) for the tiles of [begin, end) that are not left out as a whole.
template <typename Body>
HWY_INLINE void for_culled_tiles(const KeySource& source, std::size_t begin, std::size_t end, const Body& body) {
  // Which blocks are seen how, told for many without a branch: the outcome can't be foreseen.
  constexpr std::size_t told_at_once = 64;
  struct {
    std::size_t block;
    Seen seen;
  } told[told_at_once];
  for (std::size_t block = begin / block_facets; block * block_facets < end;) {
    std::size_t left = 0;
    const std::size_t last = std::min(block + told_at_once, (end + block_facets - 1) / block_facets);
    for (; block < last; ++block) {
      told[left] = {block, source.facing.x == nullptr ? Seen::from_front
                                                      : seen_of_block(source.facing, source.facing.cones[block])};
      left += told[left].seen != Seen::from_behind;
    }
    for (std::size_t i = 0; i < left; ++i) {
      const BlockCulling culling(source, told[i].block, told[i].seen);
      const std::size_t first = std::max(begin, told[i].block * block_facets);
      if (!culling.leaves_out_all) body(first, std::min(end, (told[i].block + 1) * block_facets) - first, culling);
    }
  }
}

// Calls body(kept, count) with the keys and ids of each tile's facets that are not culled in `tile`.
template <typename Body>
HWY_INLINE void for_entries(const KeySource& source, std::size_t begin, std::size_t end, Tile& tile, const Body& body) {
  for_culled_tiles(source, begin, end, [&](std::size_t first, std::size_t count, const BlockCulling& culling) HWY_ATTR {
    body(entries_of_tile(source, culling, first, count, tile), count);
  });
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

void KeysOf(const KeySource& source, const std::uint32_t* ids, std::size_t count, float* keys) {
  HWY_ALIGN float tile[tile_facets];
  for (std::size_t first = 0; first < count; first += tile_facets) {
    const std::size_t size = std::min(tile_facets, count - first);
    keys_of_tile(source, ids + first, size, tile);
    if (source.sign < 0) flip_sign(size, tile);
    std::memcpy(keys + first, tile, size * sizeof(float));
  }
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
  for_entries(source, begin, end, tile, [&](std::size_t kept, std::size_t count) HWY_ATTR {
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
  for_entries(source, begin, end, tile,
              [&](std::size_t kept, std::size_t) HWY_ATTR { count_tile(tile.keys, kept, map, tile.buckets, counts); });
}

void PartitionFacets(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                     std::uint32_t* cursors, const Entries& to) {
  Tile tile;
  for_entries(source, begin, end, tile, [&](std::size_t kept, std::size_t) HWY_ATTR {
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

}  // namespace facetsort::order_internal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
