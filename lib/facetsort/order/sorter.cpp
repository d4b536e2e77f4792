// Three passes over a large mesh, one over a small one. Count: how many facets fall into each bucket of depth.
// Partition: their keys and ids go there. Sort: each bucket, small enough for the cache, is put in order and written
// out. A mesh that fits the cache is one bucket.
#include "facetsort/order/sorter.h"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/order/depth_kernels.h"

namespace facetsort {

using namespace order_internal;

namespace {

constexpr std::size_t facets_per_task = 16384;

// A mesh of more facets is partitioned first, unless it is too small for two threads; then its buckets are sorted at
// once, which are half as large as that on average, so that entries, bins and output of one share the second-level
// cache. There are as many facets a thread at least: the threads' scratch is no more than a mesh's.
constexpr std::size_t facets_of_thread = 32768;
static_assert(2 * facets_of_thread - 1 <= most_sorted_entries);
constexpr std::size_t facets_per_bucket = facets_of_thread / 2;
constexpr std::size_t most_buckets = 1024;
// So that a thread that is late holds up little.
constexpr std::size_t parts_per_thread = 4;

// The largest of a vector's components brought into [1, 2) by a power of two, which changes no comparison and keeps
// products finite for an eye at 1e38.
double exact_shrink(const glm::dvec3& v) {
  return std::ldexp(1.0, -std::ilogb(std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)})));
}

// Straight distance. Near the mesh, differences to the eye are exact enough: their error is a rounding of the distance.
// Far from it, |q + f|^2 = |f|^2 + dot(q, q + 2 f), f being the vector from the eye to the frame's origin: the first
// term is the same for all facets and is left out, and with it the digits that a far eye would cost.
KeyForm distance_form(const FacetFrame& frame, const glm::vec4& eye) {
  // In units of the frame, in which the mesh reaches to 2: where the two forms' errors meet.
  constexpr double near = 4;
  const glm::dvec3 to_centre = (frame.origin - glm::dvec3(eye)) * frame.scale;
  const double largest = std::max({std::abs(to_centre.x), std::abs(to_centre.y), std::abs(to_centre.z)});
  if (largest < near) return {.kind = KeyForm::Kind::distance, .eye = glm::vec3(-to_centre)};
  const double shrink = exact_shrink(to_centre);
  return {.kind = KeyForm::Kind::polynomial,
          .constant = glm::vec3(2.0 * shrink * to_centre),
          .linear = static_cast<float>(shrink)};
}

KeyForm axis_form(const glm::vec3& direction) {
  const glm::dvec3 axis(direction);
  return {.kind = KeyForm::Kind::polynomial, .constant = glm::vec3(axis * exact_shrink(axis))};
}

FacingTest facing_test(const FacetFrame& frame, const glm::vec4& eye) {
  FacingTest test;
  const glm::dvec3 to_eye = eye.w == 0.0f ? glm::dvec3(eye) : (glm::dvec3(eye) - frame.origin) * frame.scale;
  const double shrink = eye.w == 0.0f || glm::length(to_eye) > 1 ? exact_shrink(to_eye) : 1.0;
  test.eye = glm::vec3(to_eye * shrink);
  test.scale = eye.w == 0.0f ? 0.0f : static_cast<float>(shrink);
  return test;
}

// Of unit normal, in the frame.
glm::vec4 plane_in_frame(const FacetFrame& frame, const glm::vec4& plane) {
  const glm::dvec3 normal(plane);
  const double length = glm::length(normal);
  const double offset = (glm::dot(normal, frame.origin) + static_cast<double>(plane.w)) * frame.scale / length;
  constexpr double limit = 1e30;
  return {glm::vec3(normal / length), static_cast<float>(std::clamp(offset, -limit, limit))};
}

// Sixteen bits are enough for a test that errs on one side: see FacingTest.
struct Normals {
  std::vector<std::int16_t> x, y, z;
};

void compute_normals(std::span<const glm::uvec3> triangles, const StridedPositions& positions, Normals& normals) {
  for (auto* component : {&normals.x, &normals.y, &normals.z}) component->resize(triangles.size());
  parallel_ranges(triangles.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t facet = begin; facet < end; ++facet) {
      const glm::uvec3& t = triangles[facet];
      const glm::dvec3 a(positions[t.x]);
      const glm::dvec3 normal = glm::cross(glm::dvec3(positions[t.y]) - a, glm::dvec3(positions[t.z]) - a);
      const double largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
      const glm::dvec3 steps = largest > 0 ? normal * (32767.0 / largest) : glm::dvec3(0);
      normals.x[facet] = static_cast<std::int16_t>(std::lround(steps.x));
      normals.y[facet] = static_cast<std::int16_t>(std::lround(steps.y));
      normals.z[facet] = static_cast<std::int16_t>(std::lround(steps.z));
    }
  });
}

