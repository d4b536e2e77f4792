#include "facetsort/exact/order_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/part_sample.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/facets/facets.h"

namespace facetsort::exact_internal {
namespace {

// Subtrees are grown in parallel; there are about `most_subtrees`, each of `fewest_parts` or more but in small meshes.
constexpr std::size_t most_subtrees = 16, fewest_parts = 512;

// Planes tried at a node, for each unit of effort.
constexpr std::size_t facet_planes_tried = 20, edge_planes_tried = 100, moves_tried = 100;

// A part while the tree is grown. Its corners are in the grower's places, in the mesh's frame.
struct Item {
  std::uint32_t part;
  FacetId facet;
  std::uint32_t first_place, place_count;
};

// A node to be made of parts, and where it goes.
struct Job {
  std::vector<Item> items;
  std::uint32_t parent;
  bool in_front;
};

// A plane in the mesh's frame: value(p) has the sign of p's side where its magnitude exceeds `error`.
struct PlaneInFrame {
  glm::dvec3 normal{0}, origin{0};
  double error = 0;

  double value(const glm::dvec3& p) const { return glm::dot(normal, p - origin); }
};

// Grows the nodes of one subtree, on points and pieces of its own that stand on those of a base.
class Grower {
 public:
  Grower(const Points& base, const PartList& base_pieces, const FacetFrame& frame, const TreeOptions& options)
      : points_(&base),
        base_pieces_(base_pieces),
        frame_(frame),
        first_point_(base.size()),
        first_plane_(base.plane_count()),
        first_piece_(facets() + base_pieces.parts.size()),
        most_cuts_(options.most_cuts),
        effort_(options.effort),
        progress_(options.progress) {}
  Grower(const Grower&) = delete;

  // Until what is left are jobs of at most `most_parts`, which are returned.
  std::vector<Job> grow(std::span<const std::uint32_t> parts, std::size_t most_parts) {
    std::vector<Job> jobs, left;
    jobs.push_back({items_of(parts), OrderTree::none, false});
    while (!jobs.empty() && !gave_up()) {
      Job job = std::move(jobs.back());
      jobs.pop_back();
      if (job.items.size() <= most_parts) {
        left.push_back(std::move(job));
      } else {
        make_node(std::move(job), jobs);
      }
    }
    return left;
  }

  bool gave_up() const {
    return tree_.halvings.size() > most_cuts_ ||
           (progress_ != nullptr && progress_->cancelled.load(std::memory_order_relaxed));
  }
  const OrderTree& tree() const { return tree_; }

  // Adds what was grown. Afterwards added_part() and added_node() tell what became of this grower's.
  void add_to(Points& points, DistinctPoints& distinct, PartList& pieces, OrderTree& tree) {
    plane_offset_ = points.plane_count() - first_plane_;
    for (const CutPlane& plane : points_.added_planes()) points.add_plane(plane);
    std::vector<PointId> added(points_.size() - first_point_);
    for (std::size_t i = 0; i < added.size(); ++i) {
      PointDefinition definition = points_.definition(static_cast<PointId>(first_point_ + i));
      if (definition.kind == PointDefinition::three_planes) {
        definition =
            PointDefinition::of_planes(added_plane(definition.a), added_plane(definition.b), added_plane(definition.c));
      } else {
        definition.c = added_plane(definition.c);
      }
      added[i] = distinct.id_of(definition);
    }
    part_offset_ = facets() + pieces.parts.size() - first_piece_;
    std::vector<PartCorner> corners;
    std::vector<Cut> cuts;
    for (const Part& piece : pieces_.parts) {
      corners.assign(pieces_.corners_of(piece).begin(), pieces_.corners_of(piece).end());
      for (PartCorner& corner : corners) {
        if (corner.point >= first_point_) corner.point = added[corner.point - first_point_];
        if (!is_facet_edge(corner.line)) corner.line = added_plane(corner.line);
      }
      cuts.assign(pieces_.cuts_of(piece).begin(), pieces_.cuts_of(piece).end());
      for (Cut& cut : cuts) cut.plane = added_plane(cut.plane);
      pieces.add(piece.facet, corners, cuts);
    }
    add_tree_to(tree);
  }

