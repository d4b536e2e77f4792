#include "facetsort/exact/parted_mesh.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/crossings.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/positions.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/exact/triangulation.h"
#include "facetsort/facets/facets.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t facets_per_task = 4096;

// One id for all facets that lie in one plane, as the two halves of a quad do: the smallest of them. Candidates are
// facets whose planes agree in double to some digits; which of these coincide is decided exactly.
std::vector<FacetId> find_planes(const MeshView& mesh, const std::vector<unsigned char>& degenerate) {
  struct RoundedPlane {
    std::int64_t x, y, z, offset;
    FacetId facet;

    auto operator<=>(const RoundedPlane&) const = default;
    bool agrees_with(const RoundedPlane& other) const {
      return x == other.x && y == other.y && z == other.z && offset == other.offset;
    }
  };
  const FacetFrame frame = facet_frame(facet_bounds(mesh));
  std::vector<RoundedPlane> rounded(mesh.facet_count());
  parallel_ranges(rounded.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      rounded[f].facet = static_cast<FacetId>(f);
      if (degenerate[f]) continue;
      glm::dvec3 corner[3];
      for (int i = 0; i < 3; ++i) corner[i] = (glm::dvec3(mesh.corner(f, i)) - frame.origin) * frame.scale;
      glm::dvec3 normal = glm::cross(corner[1] - corner[0], corner[2] - corner[0]);
      normal /= glm::length(normal);
      const bool flip = normal.x < 0 || (normal.x == 0 && (normal.y < 0 || (normal.y == 0 && normal.z < 0)));
      const double scale = flip ? -0x1p30 : 0x1p30;
      rounded[f] = {std::llround(scale * normal.x), std::llround(scale * normal.y), std::llround(scale * normal.z),
                    std::llround(scale * glm::dot(normal, corner[0])), static_cast<FacetId>(f)};
    }
  });
  tbb::parallel_sort(rounded);
  std::vector<FacetId> plane(mesh.facet_count());
  std::iota(plane.begin(), plane.end(), FacetId{0});
  const auto coplanar = [&](FacetId f, FacetId g) {
    for (int i = 0; i < 3; ++i) {
      if (orientation(mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2), mesh.corner(g, i)) != 0) return false;
    }
    return true;
  };
  std::vector<FacetId> distinct;  // planes that round to the same
  for (std::size_t i = 0; i < rounded.size(); ++i) {
    const FacetId facet = rounded[i].facet;
    if (degenerate[facet]) continue;
    if (i == 0 || !rounded[i].agrees_with(rounded[i - 1])) distinct.clear();
    const auto same =
        std::find_if(distinct.begin(), distinct.end(), [&](FacetId other) { return coplanar(other, facet); });
    if (same != distinct.end()) {
      plane[facet] = *same;
    } else {
      distinct.push_back(facet);
    }
  }
  return plane;
}

// Whether a facet's normal is opposite to that of the facet that stands for its plane.
std::vector<unsigned char> find_facing_away(const MeshView& mesh, const std::vector<FacetId>& plane) {
  std::vector<unsigned char> away(mesh.facet_count());
  parallel_ranges(away.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t f = begin; f < end; ++f) {
      const FacetId g = plane[f];
      if (g == f) continue;
      for (int axis = 0; axis < 3; ++axis) {
        const int sign = normal_sign(mesh.corner(f, 0), mesh.corner(f, 1), mesh.corner(f, 2), axis);
        if (sign == 0) continue;
        away[f] = normal_sign(mesh.corner(g, 0), mesh.corner(g, 1), mesh.corner(g, 2), axis) != sign;
        break;
      }
    }
  });
  return away;
}

PointSpace point_space(const MeshView& mesh, const std::vector<unsigned char>& degenerate) {
  PointSpace space{mesh, identify_positions(mesh), {}, {}, {}, {}};
  space.plane_of_facet = find_planes(mesh, degenerate);
  space.faces_away = find_facing_away(mesh, space.plane_of_facet);
  space.find_facets_around();
  return space;
}

}  // namespace

PartedMesh::PartedMesh(const MeshView& mesh, double max_growth)
    : degenerate(find_degenerate_facets(mesh)),
      space(point_space(mesh, degenerate)),
      points(space),
      most_triangles(most_triangles_of(mesh.facet_count(), max_growth)) {
  PartedFacets parted = part_crossing_facets(points, degenerate, most_triangles);
  pieces = std::move(parted.pieces);
  crossing_pairs = parted.crossing_pairs;
  uncut_pairs = parted.uncut_pairs;
  cuts = parted.cuts;
  triangles = count_triangles(points, pieces, parts_to_draw(pieces, mesh.facet_count()));
}

std::size_t PartedMesh::memory_bytes() const {
  return points.memory_bytes() + pieces.memory_bytes() +
         bytes_of(space.position_of_vertex, space.plane_of_facet, space.faces_away, space.around_begin, space.around,
                  degenerate);
}

std::size_t most_triangles_of(std::size_t facets, double max_growth) {
  const double most = max_growth * static_cast<double>(facets);
  return most < 1e18 ? static_cast<std::size_t>(most) : std::size_t{1} << 60;
}

std::vector<std::uint32_t> degenerate_facets(const PartedMesh& parted) {
  std::vector<std::uint32_t> facets;
  for (std::size_t f = 0; f < parted.degenerate.size(); ++f) {
    if (parted.degenerate[f]) facets.push_back(static_cast<std::uint32_t>(f));
  }
  return facets;
}

}  // namespace facetsort::exact_internal
