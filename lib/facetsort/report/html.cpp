#include "facetsort/report/html.h"

namespace facetsort {

std::string html_escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        if ((static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n') || c == 0x7f) {
          escaped += "\xef\xbf\xbd";  // U+FFFD
        } else {
          escaped += c;
        }
    }
  }
  return escaped;
}

std::string url_path(std::string_view path) {
  static constexpr std::string_view unreserved = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  static constexpr std::string_view hexadecimal = "0123456789ABCDEF";
  std::string url;
  for (const char c : path) {
    if (unreserved.find(c) != std::string_view::npos) {
      url += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      url += '%';
      url += hexadecimal[byte >> 4];
      url += hexadecimal[byte & 15];
    }
  }
  return url;
}

}  // namespace facetsort