  std::uint32_t added_part(std::uint32_t part) const {
    return part < first_piece_ ? part : static_cast<std::uint32_t>(part + part_offset_);
  }
  std::uint32_t added_node(std::uint32_t node) const {
    return node == OrderTree::none ? node : static_cast<std::uint32_t>(node + node_offset_);
  }

 private:
  const PointSpace& space() const { return points_.space(); }
  std::size_t facets() const { return space().mesh.facet_count(); }

  PlaneId added_plane(PlaneId plane) const {
    return plane < first_plane_ ? plane : static_cast<PlaneId>(plane + plane_offset_);
  }

  void add_tree_to(OrderTree& tree) {
    node_offset_ = tree.nodes.size();
    const auto member_offset = static_cast<std::uint32_t>(tree.members.size());
    const auto halving_offset = static_cast<std::uint32_t>(tree.halvings.size());
    for (OrderTree::Node node : tree_.nodes) {
      node.plane = added_plane(node.plane);
      node.front = added_node(node.front);
      node.back = added_node(node.back);
      node.first_member += member_offset;
      node.first_halving += halving_offset;
      tree.nodes.push_back(node);
    }
    for (const std::uint32_t part : tree_.members) tree.members.push_back(added_part(part));
    for (const OrderTree::Halving& halving : tree_.halvings) {
      tree.halvings.push_back({added_part(halving.whole), added_part(halving.front), added_part(halving.back)});
    }
  }

  Polygon polygon_of(std::uint32_t part) const {
    if (part < facets()) return whole_facet(space(), part);
    const PartList& list = part < first_piece_ ? base_pieces_ : pieces_;
    const Part& piece = list.parts[part - (part < first_piece_ ? facets() : first_piece_)];
    return {{list.corners_of(piece).begin(), list.corners_of(piece).end()},
            {list.cuts_of(piece).begin(), list.cuts_of(piece).end()}};
  }

  Item item_of(std::uint32_t part, FacetId facet, const Polygon& polygon) {
    const Item item{part, facet, static_cast<std::uint32_t>(places_.size()),
                    static_cast<std::uint32_t>(polygon.corners.size())};
    for (const PartCorner& corner : polygon.corners) {
      places_.push_back((points_.position(corner.point) - frame_.origin) * frame_.scale);
      ids_.push_back(corner.point);
      point_error_ = std::max(point_error_, points_.error(corner.point) * frame_.scale);
    }
    return item;
  }

  std::vector<Item> items_of(std::span<const std::uint32_t> parts) {
    std::vector<Item> items;
    items.reserve(parts.size());
    for (const std::uint32_t part : parts) {
      const FacetId facet = part < facets() ? part : base_pieces_.parts[part - facets()].facet;
      items.push_back(item_of(part, facet, polygon_of(part)));
    }
    return items;
  }

  PlaneInFrame plane_through(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) const {
    const glm::dvec3 origin(a);
    const glm::dvec3 u = (glm::dvec3(b) - origin) * frame_.scale, v = (glm::dvec3(c) - origin) * frame_.scale;
    PlaneInFrame plane{glm::cross(u, v), (origin - frame_.origin) * frame_.scale, 0};
    // Places are below 2 in each coordinate, and off by 2^-51 and the error of points; the normal's coordinates are off
    // by a few of their ulps.
    plane.error = sum_of_magnitudes(u) * sum_of_magnitudes(v) * (0x1p-45 + 4 * point_error_);
    return plane;
  }
  PlaneInFrame plane_of_facet(FacetId facet) const {
    const MeshView& mesh = space().mesh;
    return plane_through(mesh.corner(facet, 0), mesh.corner(facet, 1), mesh.corner(facet, 2));
  }
  PlaneInFrame plane_of(const CutPlane& plane) const {
    return plane_through(space().position(plane.first), space().position(plane.second), space().position(plane.third));
  }

