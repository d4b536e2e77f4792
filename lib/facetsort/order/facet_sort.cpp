// Quantised keys: count how many facets lie on each step of depth, put their ids in their places, write them out. A
// step is short enough for two facets to share it; those that do come out by id, unless they are many.
//
// Whole keys: three passes over a large mesh, one over a small one. Count: how many facets fall into each bucket of
// depth. Partition: their keys and ids go there. Sort: each bucket, small enough for the cache, is put in order and
// written out. A mesh that fits the cache is one bucket.
#include "facetsort/order/facet_sort.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <utility>

namespace facetsort::order_internal {
namespace {

// A mesh of more facets is partitioned first, unless it is too small for two threads; then its buckets are sorted at
// once, which are half as large as that on average, so that entries, bins and output of one share the second-level
// cache. There are as many facets a thread at least: the threads' scratch is no more than a mesh's.
constexpr std::size_t facets_of_thread = 32768;
static_assert(2 * facets_of_thread - 1 <= most_sorted_entries);
constexpr std::size_t facets_per_bucket = facets_of_thread / 2;
constexpr std::size_t most_buckets = 1024;
// So that a thread that is late holds up little.
constexpr std::size_t parts_per_thread = 4;

// Of fewer facets each is told from the next by its whole key, at no cost that would be seen.
constexpr std::size_t least_quantised = 1024;
constexpr std::size_t least_steps = 4096;
// Of more, 4 bytes each, places are fetched ahead; measured.
constexpr std::size_t placed_in_cache = 262144;
// A step with more than so many times its share of the facets, which is one at least, is sorted by whole keys.
constexpr std::size_t crowded_share = 16;

// Depths between which nearly all facets lie, from a sample; few facets far away do not stretch it.
// Precondition: at least as many facets as samples.
KeyRange typical_range(const KeySource& source, std::size_t begin, std::size_t end) {
  constexpr std::size_t samples = 256, outliers = 2;
  std::array<std::uint32_t, samples> ids;
  std::array<float, samples> keys;
  for (std::size_t k = 0; k < samples; ++k) ids[k] = static_cast<std::uint32_t>(begin + (end - begin) * k / samples);
  keys_of(source, ids.data(), samples, keys.data());
  std::nth_element(keys.begin(), keys.begin() + outliers, keys.end());
  const float lowest = keys[outliers];
  std::nth_element(keys.begin(), keys.end() - 1 - outliers, keys.end());
  return {lowest, keys[samples - 1 - outliers]};
}

// Whole vectors of counts. Two facets a step: more steps are not seen (tests/order/precision_test.cpp), a quarter of
// them is.
std::size_t step_count(std::size_t facets) {
  return std::clamp((facets / 2 + 7) / 8 * 8, least_steps, most_steps);
}

// Room for counts of steps: a facet each, and for what rounds two parts' steps up.
std::size_t counted(std::size_t facets) {
  return facets + 16;
}

// Wider than the sample by a margin: what lies outside is on the first and the last step.
BucketMap step_map(const KeySource& source, std::size_t begin, std::size_t end, std::size_t steps) {
  const KeyRange range = typical_range(source, begin, end);
  const float margin = (range.highest - range.lowest) / 16;
  return bucket_map(range.lowest - margin, range.highest + margin, steps);
}

// Where the k-th of several equal parts of [begin, end) begins; parts begin with a block.
std::size_t part_begin(std::size_t begin, std::size_t end, std::size_t part, std::size_t parts) {
  const std::size_t at = begin + (end - begin) * part / parts;
  return part == 0 || part == parts ? at : std::min(end, (at + block_facets - 1) / block_facets * block_facets);
}

}  // namespace

std::size_t steps_of_quantised_keys(std::size_t facets) {
  return facets < least_quantised ? 0 : step_count(facets);
}

std::size_t FacetSort::reserve(std::size_t facets) {
  const auto most = static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
  const std::size_t threads = std::clamp<std::size_t>(facets / facets_of_thread, 1, most);
  sorted_at_once_ = facets < 2 * facets_of_thread ? facets : facets_of_thread;
  keys_.get(facets);
  ids_.get(facets);
  sorted_.get(facets * sizeof(std::int64_t));
  crowded_.get(facets / crowded_share + 2);
  constexpr std::size_t bins_of_count = sizeof(std::uint32_t) / sizeof(std::uint16_t);
  bins_.get(
      std::max({threads * bin_count(sorted_at_once_), counted(facets) * bins_of_count, least_steps * bins_of_count}));
  return threads;
}

FacetSort::ThreadScratch FacetSort::scratch_of(std::size_t thread) const {
  return {sorted_.data() + thread * sorted_at_once_ * sizeof(std::int64_t),
          bins_.data() + thread * bin_count(sorted_at_once_), sorted_at_once_};
}

// Entries in the order of their keys, into the output, whose ids may be the entries' own. `scratch.sorted` has room for
// `count`, whatever that is.
void FacetSort::sort_bucket(const Entries& entries, std::size_t count, const ThreadScratch& scratch,
                            const Output& output) {
  if (count == 0) return;
  const KeyRange range = key_range(entries.keys, count);
  if (range.lowest == range.highest) return write_order(entries.ids, count, output);
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

std::size_t FacetSort::sort_in_buckets(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                                       const Output& output) {
  const std::size_t buckets = std::clamp<std::size_t>((end - begin) / facets_per_bucket, 2, most_buckets);
  const std::size_t parts = threads == 1 ? 1 : threads * parts_per_thread;
  const KeyRange range = typical_range(source, begin, end);
  const BucketMap map = bucket_map(range.lowest, range.highest, buckets);
  std::uint32_t* part_counts = counts_.get(parts * buckets);
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
  std::uint32_t* begins = begins_.get(buckets + 1);
  std::uint32_t sum = static_cast<std::uint32_t>(begin);
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    begins[bucket] = sum;
    for (std::size_t part = 0; part < parts; ++part) {
      sum += std::exchange(part_counts[part * buckets + bucket], sum);
    }
  }
  begins[buckets] = sum;

  // Partition.
  const Entries entries{keys_.data(), ids_.data()};
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
      if (size_of(bucket) <= sorted_at_once_) sort_one(bucket, scratch_of(thread));
    }
  };
  for_threads(threads, sort_buckets);
  // Where depths are very uneven some are too large for a thread's scratch: they get everyone's.
  for (std::size_t bucket = 0; bucket < buckets; ++bucket) {
    if (size_of(bucket) > sorted_at_once_) sort_one(bucket, scratch_of(0));
  }
  return sum - begin;
}

