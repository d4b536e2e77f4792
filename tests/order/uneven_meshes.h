// Meshes whose depths are spread in ways that a sort may be misled by.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "facetsort/mesh/mesh.h"
#include "shapes.h"

namespace facetsort {

// Facets in places drawn from `places`, one key each along the z axis.
template <typename Place>
Mesh facets_at(std::size_t count, const Place& place) {
  Mesh mesh;
  for (std::size_t facet = 0; facet < count; ++facet) {
    const float z = place(facet);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{0, 0, z}, {1, 0, z}, {0, 1, z}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

struct UnevenMesh {
  std::string name;
  Mesh mesh;
};

// On either side of every threshold of the sort, evenly and unevenly spread in depth.
inline const std::vector<UnevenMesh>& uneven_meshes() {
  static const std::vector<UnevenMesh> list = [] {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> even(-1, 1);
    std::vector<UnevenMesh> made;
    for (const std::size_t count : {1, 2, 63, 64, 65, 200, 32768, 32769, 65535, 65536, 100000}) {
      made.push_back({"even_" + std::to_string(count), facets_at(count, [&](std::size_t) { return even(random); })});
    }
    for (const std::size_t count : {3000, 100000}) {
      const std::string size = std::to_string(count);
      made.push_back({"flat_" + size, facets_at(count, [](std::size_t) { return 0.5f; })});
      made.push_back({"two_depths_" + size, facets_at(count, [](std::size_t i) { return i % 3 == 0 ? 1.0f : -1.0f; })});
      made.push_back(
          {"outlier_" + size, facets_at(count, [&](std::size_t i) { return i == 7 ? 1e6f : even(random); })});
      made.push_back({"steps_" + size, facets_at(count, [](std::size_t i) { return static_cast<float>(i % 50); })});
      // Each a thousandth as far from 0 as the last thousand: every range has nearly all of them at its end.
      made.push_back({"many_scales_" + size, facets_at(count, [&](std::size_t i) {
                        return even(random) * std::pow(10.0f, -static_cast<float>(3 * (i % 12)));
                      })});
      made.push_back({"denormal_" + size, facets_at(count, [&](std::size_t i) {
                        return i == 0 ? 1.0f : static_cast<float>(random() % 100) * 1e-44f;
                      })});
      made.push_back({"sorted_" + size, facets_at(count, [&](std::size_t i) { return static_cast<float>(i); })});
      made.push_back({"reversed_" + size, facets_at(count, [&](std::size_t i) { return -static_cast<float>(i); })});
    }
    made.push_back({"knot_300000", shapes::torus_knot(300000)});
    return made;
  }();
  return list;
}

}  // namespace facetsort