  // Bit 0: has corners on the side of the normal; bit 1: on the other.
  unsigned sides(const PlaneInFrame& plane, PlaneId id, const Item& item) const {
    unsigned sides = 0;
    for (std::uint32_t i = 0; i < item.place_count; ++i) {
      const double value = plane.value(places_[item.first_place + i]);
      int side = value > plane.error ? 1 : value < -plane.error ? -1 : 0;
      if (side == 0) side = points_.side(id, ids_[item.first_place + i]);
      sides |= static_cast<unsigned>(side > 0) | static_cast<unsigned>(side < 0) << 1;
    }
    return sides;
  }

  void take_sample(const std::vector<Item>& items) {
    glm::dvec3 lowest(INFINITY), highest(-INFINITY);
    for (const Item& item : items) {
      for (std::uint32_t i = 0; i < item.place_count; ++i) {
        lowest = glm::min(lowest, places_[item.first_place + i]);
        highest = glm::max(highest, places_[item.first_place + i]);
      }
    }
    sample_.begin(items.size(), lowest, highest);
    // In an order in which the first of them stand for all.
    const std::size_t step = (items.size() + PartSample::most_parts - 1) / PartSample::most_parts;
    for (std::size_t phase = 0; phase < 8; ++phase) {
      for (std::size_t i = phase * step; i < items.size(); i += 8 * step) {
        const Item& item = items[i];
        sample_.add(std::span(places_).subspan(item.first_place, item.place_count));
      }
    }
  }

  // A plane that may divide the parts of a node: that of a facet, or one through three vertices.
  struct Choice {
    CutPlane plane{};
    FacetId facet = OrderTree::none;
    double cost = INFINITY;
  };

  void try_plane(const CutPlane& plane, FacetId facet, Choice& best) const {
    const PlaneInFrame in_frame = plane_of(plane);
    const double cost = sample_.cost(in_frame.normal, in_frame.origin, best.cost);
    if (cost < best.cost) best = {plane, facet, cost};
  }

  // The one of the least cost of some planes of facets, of some through an edge of one facet and a vertex of another,
  // and of those that come of the best by moving one of its three vertices, along an edge of the mesh or anywhere.
  Choice choose_plane(const std::vector<Item>& items) {
    take_sample(items);
    const MeshView& mesh = space().mesh;
    std::uint64_t state = items.size();
    const auto any = [&](std::size_t count) {  // the same numbers for the same parts
      state = state * 6364136223846793005u + 1442695040888963407u;
      return static_cast<std::size_t>(((state >> 32) * count) >> 32);
    };
    const auto any_vertex = [&](FacetId facet) { return mesh.triangles[facet][static_cast<int>(any(3))]; };
    Choice best;
    const std::size_t facet_planes = std::min(items.size(), facet_planes_tried * effort_);
    for (std::size_t i = 0; i < facet_planes; ++i) {
      const FacetId facet = items[i * items.size() / facet_planes].facet;
      try_plane(points_.plane(facet), facet, best);
    }
    const std::size_t edge_planes = std::min(4 * items.size(), edge_planes_tried * effort_);
    for (std::size_t i = 0; i < edge_planes; ++i) {
      const glm::uvec3& edge_of = mesh.triangles[items[i * items.size() / edge_planes].facet];
      const auto edge = static_cast<int>(any(3));
      const PointId apart = any_vertex(items[any(items.size())].facet);
      try_plane({edge_of[edge], edge_of[(edge + 1) % 3], apart}, OrderTree::none, best);
    }
    if (best.cost == INFINITY || sample_.is_hard_to_beat(best.cost)) return best;
    const std::size_t moves = std::min(4 * items.size(), moves_tried * effort_);
    for (std::size_t i = 0; i < moves; ++i) {
      CutPlane moved = best.plane;
      std::uint32_t& vertex = *std::array{&moved.first, &moved.second, &moved.third}[any(3)];
      if (any(2) == 0) {
        const std::span<const FacetId> around = space().facets_around(space().position_of_vertex[vertex]);
        vertex = any_vertex(around[any(around.size())]);
      } else {
        vertex = any_vertex(items[any(items.size())].facet);
      }
      try_plane(moved, OrderTree::none, best);
    }
    return best;
  }

