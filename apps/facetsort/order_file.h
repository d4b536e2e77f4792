// Draw orders as files: .u32, little-endian facet ids, farthest facet first; or .ply, the triangles themselves in draw
// order, each with the id of the facet that it is, or is part of, as its property `source`.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facetsort/exact/exact_sorter.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

// The mesh's vertices, then those of the cuts, their colours interpolated; the triangles with the colours of their
// facets.
Mesh mesh_of(const Mesh& mesh, const OrderedTriangles& order);

// All throw Failure. Files are written under a temporary name and renamed.
void write_order(const std::filesystem::path& path, const Mesh& mesh, std::span<const std::uint32_t> order);
// A .ply of mesh_of().
void write_triangles(const std::filesystem::path& path, const Mesh& mesh, const OrderedTriangles& order);

// Ids as the file has them, in and out of range. For a .ply its triangles too.
struct OrderFile {
  std::vector<std::uint32_t> ids;
  std::optional<Mesh> mesh;
};
OrderFile read_order(const std::filesystem::path& path);

}  // namespace facetsort
