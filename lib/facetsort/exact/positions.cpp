#include "facetsort/exact/positions.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {

namespace {

// A position by the bits of its coordinates, and what is there.
struct Placed {
  std::uint32_t x, y, z;
  std::uint32_t index;

  Placed() = default;
  Placed(const glm::vec3& position, std::size_t index_in)
      : x(bits_of(position.x)),
        y(bits_of(position.y)),
        z(bits_of(position.z)),
        index(static_cast<std::uint32_t>(index_in)) {}

  bool is_at(const Placed& other) const { return x == other.x && y == other.y && z == other.z; }
  auto operator<=>(const Placed&) const = default;

  static std::uint32_t bits_of(float coordinate) { return std::bit_cast<std::uint32_t>(coordinate + 0.0f); }
};

}  // namespace

std::vector<std::uint32_t> identify_positions(const MeshView& mesh) {
  constexpr std::size_t vertices_per_task = 1024;
  std::vector<Placed> vertices(mesh.vertex_count());
  parallel_ranges(vertices.size(), vertices_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) vertices[i] = Placed(mesh.positions[i], i);
  });
  tbb::parallel_sort(vertices);
  std::vector<std::uint32_t> position(vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const bool same = i > 0 && vertices[i].is_at(vertices[i - 1]);
    position[vertices[i].index] = same ? position[vertices[i - 1].index] : vertices[i].index;
  }
  return position;
}

std::vector<PointId> identify_points(const Points& points) {
  constexpr std::size_t points_per_task = 256, most_distinct = 16;
  const std::size_t vertices = points.space().mesh.vertex_count();
  std::vector<PointId> same(points.size());
  std::iota(same.begin(), same.end(), 0u);
  // Points that coincide round to the same bits.
  std::vector<Placed> added(points.size() - vertices);
  parallel_ranges(added.size(), points_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      added[i] = Placed(points.rounded(static_cast<PointId>(vertices + i)), vertices + i);
    }
  });
  tbb::parallel_sort(added);
  std::vector<std::size_t> groups;
  for (std::size_t i = 0; i < added.size(); ++i) {
    if (i == 0 || !added[i].is_at(added[i - 1])) groups.push_back(i);
  }
  groups.push_back(added.size());
  parallel_ranges(groups.size() - 1, points_per_task, [&](std::size_t begin, std::size_t end) {
    std::vector<PointId> distinct;
    for (std::size_t group = begin; group < end; ++group) {
      distinct.clear();
      for (std::size_t i = groups[group]; i < groups[group + 1]; ++i) {
        const PointId point = added[i].index;
        const auto found = std::find_if(distinct.begin(), distinct.end(),
                                        [&](PointId other) { return points.coincide(other, point); });
        if (found != distinct.end()) {
          same[point] = *found;
        } else if (distinct.size() < most_distinct) {
          distinct.push_back(point);
        }
      }
    }
  });
  return same;
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
