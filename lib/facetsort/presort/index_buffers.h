// Plain index buffers for engines that draw what they are given: a few fixed orders of a mesh's facets, each good for
// some directions.
#pragma once

#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <optional>

#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort {

// Share of the covered pixels of a view in which some facet is drawn after one nearer by more than 1e-6 bounding radii,
// drawn by the buffer for the view's eye; without facets seen from behind where the buffers need culling.
// Preconditions: validate(mesh) and validate(view) are ok; the buffers are of this mesh.
double inverted_rate(const MeshView& mesh, const View& view, const IndexBuffers& buffers);

struct IndexBuffersOptions {
  std::size_t most_buffers = 10;         // 1 or more
  std::optional<double> max_error = {};  // as few buffers as have a mean share of inverted pixels of at most this
  bool with_culling = false;             // for engines that leave out facets seen from behind
  // Called now and then, by the caller's thread, with the share of the work that is done (0 to 1; where max_error is
  // given, of the work for most_buffers). False stops the work.
  std::function<bool(double)> progress = {};
};

// Orders are made for eyes outside the mesh, at 3 bounding radii from the centre of its box; other distances do with
// them. Facets that hide each other in different ways round from the directions of one buffer are inverted in some; the
// buffers' directions are chosen so that these cover few pixels. The error is measured over 100 views, 512 x 512, from
// directions between those that the orders were made for, at the same distance: a pixel is inverted where some facet
// is drawn after one nearer by more than 1e-6 radii.
//
// Takes seconds for some thousand facets, a minute or so for 70,000, and up to 2 GiB: where views have many pairs of
// facets to look at, fewer views are taken. Parallel in the caller's task arena; the result is the same for any thread
// count. Without any buffer where `progress` stopped it.
// Precondition: `mesh` is empty or validate(mesh) is ok.
IndexBuffers make_index_buffers(const MeshView& mesh, const IndexBuffersOptions& options = {});

}  // namespace facetsort
