// What a renderer does each frame: sorts a tetrahedron for an eye and looks at what it got.
#include <array>
#include <cstdint>
#include <cstdio>
#include <glm/glm.hpp>

#include "facetsort/mesh/inspect.h"
#include "facetsort/order/sorter.h"

int main() {
  const std::array<glm::vec3, 4> positions{glm::vec3(1, 1, 1), glm::vec3(1, -1, -1), glm::vec3(-1, 1, -1),
                                           glm::vec3(-1, -1, 1)};
  const std::array<glm::uvec3, 4> triangles{glm::uvec3(0, 1, 2), glm::uvec3(0, 3, 1), glm::uvec3(0, 2, 3),
                                            glm::uvec3(1, 3, 2)};
  const facetsort::MeshView mesh{positions, triangles, {}, {}};
  if (!facetsort::validate(mesh).ok()) return 1;

  facetsort::Sorter sorter(mesh);
  std::array<std::uint16_t, 12> indices{};
  sorter.sort_indices({.eye = {9, 9, 9, 1}, .forward = {-1, -1, -1}}, triangles, indices);
  // The eye looks at vertex 0: the facet without it is the farthest.
  for (int i = 0; i < 3; ++i) {
    if (indices[i] == 0) return 1;
  }
  std::puts("sorted");
  return 0;
}
