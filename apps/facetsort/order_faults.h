// Whether a draw order holds the mesh: each facet once, whole or in parts that cover it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "facetsort/mesh/mesh.h"
#include "order_file.h"

namespace facetsort {

// Each count has the first it concerns; meaningless where it is 0.
struct OrderFaults {
  std::size_t out_of_range = 0;  // ids of no facet
  std::uint32_t first_out_of_range = 0;
  std::size_t repeated = 0;  // whole facets that came before
  std::uint32_t first_repeated = 0;
  std::size_t missing = 0;  // facets of which nothing is in the order
  std::uint32_t first_missing = 0;
  std::size_t wrong_corners = 0;        // triangles that are neither the facet they name nor lie in it
  std::size_t first_wrong_corners = 0;  // place in the order
  std::size_t wrong_cover = 0;  // facets of which the order draws some more than once, or leaves some out
  std::uint32_t first_wrong_cover = 0;

  bool none() const { return out_of_range + repeated + missing + wrong_corners + wrong_cover == 0; }
};

struct OrderContents {
  OrderFaults faults;
  std::size_t facets_in_parts = 0;  // drawn as triangles with other corners than their own

  bool is_permutation() const { return faults.none() && facets_in_parts == 0; }
};

// Parts of a facet are judged with the tolerance of vertex_rounding() for where their corners lie, and none at all for
// how they join: they cover the facet where each edge of one is the same edge of another, traversed the other way, or
// lies along a side of the facet, and their areas add up to its area.
OrderContents inspect_order(const OrderFile& file, const Mesh& mesh);

}  // namespace facetsort
