// Internal to exact: a bounding-volume hierarchy over facets, which proposes pairs.
#pragma once

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <utility>
#include <vector>

#include "facetsort/mesh/mesh_view.h"

namespace facetsort::exact_internal {

struct Bounds {
  glm::vec3 lowest, highest;

  void include(const Bounds& other) {
    lowest = glm::min(lowest, other.lowest);
    highest = glm::max(highest, other.highest);
  }
  bool overlaps(const Bounds& other) const {
    return lowest.x <= other.highest.x && other.lowest.x <= highest.x && lowest.y <= other.highest.y &&
           other.lowest.y <= highest.y && lowest.z <= other.highest.z && other.lowest.z <= highest.z;
  }
};

// A balanced binary tree over facets in which the ranges of items, and so the shape of the tree, follow from the count
// alone: the children of node n, 2 n + 1 and 2 n + 2, halve its range, and all leaves are on one level.
class FacetHierarchy {
 public:
  static constexpr std::uint32_t no_group = 0xffffffffu;

  struct Item {
    Bounds bounds;
    std::uint32_t facet;
    std::uint32_t group;  // of items whose pairs are not asked for; or no_group
  };

  explicit FacetHierarchy(std::vector<Item> items) : items_(std::move(items)) {
    if (items_.empty()) return;
    while (items_.size() >> levels_ > most_items_of_leaf) ++levels_;
    nodes_.resize((std::size_t{2} << levels_) - 1);
    build(0, 0, items_.size(), levels_);
  }

  const std::vector<Item>& items() const { return items_; }

  // Calls visit(facet) for each item after position `first` whose bounds overlap those of the item at `first` and that is
  // not of that item's group.
  template <typename Visit>
  void for_each_later_overlap(std::size_t first, const Visit& visit) const {
    const Item& item = items_[first];
    for_each_overlap(item.bounds, first + 1, item.group, visit);
  }

  // Calls visit(facet) for each item whose bounds overlap these.
  template <typename Visit>
  void for_each_overlap(const Bounds& bounds, const Visit& visit) const {
    for_each_overlap(bounds, 0, no_group, visit);
  }

 private:
  struct Node {
    Bounds bounds;
    std::uint32_t group;  // that all its items are of; or no_group

    void include(const Node& other) {
      bounds.include(other.bounds);
      if (group != other.group) group = no_group;
    }
  };

  template <typename Visit>
  void for_each_overlap(const Bounds& bounds, std::size_t first, std::uint32_t group, const Visit& visit) const {
    struct Range {
      std::size_t node, begin, end;
    };
    const auto is_passed_over = [&](std::uint32_t other) { return other == group && group != no_group; };
    const std::size_t first_leaf = nodes_.size() / 2;
    std::array<Range, 64> stack;
    std::size_t depth = 0;
    if (!items_.empty()) stack[depth++] = {0, 0, items_.size()};
    while (depth > 0) {
      const auto [node, begin, end] = stack[--depth];
      if (end <= first || !nodes_[node].bounds.overlaps(bounds) || is_passed_over(nodes_[node].group)) continue;
      if (node < first_leaf) {
        const std::size_t middle = begin + (end - begin) / 2;
        stack[depth++] = {2 * node + 2, middle, end};
        stack[depth++] = {2 * node + 1, begin, middle};
        continue;
      }
      for (std::size_t i = std::max(begin, first); i < end; ++i) {
        if (items_[i].bounds.overlaps(bounds) && !is_passed_over(items_[i].group)) visit(items_[i].facet);
      }
    }
  }

  static constexpr std::size_t most_items_of_leaf = 4;
  static constexpr std::size_t items_per_task = 1024;

  // Splits at the median of the box centres along the axis in which they spread most. Ties go by facet id, so that the
  // tree is the same each time.
  void build(std::size_t node, std::size_t begin, std::size_t end, int levels) {
    if (levels == 0) {
      nodes_[node] = {items_[begin].bounds, items_[begin].group};
      for (std::size_t i = begin + 1; i < end; ++i) nodes_[node].include({items_[i].bounds, items_[i].group});
      return;
    }
    const auto centre = [](const Item& item) { return 0.5f * item.bounds.lowest + 0.5f * item.bounds.highest; };
    Bounds spread{centre(items_[begin]), centre(items_[begin])};
    for (std::size_t i = begin + 1; i < end; ++i) spread.include({centre(items_[i]), centre(items_[i])});
    const glm::vec3 extent = 0.5f * spread.highest - 0.5f * spread.lowest;  // halves: the difference may overflow
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end,
                     [&](const Item& a, const Item& b) {
                       const float x = centre(a)[axis], y = centre(b)[axis];
                       return x < y || (x == y && a.facet < b.facet);
                     });
    const auto build_left = [&] { build(2 * node + 1, begin, middle, levels - 1); };
    const auto build_right = [&] { build(2 * node + 2, middle, end, levels - 1); };
    if (end - begin > items_per_task) {
      tbb::parallel_invoke(build_left, build_right);
    } else {
      build_left();
      build_right();
    }
    nodes_[node] = nodes_[2 * node + 1];
    nodes_[node].include(nodes_[2 * node + 2]);
  }

  std::vector<Item> items_;
  std::vector<Node> nodes_;
  int levels_ = 0;
};

// Over all facets but the degenerate ones. `group_of_facet` is empty where there are no groups.
inline FacetHierarchy hierarchy_of(const MeshView& mesh, const std::vector<unsigned char>& degenerate,
                                   const std::vector<std::uint32_t>& group_of_facet = {}) {
  std::vector<FacetHierarchy::Item> items;
  items.reserve(mesh.facet_count());
  for (std::size_t f = 0; f < mesh.facet_count(); ++f) {
    if (degenerate[f]) continue;
    const glm::vec3 a = mesh.corner(f, 0), b = mesh.corner(f, 1), c = mesh.corner(f, 2);
    items.push_back({{glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))},
                     static_cast<std::uint32_t>(f),
                     group_of_facet.empty() ? FacetHierarchy::no_group : group_of_facet[f]});
  }
  return FacetHierarchy(std::move(items));
}

}  // namespace facetsort::exact_internal