// Steps that are to be sorted by whole keys: the first and the last, where what lies outside of the range is, and those
// with more than their share. Gives their number.
std::size_t FacetSort::find_crowded(const std::uint32_t* step_ends, std::size_t steps, std::size_t most_on_a_step,
                                    std::size_t most_found, Step* crowded) {
  std::size_t found = 0;
  const auto add_above = [&](std::size_t most, std::size_t step) {
    const std::uint32_t first = step == 0 ? 0 : step_ends[step - 1], count = step_ends[step] - first;
    if (count > most) crowded[found++] = {first, count};
  };
  add_above(1, 0);
  if (most_found > most_on_a_step) {
    for (std::size_t step = 1; step + 1 < steps; ++step) add_above(most_on_a_step, step);
  }
  add_above(1, steps - 1);
  return found;
}

void FacetSort::sort_crowded(const KeySource& source, std::size_t begin, std::span<const Step> crowded,
                             std::size_t threads, std::size_t thread) {
  const auto sort_one = [&](const Step& step, const ThreadScratch& scratch) {
    const Entries entries = Entries{keys_.data(), ids_.data()} + (begin + step.first);
    keys_of(source, entries.ids, step.count, entries.keys);
    Output output;
    output.ids = entries.ids;
    sort_bucket(entries, step.count, scratch, output);
  };
  constexpr std::size_t few = 16;  // the first and the last at least, which have next to nothing on them
  std::atomic<std::size_t> next{0};
  for_threads(crowded.size() <= few ? 1 : threads, [&](std::size_t k) {
    for (std::size_t step; (step = next.fetch_add(1, std::memory_order_relaxed)) < crowded.size();) {
      if (!is_large(crowded[step].count)) sort_one(crowded[step], scratch_of(thread + k));
    }
  });
  // Those too large for a thread's scratch get everyone's.
  for (const Step& step : crowded) {
    if (is_large(step.count)) sort_one(step, scratch_of(thread));
  }
}

