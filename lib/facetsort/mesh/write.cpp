#include "facetsort/mesh/write.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <span>
#include <string>

#include "facetsort/base/new_file.h"

namespace facetsort {
namespace {

void put(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
}

void put(std::string& bytes, float value) {
  put(bytes, std::bit_cast<std::uint32_t>(value));
}

void put_colour(std::string& bytes, const glm::vec4& colour) {
  for (int c = 0; c < 4; ++c) {
    // Written so that NaN becomes 0.
    const float clamped = colour[c] > 0 ? std::min(colour[c], 1.0f) : 0.0f;
    bytes += static_cast<char>(std::lround(clamped * 255));
  }
}

std::string header(const MeshView& mesh, bool has_source) {
  const std::string colour = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  text += "element vertex " + std::to_string(mesh.vertex_count()) + "\n";
  text += "property float x\nproperty float y\nproperty float z\n";
  if (!mesh.vertex_colours.empty()) text += colour;
  text += "element face " + std::to_string(mesh.facet_count()) + "\n";
  text += "property list uchar uint vertex_indices\n";
  if (!mesh.facet_colours.empty()) text += colour;
  if (has_source) text += "property uint source\n";
  return text + "end_header\n";
}

// Calls put_element(bytes, i) for each element and writes what has gathered now and then.
template <typename PutElement>
void write_elements(NewFile& file, std::size_t count, const PutElement& put_element) {
  constexpr std::size_t flush_size = std::size_t{1} << 18;
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) {
    put_element(bytes, i);
    if (bytes.size() >= flush_size || i + 1 == count) {
      file.write(std::as_bytes(std::span(bytes)));
      bytes.clear();
    }
  }
}

}  // namespace

Status write_ply(const std::filesystem::path& path, const MeshView& mesh, std::span<const std::uint32_t> source) {
  if (!source.empty() && source.size() != mesh.facet_count()) {
    return {Fault::bad_argument, path.string() + ": " + std::to_string(source.size()) + " source ids for " +
                                     std::to_string(mesh.facet_count()) + " facets"};
  }
  try {
    NewFile file(path);
    const std::string text = header(mesh, !source.empty());
    file.write(std::as_bytes(std::span(text)));
    write_elements(file, mesh.vertex_count(), [&](std::string& bytes, std::size_t v) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, mesh.positions[v][axis]);
      if (!mesh.vertex_colours.empty()) put_colour(bytes, mesh.vertex_colours[v]);
    });
    write_elements(file, mesh.facet_count(), [&](std::string& bytes, std::size_t f) {
      bytes += '\3';
      for (int i = 0; i < 3; ++i) put(bytes, mesh.triangles[f][i]);
      if (!mesh.facet_colours.empty()) put_colour(bytes, mesh.facet_colours[f]);
      if (!source.empty()) put(bytes, source[f]);
    });
    return file.finish();
  } catch (const std::bad_alloc&) {
    return {Fault::out_of_memory, path.string() + ": not enough memory to write it"};
  }
}

}  // namespace facetsort