  bool spans_a_plane(const CutPlane& plane) const {
    for (int axis = 0; axis < 3; ++axis) {
      if (normal_sign(space().position(plane.first), space().position(plane.second), space().position(plane.third),
                      axis) != 0) {
        return true;
      }
    }
    return false;
  }

  void make_node(Job job, std::vector<Job>& jobs) {
    FacetId facet = job.items.front().facet;
    if (job.items.size() > 1) {
      const Choice choice = choose_plane(job.items);
      // Rounding may mislead: three vertices may be on a line, or none of the parts in the plane or on one of its
      // sides.
      if (choice.facet != OrderTree::none) {
        facet = choice.facet;
      } else if (choice.cost < INFINITY && spans_a_plane(choice.plane) &&
                 distribute(job, plane_of(choice.plane), points_.add_plane(choice.plane), jobs)) {
        return;
      }
    }
    const FacetId plane = space().plane_of_facet[facet];  // its normal may be the opposite
    distribute(job, plane_of_facet(plane), plane, jobs);
  }

  // Makes a node of the parts of a job, and jobs of what is below it; or returns false, where that would be one that
  // holds all of them.
  bool distribute(const Job& job, const PlaneInFrame& plane, PlaneId id, std::vector<Job>& jobs) {
    std::vector<unsigned> item_sides;
    item_sides.reserve(job.items.size());
    std::array<std::size_t, 4> count{};
    for (const Item& item : job.items) ++count[item_sides.emplace_back(sides(plane, id, item))];
    if (count[0] == 0 && (count[1] == 0 || count[2] == 0)) return false;

    const auto number = static_cast<std::uint32_t>(tree_.nodes.size());
    if (job.parent != OrderTree::none) {
      (job.in_front ? tree_.nodes[job.parent].front : tree_.nodes[job.parent].back) = number;
    }
    OrderTree::Node node{id,
                         OrderTree::none,
                         OrderTree::none,
                         static_cast<std::uint32_t>(tree_.members.size()),
                         0,
                         static_cast<std::uint32_t>(tree_.halvings.size()),
                         0};
    Job front{{}, number, true}, back{{}, number, false};
    front.items.reserve(count[1] + count[3]);
    back.items.reserve(count[2] + count[3]);
    for (std::size_t i = 0; i < job.items.size(); ++i) {
      const Item& item = job.items[i];
      if (item_sides[i] == 0) tree_.members.push_back(item.part);
      if (item_sides[i] == 1) front.items.push_back(item);
      if (item_sides[i] == 2) back.items.push_back(item);
      if (item_sides[i] == 3) halve(item, id, front.items, back.items);
    }
    std::sort(tree_.members.begin() + node.first_member, tree_.members.end());
    node.member_count = static_cast<std::uint32_t>(tree_.members.size()) - node.first_member;
    node.halving_count = static_cast<std::uint32_t>(tree_.halvings.size()) - node.first_halving;
    tree_.nodes.push_back(node);
    if (progress_ != nullptr) {
      progress_->done.fetch_add(node.member_count, std::memory_order_relaxed);
      progress_->all.fetch_add(node.halving_count, std::memory_order_relaxed);
    }
    if (!back.items.empty()) jobs.push_back(std::move(back));
    if (!front.items.empty()) jobs.push_back(std::move(front));
    return true;
  }

