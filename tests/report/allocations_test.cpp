#include "facetsort/report/allocations.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <new>
#include <thread>
#include <vector>

namespace facetsort {
namespace {

// Keeps the compiler from leaving out an allocation that nothing looks at.
void* observed(void* block) {
  asm volatile("" : : "g"(block) : "memory");
  return block;
}

TEST(Allocations, NothingAllocatedNothingCounted) {
  const AllocationScope scope;
  const AllocationCount count = scope.count();
  EXPECT_EQ(count.calls, 0u);
  EXPECT_EQ(count.peak_bytes, 0u);
}

TEST(Allocations, PeakIsTheMostHeldAtOnce) {
  const AllocationScope scope;
  for (int i = 0; i < 3; ++i) ::operator delete(observed(::operator new(100000)));
  EXPECT_EQ(scope.count().calls, 3u);
  EXPECT_GE(scope.count().peak_bytes, 100000u);
  EXPECT_LT(scope.count().peak_bytes, 200000u);
  void* first = observed(::operator new(100000));
  void* second = observed(::operator new(100000));
  ::operator delete(first);
  ::operator delete(second);
  EXPECT_EQ(scope.count().calls, 5u);
  EXPECT_GE(scope.count().peak_bytes, 200000u);
  EXPECT_LT(scope.count().peak_bytes, 300000u);
}

TEST(Allocations, WhatWasThereBeforeDoesNotCount) {
  auto before = std::make_unique<std::vector<char>>(1000000);
  const AllocationScope scope;
  observed(before->data());
  before.reset();
  ::operator delete(observed(::operator new(5000)));
  EXPECT_EQ(scope.count().calls, 1u);
  EXPECT_LT(scope.count().peak_bytes, 1000000u);
}

struct alignas(256) Wide {
  char bytes[256];
};

TEST(Allocations, EveryOverloadCountsAndKeepsAlignment) {
  const AllocationScope scope;
  constexpr std::align_val_t wide{256};
  ::operator delete(observed(::operator new(10)));
  ::operator delete[](observed(::operator new[](10)));
  ::operator delete(observed(::operator new(10, std::nothrow)), std::nothrow);
  ::operator delete[](observed(::operator new[](10, std::nothrow)), std::nothrow);
  void* const aligned[] = {::operator new(10, wide), ::operator new[](10, wide), ::operator new(10, wide, std::nothrow),
                           ::operator new[](10, wide, std::nothrow)};
  for (void* block : aligned) EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % 256, 0u);
  ::operator delete(observed(aligned[0]), wide);
  ::operator delete[](observed(aligned[1]), wide);
  ::operator delete(observed(aligned[2]), wide, std::nothrow);
  ::operator delete[](observed(aligned[3]), wide);
  std::unique_ptr<Wide> object(static_cast<Wide*>(observed(new Wide)));
  EXPECT_EQ(scope.count().calls, 9u);  // sized deletes are the compiler's to call: it does for a Wide
  object.reset();
  // All was given back: as much again does not raise the peak.
  const std::size_t peak = scope.count().peak_bytes;
  ::operator delete(observed(::operator new(10)));
  EXPECT_EQ(scope.count().peak_bytes, peak);
}

TEST(Allocations, ZeroBytesAndNullAreFine) {
  const AllocationScope scope;
  void* block = observed(::operator new(0));
  EXPECT_NE(block, nullptr);
  ::operator delete(block);
  ::operator delete(static_cast<void*>(nullptr));
  EXPECT_EQ(scope.count().calls, 1u);
}

TEST(Allocations, NestedScopesEachHaveTheirOwnPeak) {
  const AllocationScope outer;
  ::operator delete(observed(::operator new(300000)));
  {
    const AllocationScope inner;
    ::operator delete(observed(::operator new(1000)));
    EXPECT_EQ(inner.count().calls, 1u);
    EXPECT_LT(inner.count().peak_bytes, 100000u);
  }
  EXPECT_EQ(outer.count().calls, 2u);
  EXPECT_GE(outer.count().peak_bytes, 300000u);
}

TEST(Allocations, CountsAllThreads) {
  constexpr std::size_t threads = 4, blocks = 1000;
  const AllocationScope scope;
  {
    std::vector<std::thread> workers;
    for (std::size_t t = 0; t < threads; ++t) {
      workers.emplace_back([] {
        for (std::size_t b = 0; b < blocks; ++b) ::operator delete(observed(::operator new(64)));
      });
    }
    for (std::thread& worker : workers) worker.join();
  }
  EXPECT_GE(scope.count().calls, threads * blocks);
  EXPECT_LT(scope.count().calls, threads * blocks + 100);
  // Had the frees been lost, every block would still be held.
  EXPECT_LT(scope.count().peak_bytes, threads * blocks * 64 / 4);
}

}  // namespace
}  // namespace facetsort
