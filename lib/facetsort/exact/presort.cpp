#include "facetsort/exact/presort.h"

#include <cstdint>
#include <utility>
#include <vector>

#include "facetsort/base/stopwatch.h"
#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/parted_mesh.h"
#include "facetsort/exact/triangulation.h"

namespace facetsort {

using namespace exact_internal;

namespace {

// The nodes of a tree in preorder, and the draw ids of their members, without recursion: trees may be deep.
class Preorder {
 public:
  Preorder(const OrderTree& tree, const Points& points, std::vector<std::uint32_t>& drawn)
      : tree_(tree), points_(points), drawn_(drawn) {
    count_below();
    visit();
  }

  std::vector<PresortedNode> nodes;

 private:
  std::uint32_t below(std::uint32_t node) const { return node == OrderTree::none ? 0 : below_[node]; }

  // Nodes come before those below them.
  void count_below() {
    below_.resize(tree_.nodes.size());
    for (std::size_t i = below_.size(); i-- > 0;) {
      below_[i] = 1 + below(tree_.nodes[i].front) + below(tree_.nodes[i].back);
    }
  }

  void visit() {
    std::vector<std::uint32_t> waiting;
    if (!tree_.nodes.empty()) waiting.push_back(0);
    nodes.reserve(tree_.nodes.size());
    while (!waiting.empty()) {
      const OrderTree::Node& node = tree_.nodes[waiting.back()];
      waiting.pop_back();
      const CutPlane plane = points_.plane(node.plane);
      nodes.push_back(
          {{plane.first, plane.second, plane.third}, node.member_count, below(node.front), below(node.back)});
      const std::span<const std::uint32_t> members = tree_.members_of(node);
      drawn_.insert(drawn_.end(), members.begin(), members.end());
      if (node.back != OrderTree::none) waiting.push_back(node.back);
      if (node.front != OrderTree::none) waiting.push_back(node.front);
    }
  }

  const OrderTree& tree_;
  const Points& points_;
  std::vector<std::uint32_t>& drawn_;
  std::vector<std::uint32_t> below_;
};

void take_pieces(const PartedMesh& parted, std::span<const std::uint32_t> drawn, TriangulatedParts&& triangulated,
                 PresortedData& data) {
  const std::size_t facets = parted.degenerate.size();
  data.pieces.reserve(drawn.size());
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    PresortedPiece piece{drawn[i], triangulated.counts[i], 0};
    if (drawn[i] >= facets) {
      const Part& part = parted.pieces.parts[drawn[i] - facets];
      const std::span<const Cut> cuts = parted.pieces.cuts_of(part);
      piece.facet = part.facet;
      piece.cut_count = part.cut_count;
      data.cuts.insert(data.cuts.end(), cuts.begin(), cuts.end());
    }
    data.pieces.push_back(piece);
  }
  data.planes.assign(parted.points.added_planes().begin(), parted.points.added_planes().end());
  data.triangles = std::move(triangulated.triangles.triangles);
  data.made_vertices.reserve(triangulated.triangles.vertices.size());
  data.made_positions.reserve(triangulated.triangles.vertices.size());
  for (const CutVertex& vertex : triangulated.triangles.vertices) {
    data.made_vertices.push_back({vertex.facet, vertex.barycentric});
    data.made_positions.push_back(vertex.position);
  }
}

template <class T>
std::vector<T> copy_of(std::span<const T> values) {
  return {values.begin(), values.end()};
}

}  // namespace

std::optional<Presorted> presort(const MeshView& mesh, const PresortOptions& options, PresortProgress* progress) {
  std::optional<Presorted> result(std::in_place);
  PresortedData& data = result->data;
  PresortStatistics& statistics = result->statistics;
  Stopwatch stopwatch;
  PartedMesh parted(mesh, options.max_growth);
  statistics.crossing_pairs = parted.crossing_pairs;
  statistics.crossing_cuts = parted.cuts;
  statistics.part_ms = stopwatch.lap();

  std::vector<std::uint32_t> drawn = degenerate_facets(parted);
  {
    const std::optional<OrderTree> tree = build_order_tree(parted, options.max_growth, options.effort, progress);
    if (!tree) return std::nullopt;
    statistics.tree_cuts = tree->halvings.size();
    data.nodes = std::move(Preorder(*tree, parted.points, drawn).nodes);
  }
  statistics.tree_ms = stopwatch.lap();

  take_pieces(parted, drawn, triangulate_parts(parted.points, parted.pieces, drawn), data);
  data.positions = copy_of(mesh.positions);
  data.facets = copy_of(mesh.triangles);
  data.facet_colours = copy_of(mesh.facet_colours);
  data.vertex_colours = copy_of(mesh.vertex_colours);
  statistics.nodes = data.nodes.size();
  statistics.pieces = data.pieces.size();
  statistics.triangles = data.triangles.size();
  statistics.triangulate_ms = stopwatch.lap();
  return result;
}

}  // namespace facetsort
