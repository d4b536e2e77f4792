// Object File Format, as Geomview defines it, in three dimensions and text: [ST][C][N]OFF.
#include <optional>
#include <utility>

#include "facetsort/mesh/plain_ply.h"
#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

struct OffHeader {
  bool texture_coordinates = false, colours = false, normals = false;
  std::size_t vertices = 0, faces = 0;
};

std::string at_line(const text::Lines& lines) {
  return "line " + std::to_string(lines.number()) + ": ";
}

// Leaves `lines` at the line of the counts.
OffHeader read_header(text::Lines& lines) {
  OffHeader header;
  if (!lines.next()) throw ReadError{Fault::truncated, "truncated: no header"};
  std::size_t word = 0;
  // The keyword may be left out.
  if (!text::parse_integer<long long>(lines.words()[0])) {
    std::string_view keyword = lines.words()[word++];
    const auto take = [&](std::string_view prefix) {
      const bool there = keyword.starts_with(prefix);
      if (there) keyword.remove_prefix(prefix.size());
      return there;
    };
    header.texture_coordinates = take("ST");
    header.colours = take("C");
    header.normals = take("N");
    const bool other_dimension = take("4") || take("n");
    if (keyword != "OFF") throw ReadError{Fault::unsupported_format, "no OFF file: it does not start with OFF"};
    if (other_dimension) throw ReadError{Fault::unsupported_format, "OFF of another dimension than 3"};
    if (lines.words().size() > word && lines.words()[word] == "BINARY") {
      throw ReadError{Fault::unsupported_format, "binary OFF"};
    }
  }
  if (word == lines.words().size()) {
    if (!lines.next()) throw ReadError{Fault::truncated, "truncated: no counts of vertices and facets"};
    word = 0;
  }
  // The count of edges, which nothing needs, is often left out.
  const std::size_t counts = lines.words().size() - word;
  std::optional<std::size_t> vertices, faces;
  if (counts == 2 || counts == 3) {
    vertices = text::parse_integer<std::size_t>(lines.words()[word]);
    faces = text::parse_integer<std::size_t>(lines.words()[word + 1]);
  }
  if (!vertices || !faces) throw ReadError{Fault::malformed, at_line(lines) + "no counts of vertices and facets"};
  header.vertices = *vertices;
  header.faces = *faces;
  return header;
}

// `count` words, 0 for none.
glm::vec4 read_colour(const text::Lines& lines, std::size_t first, std::size_t count) {
  if (count == 0) return no_colour;
  const std::optional<glm::vec4> colour = parse_colour(std::span(lines.words()).subspan(first, count));
  if (!colour) throw ReadError{Fault::malformed, at_line(lines) + "a colour that is not a number or is negative"};
  return *colour;
}

[[noreturn]] void throw_truncated(std::size_t read, std::size_t promised, const char* what) {
  throw ReadError{Fault::truncated,
                  "truncated: " + std::to_string(read) + " of " + std::to_string(promised) + " " + what + " read"};
}

// x y z [normal] [colour] [texture coordinates]
void scan_vertices(text::Lines& lines, const OffHeader& header, PlainText& plain, std::vector<glm::vec4>& colours) {
  const std::size_t colour_at = header.normals ? 6 : 3;
  const std::size_t least_words = colour_at + (header.texture_coordinates ? 2 : 0);
  for (std::size_t v = 0; v < header.vertices; ++v) {
    if (!lines.next()) throw_truncated(v, header.vertices, "vertices");
    const std::size_t words = lines.words().size();
    if (words < least_words && lines.is_cut()) throw_truncated(v, header.vertices, "vertices");
    const std::size_t channels = words < least_words ? 1 : words - least_words;
    if (channels != 0 && !(header.colours && (channels == 3 || channels == 4))) {
      throw ReadError{Fault::malformed,
                      at_line(lines) + "vertex " + std::to_string(v) + " has " + std::to_string(words) + " numbers"};
    }
    plain.add_vertex(lines.words()[0], lines.words()[1], lines.words()[2]);
    if (header.colours) colours.push_back(read_colour(lines, colour_at, channels));
  }
}

// n, n corners, [colour]
void scan_faces(text::Lines& lines, const OffHeader& header, PlainText& plain, std::vector<glm::vec4>& colours) {
  bool any_colour = false;
  for (std::size_t f = 0; f < header.faces; ++f) {
    if (!lines.next()) throw_truncated(f, header.faces, "facets");
    const auto malformed = [&](const std::string& what) {
      return ReadError{Fault::malformed, at_line(lines) + "facet " + std::to_string(f) + " has " + what};
    };
    const std::optional<std::size_t> corners = text::parse_integer<std::size_t>(lines.words()[0]);
    if (!corners) throw malformed("no count of corners");
    if (*corners < 3) throw malformed(std::to_string(*corners) + " corners, fewer than 3");
    const std::size_t words = lines.words().size() - 1;
    if (words < *corners) {
      if (lines.is_cut()) throw_truncated(f, header.faces, "facets");
      throw malformed(std::to_string(words) + " of " + std::to_string(*corners) + " corners");
    }
    plain.begin_face(*corners);
    for (std::size_t i = 1; i <= *corners; ++i) plain.add_corner(lines.words()[i]);
    // One word is an entry of a colour map, which the file does not have.
    const std::size_t more = words - *corners, channels = more == 1 ? 0 : more;
    if (channels == 2 || channels > 4) {
      throw malformed(std::to_string(more) + " words behind its corners");
    }
    any_colour |= channels != 0;
    colours.insert(colours.end(), *corners - 2, read_colour(lines, *corners + 1, channels));
  }
  if (!any_colour) colours.clear();
}

}  // namespace

PlainPly scan_off(std::string_view file) {
  text::Lines lines(file, {.comment = '#'});
  const OffHeader header = read_header(lines);
  PlainText plain;
  std::vector<glm::vec4> vertex_colours, facet_colours;
  scan_vertices(lines, header, plain, vertex_colours);
  scan_faces(lines, header, plain, facet_colours);
  if (lines.next()) throw ReadError{Fault::malformed, at_line(lines) + "the file goes on after its last facet"};

  PlainPly result = plain.finish();
  scale_to_unit(vertex_colours, "colours of vertices");
  scale_to_unit(facet_colours, "colours of facets");
  result.vertex_colours = std::move(vertex_colours);
  result.facet_colours = std::move(facet_colours);
  return result;
}

}  // namespace facetsort