std::size_t FacetSort::sort_in_steps(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                                     std::size_t thread, const Output& output) {
  const std::size_t facets = end - begin, steps = step_count(facets);
  // As many as there is room for counts.
  const std::size_t parts = threads == 1 ? 1 : std::clamp<std::size_t>(counted(facets) / steps, 1, threads);
  const BucketMap map = step_map(source, begin, end, steps);
  const ThreadScratch scratch = scratch_of(thread);
  std::uint32_t* counts = reinterpret_cast<std::uint32_t*>(scratch.bins);
  std::uint32_t* order = ids_.data() + begin;
  std::uint32_t* kept_ids = reinterpret_cast<std::uint32_t*>(scratch.sorted);
  std::uint16_t* facet_steps = reinterpret_cast<std::uint16_t*>(kept_ids + facets);
  std::uint32_t kept_of_one = 0;
  std::uint32_t* kept = parts == 1 ? &kept_of_one : counts_.get(parts);
  const auto for_parts = [&](const auto& body) {
    for_threads(parts, [&](std::size_t part) {
      const std::size_t first = part_begin(begin, end, part, parts);
      body(part, first, first - begin, counts + part * steps);
    });
  };

  // Count.
  for_parts([&](std::size_t part, std::size_t first, std::size_t at, std::uint32_t* of_part) {
    std::fill(of_part, of_part + steps, 0u);
    kept[part] = static_cast<std::uint32_t>(count_steps(source, map, first, part_begin(begin, end, part + 1, parts),
                                                        facet_steps + at, kept_ids + at, of_part));
  });
  std::size_t total = 0;
  for (std::size_t part = 0; part < parts; ++part) total += kept[part];
  const std::size_t most_found = sum_steps(counts, parts, steps);

  // Place.
  for_parts([&](std::size_t part, std::size_t first, std::size_t at, std::uint32_t* of_part) {
    place_ids({.steps = facet_steps + at,
               .count = kept[part],
               .ids = source.culls() ? kept_ids + at : nullptr,
               .first_id = static_cast<std::uint32_t>(first),
               .prefetches = facets > placed_in_cache},
              of_part, order);
  });
  const std::uint32_t* step_ends = counts + (parts - 1) * steps;
  Step* crowded = crowded_.data() + begin / crowded_share;
  const std::size_t crowded_steps =
      find_crowded(step_ends, steps, crowded_share * (1 + facets / steps), most_found, crowded);
  sort_crowded(source, begin, {crowded, crowded_steps}, threads, thread);

  // Write.
  for_threads(parts, [&](std::size_t part) {
    // Whole vectors of four triangles.
    const auto begin_of = [&](std::size_t p) { return p == parts ? total : total * p / parts / 4 * 4; };
    const std::size_t first = begin_of(part), last = begin_of(part + 1);
    write_order(order + first, last - first, output + first);
  });
  return total;
}

std::size_t FacetSort::sort(const KeySource& source, std::size_t begin, std::size_t end, Keys keys, std::size_t threads,
                            std::size_t thread, const Output& output) {
  if (keys == Keys::quantised && end - begin >= least_quantised) {
    return sort_in_steps(source, begin, end, threads, thread, output);
  }
  if (is_large(end - begin)) return sort_in_buckets(source, begin, end, threads, output);
  const Entries entries = Entries{keys_.data(), ids_.data()} + begin;
  const std::size_t count = collect(source, begin, end, entries);
  sort_bucket(entries, count, scratch_of(thread), output);
  return count;
}

std::size_t FacetSort::bytes() const {
  return keys_.bytes() + ids_.bytes() + sorted_.bytes() + bins_.bytes() + counts_.bytes() + begins_.bytes() +
         crowded_.bytes();
}

}  // namespace facetsort::order_internal
