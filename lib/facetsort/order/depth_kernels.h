// Internal to order: the loops of the per-frame sort, for every instruction set. Sorter puts them together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace facetsort::order_internal {

// Culling works on blocks of facets that follow each other in memory; a block never lies in two tiles of a kernel.
constexpr std::size_t block_facets = 64;

// What the culling of one block needs, in the mesh's frame, rounded outwards.
struct FacetBlock {
  glm::vec3 lowest, highest;  // box of the corners
  float reach;                // longest way from a facet's point to one of its corners
};

// A depth key, larger is farther: dot(p, constant + linear p), or |p - eye| squared.
struct KeyForm {
  enum class Kind { polynomial, distance } kind;
  glm::vec3 constant{0};
  float linear = 0;
  glm::vec3 eye{0};
};

enum class Combine { none, nearest, farthest };  // one point a facet; or the smallest, or largest key of three

// The normals of a block's facets, and where they stand, in the mesh's frame, rounded outwards. Where the normals are
// in no half-space, or one is 0, the cosine is 0 and the sine 1.
struct NormalCone {
  glm::vec3 centre;  // of a ball around the facets' points
  float radius;
  glm::vec3 axis;      // unit vector
  float cosine, sine;  // of the largest angle between axis and normal
};

// Facets seen from behind: those whose normal has a negative product with eye - scale * point, beyond all rounding.
// Blocks whose facets all are, or none, are told by their cones first; that changes no outcome.
struct FacingTest {
  const std::int16_t *x = nullptr, *y = nullptr, *z = nullptr;  // normals, the largest component 32767; null: no test
  const NormalCone* cones = nullptr;
  glm::vec3 eye{0};
  float scale = 0;
};

constexpr int most_clip_planes = 8;

// Everything that gives a facet its key, or leaves it out.
struct KeySource {
  struct Points {
    const float *x, *y, *z;
  } points[3];
  Points culled_by{};  // a point of the facet's plane
  KeyForm form;
  Combine combine = Combine::none;
  float sign = 1;  // -1: nearest facet first
  FacingTest facing;
  const FacetBlock* blocks = nullptr;
  glm::vec4 planes[most_clip_planes];  // dot(normal, p) + w is negative outside; unit normals
  int plane_count = 0;

  bool culls() const { return facing.x != nullptr || plane_count != 0; }
};

// Keys and facet ids, side by side.
struct Entries {
  float* keys;
  std::uint32_t* ids;

  Entries operator+(std::size_t offset) const { return {keys + offset, ids + offset}; }
};

// Linear in the key, largest key in bucket 0; keys beyond the range go to the first and the last bucket.
struct BucketMap {
  float highest;
  float scale;
  float last;  // number of buckets - 1
};
// All in bucket 0 where there is no such range.
BucketMap bucket_map(float lowest, float highest, std::size_t buckets);

// Where an order goes. Those that are null are not written; each is written once and in order, and never read.
struct Output {
  const std::uint32_t* corners = nullptr;  // three a facet, read by id
  std::uint32_t* indices_32 = nullptr;
  std::uint16_t* indices_16 = nullptr;
  std::uint32_t* ids = nullptr;
  bool is_from_memory = false;  // corners and indices are too many for the cache

  Output operator+(std::size_t facets) const;
};

// Counters of a bin have 16 bits.
constexpr std::size_t most_sorted_entries = 65535;
std::size_t bin_count(std::size_t entries);

// The key of each facet of [begin, end) into keys[0] onwards, culled or not, without the sign.
void compute_keys(const KeySource& source, std::size_t begin, std::size_t end, float* keys);
// Entries of the facets of [begin, end) that are not culled; the number of them.
std::size_t collect(const KeySource& source, std::size_t begin, std::size_t end, const Entries& to);
// Adds to counts[b] the number of those in bucket b.
void count_buckets(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                   std::uint32_t* counts);
// Appends each to its bucket, at cursors[b].
void partition(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
               std::uint32_t* cursors, const Entries& to);
// The same for entries already made.
void count_buckets(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* counts);
void partition(const Entries& from, std::size_t count, const BucketMap& map, std::uint32_t* cursors, const Entries& to);

struct KeyRange {
  float lowest, highest;
};
// Precondition: count > 0.
KeyRange key_range(const float* keys, std::size_t count);

// Sorts entries by descending key, equal keys by ascending id, into the output. False, and nothing written, where they
// are too unevenly spread over `range` for that to be quick. `sorted` has room for `count`, `bins` for
// bin_count(count). Preconditions: count <= most_sorted_entries; the ids of equal keys ascend; range.lowest <
// range.highest.
bool sort_entries(const Entries& from, std::size_t count, const KeyRange& range, std::int64_t* sorted,
                  std::uint16_t* bins, const Output& output);
// The same by comparisons, for any spread.
void sort_uneven_entries(const Entries& from, std::size_t count, std::int64_t* sorted, const Output& output);
// Facets in the order of `ids`, which may be the output's own.
void write_order(const std::uint32_t* ids, std::size_t count, const Output& output);

// Of the facets `ids`, with the sign.
void keys_of(const KeySource& source, const std::uint32_t* ids, std::size_t count, float* keys);

// Steps of depth have 16 bits.
constexpr std::size_t most_steps = 65536;
// The step, by the map, of each facet of [begin, end) that is not culled, and their number; adds to counts[s] the number
// of those on step s. Where facets are culled, `ids` gets the ids of those that are not.
std::size_t count_steps(const KeySource& source, const BucketMap& map, std::size_t begin, std::size_t end,
                        std::uint16_t* steps, std::uint32_t* ids, std::uint32_t* counts);
// Counts of several parts of a mesh, one part after the other, become the places in the order at which the facets of a
// part and step begin. Gives the largest number of facets on a step. Precondition: `steps` is a multiple of eight.
std::uint32_t sum_steps(std::uint32_t* counts, std::size_t parts, std::size_t steps);
// The steps of a part's facets, and their ids.
struct StepIds {
  const std::uint16_t* steps;
  std::size_t count;
  const std::uint32_t* ids;  // null: in a row, from first_id on
  std::uint32_t first_id;
  bool prefetches;  // places in the order, where it is too large for the cache
};
// Appends ids to their steps, at cursors[s].
void place_ids(const StepIds& from, std::uint32_t* cursors, std::uint32_t* order);

}  // namespace facetsort::order_internal
