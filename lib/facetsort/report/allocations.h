// Counting what a piece of code allocates. A program that uses this links facetsort_allocation_counter, which replaces
// the global operator new and delete; memory taken in other ways (malloc, mmap, the scalable allocators of oneTBB) is
// not seen. Internal to our programs.
#pragma once

#include <cstddef>

namespace facetsort {

struct AllocationCount {
  std::size_t calls = 0;       // of any operator new
  std::size_t peak_bytes = 0;  // the most that was held at once beyond what was held at the beginning
};

// Counts over all threads from its construction on. Scopes may be nested, each inside the lifetime of the one around
// it; scopes that overlap in any other way spoil each other's peak.
class AllocationScope {
 public:
  AllocationScope();
  AllocationScope(const AllocationScope&) = delete;
  AllocationScope& operator=(const AllocationScope&) = delete;
  ~AllocationScope();

  AllocationCount count() const;

 private:
  std::size_t calls_at_start_;
  std::ptrdiff_t held_at_start_;
  std::ptrdiff_t outer_peak_;
};

}  // namespace facetsort
