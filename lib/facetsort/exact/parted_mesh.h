// Internal to exact: a mesh whose facets do not cross any more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::exact_internal {

// What every exact order starts from. Parallel in the caller's task arena; the same for any thread count.
struct PartedMesh {
  // `max_growth`: most triangles out over facets in. The mesh's arrays must outlive this.
  PartedMesh(const MeshView& mesh, double max_growth);
  PartedMesh(const PartedMesh&) = delete;
  PartedMesh& operator=(const PartedMesh&) = delete;

  std::size_t memory_bytes() const;

  std::vector<unsigned char> degenerate;  // by facet
  PointSpace space;
  Points points;
  PartList pieces;  // of facets that cross others
  std::size_t crossing_pairs = 0, uncut_pairs = 0, cuts = 0;
  std::size_t triangles = 0;       // that pieces and whole facets make
  std::size_t most_triangles = 0;  // that they may make
};

// Of so many facets.
std::size_t most_triangles_of(std::size_t facets, double max_growth);

// Draw ids of the facets without area.
std::vector<std::uint32_t> degenerate_facets(const PartedMesh& parted);

}  // namespace facetsort::exact_internal
