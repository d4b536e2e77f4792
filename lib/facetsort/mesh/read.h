// Mesh files in: PLY (ASCII, both binaries), OBJ with MTL, OFF, STL (ASCII, binary), through OpenMesh.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort {

// Reads a mesh file; the extension (any case) tells the format.
//
// Every face of the file is kept, in the file's order: non-manifold, duplicate and degenerate ones too. A face of n
// corners becomes the n - 2 triangles of its fan, one after the other, so for files of triangles a facet's id is its
// position in the file. Colours become facet_colours (OBJ materials: Kd and d or Tr) or vertex_colours, 8-bit ones
// divided by 255; they are taken as linear. Materials or colours that a file leaves out stay empty; where it gives
// them to some facets (or vertices) only, the others are opaque white.
//
// Refuses, with one line that names the file, the fault and the place: what can't be opened, an unknown format, a
// malformed or truncated file, an index out of range, a non-finite position of a vertex that a facet uses, no facets.
// Places count the faces of the file from 0.
// Reentrant: may be called from several threads.
Result<Mesh> read_mesh(const std::filesystem::path& path);

// The `source` ids of a PLY's facets, as write_ply wrote them; empty where the file has no such property. Refuses what
// read_mesh refuses of a PLY's structure; indices and positions are not looked at.
Result<std::vector<std::uint32_t>> read_ply_source(const std::filesystem::path& path);

}  // namespace facetsort
