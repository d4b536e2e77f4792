// One string out of many pieces. Internal to report.
#pragma once

#include <string>
#include <string_view>

namespace facetsort {

// The parts, each something that a string_view can be made of, one after the other.
template <typename... Parts>
std::string join(const Parts&... parts) {
  std::string text;
  ((text += std::string_view(parts)), ...);
  return text;
}

}  // namespace facetsort
