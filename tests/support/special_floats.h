// Floats that are no numbers or no finite ones.
#pragma once

#include <limits>

namespace facetsort {

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();
inline constexpr float infinity = std::numeric_limits<float>::infinity();

}  // namespace facetsort
