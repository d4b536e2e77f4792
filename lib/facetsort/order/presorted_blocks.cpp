#include "facetsort/order/presorted_blocks.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facetsort/base/memory.h"
#include "facetsort/order/eye_side.h"

namespace facetsort::order_internal {
namespace {

PlaneFrame frame_of(const PresortedView& mesh) {
  if (mesh.nodes.empty()) return {};
  glm::dvec3 lowest(mesh.mesh.positions[mesh.nodes.front().plane.x]), highest = lowest;
  for (const PresortedNode& node : mesh.nodes) {
    for (int i = 0; i < 3; ++i) {
      const glm::dvec3 p(mesh.mesh.positions[node.plane[i]]);
      lowest = glm::min(lowest, p);
      highest = glm::max(highest, p);
    }
  }
  const glm::dvec3 half = 0.5 * (highest - lowest);
  // Half of what would just fit: the origin is rounded.
  const int exponent = std::ilogb(std::max({half.x, half.y, half.z})) + 2;
  return {lowest + half, std::ldexp(1.0, -exponent)};
}

// The plane in the frame, or zero.
glm::vec4 rounded_plane(const PresortedView& mesh, const PlaneFrame& frame, const PresortedNode& node) {
  const glm::dvec3 a(mesh.mesh.positions[node.plane.x]);
  const glm::dvec3 u = glm::dvec3(mesh.mesh.positions[node.plane.y]) - a;
  const glm::dvec3 v = glm::dvec3(mesh.mesh.positions[node.plane.z]) - a;
  glm::dvec3 normal = glm::cross(u, v);
  double largest = 0, error = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    largest = std::max(largest, std::abs(normal[i]));
    error = std::max(error, 0x1p-50 * (std::abs(u[j] * v[k]) + std::abs(u[k] * v[j])));
  }
  constexpr double well_below_float = 0x1p-28;
  if (!(error < well_below_float * largest)) return glm::vec4(0);
  normal /= largest;
  return glm::vec4(normal, -glm::dot(normal, (a - frame.origin) * frame.scale));
}

// Whether two planes in one place face opposite ways. Directions along the axes tell: one of them is off the planes.
bool are_opposite(const MeshView& mesh, const glm::uvec3& first, const glm::uvec3& second) {
  const auto side = [&](const glm::uvec3& plane, int axis) {
    glm::vec4 direction(0);
    direction[axis] = 1;
    return eye_side(mesh.positions[plane.x], mesh.positions[plane.y], mesh.positions[plane.z], direction);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int of_first = side(first, axis);
    if (of_first != 0) return of_first != side(second, axis);
  }
  return false;
}

class BlockMaker {
 public:
  BlockMaker(const PresortedView& mesh, bool culls_back_faces)
      : mesh_(mesh), culls_(culls_back_faces), own_(mesh.nodes.size()), below_(own_), blocks_below_(own_) {
    result_.frame = frame_of(mesh);
    if (culls_) result_.facings.resize(mesh.triangles.size());
  }

  PresortedBlocks make() {
    count_triangles();
    add_loose_blocks();
    add_nodes();
    link_top();
    result_.planes.pad();
    result_.top_planes.pad();
    return std::move(result_);
  }

 private:
  std::size_t node_count(std::size_t node) const {
    return std::size_t{1} + mesh_.nodes[node].front_nodes + mesh_.nodes[node].back_nodes;
  }
  bool is_block(std::size_t node) const {
    return below_[node] <= most_block_triangles && node_count(node) <= most_block_nodes;
  }
  std::size_t front_of(std::size_t node) const { return node + 1; }
  std::size_t back_of(std::size_t node) const { return node + 1 + mesh_.nodes[node].front_nodes; }

  template <typename T>
  T of_front(const std::vector<T>& values, std::size_t node) const {
    return mesh_.nodes[node].front_nodes > 0 ? values[front_of(node)] : T{0};
  }
  template <typename T>
  T of_back(const std::vector<T>& values, std::size_t node) const {
    return mesh_.nodes[node].back_nodes > 0 ? values[back_of(node)] : T{0};
  }

