#include "output.h"

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <system_error>

#include "failure.h"

namespace facetsort {

void print_json(const Json& document) {
  std::cout << document.dump(2, ' ', false, Json::error_handler_t::replace) << '\n';
}

void print_text(std::string_view text) {
  std::cout << text;
}

void print_facts(const Facts& facts) {
  std::size_t width = 0;
  for (const auto& [name, value] : facts) width = std::max(width, name.size());
  for (const auto& [name, value] : facts) {
    std::cout << name << std::string(width + 2 - name.size(), ' ') << printable(value) << '\n';
  }
}

void print_failure(std::string message) {
  while (!message.empty() && message.back() == '\n') message.pop_back();
  std::cerr << "facetsort: " << printable(message) << '\n';
}

std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string number_text(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", number);
  return text;
}

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  return extension;
}

void require_output_file(const std::filesystem::path& path, std::initializer_list<std::string_view> extensions) {
  if (std::find(extensions.begin(), extensions.end(), extension_of(path)) == extensions.end()) {
    std::string known;
    for (const std::string_view extension : extensions) known.append(known.empty() ? "" : " or ").append(extension);
    throw Failure(path.string() + ": an output file that ends in " + known + " is needed");
  }
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
    throw Failure(path.string() + ": cannot be replaced: not a regular file");
  }
}

}  // namespace facetsort
