// Making a mesh that fails a property as small as it can be, and writing it down as code: what a person wants to see.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/mesh/mesh.h"

namespace facetsort {

// The mesh without `count` facets from `first` on.
inline Mesh without_facets(const Mesh& mesh, std::size_t first, std::size_t count) {
  Mesh smaller = mesh;
  const auto begin = smaller.triangles.begin() + static_cast<std::ptrdiff_t>(first);
  smaller.triangles.erase(begin, begin + static_cast<std::ptrdiff_t>(count));
  return smaller;
}

// The mesh without vertices that no facet uses.
inline Mesh without_unused_vertices(const Mesh& mesh) {
  constexpr std::uint32_t unused = 0xffffffffu;
  std::vector<std::uint32_t> place(mesh.positions.size(), unused);
  Mesh smaller;
  for (glm::uvec3 triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      std::uint32_t& vertex = place[triangle[i]];
      if (vertex == unused) {
        vertex = static_cast<std::uint32_t>(smaller.positions.size());
        smaller.positions.push_back(mesh.positions[triangle[i]]);
      }
      triangle[i] = vertex;
    }
    smaller.triangles.push_back(triangle);
  }
  return smaller;
}

// Takes facets away while `fails` still holds, in halves, quarters and so on down to one by one, until no facet can be
// spared. Precondition: fails(mesh).
inline Mesh shrink(Mesh mesh, const std::function<bool(const Mesh&)>& fails) {
  std::size_t chunk = mesh.triangles.size();
  while (chunk > 0) {
    bool spared = false;
    for (std::size_t first = 0; first + chunk <= mesh.triangles.size() && chunk < mesh.triangles.size();) {
      Mesh smaller = without_facets(mesh, first, chunk);
      if (fails(smaller)) {
        mesh = std::move(smaller);
        spared = true;
      } else {
        first += chunk;
      }
    }
    if (!spared) chunk /= 2;
  }
  return without_unused_vertices(mesh);
}

// The mesh as an initialiser, every bit of it.
inline std::string as_code(const Mesh& mesh) {
  std::string code = "const Mesh mesh{{";
  char text[128];
  for (const glm::vec3& p : mesh.positions) {
    std::snprintf(text, sizeof text, "{%af, %af, %af}, ", static_cast<double>(p.x), static_cast<double>(p.y),
                  static_cast<double>(p.z));
    code += text;
  }
  code += "}, {";
  for (const glm::uvec3& t : mesh.triangles) {
    std::snprintf(text, sizeof text, "{%u, %u, %u}, ", t.x, t.y, t.z);
    code += text;
  }
  return code + "}, {}, {}};";
}

}  // namespace facetsort
