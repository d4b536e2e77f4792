// Draw orders as files: .u32, little-endian facet ids, farthest facet first; or .ply, the triangles themselves in draw
// order, each with the id that it has in the mesh as its property `source`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facetsort/mesh/mesh.h"

namespace facetsort {

// Both throw Failure. Files are written under a temporary name and renamed.
void write_order(const std::filesystem::path& path, const Mesh& mesh, std::span<const std::uint32_t> order);

// Ids as the file has them, in and out of range. For a .ply its triangles too.
struct OrderFile {
  std::vector<std::uint32_t> ids;
  std::optional<Mesh> mesh;
};
OrderFile read_order(const std::filesystem::path& path);

// What keeps a list of ids from being a permutation of the facets, and triangles from being those that they name. Each
// count has the first it concerns; meaningless where it is 0.
struct OrderFaults {
  std::size_t out_of_range = 0;  // ids of no facet
  std::uint32_t first_out_of_range = 0;
  std::size_t repeated = 0;  // ids that came before
  std::uint32_t first_repeated = 0;
  std::size_t missing = 0;  // facets that are not in the list
  std::uint32_t first_missing = 0;
  std::size_t wrong_corners = 0;        // triangles of a .ply with other corners than the facet they name
  std::size_t first_wrong_corners = 0;  // place in the order

  bool none() const { return out_of_range + repeated + missing + wrong_corners == 0; }
};
OrderFaults find_faults(const OrderFile& file, const Mesh& mesh);

}  // namespace facetsort
