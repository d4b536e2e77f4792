// How much of a long test is run where sanitizers make it many times as slow.
#pragma once

#include <algorithm>

namespace facetsort {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define FACETSORT_IS_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define FACETSORT_IS_SANITIZED 1
#endif
#endif

#ifdef FACETSORT_IS_SANITIZED
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif

// Cases of a test over many: all, or an eighth. A test that counts what it saw must see it in those.
constexpr int cases(int count) { return is_sanitized ? std::max(1, count / 8) : count; }

}  // namespace facetsort
