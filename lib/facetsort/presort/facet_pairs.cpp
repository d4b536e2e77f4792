#include "facetsort/presort/facet_pairs.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::presort_internal {
namespace {

// Facets that share a corner fold over each other along silhouettes, in slivers that few pixels show. Where very many
// share one, what is seen has to do.
constexpr std::size_t most_around_a_corner = 24;
// Pairs farther from each other along a ray than so many times the size of both are right in any order near to depth.
constexpr double most_sizes = 1.5;

using PairKey = std::uint64_t;

PairKey key_of(std::uint32_t a, std::uint32_t b) {
  return (PairKey{std::min(a, b)} << 32) | std::max(a, b);
}

void make_set(std::vector<PairKey>& keys) {
  tbb::parallel_sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

// For each facet the largest distance of a corner from the centroid.
std::vector<double> facet_sizes(const MeshView& mesh) {
  std::vector<double> sizes(mesh.facet_count());
  parallel_ranges(sizes.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t facet = begin; facet < end; ++facet) {
      const glm::dvec3 a(mesh.corner(facet, 0)), b(mesh.corner(facet, 1)), c(mesh.corner(facet, 2));
      const glm::dvec3 centroid = (a + b + c) / 3.0;
      sizes[facet] = std::max({glm::distance(a, centroid), glm::distance(b, centroid), glm::distance(c, centroid)});
    }
  });
  return sizes;
}

std::vector<PairKey> pairs_next_to_each_other(const FragmentLists& lists, std::span<const double> sizes, double gap) {
  std::vector<PairKey> keys;
  for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
    const std::span<const Fragment> fragments = lists.pixel(pixel);
    for (std::size_t i = 1; i < fragments.size(); ++i) {
      const Fragment &far = fragments[i - 1], &near = fragments[i];
      const double distance = far.depth - near.depth;
      if (distance > most_sizes * (sizes[far.facet] + sizes[near.facet]) || distance <= gap) continue;
      keys.push_back(key_of(far.facet, near.facet));
    }
  }
  make_set(keys);
  return keys;
}

void append_pairs_around_corners(const MeshView& mesh, std::vector<PairKey>& keys) {
  std::vector<std::size_t> begins(mesh.vertex_count() + 1, 0);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++begins[triangle[i] + 1];
  }
  std::partial_sum(begins.begin(), begins.end(), begins.begin());
  std::vector<std::uint32_t> facets(begins.back());
  std::vector<std::size_t> cursors(begins.begin(), begins.end() - 1);
  for (std::size_t facet = 0; facet < mesh.facet_count(); ++facet) {
    for (int i = 0; i < 3; ++i) facets[cursors[mesh.triangles[facet][i]]++] = static_cast<std::uint32_t>(facet);
  }
  for (std::size_t vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
    if (begins[vertex + 1] - begins[vertex] > most_around_a_corner) continue;
    for (std::size_t i = begins[vertex]; i < begins[vertex + 1]; ++i) {
      for (std::size_t j = begins[vertex]; j < i; ++j) {
        if (facets[i] != facets[j]) keys.push_back(key_of(facets[i], facets[j]));
      }
    }
  }
}

// +1 or -1 where all of a facet lies on one side of the plane of another, boundary included.
std::int8_t side_of(const MeshView& mesh, std::uint32_t facet, std::uint32_t plane) {
  bool front = false, back = false;
  for (int i = 0; i < 3; ++i) {
    const int side =
        orientation(mesh.corner(plane, 0), mesh.corner(plane, 1), mesh.corner(plane, 2), mesh.corner(facet, i));
    front |= side > 0;
    back |= side < 0;
  }
  return static_cast<std::int8_t>(front - back);
}

// Corners on the picture: x and y in pixels, z the inverse of the distance along the camera axis, which is linear
// there.
using Corners = std::array<glm::dvec3, 3>;

double cross(const glm::dvec2& a, const glm::dvec2& b) {
  return a.x * b.y - a.y * b.x;
}