  void halve(const Item& item, PlaneId plane, std::vector<Item>& front, std::vector<Item>& back) {
    Polygon halves[2];
    cut_in_two(points_, item.facet, polygon_of(item.part), plane, halves[0], halves[1], corner_sides_);
    std::uint32_t parts[2];
    for (int k = 0; k < 2; ++k) {
      parts[k] = static_cast<std::uint32_t>(first_piece_ + pieces_.parts.size());
      pieces_.add(item.facet, halves[k].corners, halves[k].cuts);
      (k == 0 ? front : back).push_back(item_of(parts[k], item.facet, halves[k]));
    }
    tree_.halvings.push_back({item.part, parts[0], parts[1]});
  }

  Points points_;
  const PartList& base_pieces_;
  FacetFrame frame_;
  std::size_t first_point_, first_plane_, first_piece_, most_cuts_, effort_;
  std::size_t plane_offset_ = 0, part_offset_ = 0, node_offset_ = 0;
  PresortProgress* progress_;
  PartList pieces_;
  OrderTree tree_;
  std::vector<glm::dvec3> places_;  // of corners
  std::vector<PointId> ids_;        // the same
  PartSample sample_;
  std::vector<int> corner_sides_;  // scratch
  double point_error_ = 0;
};

}  // namespace

std::optional<OrderTree> build_order_tree(Points& points, PartList& pieces, std::span<const std::uint32_t> parts,
                                          const TreeOptions& options) {
  const FacetFrame frame = facet_frame(facet_bounds(points.space().mesh));
  const std::size_t points_before = points.size(), planes_before = points.plane_count();
  const std::size_t pieces_before = pieces.parts.size();
  OrderTree tree;
  if (parts.empty()) return tree;
  if (options.progress != nullptr) options.progress->all += parts.size();
  DistinctPoints distinct(points);
  distinct.know_all();

  Grower top(points, pieces, frame, options);
  const std::vector<Job> jobs = top.grow(parts, std::max(fewest_parts, parts.size() / most_subtrees));
  if (top.gave_up()) return std::nullopt;
  top.add_to(points, distinct, pieces, tree);

  std::vector<std::unique_ptr<Grower>> growers(jobs.size());
  parallel_ranges(jobs.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> job_parts;
    for (std::size_t i = begin; i < end; ++i) {
      job_parts.clear();
      for (const Item& item : jobs[i].items) job_parts.push_back(top.added_part(item.part));
      growers[i] = std::make_unique<Grower>(points, pieces, frame, options);
      growers[i]->grow(job_parts, 0);
    }
  });
  std::size_t cuts = tree.halvings.size();
  for (const std::unique_ptr<Grower>& grower : growers) cuts += grower->tree().halvings.size();
  if (cuts > options.most_cuts || (options.progress != nullptr && options.progress->cancelled)) {
    pieces.truncate(pieces_before);
    points.truncate(points_before, planes_before);
    return std::nullopt;
  }
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(tree.nodes.size());
    growers[i]->add_to(points, distinct, pieces, tree);
    growers[i].reset();
    tree.subtrees.push_back({first, static_cast<std::uint32_t>(tree.nodes.size()) - first});
    if (jobs[i].parent == OrderTree::none) continue;
    OrderTree::Node& parent = tree.nodes[top.added_node(jobs[i].parent)];
    (jobs[i].in_front ? parent.front : parent.back) = first;
  }
  return tree;
}

std::optional<OrderTree> build_order_tree(PartedMesh& parted, double max_growth, std::size_t effort,
                                          PresortProgress* progress) {
  if (parted.uncut_pairs > 0) return std::nullopt;
  const std::size_t facets = parted.degenerate.size();
  std::vector<std::uint32_t> with_area = parts_to_draw(parted.pieces, facets);
  std::erase_if(with_area, [&](std::uint32_t part) { return part < facets && parted.degenerate[part]; });
  // A cut makes two parts of one and two corners that neighbours take part in: four triangles at most.
  const std::size_t most = most_triangles_of(facets, max_growth);
  const std::size_t allowed = most > parted.triangles ? (most - parted.triangles) / 4 : 0;
  return build_order_tree(parted.points, parted.pieces, with_area, {allowed, effort, progress});
}

}  // namespace facetsort::exact_internal