void compute_blocks(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const FacetFrame& frame,
                    const PointArrays& points, std::vector<FacetBlock>& blocks) {
  constexpr double outwards = 0x1p-21;  // beyond the rounding of a coordinate below 2
  blocks.resize((triangles.size() + block_facets - 1) / block_facets);
  parallel_ranges(blocks.size(), facets_per_task / block_facets, [&](std::size_t begin, std::size_t end) {
    for (std::size_t block = begin; block < end; ++block) {
      const std::size_t first = block * block_facets, last = std::min(first + block_facets, triangles.size());
      glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest = -lowest;
      double reach = 0;
      for (std::size_t facet = first; facet < last; ++facet) {
        const glm::dvec3 point(points.x[facet], points.y[facet], points.z[facet]);
        for (int i = 0; i < 3; ++i) {
          const glm::dvec3 corner = (glm::dvec3(positions[triangles[facet][i]]) - frame.origin) * frame.scale;
          lowest = glm::min(lowest, corner);
          highest = glm::max(highest, corner);
          reach = std::max(reach, glm::length(corner - point));
        }
      }
      blocks[block] = {glm::vec3(lowest - outwards), glm::vec3(highest + outwards),
                       static_cast<float>(reach + outwards)};
    }
  });
}

// Room for a number of objects that are written before they are read; grows, and never shrinks.
template <typename T>
class Scratch {
 public:
  T* get(std::size_t count) {
    if (count > capacity_) {
      memory_ = std::make_unique_for_overwrite<T[]>(count);
      capacity_ = count;
    }
    return memory_.get();
  }
  T* data() const { return memory_.get(); }
  std::size_t bytes() const { return capacity_ * sizeof(T); }

 private:
  std::unique_ptr<T[]> memory_;
  std::size_t capacity_ = 0;
};

// Calls body(0) to body(count - 1), each as a task where there are several.
template <typename Body>
void for_threads(std::size_t count, const Body& body) {
  if (count == 1) return body(std::size_t{0});
  tbb::parallel_for(std::size_t{0}, count, body, tbb::simple_partitioner());
}

// Depths between which nearly all facets lie, from a sample; few facets far away do not stretch it.
KeyRange typical_range(const KeySource& source, std::size_t begin, std::size_t end) {
  constexpr std::size_t places = 32, in_a_row = 8, samples = places * in_a_row, outliers = 4;
  std::array<float, samples> keys;
  const std::size_t step = (end - begin) / places;
  for (std::size_t place = 0; place < places; ++place) {
    const std::size_t first = begin + place * step;
    compute_keys(source, first, first + in_a_row, &keys[place * in_a_row]);
  }
  for (float& key : keys) key *= source.sign;
  std::nth_element(keys.begin(), keys.begin() + outliers, keys.end());
  const float lowest = keys[outliers];
  std::nth_element(keys.begin(), keys.end() - 1 - outliers, keys.end());
  return {lowest, keys[samples - 1 - outliers]};
}

// Where the k-th of several equal parts of [begin, end) begins; parts begin with a block.
std::size_t part_begin(std::size_t begin, std::size_t end, std::size_t part, std::size_t parts) {
  const std::size_t at = begin + (end - begin) * part / parts;
  return part == 0 || part == parts ? at : std::min(end, (at + block_facets - 1) / block_facets * block_facets);
}

// What a thread sorts in.
struct ThreadScratch {
  std::byte* sorted;    // room for `entries`
  std::uint16_t* bins;  // room for theirs
  std::size_t entries;
};

