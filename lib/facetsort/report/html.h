// Text from outside (mesh names, commands, paths) on its way into a page. Internal to report.
#pragma once

#include <string>
#include <string_view>

namespace facetsort {

// For element content and quoted attributes: & < > " ' are escaped, control characters become U+FFFD.
std::string html_escape(std::string_view text);
// A relative path as a relative URL: every byte but letters, digits, "-._~" and "/" is percent-encoded.
std::string url_path(std::string_view path);

}  // namespace facetsort