  // Of each node, of all below it, and in how many blocks.
  void count_triangles() {
    std::size_t piece = mesh_.pieces.size();
    for (std::size_t node = mesh_.nodes.size(); node-- > 0;) {
      for (std::uint32_t k = 0; k < mesh_.nodes[node].piece_count; ++k) {
        own_[node] += mesh_.pieces[--piece].triangle_count;
      }
      below_[node] = own_[node] + of_front(below_, node) + of_back(below_, node);
      const auto own_blocks =
          static_cast<std::uint32_t>((own_[node] + most_block_triangles - 1) / most_block_triangles);
      blocks_below_[node] =
          is_block(node) ? 1 : own_blocks + of_front(blocks_below_, node) + of_back(blocks_below_, node);
    }
    loose_pieces_ = piece;
  }

  void begin_block() {
    result_.blocks.push_back({triangle_, static_cast<std::uint32_t>(result_.spots.size()),
                              static_cast<std::uint32_t>(result_.planes.size()),
                              static_cast<std::uint32_t>(result_.branches.size()), 0, 0, 0});
  }

  void end_block() {
    Block& block = result_.blocks.back();
    block.triangle_count = static_cast<std::uint8_t>(triangle_ - block.first_triangle);
    block.plane_count = static_cast<std::uint8_t>(result_.planes.size() - block.first_plane);
    block.branch_count = static_cast<std::uint8_t>(result_.branches.size() - block.first_branch);
    for (std::uint8_t place = 0; result_.spots.size() % triangles_at_a_time != 0; ++place) {
      result_.spots.push_back({end_slot, place});
    }
  }

  void add_plane(std::size_t node) {
    result_.planes.add(rounded_plane(mesh_, result_.frame, mesh_.nodes[node]), static_cast<std::uint32_t>(node));
  }

  // The next triangle, of the next piece that has one left.
  void add_triangle(std::uint8_t slot, std::uint8_t place, Facing facing) {
    result_.spots.push_back({slot, place});
    if (culls_) result_.facings[triangle_] = facing;
    ++triangle_;
  }

  Facing facing_of(std::size_t node, const PresortedPiece& piece) const {
    if (!culls_) return Facing::always;
    const glm::uvec3& facet = mesh_.mesh.triangles[piece.facet];
    return are_opposite(mesh_.mesh, mesh_.nodes[node].plane, facet) ? Facing::back : Facing::front;
  }

  void add_loose_blocks() {
    std::uint32_t left = 0;
    for (; piece_ < loose_pieces_; ++piece_) left += mesh_.pieces[piece_].triangle_count;
    while (left > 0) {
      const auto size = std::min(left, static_cast<std::uint32_t>(most_block_triangles));
      begin_block();
      for (std::uint32_t k = 0; k < size; ++k) add_triangle(0, static_cast<std::uint8_t>(k), Facing::always);
      end_block();
      left -= size;
    }
    result_.loose_blocks = result_.blocks.size();
  }

  void add_nodes() {
    element_.resize(mesh_.nodes.size());
    for (std::size_t node = 0; node < mesh_.nodes.size();) {
      if (is_block(node)) {
        element_[node] = static_cast<std::uint32_t>(result_.blocks.size());
        add_block(node);
        node += node_count(node);
      } else {
        element_[node] = static_cast<std::uint32_t>(result_.top.size());
        add_top_node(node);
        ++node;
      }
    }
  }

  bool has_branches(std::size_t node) const { return mesh_.nodes[node].front_nodes + mesh_.nodes[node].back_nodes > 0; }

  // Level by level: what a node hands down is long known when the nodes below it take it up.
  void add_branches(std::size_t root) {
    level_.clear();
    if (has_branches(root)) level_.push_back(root);
    for (std::size_t k = 0; k < level_.size(); ++k) {
      const std::size_t node = level_[k];
      const auto slot_of_child = [&](std::size_t child, std::uint32_t nodes) {
        if (nodes == 0) return no_slot;
        if (has_branches(child)) level_.push_back(child);
        return static_cast<std::uint8_t>(child - root);
      };
      const std::uint8_t front_slot = slot_of_child(front_of(node), mesh_.nodes[node].front_nodes);
      const std::uint8_t back_slot = slot_of_child(back_of(node), mesh_.nodes[node].back_nodes);
      result_.branches.push_back(
          {static_cast<std::uint8_t>(node - root),
           static_cast<std::uint8_t>(own_[node]),
           {static_cast<std::uint8_t>(of_front(below_, node)), static_cast<std::uint8_t>(of_back(below_, node))},
           {front_slot, back_slot, front_slot}});
      if (!culls_) add_plane(node);
    }
  }

