// Internal to exact: presorting a mesh whose crossing facets have been parted already.
#pragma once

#include <cstddef>
#include <optional>

#include "facetsort/exact/parted_mesh.h"
#include "facetsort/exact/presort.h"

namespace facetsort::exact_internal {

// Adds the tree's pieces to the mesh. Nothing, and then nothing is added, where presort() gives nothing.
std::optional<Presorted> presort_parted(PartedMesh& parted, std::size_t effort, PresortProgress* progress);

}  // namespace facetsort::exact_internal
