// Presorted meshes for tests and benchmarks of what reads them: the tree of the exact order, written down as it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "facetsort/exact/crossings.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/positions.h"
#include "facetsort/exact/triangulation.h"
#include "facetsort/mesh/mesh.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort {

class OrderTreeData {
 public:
  // The tree of a mesh that has one: any that is cut by no more than a hundred planes a facet.
  static PresortedData of(const Mesh& mesh) { return OrderTreeData(mesh).make(); }

 private:
  explicit OrderTreeData(const Mesh& mesh)
      : mesh_(mesh), degenerate_(exact_internal::find_degenerate_facets(mesh.view())), points_(space()) {}

  const exact_internal::PointSpace& space() {
    const MeshView view = mesh_.view();
    space_.mesh = view;
    space_.position_of_vertex = exact_internal::identify_positions(view);
    space_.plane_of_facet.resize(view.facet_count());
    std::iota(space_.plane_of_facet.begin(), space_.plane_of_facet.end(), 0u);
    space_.faces_away.assign(view.facet_count(), 0);
    space_.find_facets_around();
    return space_;
  }

  PresortedData make() {
    const std::size_t facets = mesh_.triangles.size();
    parts_ = exact_internal::part_crossing_facets(points_, degenerate_, 1'000'000'000).pieces;
    std::vector<std::uint32_t> with_area;
    for (const std::uint32_t part : exact_internal::parts_to_draw(parts_, facets)) {
      (part < facets && degenerate_[part] ? order_ : with_area).push_back(part);
    }
    tree_ = exact_internal::build_order_tree(points_, parts_, with_area, 100 * facets);
    data_.positions = mesh_.positions;
    data_.facets = mesh_.triangles;
    if (!with_area.empty()) write_nodes();
    write_pieces();
    return std::move(data_);
  }

  // In preorder, from a stack, with the parts in each.
  void write_nodes() {
    std::vector<std::uint32_t> below(tree_->nodes.size(), 1);
    const auto count = [&](std::uint32_t node) { return node == exact_internal::OrderTree::none ? 0 : below[node]; };
    for (std::size_t i = below.size(); i-- > 0;) {
      below[i] += count(tree_->nodes[i].front) + count(tree_->nodes[i].back);
    }
    std::vector<std::uint32_t> left{0};
    while (!left.empty()) {
      const exact_internal::OrderTree::Node& node = tree_->nodes[left.back()];
      left.pop_back();
      const CutPlane plane = points_.plane(node.plane);
      data_.nodes.push_back(
          {{plane.first, plane.second, plane.third}, node.member_count, count(node.front), count(node.back)});
      for (const std::uint32_t part : tree_->members_of(node)) order_.push_back(part);
      for (const std::uint32_t next : {node.back, node.front}) {
        if (next != exact_internal::OrderTree::none) left.push_back(next);
      }
    }
  }

  std::uint32_t facet_of(std::uint32_t part) const {
    const std::size_t facets = mesh_.triangles.size();
    return part < facets ? part : parts_.parts[part - facets].facet;
  }

  void write_pieces() {
    // Triangles tell their facet only: between two parts of one facet another facet is drawn, and taken out again.
    std::vector<std::uint32_t> drawn;
    std::vector<unsigned char> is_separator;
    for (const std::uint32_t part : order_) {
      if (!drawn.empty() && facet_of(drawn.back()) == facet_of(part)) {
        drawn.push_back(facet_of(part) == 0 ? 1 : 0);
        is_separator.push_back(1);
      }
      drawn.push_back(part);
      is_separator.push_back(0);
    }
    const OrderedTriangles all = exact_internal::triangulate(points_, parts_, drawn);
    for (const CutVertex& vertex : all.vertices) {
      data_.made_vertices.push_back({vertex.facet, vertex.barycentric});
      data_.made_positions.push_back(vertex.position);
    }
    std::size_t t = 0;
    for (std::size_t k = 0; k < drawn.size(); ++k) {
      const std::uint32_t facet = facet_of(drawn[k]);
      PresortedPiece piece{facet, 0, 0};
      for (; t < all.source.size() && all.source[t] == facet; ++t) {
        if (is_separator[k]) continue;
        data_.triangles.push_back(all.triangles[t]);
        ++piece.triangle_count;
      }
      if (is_separator[k]) continue;
      if (drawn[k] >= mesh_.triangles.size()) {
        const auto cuts = parts_.cuts_of(parts_.parts[drawn[k] - mesh_.triangles.size()]);
        data_.cuts.insert(data_.cuts.end(), cuts.begin(), cuts.end());
        piece.cut_count = static_cast<std::uint32_t>(cuts.size());
      }
      data_.pieces.push_back(piece);
    }
    data_.planes.assign(points_.added_planes().begin(), points_.added_planes().end());
  }

  const Mesh& mesh_;
  std::vector<unsigned char> degenerate_;
  exact_internal::PointSpace space_;
  exact_internal::Points points_;
  exact_internal::PartList parts_;
  std::optional<exact_internal::OrderTree> tree_;
  std::vector<std::uint32_t> order_;  // parts: those without area, then those of each node
  PresortedData data_;
};

}  // namespace facetsort