// What two triangles have in common: its area, and twice that times its centroid.
struct Overlap {
  double area = 0;
  glm::dvec2 centroid{0};
};

// Clips one triangle by the edges of the other (Sutherland and Hodgman 1974, "Reentrant Polygon Clipping").
Overlap overlap(const Corners& a, const Corners& b) {
  const double turn = cross(glm::dvec2(b[1]) - glm::dvec2(b[0]), glm::dvec2(b[2]) - glm::dvec2(b[0])) > 0 ? 1 : -1;
  std::array<glm::dvec2, 7> polygon{glm::dvec2(a[0]), glm::dvec2(a[1]), glm::dvec2(a[2])}, kept;
  std::size_t count = 3;
  for (int edge = 0; edge < 3; ++edge) {
    const glm::dvec2 from(b[edge]), along = turn * (glm::dvec2(b[(edge + 1) % 3]) - from);
    std::size_t kept_count = 0;
    glm::dvec2 previous = polygon[count - 1];
    double previous_side = cross(along, previous - from);
    for (std::size_t i = 0; i < count; ++i) {
      const glm::dvec2 next = polygon[i];
      const double side = cross(along, next - from);
      if ((side > 0) != (previous_side > 0)) {
        kept[kept_count++] = previous + (next - previous) * (previous_side / (previous_side - side));
      }
      if (side > 0) kept[kept_count++] = next;
      previous = next;
      previous_side = side;
    }
    if (kept_count < 3) return {};
    std::swap(polygon, kept);
    count = kept_count;
  }
  Overlap result;
  for (std::size_t i = 2; i < count; ++i) {
    const double twice = std::abs(cross(polygon[i - 1] - polygon[0], polygon[i] - polygon[0]));
    result.area += twice / 2;
    result.centroid += twice / 6 * (polygon[0] + polygon[i - 1] + polygon[i]);
  }
  if (result.area > 0) result.centroid /= result.area;
  return result;
}

// Of the plane through the corners, at a place on the picture.
double inverse_distance(const Corners& corners, const glm::dvec2& at) {
  const glm::dvec2 a(corners[0]), b(corners[1]), c(corners[2]);
  const double u = cross(b - at, c - at), v = cross(c - at, a - at), w = cross(a - at, b - at);
  return (u * corners[0].z + v * corners[1].z + w * corners[2].z) / (u + v + w);
}

// Box of a facet on the picture.
struct PictureBox {
  float left, right, top, bottom;
};

PictureBox box_of(const Corners& corners) {
  const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
  const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
  return {static_cast<float>(left), static_cast<float>(right), static_cast<float>(top), static_cast<float>(bottom)};
}

// Without a branch: nearly all pairs are apart, but which ones can't be foreseen.
bool overlap(const PictureBox& a, const PictureBox& b) {
  return static_cast<bool>(int{a.left < b.right} & int{b.left < a.right} & int{a.top < b.bottom} &
                           int{b.top < a.bottom});
}

}  // namespace

FragmentLists without_back_faces(const MeshView& mesh, const View& view, const FragmentLists& lists) {
  const glm::vec4 eye = view.homogeneous_eye();
  std::vector<char> faces_viewer(mesh.facet_count());
  for (std::size_t facet = 0; facet < faces_viewer.size(); ++facet) {
    faces_viewer[facet] = side_of_plane(mesh.corner(facet, 0), mesh.corner(facet, 1), mesh.corner(facet, 2), eye) > 0;
  }
  FragmentLists kept;
  kept.width = lists.width;
  kept.height = lists.height;
  kept.facets_drawn = lists.facets_drawn;
  kept.offsets.reserve(lists.offsets.size());
  for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
    kept.offsets.push_back(kept.fragments.size());
    for (const Fragment& fragment : lists.pixel(pixel)) {
      if (faces_viewer[fragment.facet]) kept.fragments.push_back(fragment);
    }
  }
  kept.offsets.push_back(kept.fragments.size());
  return kept;
}

PairFinder::PairFinder(const MeshView& mesh, const PairOptions& options)
    : mesh_(mesh), options_(options), sizes_(facet_sizes(mesh)) {
  append_pairs_around_corners(mesh, found_);
  make_set(found_);
}

