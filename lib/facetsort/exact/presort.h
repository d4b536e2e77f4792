// Presorting: all the work is done once, and the order for any eye is read out afterwards.
#pragma once

#include <atomic>
#include <cstddef>
#include <optional>

#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort {

struct PresortOptions {
  // Planes tried at each node of the tree, in units: more time, fewer cuts.
  std::size_t effort = 1;
  // Most triangles out over facets in, about.
  double max_growth = 64;
};

// What is looked at, and set, while a mesh is presorted on another thread.
struct PresortProgress {
  std::atomic<std::size_t> done{0}, all{0};  // parts of facets; `all` grows with every cut
  std::atomic<bool> cancelled{false};
};

struct PresortStatistics {
  std::size_t crossing_pairs = 0;  // pairs of facets that pass through each other
  std::size_t crossing_cuts = 0;   // that part them
  std::size_t tree_cuts = 0;       // by the tree's planes
  std::size_t nodes = 0, pieces = 0, triangles = 0;
  double part_ms = 0, tree_ms = 0, triangulate_ms = 0;
};

struct Presorted {
  PresortedData data;
  PresortStatistics statistics;
};

// Cuts facets that cross, builds a binary space partition of all (Fuchs, Kedem and Naylor 1980, "On Visible Surface
// Generation by A Priori Tree Structures") and makes triangles of its pieces, without cracks. Every side that a part is
// found to be on is exact, so that an order read from it is exact from any eye. Planes go through vertices of the mesh.
// Nothing where max_growth does not allow it, or where it was cancelled.
//
// Parallel in the caller's task arena; the result depends on neither thread count nor instruction set.
// Precondition: validate(mesh) is ok.
std::optional<Presorted> presort(const MeshView& mesh, const PresortOptions& options = {},
                                 PresortProgress* progress = nullptr);

}  // namespace facetsort
