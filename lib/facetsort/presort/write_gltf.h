// Index buffers out: glTF 2.0, for viewers and engines that draw it as it is.
#pragma once

#include <filesystem>

#include "facetsort/base/status.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort {

// Writes `path`, in text with its buffer embedded where the extension is .gltf, else as binary glTF (.glb). One node
// with one mesh: a primitive for each index buffer, of which a viewer shows one at a time, and one vertex buffer for
// all, with positions, and colours where the mesh has some (vertices are then a facet's own where the colours are). The
// material is blended, and double-sided unless the buffers need culling. A mesh without colours has alpha 0.5.
//
// The node's extras: "directions", three numbers each; "buffers", the index of the primitive for each direction;
// "centre", from which directions start: a view takes the primitive of the direction with the largest dot product with
// (eye - centre); "needsCulling"; "meanInvertedRate" and "worstInvertedRate".
//
// Preconditions: validate(mesh) is ok; the buffers are of this mesh. Faults: empty_mesh and too_many_facets, as glTF
// has room for neither, and what writing meets; what stood at `path` is then as it was.
Status write_gltf(const std::filesystem::path& path, const MeshView& mesh, const IndexBuffers& buffers);

}  // namespace facetsort
