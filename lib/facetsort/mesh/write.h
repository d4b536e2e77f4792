// Mesh files out: binary little-endian PLY.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "facetsort/base/status.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// Writes a binary little-endian PLY: float x, y, z (and uchar red, green, blue, alpha where the mesh has vertex
// colours), then the facets in the order of `mesh.triangles` (with uchar colours where the mesh has facet colours).
// `source`, empty or one id a facet, becomes the facets' uint property `source`: for a mesh whose triangles were put
// in draw order, the id that each had in the mesh it came from.
//
// Written beside `path` under a temporary name and renamed: a failure leaves what stood there untouched.
Status write_ply(const std::filesystem::path& path, const MeshView& mesh, std::span<const std::uint32_t> source = {});

}  // namespace facetsort
