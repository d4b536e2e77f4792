// Per-pixel lists: every fragment of every pixel, by depth. The reference that orders and pictures are judged by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "facetsort/blend/view.h"
#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

// The rank (position in an order) of what the order leaves out.
inline constexpr std::uint32_t not_drawn = 0xffffffffu;

// One facet at one pixel centre.
struct Fragment {
  std::uint32_t facet;
  float depth_error;  // bound on the rounding of `depth`, same unit
  double depth;       // along the pixel's ray, as Ray has it, from the float32 corners in double
};

// Pixels in row-major order, row 0 on top; the fragments of pixel p are fragments[offsets[p] .. offsets[p + 1]),
// farthest first, equal depths by smaller facet id first.
struct FragmentLists {
  int width = 0, height = 0;
  std::size_t facets_drawn = 0;  // facets that may cover some pixel of the picture
  std::vector<std::uint64_t> offsets;  // width * height + 1
  std::vector<Fragment> fragments;

  std::span<const Fragment> pixel(std::size_t p) const {
    return {fragments.data() + offsets[p], static_cast<std::size_t>(offsets[p + 1] - offsets[p])};
  }
};

// Rasterises the whole mesh, no facet culled. Coverage is exact: a facet is in a pixel's list if and only if the ray
// through the pixel's centre meets it (edges and corners by the top-left rule, each pixel once). Parallel in the
// caller's task arena; same result for any thread count.
FragmentLists collect_fragments(const MeshView& mesh, const View& view);

// The rank of each fragment, parallel to lists.fragments: the position in `order` of its facet or, where the order
// draws pieces of that, of the piece that covers the pixel; not_drawn where there is none. Exact. `order`: draw ids (see
// Pieces), each at most once, and no facet both whole and in pieces. `lists`: of this mesh and view, whoever found
// them. Parallel in the caller's task arena.
std::vector<std::uint32_t> fragment_ranks(const MeshView& mesh, const View& view, const FragmentLists& lists,
                                          std::span<const std::uint32_t> order, const Pieces& pieces = {});

}  // namespace facetsort
