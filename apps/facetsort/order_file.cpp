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

bool same_corners(const Mesh& a, std::size_t facet_of_a, const Mesh& b, std::size_t facet_of_b) {
  for (int i = 0; i < 3; ++i) {
    if (a.view().corner(facet_of_a, i) != b.view().corner(facet_of_b, i)) return false;
  }
  return true;
}

}  // namespace

void write_order(const std::filesystem::path& path, const Mesh& mesh, std::span<const std::uint32_t> order) {
  if (extension_of(path) == ".ply") {
    require(write_ply(path, in_draw_order(mesh, order).view(), order));
  } else {
    require(replace_file_content(path, little_endian_bytes(order)));
  }
}

OrderFile read_order(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  if (extension == ".u32") return read_ids(path);
  if (extension == ".ply") return read_triangles(path);
  throw Failure(path.string() + ": an order is a file that ends in .u32 or .ply");
}

OrderFaults find_faults(const OrderFile& file, const Mesh& mesh) {
  OrderFaults faults;
  std::vector<unsigned char> drawn(mesh.triangles.size());
  for (std::size_t place = 0; place < file.ids.size(); ++place) {
    const std::uint32_t id = file.ids[place];
    if (id >= drawn.size()) {
      if (faults.out_of_range++ == 0) faults.first_out_of_range = id;
      continue;
    }
    if (drawn[id] && faults.repeated++ == 0) faults.first_repeated = id;
    drawn[id] = 1;
    if (file.mesh && !same_corners(*file.mesh, place, mesh, id) && faults.wrong_corners++ == 0)
      faults.first_wrong_corners = place;
  }
  for (std::size_t facet = 0; facet < drawn.size(); ++facet) {
    if (!drawn[facet] && faults.missing++ == 0) faults.first_missing = static_cast<std::uint32_t>(facet);
  }
  return faults;
}

}  // namespace facetsort
