#include "facetsort/exact/positions.h"

#include <tbb/parallel_sort.h>

#include <bit>
#include <cstddef>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {

std::vector<std::uint32_t> identify_positions(const MeshView& mesh) {
  constexpr std::size_t vertices_per_task = 1024;
  struct Vertex {
    std::uint32_t x, y, z;  // bits of the coordinates
    std::uint32_t index;

    auto operator<=>(const Vertex&) const = default;
  };
  std::vector<Vertex> vertices(mesh.vertex_count());
  parallel_ranges(vertices.size(), vertices_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const glm::vec3 p = mesh.positions[i] + 0.0f;
      vertices[i] = {std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                     std::bit_cast<std::uint32_t>(p.z), static_cast<std::uint32_t>(i)};
    }
  });
  tbb::parallel_sort(vertices);
  std::vector<std::uint32_t> position(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vertex& vertex = vertices[i];
    const Vertex& previous = vertices[i == 0 ? 0 : i - 1];
    const bool same = i > 0 && vertex.x == previous.x && vertex.y == previous.y && vertex.z == previous.z;
    position[vertex.index] = same ? position[previous.index] : vertex.index;
  }
  return position;
}

std::vector<unsigned char> find_degenerate_facets(const MeshView& mesh) {
  constexpr std::size_t facets_per_task = 1024;
  std::vector<unsigned char> degenerate(mesh.facet_count());
  parallel_ranges(degenerate.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      degenerate[f] = collinear(mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2));
    }
  });
  return degenerate;
}

}  // namespace facetsort::exact_internal
