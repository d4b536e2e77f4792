// What every mesh format is brought to before OpenMesh converts its numbers: a PLY of nothing but positions and
// corners. Internal to the readers.
//
// OpenMesh 9.0 has a reader for each of our formats, but only its PLY reader hands over every face, and that one only
// for the plainest of files. What the others do to facets before an importer sees them:
//   - OBJ: repeated corners are taken out of a face, and a face left with fewer than three is dropped; a `v` line that
//     does not parse is skipped, so that every later index means another vertex; an index that does not parse is left
//     out of its face; opacity `d` and transparency `Tr` are taken for the same number; a second mtllib replaces the
//     first; numbers follow the global locale.
//   - OFF: comments, counts on the keyword's line and colours of faces in a file that starts with OFF and not COFF
//     are read as counts and indices; a missing line is read as zeros.
//   - STL: facets with two equal corners are dropped; a NaN corner breaks the ordering of its vertex map; the end of
//     the file is not noticed.
//   - PLY: the header loop never ends where the header does not; obj_info lines are read as keywords; lists other than
//     vertex_indices, elements other than vertex and face, face properties before vertex_indices, list counts of most
//     types and vertices after faces are misread or refused; float colours lose all but 8 bits; ASCII nan makes zeros
//     of the rest of the file; a short file can pass for a whole one.
// So one scanner a format walks the file's structure strictly and copies its numbers, as they stand, into a plain PLY.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/base/status.h"

namespace facetsort {

// Thrown between the scanners, the importer (through OpenMesh) and read_mesh, which turns it into a Status. The
// message has the place, and no file name yet.
struct ReadError {
  Fault fault;
  std::string message;
};

// Every face has three corners or more. Colours and sources are already one a facet: a face of n corners has n - 2.
struct PlainPly {
  std::string bytes;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::vector<glm::vec4> facet_colours;   // empty, or one a facet
  std::vector<glm::vec4> vertex_colours;  // empty, or one a vertex
  std::vector<std::uint32_t> source;      // a PLY's face property of that name: empty, or one a facet
};

// Three or four words as red, green, blue and perhaps alpha; nothing where one is no number or is negative.
std::optional<glm::vec4> parse_colour(std::span<const std::string_view> words);

// Stands where the file gives no colour though it gives others: becomes opaque white.
constexpr glm::vec4 no_colour(-1);

// Brings colours from parse_colour to 0 to 1. The file doesn't say which of the two usual ranges it means: whole
// numbers to 255 where some number is above 1, otherwise 0 to 1. Throws ReadError naming the first that is in neither;
// `list` names them in the plural.
void scale_to_unit(std::vector<glm::vec4>& colours, const char* list);

// Puts the header before a body. `face_list` is "TYPE TYPE" of the list of corners.
std::string plain_header(std::string_view encoding, std::string_view vertex_properties, std::string_view face_list,
                         std::size_t vertices, std::size_t faces);

// A plain ASCII PLY from a text file: vertices and faces may come in any order.
class PlainText {
 public:
  std::size_t vertex_count() const { return vertices_; }
  std::size_t face_count() const { return faces_; }
  void add_vertex(std::string_view x, std::string_view y, std::string_view z);
  // Precondition: three corners or more.
  void begin_face(std::size_t corners);
  void add_corner(std::string_view index);
  void add_corner(std::size_t index);
  // Leaves this object empty.
  PlainPly finish();

 private:
  std::string vertex_lines_, face_lines_;
  std::size_t vertices_ = 0, faces_ = 0;
};

// The scanners. They throw ReadError, and std::bad_alloc; they allocate no more than a few times the file's size
// whatever its counts say.
PlainPly scan_ply(std::string_view file);
PlainPly scan_off(std::string_view file);
PlainPly scan_stl(std::string_view file);
// Material files are looked up in `folder`; one that is not there leaves its materials undefined.
PlainPly scan_obj(std::string_view file, const std::filesystem::path& folder);

// All bytes of a regular file. Throws ReadError.
std::string read_bytes(const std::filesystem::path& path);

}  // namespace facetsort
