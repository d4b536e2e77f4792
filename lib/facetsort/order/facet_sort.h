// Internal to order: the ways to put a range of facets in order, and the memory that they share.
#pragma once

#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "facetsort/order/depth_kernels.h"

namespace facetsort::order_internal {

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

enum class Keys { quantised, whole };

// 0 where there are so few facets that their keys are whole.
std::size_t steps_of_quantised_keys(std::size_t facets);

// Sorts ranges of the facets of one mesh. Allocates where it needs more memory than ever before.
class FacetSort {
 public:
  // Before sort(): room for a mesh of `facets`. Gives the number of threads that there is work for.
  std::size_t reserve(std::size_t facets);
  // Whether so many facets are work for several threads, which a call has to have for itself; other ranges may be
  // sorted by several threads at once.
  bool is_large(std::size_t facets) const { return facets > sorted_at_once_; }
  // The facets of [begin, end) by themselves, from output[0] on; the number of them that are not culled. For a large
  // range `thread` is 0 and `threads` are all; for another, `threads` is 1 and `thread` is the caller's.
  std::size_t sort(const KeySource& source, std::size_t begin, std::size_t end, Keys keys, std::size_t threads,
                   std::size_t thread, const Output& output);

  // Where ids may be written: output.ids for an order that nobody else asks for.
  std::uint32_t* ids() const { return ids_.data(); }
  std::size_t bytes() const;

 private:
  // What a thread sorts in.
  struct ThreadScratch {
    std::byte* sorted;    // room for `entries`
    std::uint16_t* bins;  // room for theirs
    std::size_t entries;
  };

  // Facets that share a quantised key: where they begin in the order of their range, and their number.
  struct Step {
    std::uint32_t first, count;
  };

  ThreadScratch scratch_of(std::size_t thread) const;
  std::size_t sort_in_steps(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                            std::size_t thread, const Output& output);
  static std::size_t find_crowded(const std::uint32_t* step_ends, std::size_t steps, std::size_t most_on_a_step,
                                  std::size_t most_found, Step* crowded);
  void sort_crowded(const KeySource& source, std::size_t begin, std::span<const Step> crowded, std::size_t threads,
                    std::size_t thread);
  std::size_t sort_in_buckets(const KeySource& source, std::size_t begin, std::size_t end, std::size_t threads,
                              const Output& output);
  static void sort_bucket(const Entries& entries, std::size_t count, const ThreadScratch& scratch,
                          const Output& output);

  // 16 bytes a facet, and 4 for bins where a mesh is sorted at once or by as many threads as it has work for.
  std::size_t sorted_at_once_ = 0;
  Scratch<float> keys_;
  Scratch<std::uint32_t> ids_;
  Scratch<std::byte> sorted_;
  Scratch<std::uint16_t> bins_;    // and counts of steps
  Scratch<std::uint32_t> counts_;  // of each part and bucket, and then where they go
  Scratch<std::uint32_t> begins_;  // of buckets
  Scratch<Step> crowded_;
};

}  // namespace facetsort::order_internal
