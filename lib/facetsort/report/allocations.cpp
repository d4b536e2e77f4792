#include "facetsort/report/allocations.h"

#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <new>

namespace facetsort {
namespace {

// Nothing is counted while no scope is open, so that a program pays for the counter only where it asks. `held` may
// then fall below zero, when something from before is freed: only differences mean anything.
std::atomic<int> open_scopes{0};
std::atomic<std::size_t> calls{0};
std::atomic<std::ptrdiff_t> held{0};
std::atomic<std::ptrdiff_t> peak{0};

void raise_peak(std::ptrdiff_t bytes) {
  std::ptrdiff_t seen = peak.load(std::memory_order_relaxed);
  while (seen < bytes && !peak.compare_exchange_weak(seen, bytes, std::memory_order_relaxed)) {
  }
}

// The usable size is what malloc set aside, and all that is known again when the block is freed.
std::ptrdiff_t block_size(void* block) {
  return static_cast<std::ptrdiff_t>(malloc_usable_size(block));
}

void* allocate_once(std::size_t size, std::size_t alignment) {
  size = std::max<std::size_t>(size, 1);
  if (alignment <= __STDCPP_DEFAULT_NEW_ALIGNMENT__) return std::malloc(size);
  void* block = nullptr;
  return posix_memalign(&block, alignment, size) == 0 ? block : nullptr;
}

// Null when there is no memory and no handler to find some.
void* allocate(std::size_t size, std::size_t alignment) {
  void* block = allocate_once(size, alignment);
  while (block == nullptr) {
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) return nullptr;
    handler();
    block = allocate_once(size, alignment);
  }
  if (open_scopes.load(std::memory_order_relaxed) > 0) {
    calls.fetch_add(1, std::memory_order_relaxed);
    const std::ptrdiff_t bytes = block_size(block);
    raise_peak(held.fetch_add(bytes, std::memory_order_relaxed) + bytes);
  }
  return block;
}

void* allocate_or_throw(std::size_t size, std::size_t alignment = 0) {
  void* block = allocate(size, alignment);
  if (block == nullptr) throw std::bad_alloc();
  return block;
}

void* allocate_or_null(std::size_t size, std::size_t alignment = 0) noexcept {
  try {
    return allocate(size, alignment);
  } catch (...) {  // a new handler may throw
    return nullptr;
  }
}

void release(void* block) noexcept {
  if (block != nullptr && open_scopes.load(std::memory_order_relaxed) > 0) {
    held.fetch_sub(block_size(block), std::memory_order_relaxed);
  }
  std::free(block);
}

}  // namespace

AllocationScope::AllocationScope()
    : calls_at_start_(calls.load()), held_at_start_(held.load()), outer_peak_(peak.exchange(held_at_start_)) {
  ++open_scopes;
}

AllocationScope::~AllocationScope() {
  --open_scopes;
  raise_peak(outer_peak_);
}

AllocationCount AllocationScope::count() const {
  return {calls.load() - calls_at_start_,
          static_cast<std::size_t>(std::max<std::ptrdiff_t>(peak.load() - held_at_start_, 0))};
}

}  // namespace facetsort

// All overloads, although the standard library's own would forward to the first few: the sanitizers' runtime brings
// versions of each that do not.
using facetsort::allocate_or_null;
using facetsort::allocate_or_throw;
using facetsort::release;

void* operator new(std::size_t size) {
  return allocate_or_throw(size);
}
void* operator new[](std::size_t size) {
  return allocate_or_throw(size);
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return allocate_or_null(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return allocate_or_null(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment, const std::nothrow_t&) noexcept {
  return allocate_or_null(size, static_cast<std::size_t>(alignment));
}

void operator delete(void* block) noexcept {
  release(block);
}
void operator delete[](void* block) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t) noexcept {
  release(block);
}
void operator delete(void* block, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete[](void* block, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::align_val_t) noexcept {
  release(block);
}
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}
void operator delete[](void* block, std::size_t, std::align_val_t) noexcept {
  release(block);
}
void operator delete(void* block, std::align_val_t, const std::nothrow_t&) noexcept {
  release(block);
}
void operator delete[](void* block, std::align_val_t, const std::nothrow_t&) noexcept {
  release(block);
}