  void add_block(std::size_t root) {
    begin_block();
    add_branches(root);
    const std::size_t end = root + node_count(root);
    for (std::size_t node = root; node < end; ++node) {
      const PresortedNode& from = mesh_.nodes[node];
      const auto slot = static_cast<std::uint8_t>(node - root);
      if (culls_) add_plane(node);
      std::uint8_t place = 0;
      for (std::uint32_t k = 0; k < from.piece_count; ++k) {
        const PresortedPiece& piece = mesh_.pieces[piece_++];
        const Facing facing = facing_of(node, piece);
        for (std::uint32_t t = 0; t < piece.triangle_count; ++t) add_triangle(slot, place++, facing);
      }
    }
    end_block();
  }

  void add_top_node(std::size_t node) {
    TopNode& added = result_.top.emplace_back();
    result_.top_planes.add(rounded_plane(mesh_, result_.frame, mesh_.nodes[node]), static_cast<std::uint32_t>(node));
    added.first_own = static_cast<std::uint32_t>(result_.blocks.size());
    added.front_blocks = of_front(blocks_below_, node);
    added.back_blocks = of_back(blocks_below_, node);
    top_nodes_.push_back(node);
    std::uint8_t place = most_block_triangles;
    for (std::uint32_t k = 0; k < mesh_.nodes[node].piece_count; ++k) {
      const PresortedPiece& piece = mesh_.pieces[piece_++];
      const Facing facing = facing_of(node, piece);
      for (std::uint32_t t = 0; t < piece.triangle_count; ++t) {
        if (place == most_block_triangles) {
          if (added.own_count++ > 0) end_block();
          begin_block();
          if (culls_) add_plane(node);
          place = 0;
        }
        add_triangle(0, place++, facing);
      }
    }
    if (added.own_count > 0) end_block();
  }

  void link_top() {
    const auto top_count = static_cast<std::uint32_t>(result_.top.size());
    const std::uint32_t nothing = top_count + static_cast<std::uint32_t>(result_.blocks.size());
    const auto element = [&](std::size_t node) { return element_[node] + (is_block(node) ? top_count : 0); };
    for (std::size_t i = 0; i < top_count; ++i) {
      const std::size_t node = top_nodes_[i];
      result_.top[i].front = mesh_.nodes[node].front_nodes > 0 ? element(front_of(node)) : nothing;
      result_.top[i].back = mesh_.nodes[node].back_nodes > 0 ? element(back_of(node)) : nothing;
    }
  }

  const PresortedView& mesh_;
  const bool culls_;
  std::vector<std::uint32_t> own_, below_, blocks_below_;  // of each node
  std::vector<std::uint32_t> element_;                     // of each node that is of the top, or a block's root
  std::vector<std::size_t> top_nodes_, level_;
  std::size_t loose_pieces_ = 0, piece_ = 0;  // the next
  std::uint32_t triangle_ = 0;                // the next
  PresortedBlocks result_;
};

std::size_t bytes_of_planes(const PlaneArrays& planes) {
  return bytes_of(planes.x, planes.y, planes.z, planes.offset, planes.node);
}

}  // namespace

void PlaneArrays::add(const glm::vec4& plane, std::uint32_t node_of_plane) {
  x.push_back(plane.x);
  y.push_back(plane.y);
  z.push_back(plane.z);
  offset.push_back(plane.w);
  node.push_back(node_of_plane);
}

void PlaneArrays::pad() {
  constexpr std::size_t longest_vector = 8;
  for (std::vector<float>* values : {&x, &y, &z, &offset}) values->resize(size() + longest_vector);
}

std::size_t PresortedBlocks::memory_bytes() const {
  return bytes_of(blocks, branches, spots, facings, top) + bytes_of_planes(planes) + bytes_of_planes(top_planes);
}

FrameEye frame_eye(const PlaneFrame& frame, const glm::vec4& eye) {
  const glm::dvec4 e = eye.w == 0 ? glm::dvec4(eye) : glm::dvec4((glm::dvec3(eye) - frame.origin) * frame.scale, 1.0);
  const double largest = std::max({std::abs(e.x), std::abs(e.y), std::abs(e.z), e.w});
  return {eye, e * std::ldexp(1.0, -std::ilogb(largest) - 1)};
}

double distance_between(const FrameEye& a, const FrameEye& b) {
  const glm::dvec4 moved = glm::abs(a.in_frame - b.in_frame);
  return moved.x + moved.y + moved.z + 3 * moved.w;
}

PresortedBlocks make_blocks(const PresortedView& mesh, bool culls_back_faces) {
  return BlockMaker(mesh, culls_back_faces).make();
}

}  // namespace facetsort::order_internal