void PairFinder::add(std::span<const View> views) {
  std::vector<std::vector<PairKey>> of_views(views.size());
  parallel_ranges(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      FragmentLists lists = collect_fragments(mesh_, views[i]);
      if (options_.with_culling) lists = without_back_faces(mesh_, views[i], lists);
      of_views[i] = pairs_next_to_each_other(lists, sizes_, options_.gap);
    }
  });
  for (const std::vector<PairKey>& keys : of_views) found_.insert(found_.end(), keys.begin(), keys.end());
  make_set(found_);
}

std::vector<FacetPair> PairFinder::pairs() {
  std::vector<FacetPair> pairs(found_.size());
  parallel_ranges(found_.size(), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto first = static_cast<std::uint32_t>(found_[i] >> 32), second = static_cast<std::uint32_t>(found_[i]);
      pairs[i] = {first, second, side_of(mesh_, second, first), side_of(mesh_, first, second)};
    }
  });
  found_ = {};
  return pairs;
}

std::vector<SeenPair> seen_pairs(const MeshView& mesh, const View& view, std::span<const FacetPair> pairs,
                                 const PairOptions& options) {
  const Camera camera(view);
  std::vector<glm::dvec3> projected(mesh.vertex_count());
  for (std::size_t vertex = 0; vertex < projected.size(); ++vertex) {
    const glm::dvec3 p = camera.project(glm::dvec3(mesh.positions[vertex]));
    projected[vertex] = {p.x / p.z, p.y / p.z, 1 / p.z};
  }
  const auto corners_of = [&](std::uint32_t facet) -> Corners {
    const glm::uvec3& triangle = mesh.triangles[facet];
    return {projected[triangle[0]], projected[triangle[1]], projected[triangle[2]]};
  };
  struct SeenFacet {
    PictureBox box;
    int facing;
  };
  std::vector<SeenFacet> facets(mesh.facet_count());
  for (std::uint32_t facet = 0; facet < facets.size(); ++facet) {
    const Corners corners = corners_of(facet);
    const double turn = cross(glm::dvec2(corners[1] - corners[0]), glm::dvec2(corners[2] - corners[0]));
    const int facing = (turn < 0) - (turn > 0);  // y points down
    facets[facet] = {box_of(corners), options.with_culling && facing < 0 ? 0 : facing};
  }
  // Whether the second is before or behind the first, by the planes of both: they disagree where the two are seen
  // side by side.
  const auto before_by_first = [&](const FacetPair& pair) {
    return pair.second_from_first * facets[pair.first].facing;
  };
  const auto before_by_second = [&](const FacetPair& pair) {
    return -pair.first_from_second * facets[pair.second].facing;
  };

  std::vector<std::uint32_t> candidates(pairs.size());
  std::size_t candidate_count = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const FacetPair& pair = pairs[i];
    const SeenFacet &first = facets[pair.first], &second = facets[pair.second];
    candidates[candidate_count] = static_cast<std::uint32_t>(i);
    candidate_count += int{overlap(first.box, second.box)} & int{first.facing * second.facing != 0} &
                       int{before_by_first(pair) * before_by_second(pair) >= 0};
  }

  std::vector<SeenPair> seen;
  for (std::size_t i = 0; i < candidate_count; ++i) {
    const FacetPair& pair = pairs[candidates[i]];
    const Corners first = corners_of(pair.first), second = corners_of(pair.second);
    const Overlap common = overlap(first, second);
    const double area = common.area * areas_per_pixel;
    if (!(area >= 1)) continue;
    int before = before_by_first(pair) + before_by_second(pair);
    if (before == 0) {
      before = inverse_distance(second, common.centroid) > inverse_distance(first, common.centroid) ? 1 : -1;
    }
    seen.push_back({candidates[i] & 0x7fffffffu, before < 0, static_cast<std::uint32_t>(area)});
  }
  return seen;
}

}  // namespace facetsort::presort_internal
