// The look of index.html. Internal to report.
#pragma once

#include <string_view>

namespace facetsort {

extern const std::string_view page_style;   // CSS
extern const std::string_view page_script;  // JavaScript; the page is complete without it

}  // namespace facetsort
