#include "order_faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "vertex_rounding.h"

namespace facetsort {
namespace {

using Corners = std::array<glm::vec3, 3>;

Corners corners_of(const Mesh& mesh, std::size_t facet) {
  const MeshView view = mesh.view();
  return {view.corner(facet, 0), view.corner(facet, 1), view.corner(facet, 2)};
}

// An edge between two of a facet's parts, or along one of its sides.
struct PartEdge {
  glm::vec3 first, second;  // in an order that does not depend on the direction
  int direction;            // +1 from first to second, -1 back

  auto key() const { return std::tie(first.x, first.y, first.z, second.x, second.y, second.z); }
};

PartEdge part_edge(const glm::vec3& from, const glm::vec3& to) {
  const bool forward = std::tie(from.x, from.y, from.z) < std::tie(to.x, to.y, to.z);
  return forward ? PartEdge{from, to, 1} : PartEdge{to, from, -1};
}

// A facet that the order draws in parts.
class PartedFacet {
 public:
  PartedFacet(const Mesh& mesh, std::uint32_t facet)
      : rounding_(vertex_rounding(mesh.view(), facet)), corner_{}, normal_(0) {
    const Corners corners = corners_of(mesh, facet);
    for (std::size_t i = 0; i < 3; ++i) corner_[i] = glm::dvec3(corners[i]);
    normal_ = glm::cross(corner_[1] - corner_[0], corner_[2] - corner_[0]);
  }

  bool holds(const Corners& part) const {
    return std::all_of(part.begin(), part.end(), [&](const glm::vec3& p) { return holds_point(glm::dvec3(p)); });
  }

  // Precondition: the facet holds each part.
  bool is_covered_by(std::span<const Corners> parts) const { return edges_join(parts) && areas_add_up(parts); }

 private:
  bool is_on_side(const glm::dvec3& p, std::size_t side) const {
    return distance_to_segment(p, corner_[side], corner_[(side + 1) % 3]) <= rounding_;
  }

  // Sides come first: near them, in a facet thinner than rounding above all, the plane says nothing.
  bool holds_point(const glm::dvec3& p) const {
    if (is_on_side(p, 0) || is_on_side(p, 1) || is_on_side(p, 2)) return true;
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 side = corner_[(i + 1) % 3] - corner_[i];
      if (glm::dot(glm::cross(side, p - corner_[i]), normal_) < 0) return false;
    }
    return std::abs(glm::dot(normal_, p - corner_[0])) <= rounding_ * glm::length(normal_);
  }

  // What is left of the parts' edges when those traversed both ways are taken out is the outline of what the parts
  // cover, counted as often as they do. Where all of it lies along the facet's sides, every point within is covered
  // equally often.
  bool edges_join(std::span<const Corners> parts) const {
    std::vector<PartEdge> edges;
    for (const Corners& part : parts) {
      for (std::size_t i = 0; i < 3; ++i) {
        // Rounding can bring two corners together.
        if (part[i] != part[(i + 1) % 3]) edges.push_back(part_edge(part[i], part[(i + 1) % 3]));
      }
    }
    std::sort(edges.begin(), edges.end(), [](const PartEdge& a, const PartEdge& b) { return a.key() < b.key(); });
    for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
      int balance = 0;
      for (end = begin; end < edges.size() && edges[end].key() == edges[begin].key(); ++end) {
        balance += edges[end].direction;
      }
      if (balance != 0 && !is_along_side(edges[begin])) return false;
    }
    return true;
  }

  bool is_along_side(const PartEdge& edge) const {
    for (std::size_t side = 0; side < 3; ++side) {
      if (is_on_side(glm::dvec3(edge.first), side) && is_on_side(glm::dvec3(edge.second), side)) return true;
    }
    return false;
  }

  // How often the facet is covered, given that it is equally often all over: once, and no part turned over.
  bool areas_add_up(std::span<const Corners> parts) const {
    const double twice_area = glm::length(normal_);
    double sum = 0, sum_of_magnitudes = 0, lengths = outline_length(corner_);
    for (const Corners& part : parts) {
      const std::array<glm::dvec3, 3> p{glm::dvec3(part[0]), glm::dvec3(part[1]), glm::dvec3(part[2])};
      const double twice_part = glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), normal_);
      sum += twice_part;
      sum_of_magnitudes += std::abs(twice_part);
      lengths += outline_length(p);
    }
    // Corners that move by up to the rounding sweep no more than this.
    const double swept = 2 * rounding_ * lengths;
    return std::abs(sum - twice_area * twice_area) <= swept * twice_area &&
           sum_of_magnitudes - sum <= 2 * swept * twice_area;
  }

  static double outline_length(const std::array<glm::dvec3, 3>& p) {
    return glm::length(p[1] - p[0]) + glm::length(p[2] - p[1]) + glm::length(p[0] - p[2]);
  }

  double rounding_;
  std::array<glm::dvec3, 3> corner_;
  glm::dvec3 normal_;  // its length is twice the area
};

struct Part {
  std::uint32_t facet;
  std::size_t place;  // in the order
};

// Judges the parts of one facet. Rounding can make one of them the whole facet, and the rest flat.
void inspect_parts(const OrderFile& file, const Mesh& mesh, std::span<const Part> parts, bool is_whole_too,
                   OrderFaults& faults) {
  const std::uint32_t facet = parts.front().facet;
  const PartedFacet parted(mesh, facet);
  std::vector<Corners> corners;
  std::size_t outside = 0;
  for (const Part& part : parts) {
    corners.push_back(corners_of(*file.mesh, part.place));
    if (parted.holds(corners.back())) continue;
    ++outside;
    if (faults.wrong_corners++ == 0 || part.place < faults.first_wrong_corners) faults.first_wrong_corners = part.place;
  }
  if (outside > 0) return;
  if (is_whole_too) corners.push_back(corners_of(mesh, facet));
  if (parted.is_covered_by(corners)) return;
  if (faults.wrong_cover++ == 0) faults.first_wrong_cover = facet;
}

}  // namespace

OrderContents inspect_order(const OrderFile& file, const Mesh& mesh) {
  OrderContents contents;
  OrderFaults& faults = contents.faults;
  std::vector<unsigned char> whole(mesh.triangles.size()), in_parts(mesh.triangles.size());
  std::vector<Part> parts;
  for (std::size_t place = 0; place < file.ids.size(); ++place) {
    const std::uint32_t id = file.ids[place];
    if (id >= whole.size()) {
      if (faults.out_of_range++ == 0) faults.first_out_of_range = id;
    } else if (file.mesh && corners_of(*file.mesh, place) != corners_of(mesh, id)) {
      in_parts[id] = 1;
      parts.push_back({id, place});
    } else {
      if (whole[id] && faults.repeated++ == 0) faults.first_repeated = id;
      whole[id] = 1;
    }
  }

  std::stable_sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.facet < b.facet; });
  for (std::size_t begin = 0, end = 0; begin < parts.size(); begin = end) {
    while (end < parts.size() && parts[end].facet == parts[begin].facet) ++end;
    ++contents.facets_in_parts;
    inspect_parts(file, mesh, std::span(parts).subspan(begin, end - begin), whole[parts[begin].facet] != 0, faults);
  }
  for (std::size_t facet = 0; facet < whole.size(); ++facet) {
    if (!whole[facet] && !in_parts[facet] && faults.missing++ == 0) {
      faults.first_missing = static_cast<std::uint32_t>(facet);
    }
  }
  return contents;
}

}  // namespace facetsort
