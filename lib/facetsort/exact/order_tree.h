// Internal to exact: a tree of planes over the parts of a mesh, from which a back-to-front order can be read for any
// eye (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree Structures").
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/exact/parted_mesh.h"
#include "facetsort/exact/parts.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/presort.h"

namespace facetsort::exact_internal {

// Parts are told by draw id: facets below the mesh's facet count, then pieces.
struct OrderTree {
  static constexpr std::uint32_t none = 0xffffffffu;

  // What is on both sides of a plane, which goes through vertices only. Seen from one side, all beyond the plane is
  // behind all before it, and what lies in the plane is between them.
  struct Node {
    PlaneId plane;
    std::uint32_t front, back;                   // nodes on the side of the plane's normal, and on the other; or none
    std::uint32_t first_member, member_count;    // parts in the plane
    std::uint32_t first_halving, halving_count;  // parts that the plane cuts in two
  };

  struct Halving {
    std::uint32_t whole, front, back;
  };

  // Nodes in a row: one, and all that are below it.
  struct Subtree {
    std::uint32_t first_node, node_count;
  };

  std::vector<Node> nodes;  // each before those below it: those at the top, then the subtrees; the first is the root
  std::vector<std::uint32_t> members;
  std::vector<Halving> halvings;
  std::vector<Subtree> subtrees;

  std::span<const std::uint32_t> members_of(const Node& node) const {
    return std::span(members).subspan(node.first_member, node.member_count);
  }
  std::span<const Halving> halvings_of(const Node& node) const {
    return std::span(halvings).subspan(node.first_halving, node.halving_count);
  }
  // The one that begins with a node. Precondition: one does.
  const Subtree& subtree_at(std::uint32_t first_node) const {
    return *std::lower_bound(subtrees.begin(), subtrees.end(), first_node,
                             [](const Subtree& subtree, std::uint32_t node) { return subtree.first_node < node; });
  }
  // Nodes that are in no subtree.
  std::size_t top_nodes() const { return subtrees.empty() ? nodes.size() : subtrees.front().first_node; }
  std::size_t memory_bytes() const { return bytes_of(nodes, members, halvings, subtrees); }
};

struct TreeOptions {
  std::size_t most_cuts;
  std::size_t effort = 1;  // planes tried at each node, in units: more time, fewer cuts
  PresortProgress* progress = nullptr;
};

// Builds a tree over parts with area that do not cross. Halves are added to `pieces`, points and planes to `points`.
// Nothing, and then nothing is added, where that would take more than `most_cuts`, or where it was cancelled. Parallel in
// the caller's task arena; the result does not depend on the thread count.
std::optional<OrderTree> build_order_tree(Points& points, PartList& pieces, std::span<const std::uint32_t> parts,
                                          const TreeOptions& options);

// The same over all parts with area of a mesh. Nothing also where some of its facets still cross, or where the triangles
// out over facets in would be more than `max_growth`.
std::optional<OrderTree> build_order_tree(PartedMesh& parted, double max_growth, std::size_t effort,
                                          PresortProgress* progress);

}  // namespace facetsort::exact_internal
