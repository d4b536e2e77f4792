// What a verb gives: JSON or text on standard output, and files.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace facetsort {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written

// One document on standard output. Bytes of file names that are not UTF-8 become U+FFFD.
void print_json(const Json& document);

void print_text(std::string_view text);

// Lines of a name and its value, the values below each other.
using Facts = std::vector<std::pair<std::string, std::string>>;
void print_facts(const Facts& facts);

// What a parser or the library says, as the one line on standard error that stands for it.
void print_failure(std::string message);

// Text from outside as part of one line for a terminal: control characters become '?'.
std::string printable(std::string text);

// "0.00123": six significant digits.
std::string number_text(double number);

// A file name's extension in lower case: ".ply".
std::string extension_of(const std::filesystem::path& path);

// Throws Failure, before any work is done, where `path` has none of the extensions or names something that a file may
// not replace (a folder, a device).
void require_output_file(const std::filesystem::path& path, std::initializer_list<std::string_view> extensions);

}  // namespace facetsort