// Entries in the order of their keys, into the output. `scratch.sorted` has room for `count`, whatever that is.
void sort_bucket(const Entries& entries, std::size_t count, const ThreadScratch& scratch, const Output& output) {
  if (count == 0) return;
  const KeyRange range = key_range(entries.keys, count);
  if (range.lowest == range.highest) return write_entries(entries.ids, count, output);
  std::int64_t* sorted = reinterpret_cast<std::int64_t*>(scratch.sorted);
  if (count <= scratch.entries && sort_entries(entries, count, range, sorted, scratch.bins, output)) return;

  // Too many, or unevenly spread: over buckets of their own, in each of which the range is narrower.
  constexpr std::size_t buckets = 256;
  const BucketMap map = bucket_map(range.lowest, range.highest, buckets);
  std::array<std::uint32_t, buckets> counts{}, cursors;
  count_buckets(entries, count, map, counts.data());
  if (*std::max_element(counts.begin(), counts.end()) == count) {
    return sort_uneven_entries(entries, count, sorted, output);  // keys that differ by less than floats can divide
  }
  std::uint32_t sum = 0;
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    cursors[bucket] = sum;
    sum += counts[bucket];
  }
  const Entries parted{reinterpret_cast<float*>(scratch.sorted),
                       reinterpret_cast<std::uint32_t*>(scratch.sorted) + count};
  partition(entries, count, map, cursors.data(), parted);
  std::memcpy(entries.keys, parted.keys, count * sizeof(float));
  std::memcpy(entries.ids, parted.ids, count * sizeof(std::uint32_t));
  std::size_t first = 0;
  for (const std::uint32_t size : counts) {
    sort_bucket(entries + first, size, scratch, output + first);
    first += size;
  }
}

}  // namespace

struct Sorter::State {
  SorterOptions options;
  FacetFrame frame;
  PointArrays points[3];  // one set for the keys of one point a facet; three corners for nearest and farthest
  PointArrays centroids;  // to cull by, where points[0] lies beside the facet's plane
  Normals normals;
  std::vector<FacetBlock> blocks;

  // 16 bytes a facet, and 4 for bins where a mesh is sorted at once or by as many threads as it has work for.
  Scratch<float> keys;
  Scratch<std::uint32_t> ids;
  Scratch<std::byte> sorted;
  Scratch<std::uint16_t> bins;
  Scratch<std::uint32_t> counts;  // of each part and bucket, and then where they go
  Scratch<std::uint32_t> bucket_begins;
  Scratch<float> asked_keys;

  // What was sorted last.
  bool has_view = false;
  SortView view;
  std::array<glm::vec4, most_clip_planes> view_planes{};
  std::size_t facets_in_ids = 0;
  bool ids_hold_order = false, asked_keys_are_current = false;

  std::size_t facet_count() const { return points[0].size(); }
  void prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions);
  bool is_sorted_for(const SortView& other) const;
  void remember(const SortView& sorted_view);
  void forget_view() { has_view = ids_hold_order = asked_keys_are_current = false; }
  KeySource source() const;
  std::size_t sorted_at_once() const;
  std::size_t reserve_scratch();
  ThreadScratch scratch_of(std::size_t thread);
  std::size_t sort_range(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                         const ThreadScratch& scratch, const Output& output);
  std::size_t sort_large_range(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                               const Output& output);
  std::size_t sort_all(const SortView& view, const Output& output);
  template <typename Index>
  std::size_t sort_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<Index> indices,
                           std::span<std::uint32_t> ids_out);
  template <typename Index>
  void sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles, std::span<const FacetRange> ranges,
                   std::span<Index> indices, std::span<std::uint32_t> counts_out, std::span<std::uint32_t> ids_out);
  std::size_t prepared_bytes() const;
};

void Sorter::State::prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  frame = facet_frame(facet_bounds(triangles, positions));
  const auto compute = [&](FacetPoint point, PointArrays& to) {
    compute_facet_points(triangles, positions, point, frame, to);
  };
  switch (options.method) {
    case Method::centroid_distance:
    case Method::centroid_depth:
      compute(FacetPoint::centroid, points[0]);
      break;
    case Method::bounds_centre:
      compute(FacetPoint::bounds_centre, points[0]);
      if (options.cull_back_faces) compute(FacetPoint::centroid, centroids);
      break;
    case Method::first_vertex:
      compute(FacetPoint::corner_0, points[0]);
      break;
    case Method::nearest_vertex:
    case Method::farthest_vertex:
      compute(FacetPoint::corner_0, points[0]);
      compute(FacetPoint::corner_1, points[1]);
      compute(FacetPoint::corner_2, points[2]);
      break;
    case Method::exact:
    case Method::exact_tree:
    case Method::exact_tree_pieces:
      assert(false && "not a depth key");
  }
  if (options.cull_back_faces) compute_normals(triangles, positions, normals);
  if (options.cull_by_clip_planes) {
    compute_blocks(triangles, positions, frame, centroids.size() == 0 ? points[0] : centroids, blocks);
  }
  forget_view();
}

