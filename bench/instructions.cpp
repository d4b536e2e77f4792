// Sorts for count_instructions.sh: FACETS of a knot in spatial order, seen from 16 sides, on one thread.
#include <tbb/task_arena.h>

#include <cstdint>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "facetsort/order/spatial_order.h"
#include "shapes.h"
#include "sort_subjects.h"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  facetsort::Mesh mesh = facetsort::shapes::torus_knot(std::strtoul(argv[1], nullptr, 10));
  const std::vector<glm::uvec3> triangles = mesh.triangles;
  const std::vector<std::uint32_t> order = facetsort::spatial_order(mesh.view());
  for (std::size_t k = 0; k < order.size(); ++k) mesh.triangles[k] = triangles[order[k]];
  std::vector<std::uint32_t> indices(3 * mesh.triangles.size());
  tbb::task_arena arena(1);
  arena.execute([&] {
    facetsort::Sorter sorter(mesh.view());
    // The first sort allocates, and is counted too: a sixteenth of it, in the quotient.
    for (const facetsort::SortView& view : facetsort::bench::sort_views(mesh)) {
      sorter.sort_indices(view, mesh.triangles, std::span(indices));
    }
  });
}
