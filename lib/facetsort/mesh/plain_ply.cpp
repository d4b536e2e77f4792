#include "facetsort/mesh/plain_ply.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <memory>
#include <system_error>
#include <utility>

#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

std::string describe(int error) {
  return std::generic_category().message(error);
}

}  // namespace

std::optional<glm::vec4> parse_colour(std::span<const std::string_view> words) {
  glm::vec4 colour = no_colour;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::optional<float> channel = text::parse_float(words[i]);
    if (!channel || !(*channel >= 0)) return std::nullopt;
    colour[static_cast<int>(i)] = *channel;
  }
  return colour;
}

void scale_to_unit(std::vector<glm::vec4>& colours, const char* list) {
  const auto above_one = [](const glm::vec4& c) { return std::max({c.r, c.g, c.b, c.a}) > 1; };
  const bool to_255 = std::any_of(colours.begin(), colours.end(), above_one);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    glm::vec4& colour = colours[i];
    if (colour == no_colour)
      colour = glm::vec4(1);
    else if (to_255) {
      if (glm::floor(colour) != colour || glm::any(glm::greaterThan(colour, glm::vec4(255)))) {
        throw ReadError{Fault::malformed, std::string(list) + ": number " + std::to_string(i) +
                                              " is neither in 0 to 1 nor in whole numbers to 255"};
      }
      const bool opaque = colour.a == no_colour.a;
      colour /= 255.0f;
      if (opaque) colour.a = 1;
    } else if (colour.a == no_colour.a) {
      colour.a = 1;
    }
  }
}

std::string plain_header(std::string_view encoding, std::string_view vertex_properties, std::string_view face_list,
                         std::size_t vertices, std::size_t faces) {
  std::string header = "ply\nformat ";
  header += encoding;
  header += " 1.0\nelement vertex " + std::to_string(vertices) + "\n";
  header += vertex_properties;
  header += "element face " + std::to_string(faces) + "\nproperty list ";
  header += face_list;
  header += " vertex_indices\nend_header\n";
  return header;
}

void PlainText::add_vertex(std::string_view x, std::string_view y, std::string_view z) {
  for (const std::string_view coordinate : {x, y, z}) {
    vertex_lines_ += coordinate;
    vertex_lines_ += ' ';
  }
  vertex_lines_.back() = '\n';
  ++vertices_;
}

void PlainText::begin_face(std::size_t corners) {
  assert(corners >= 3);
  face_lines_ += '\n';
  face_lines_ += std::to_string(corners);
  ++faces_;
}

void PlainText::add_corner(std::string_view index) {
  face_lines_ += ' ';
  face_lines_ += index;
}

void PlainText::add_corner(std::size_t index) {
  char digits[24];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, index);
  add_corner(std::string_view(digits, static_cast<std::size_t>(end - digits)));
}

PlainPly PlainText::finish() {
  PlainPly plain;
  plain.vertices = std::exchange(vertices_, 0);
  plain.faces = std::exchange(faces_, 0);
  plain.bytes = plain_header("ascii", "property float x\nproperty float y\nproperty float z\n", "int int",
                             plain.vertices, plain.faces);
  plain.bytes.reserve(plain.bytes.size() + vertex_lines_.size() + face_lines_.size() + 1);
  plain.bytes += std::exchange(vertex_lines_, {});
  plain.bytes += std::exchange(face_lines_, {});
  plain.bytes += '\n';
  return plain;
}

std::string read_bytes(const std::filesystem::path& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (std::filesystem::is_directory(status)) throw ReadError{Fault::cannot_read, "is a directory"};
  if (!std::filesystem::exists(status)) throw ReadError{Fault::cannot_read, "cannot be opened: " + error.message()};
  // A pipe or a device may have no end.
  if (!std::filesystem::is_regular_file(status)) throw ReadError{Fault::cannot_read, "is not a regular file"};

  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) throw ReadError{Fault::cannot_read, "cannot be opened: " + describe(errno)};
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) throw ReadError{Fault::cannot_read, "cannot be read: " + error.message()};
  std::string bytes(size, '\0');
  const std::size_t read = std::fread(bytes.data(), 1, bytes.size(), file.get());
  if (std::ferror(file.get())) throw ReadError{Fault::cannot_read, "cannot be read: " + describe(errno)};
  bytes.resize(read);
  return bytes;
}

}  // namespace facetsort