bool Sorter::State::is_sorted_for(const SortView& other) const {
  return has_view && view.eye == other.eye && view.forward == other.forward &&
         std::equal(view.clip_planes.begin(), view.clip_planes.end(), other.clip_planes.begin(),
                    other.clip_planes.end());
}

void Sorter::State::remember(const SortView& sorted_view) {
  has_view = true;
  asked_keys_are_current = false;
  view = sorted_view;
  std::copy(sorted_view.clip_planes.begin(), sorted_view.clip_planes.end(), view_planes.begin());
  view.clip_planes = std::span(view_planes).first(sorted_view.clip_planes.size());
}

// Of the view remembered.
KeySource Sorter::State::source() const {
  const bool orthographic = view.eye.w == 0.0f;
  const auto of = [](const PointArrays& from) {
    return KeySource::Points{from.x.data(), from.y.data(), from.z.data()};
  };
  KeySource made;
  for (int i = 0; i < 3; ++i) made.points[i] = of(points[i]);
  made.culled_by = of(centroids.size() == 0 ? points[0] : centroids);
  made.form = options.method == Method::centroid_distance && !orthographic
                  ? distance_form(frame, view.eye)
                  : axis_form(orthographic ? -glm::vec3(view.eye) : view.forward);
  made.combine = options.method == Method::nearest_vertex    ? Combine::nearest
                 : options.method == Method::farthest_vertex ? Combine::farthest
                                                             : Combine::none;
  made.sign = options.direction == Direction::front_to_back ? -1.0f : 1.0f;
  if (options.cull_back_faces) {
    made.facing = facing_test(frame, view.eye);
    made.facing.x = normals.x.data();
    made.facing.y = normals.y.data();
    made.facing.z = normals.z.data();
  }
  if (options.cull_by_clip_planes) {
    made.blocks = blocks.data();
    for (const glm::vec4& plane : view.clip_planes) made.planes[made.plane_count++] = plane_in_frame(frame, plane);
  }
  return made;
}

std::size_t Sorter::State::sorted_at_once() const {
  return facet_count() < 2 * facets_of_thread ? facet_count() : facets_of_thread;
}

// The number of threads that there is work for.
std::size_t Sorter::State::reserve_scratch() {
  const std::size_t count = facet_count();
  const auto most = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t threads = std::clamp<std::size_t>(count / facets_of_thread, 1, most);
  keys.get(count);
  ids.get(count);
  sorted.get(count * sizeof(std::int64_t));
  bins.get(threads * bin_count(sorted_at_once()));
  return threads;
}

ThreadScratch Sorter::State::scratch_of(std::size_t thread) {
  const std::size_t entries = sorted_at_once();
  return {sorted.data() + thread * entries * sizeof(std::int64_t), bins.data() + thread * bin_count(entries), entries};
}

std::size_t Sorter::State::sort_large_range(const KeySource& source, std::size_t begin, std::size_t end,
                                            std::size_t threads, const Output& output) {
  const std::size_t buckets = std::clamp<std::size_t>((end - begin) / facets_per_bucket, 2, most_buckets);
  const std::size_t parts = threads == 1 ? 1 : threads * parts_per_thread;
  const KeyRange range = typical_range(source, begin, end);
  const BucketMap map = range.lowest < range.highest ? bucket_map(range.lowest, range.highest, buckets)
                                                     : BucketMap{range.highest, 0, static_cast<float>(buckets - 1)};
  std::uint32_t* part_counts = counts.get(parts * buckets);
  const auto for_parts = [&](const auto& body) {
    for_threads(parts, [&](std::size_t part) {
      body(part_begin(begin, end, part, parts), part_begin(begin, end, part + 1, parts), part_counts + part * buckets);
    });
  };

  // Count.
  for_parts([&](std::size_t first, std::size_t last, std::uint32_t* of_part) {
    std::fill(of_part, of_part + buckets, 0u);
    count_buckets(source, map, first, last, of_part);
  });
  std::uint32_t* begins = bucket_begins.get(buckets + 1);
  std::uint32_t sum = static_cast<std::uint32_t>(begin);
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    begins[bucket] = sum;
    for (std::size_t part = 0; part < parts; ++part) {
      sum += std::exchange(part_counts[part * buckets + bucket], sum);
    }
  }
  begins[buckets] = sum;

  // Partition.
  const Entries entries{keys.data(), ids.data()};
  for_parts([&](std::size_t first, std::size_t last, std::uint32_t* of_part) {
    partition(source, map, first, last, of_part, entries);
  });

  // Sort, farthest bucket first, each thread the next that none has taken.
  const auto size_of = [&](std::size_t bucket) { return begins[bucket + 1] - begins[bucket]; };
  const auto sort_one = [&](std::size_t bucket, const ThreadScratch& scratch) {
    sort_bucket(entries + begins[bucket], size_of(bucket), scratch, output + (begins[bucket] - begin));
  };
  std::atomic<std::size_t> next{0};
  const auto sort_buckets = [&](std::size_t thread) {
    for (std::size_t bucket; (bucket = next.fetch_add(1, std::memory_order_relaxed)) < buckets;) {
      if (size_of(bucket) <= sorted_at_once()) sort_one(bucket, scratch_of(thread));
    }
  };
  for_threads(threads, sort_buckets);
  // Where depths are very uneven some are too large for a thread's scratch: they get everyone's.
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    if (size_of(bucket) > sorted_at_once()) sort_one(bucket, scratch_of(0));
  }
  return sum - begin;
}

