#include "order_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "facetsort/mesh/read.h"
#include "facetsort/mesh/write.h"
#include "facetsort/report/replace_file.h"
#include "failure.h"
#include "output.h"

namespace facetsort {
namespace {

constexpr std::size_t id_bytes = 4;

Mesh in_draw_order(const Mesh& mesh, std::span<const std::uint32_t> order) {
  Mesh drawn;
  drawn.positions = mesh.positions;
  drawn.vertex_colours = mesh.vertex_colours;
  for (const std::uint32_t facet : order) {
    drawn.triangles.push_back(mesh.triangles[facet]);
    if (!mesh.facet_colours.empty()) drawn.facet_colours.push_back(mesh.facet_colours[facet]);
  }
  return drawn;
}

glm::vec4 interpolated_colour(const Mesh& mesh, const CutVertex& vertex) {
  glm::vec4 colour(0);
  for (int i = 0; i < 3; ++i) {
    colour += vertex.barycentric[i] * mesh.vertex_colours[mesh.triangles[vertex.facet][i]];
  }
  return colour;
}

std::string little_endian_bytes(std::span<const std::uint32_t> ids) {
  std::string bytes;
  bytes.reserve(id_bytes * ids.size());
  for (const std::uint32_t id : ids) {
    for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(id >> shift & 0xff));
  }
  return bytes;
}

std::string read_bytes_of(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    throw Failure(path.string() + ": cannot be read: " + (error ? error.message() : "not a regular file"));
  }
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::string bytes(std::istreambuf_iterator<char>(file), {});
  if (!file || file.bad()) throw Failure(path.string() + ": cannot be read: " + std::strerror(errno));
  return bytes;
}

OrderFile read_ids(const std::filesystem::path& path) {
  const std::string bytes = read_bytes_of(path);
  if (bytes.size() % id_bytes != 0) {
    throw Failure(path.string() + ": truncated: " + std::to_string(bytes.size()) +
                  " bytes are no whole number of 4-byte facet ids");
  }
  OrderFile file;
  file.ids.resize(bytes.size() / id_bytes);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    file.ids[i / id_bytes] |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i])) << 8 * (i % id_bytes);
  }
  return file;
}

OrderFile read_triangles(const std::filesystem::path& path) {
  OrderFile file;
  file.mesh = require(read_mesh(path));
  file.ids = require(read_ply_source(path));
  if (file.ids.empty()) throw Failure(path.string() + ": its facets have no property `source`: it is no draw order");
  return file;
}

}  // namespace

Mesh mesh_of(const Mesh& mesh, const OrderedTriangles& order) {
  Mesh drawn;
  drawn.positions = mesh.positions;
  drawn.vertex_colours = mesh.vertex_colours;
  for (const CutVertex& vertex : order.vertices) {
    drawn.positions.push_back(vertex.position);
    if (!mesh.vertex_colours.empty()) drawn.vertex_colours.push_back(interpolated_colour(mesh, vertex));
  }
  drawn.triangles = order.triangles;
  if (!mesh.facet_colours.empty()) {
    for (const std::uint32_t facet : order.source) drawn.facet_colours.push_back(mesh.facet_colours[facet]);
  }
  return drawn;
}

void write_order(const std::filesystem::path& path, const Mesh& mesh, std::span<const std::uint32_t> order) {
  if (extension_of(path) == ".ply") {
    require(write_ply(path, in_draw_order(mesh, order).view(), order));
  } else {
    require(replace_file_content(path, little_endian_bytes(order)));
  }
}

void write_triangles(const std::filesystem::path& path, const Mesh& mesh, const OrderedTriangles& order) {
  require(write_ply(path, mesh_of(mesh, order).view(), order.source));
}

OrderFile read_order(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension == ".u32") return read_ids(path);
  if (extension == ".ply") return read_triangles(path);
  throw Failure(path.string() + ": an order is a file that ends in .u32 or .ply");
}

}  // namespace facetsort
