// STL, both kinds. Each facet keeps its own three vertices, as in the file. The attribute bytes of the binary kind are
// not read: no two programs agree on what they mean.
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>

#include "facetsort/mesh/plain_ply.h"
#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

constexpr std::size_t header_size = 80, count_size = 4, facet_size = 50, normal_size = 12, position_size = 12;

std::uint32_t little_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

std::size_t promised_facets(std::string_view file) {
  return little_endian(file.substr(header_size, count_size));
}

// The first word tells nothing: many binary files start with "solid" too. No text has a zero byte, and hardly any
// binary file is without one.
bool is_binary(std::string_view file) {
  return file.find('\0') != file.npos || (file.size() >= header_size + count_size &&
                                          file.size() == header_size + count_size + promised_facets(file) * facet_size);
}

PlainPly scan_binary(std::string_view file) {
  if (file.size() < header_size + count_size) throw ReadError{Fault::truncated, "truncated: no count of facets"};
  PlainPly plain;
  plain.faces = promised_facets(file);
  plain.vertices = 3 * plain.faces;
  file.remove_prefix(header_size + count_size);
  if (file.size() / facet_size < plain.faces) {
    throw ReadError{Fault::truncated, "truncated: " + std::to_string(file.size() / facet_size) + " of " +
                                          std::to_string(plain.faces) + " facets read"};
  }
  if (file.size() > plain.faces * facet_size) {
    throw ReadError{Fault::malformed, std::to_string(file.size() - plain.faces * facet_size) +
                                          " bytes behind the last of " + std::to_string(plain.faces) + " facets"};
  }

  plain.bytes = plain_header("binary_little_endian", "property float x\nproperty float y\nproperty float z\n",
                             "uchar uint", plain.vertices, plain.faces);
  plain.bytes.reserve(plain.bytes.size() + plain.faces * (3 * position_size + 13));
  for (std::size_t f = 0; f < plain.faces; ++f) {
    plain.bytes += file.substr(f * facet_size + normal_size, 3 * position_size);
  }
  for (std::size_t vertex = 0; vertex < plain.vertices; ++vertex) {
    if (vertex % 3 == 0) plain.bytes += '\3';
    for (int shift = 0; shift < 32; shift += 8) plain.bytes += static_cast<char>(vertex >> shift & 0xff);
  }
  return plain;
}

bool equal_ignoring_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

// The text kind, one statement a line, as every writer lays it out.
class TextScanner {
 public:
  explicit TextScanner(std::string_view file) : lines_(file) {}

  // Any number of solids, one after the other.
  PlainPly scan() {
    while (lines_.next()) {
      if (!is("solid")) throw unexpected("solid");
      advance();
      for (; !is("endsolid"); advance()) scan_facet();
    }
    return plain_.finish();
  }

 private:
  void scan_facet() {
    if (!is("facet")) throw unexpected("facet or endsolid");
    advance();
    if (!is("outer")) throw unexpected("outer loop");
    advance();
    std::size_t corners = 0;
    for (; is("vertex"); advance(), ++corners) {
      if (lines_.words().size() != 4) throw unexpected("three numbers");
      plain_.add_vertex(lines_.words()[1], lines_.words()[2], lines_.words()[3]);
    }
    if (!is("endloop")) throw unexpected("vertex or endloop");
    if (corners < 3) throw unexpected("a third vertex");
    plain_.begin_face(corners);
    for (std::size_t i = corners; i > 0; --i) plain_.add_corner(plain_.vertex_count() - i);
    advance();
    if (!is("endfacet")) throw unexpected("endfacet");
  }

  bool is(std::string_view keyword) const { return equal_ignoring_case(lines_.words()[0], keyword); }

  void advance() {
    if (!lines_.next()) throw truncated();
  }

  ReadError truncated() const {
    return {Fault::truncated, "truncated: no endsolid after line " + std::to_string(lines_.number()) + ", " +
                                  std::to_string(plain_.face_count()) + " facets read"};
  }

  ReadError unexpected(const std::string& expected) const {
    if (lines_.is_cut()) return truncated();
    return {Fault::malformed, "line " + std::to_string(lines_.number()) + ": " + expected + " expected in facet " +
                                  std::to_string(plain_.face_count())};
  }

  text::Lines lines_;
  PlainText plain_;
};

}  // namespace

PlainPly scan_stl(std::string_view file) {
  return is_binary(file) ? scan_binary(file) : TextScanner(file).scan();
}

}  // namespace facetsort