// The facets of [begin, end) by themselves, from output[0] on; the number of them that are not culled.
std::size_t Sorter::State::sort_range(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                                      const ThreadScratch& scratch, const Output& output) {
  if (end - begin > sorted_at_once()) return sort_large_range(source, begin, end, threads, output);
  const Entries entries = Entries{keys.data(), ids.data()} + begin;
  const std::size_t count = collect(source, begin, end, entries);
  sort_bucket(entries, count, scratch, output);
  return count;
}

std::size_t Sorter::State::sort_all(const SortView& of_view, const Output& output) {
  remember(of_view);
  const std::size_t threads = reserve_scratch();
  ids_hold_order = output.ids == ids.data();
  return facets_in_ids = sort_range(source(), 0, facet_count(), threads, scratch_of(0), output);
}

template <typename Index>
Output output_to(std::span<const glm::uvec3> triangles, std::span<Index> indices, std::span<std::uint32_t> ids) {
  Output output;
  constexpr std::size_t fit_the_cache = 262144;  // measured; 12 bytes each
  output.corners = &triangles.data()->x;
  output.prefetches = triangles.size() > fit_the_cache;
  if constexpr (sizeof(Index) == sizeof(std::uint32_t)) {
    output.indices_32 = indices.data();
  } else {
    output.indices_16 = indices.data();
  }
  output.ids = ids.empty() ? nullptr : ids.data();
  return output;
}

template <typename Index>
std::size_t Sorter::State::sort_indices(const SortView& of_view, std::span<const glm::uvec3> triangles,
                                        std::span<Index> indices, std::span<std::uint32_t> ids_out) {
  assert(triangles.size() == facet_count() && indices.size() >= 3 * triangles.size());
  assert(ids_out.empty() || ids_out.size() >= triangles.size());
  return sort_all(of_view, output_to(triangles, indices, ids_out));
}

template <typename Index>
void Sorter::State::sort_ranges(const SortView& of_view, std::span<const glm::uvec3> triangles,
                                std::span<const FacetRange> ranges, std::span<Index> indices,
                                std::span<std::uint32_t> counts_out, std::span<std::uint32_t> ids_out) {
  assert(triangles.size() == facet_count() && indices.size() >= 3 * triangles.size());
  assert(ids_out.empty() || ids_out.size() >= triangles.size());
  assert(counts_out.size() == ranges.size());
  remember(of_view);
  has_view = ids_hold_order = false;  // no order of all facets
  const std::size_t threads = reserve_scratch();
  const KeySource from = source();
  const Output output = output_to(triangles, indices, ids_out);
  const auto sort_one = [&](std::size_t range, std::size_t with_threads, const ThreadScratch& scratch) {
    const FacetRange& r = ranges[range];
    assert(std::size_t{r.first} + r.count <= facet_count());
    counts_out[range] = static_cast<std::uint32_t>(
        sort_range(from, r.first, std::size_t{r.first} + r.count, with_threads, scratch, output + r.first));
  };
  const auto is_large = [&](std::size_t range) { return ranges[range].count > sorted_at_once(); };
  // A large range has work for all threads; the others are shared out.
  for (std::size_t range = 0; range < ranges.size(); ++range) {
    if (is_large(range)) sort_one(range, threads, scratch_of(0));
  }
  std::atomic<std::size_t> next{0};
  for_threads(threads, [&](std::size_t thread) {
    for (std::size_t range; (range = next.fetch_add(1, std::memory_order_relaxed)) < ranges.size();) {
      if (!is_large(range)) sort_one(range, 1, scratch_of(thread));
    }
  });
}

