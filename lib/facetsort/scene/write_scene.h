// Scenes out: glTF 2.0, with facets in draw order.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

// Facets of one object's mesh in draw order. Empty: as they are.
using ObjectOrder = std::vector<std::uint32_t>;

// Of each object of the scene, its facets in the order in which an order of the merged mesh has them; those of objects
// that were not merged stay as they are. Facets drawn in several pieces come at the place of their last, so that what
// they hide is drawn before. Precondition: `facets` are of the merged mesh.
std::vector<ObjectOrder> object_orders(const Scene& scene, const MergedMesh& merged,
                                       std::span<const std::uint32_t> facets);

// Writes `path`, in text with its buffer embedded where the extension is .gltf, else as binary glTF (.glb): a node for
// each object and camera, with its place in the world; a mesh for each that is shown, which objects share unless they
// have orders of their own; materials, and textures as PNG with 8 bits a channel. read_scene() gives the same scene
// back, but for facet colours, which become vertex colours, and finer textures. What read_scene() leaves out of a file
// is not written.
//
// `orders` is empty, or has one for each object. Preconditions: validate(scene) is ok. Faults: bad_argument where an
// order names a facet that is not there; too_many_facets and empty_mesh, as glTF has room for neither; what writing
// meets. Written beside `path` under a temporary name and renamed: after a fault, what stood there is as it was.
Status write_scene(const std::filesystem::path& path, const Scene& scene, std::span<const ObjectOrder> orders = {});

}  // namespace facetsort