std::size_t Sorter::State::prepared_bytes() const {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  std::size_t sum = bytes(normals.x) + bytes(normals.y) + bytes(normals.z) + bytes(blocks);
  for (const PointArrays* of : {&points[0], &points[1], &points[2], &centroids}) {
    sum += bytes(of->x) + bytes(of->y) + bytes(of->z);
  }
  return sum;
}

std::array<glm::vec4, 6> clip_planes_of(const glm::mat4& clip_from_mesh) {
  const glm::mat4 rows = glm::transpose(clip_from_mesh);
  return {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
          rows[3] - rows[1], rows[3] + rows[2], rows[3] - rows[2]};
}

Sorter::Sorter(const MeshView& mesh, Method method) : Sorter(mesh, SorterOptions{.method = method}) {}

Sorter::Sorter(const MeshView& mesh, const SorterOptions& options)
    : Sorter(mesh.triangles, StridedPositions(mesh.positions), options) {}

Sorter::Sorter(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const SorterOptions& options)
    : state_(std::make_unique<State>()) {
  state_->options = options;
  state_->prepare(triangles, positions);
}

Sorter::Sorter(Sorter&&) noexcept = default;
Sorter& Sorter::operator=(Sorter&&) noexcept = default;
Sorter::~Sorter() = default;

void Sorter::set_positions(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  assert(triangles.size() == state_->facet_count());
  state_->prepare(triangles, positions);
}

std::span<const std::uint32_t> Sorter::sort(const SortView& view) {
  State& state = *state_;
  if (!(state.ids_hold_order && state.is_sorted_for(view))) {
    Output output;
    output.ids = state.ids.get(state.facet_count());
    state.sort_all(view, output);
  }
  return {state.ids.data(), state.facets_in_ids};
}

std::size_t Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                                 std::span<std::uint32_t> indices, std::span<std::uint32_t> ids) {
  return state_->sort_indices(view, triangles, indices, ids);
}

std::size_t Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                                 std::span<std::uint16_t> indices, std::span<std::uint32_t> ids) {
  return state_->sort_indices(view, triangles, indices, ids);
}

void Sorter::sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles,
                         std::span<const FacetRange> ranges, std::span<std::uint32_t> indices,
                         std::span<std::uint32_t> counts, std::span<std::uint32_t> ids) {
  state_->sort_ranges(view, triangles, ranges, indices, counts, ids);
}

void Sorter::sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles,
                         std::span<const FacetRange> ranges, std::span<std::uint16_t> indices,
                         std::span<std::uint32_t> counts, std::span<std::uint32_t> ids) {
  state_->sort_ranges(view, triangles, ranges, indices, counts, ids);
}

bool Sorter::is_sorted_for(const SortView& view) const {
  return state_->is_sorted_for(view);
}

void Sorter::forget_view() {
  state_->forget_view();
}

std::span<const float> Sorter::keys() {
  State& state = *state_;
  float* keys = state.asked_keys.get(state.facet_count());
  if (!state.asked_keys_are_current) {
    const KeySource source = state.source();
    parallel_ranges(state.facet_count(), facets_per_task,
                    [&](std::size_t begin, std::size_t end) { compute_keys(source, begin, end, keys + begin); });
    state.asked_keys_are_current = true;
  }
  return {keys, state.facet_count()};
}

Method Sorter::method() const {
  return state_->options.method;
}

std::size_t Sorter::prepared_bytes() const {
  return state_->prepared_bytes();
}

std::size_t Sorter::memory_bytes() const {
  const State& state = *state_;
  return state.prepared_bytes() + state.keys.bytes() + state.ids.bytes() + state.sorted.bytes() + state.bins.bytes() +
         state.counts.bytes() + state.bucket_begins.bytes() + state.asked_keys.bytes();
}

std::vector<std::uint32_t> sort_facets(const MeshView& mesh, const SortView& view, Method method) {
  Sorter sorter(mesh, method);
  const std::span<const std::uint32_t> order = sorter.sort(view);
  return {order.begin(), order.end()};
}

}  // namespace facetsort
