// The order by depth, mended where it is wrong.
//
// Facets come in the order of a depth key, as in a painter's algorithm (Newell, Newell and Sancha 1972, "A Solution to
// the Hidden Surface Problem"), but what must come before what is decided exactly, and of all the constraints only
// those are found that matter (see Precedence): those that the key order breaks, and those that drawing a part ahead of
// its turn would break. Then the key order is walked, depth first into what a part needs to have been drawn before it:
// Tarjan's algorithm (see ComponentFinder). The components that it finds are cycles, and are cut.
#include "facetsort/exact/exact_sorter.h"

#include <tbb/combinable.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/base/stopwatch.h"
#include "facetsort/exact/cycles.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/hiding_graph.h"
#include "facetsort/exact/order_tree.h"
#include "facetsort/exact/parted_mesh.h"
#include "facetsort/exact/precedence.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/exact/presorted_order.h"
#include "facetsort/exact/relation.h"
#include "facetsort/exact/screen.h"
#include "facetsort/exact/tree_order.h"
#include "facetsort/exact/triangulation.h"
#include "facetsort/order/key_sort.h"

namespace facetsort {

using namespace exact_internal;

namespace {

// Beyond this a tree costs more than it saves.
constexpr double most_tree_growth = 32;

// A place in the order as it is found: a draw id, or a cycle to be filled in.
constexpr std::uint32_t cycle_mark = 0x80000000u;

struct Cycle {
  std::vector<std::uint32_t> elements;  // farthest first
  std::vector<HidingPair> pairs;        // by place in `elements`
};

}  // namespace

struct ExactSorter::State {
  State(const MeshView& mesh_in, const ExactOptions& options_in)
      : options(options_in),
        mesh(mesh_in),
        presorted(presort_if_asked()),
        parted(presorted ? MeshView{} : mesh_in, options_in.max_growth) {}
  explicit State(const PresortedView& view)
      : options{.from = OrderFrom::presorted},
        mesh(view.mesh),
        presorted(std::make_unique<PresortedOrder>(view)),
        parted({}, 1) {}

  std::unique_ptr<PresortedOrder> presort_if_asked() const {
    if (options.from != OrderFrom::presorted) return nullptr;
    std::optional<Presorted> result = presort(mesh, {.max_growth = std::min(options.max_growth, most_tree_growth)});
    return result ? std::make_unique<PresortedOrder>(std::move(*result)) : nullptr;
  }

  std::size_t bytes_held() const;
  void prepare();
  bool prepare_tree();
  void tell_presorted();
  void forget_last_view();
  void order_from_tree(const Eye& eye);
  void order_from_pairs(const Eye& eye);
  void walk();
  void add_cycle(std::span<const std::uint32_t> ranks);
  void fill_in_cycles();

  Stopwatch construction;
  ExactOptions options;
  MeshView mesh;
  std::unique_ptr<PresortedOrder> presorted;
  PartedMesh parted;                // of nothing, where the mesh is presorted
  Points& points = parted.points;   // vertices, those of prepared pieces, then those of the last view
  PartList& parts = parted.pieces;  // prepared pieces, then those of the last view
  std::vector<Piece> pieces;        // the same, for drawing
  bool triangles_counted = false;   // of the last view
  std::optional<Eye> last_eye;
  std::size_t prepared_pieces = 0, prepared_points = 0, prepared_bytes = 0;
  std::optional<OrderTree> tree;
  std::vector<std::uint32_t> without_area;  // draw ids, where there is a tree
  Elements elements;
  ExactStatistics statistics;

  Screen screen;
  std::vector<float> keys;  // by draw id
  KeySort key_sort;
  TreeWalk tree_walk;
  RejoinedOrder rejoined_order;
  Precedence precedence;
  ComponentFinder component_finder;
  std::vector<std::uint32_t> order;  // draw ids and cycles
  std::vector<std::uint32_t> filled_order;
  std::vector<Cycle> cycles;
};

namespace {

Piece piece_of(const Part& part) {
  return {part.facet, part.first_cut, part.cut_count};
}

}  // namespace

void ExactSorter::State::prepare() {
  if (presorted) {
    tell_presorted();
    return;
  }
  statistics.crossing_pairs = parted.crossing_pairs;
  statistics.crossing_pairs_uncut = parted.uncut_pairs;
  statistics.prepared_cuts = parted.cuts;
  std::vector<std::uint32_t> drawn = parts_to_draw(parts, mesh.facet_count());
  statistics.prepared_pieces = drawn.size();
  if (options.from != OrderFrom::tree || !prepare_tree()) {
    sort_spatially(points, parts, drawn);
    elements = make_elements(points, parts, parted.degenerate, drawn, parted.uncut_pairs == 0);
  }
  prepared_pieces = parts.parts.size();
  prepared_points = points.size();
  for (const Part& part : parts.parts) pieces.push_back(piece_of(part));
  order = filled_order = std::move(drawn);
  prepared_bytes = bytes_held();
  statistics.prepare_ms = construction.lap();
}

// Builds the tree, and elements in its order, or returns false.
bool ExactSorter::State::prepare_tree() {
  tree = build_order_tree(parted, std::min(options.max_growth, most_tree_growth), 1, nullptr);
  if (!tree) return false;
  without_area = degenerate_facets(parted);
  statistics.tree_nodes = tree->nodes.size();
  statistics.tree_cuts = tree->halvings.size();
  tree_walk.prepare(points, *tree, RejoinedOrder::places_per_block);
  std::vector<std::uint32_t> all = without_area;
  for (const OrderTree::Node& node : tree->nodes) {
    for (const std::uint32_t part : tree->members_of(node)) all.push_back(part);
    for (const OrderTree::Halving& halving : tree->halvings_of(node)) all.push_back(halving.whole);
  }
  elements = make_elements(points, parts, parted.degenerate, all, false);
  find_outline_ids(points, parts, elements);
  rejoined_order.prepare(*tree, elements);
  return true;
}

void ExactSorter::State::tell_presorted() {
  const PresortStatistics& made = presorted->statistics();
  statistics.crossing_pairs = made.crossing_pairs;
  statistics.prepared_cuts = made.crossing_cuts;
  statistics.prepared_pieces = made.pieces - made.tree_cuts;
  statistics.tree_nodes = made.nodes;
  statistics.tree_cuts = statistics.view_cuts = made.tree_cuts;  // the same pieces from everywhere
  statistics.triangles = made.triangles;
  triangles_counted = true;
  prepared_bytes = presorted->memory_bytes();
  statistics.prepare_ms = construction.lap();
}

void ExactSorter::State::forget_last_view() {
  parts.truncate(prepared_pieces);
  pieces.resize(prepared_pieces);
  points.truncate(prepared_points);
}

// What construction made.
std::size_t ExactSorter::State::bytes_held() const {
  return parted.memory_bytes() + elements.memory_bytes() + bytes_of(pieces, without_area) +
         (presorted ? presorted->memory_bytes() : 0) + (tree ? tree->memory_bytes() : 0) + tree_walk.prepared_bytes() +
         rejoined_order.prepared_bytes();
}

void ExactSorter::State::add_cycle(std::span<const std::uint32_t> ranks) {
  Cycle& cycle = cycles.emplace_back();
  for (std::uint32_t place = 0; place < ranks.size(); ++place) {
    cycle.elements.push_back(precedence.element_at()[ranks[place]]);
    for (const std::uint32_t behind : precedence.behind()[ranks[place]]) {
      const auto found = std::lower_bound(ranks.begin(), ranks.end(), behind);
      if (found == ranks.end() || *found != behind) continue;
      cycle.pairs.push_back({static_cast<std::uint32_t>(found - ranks.begin()), place});
    }
  }
  order.push_back(cycle_mark | static_cast<std::uint32_t>(cycles.size() - 1));
}

void ExactSorter::State::walk() {
  order.clear();
  cycles.clear();
  const NodeLists& components = component_finder.find(precedence.behind());
  for (std::size_t i = 0; i < components.count(); ++i) {
    const std::span<const std::uint32_t> ranks = components[i];
    if (ranks.size() == 1) {
      order.push_back(elements.draw_id[precedence.element_at()[ranks.front()]]);
    } else {
      add_cycle(ranks);
    }
  }
}

void ExactSorter::State::fill_in_cycles() {
  statistics.components = cycles.size();
  statistics.pieces_in_cycles = statistics.largest_component = 0;
  statistics.view_cuts = statistics.unordered_pairs = 0;
  for (const Cycle& cycle : cycles) {
    statistics.pieces_in_cycles += cycle.elements.size();
    statistics.largest_component = std::max(statistics.largest_component, cycle.elements.size());
  }
  if (cycles.empty()) return;
  std::vector<OrderedCycle> ordered;
  ordered.reserve(cycles.size());
  for (std::size_t c = 0; c < cycles.size(); ++c) ordered.push_back({Points(&points), {}, {}, 0, false});
  const std::size_t limit = parted.most_triangles;
  const std::size_t most_cuts = limit > parted.triangles ? (limit - parted.triangles) / 2 : 0;
  tbb::combinable<unsigned long long> fallbacks;
  tbb::parallel_for(std::size_t{0}, cycles.size(), [&](std::size_t c) {
    const unsigned long long before = exact_fallbacks();
    std::vector<CycleMember> members;
    for (const std::uint32_t element : cycles[c].elements) {
      const std::uint32_t id = elements.draw_id[element];
      CycleMember& member = members.emplace_back(CycleMember{elements.facet[element], screen.facing(element), {}, {}});
      if (id < mesh.facet_count()) {
        member.corners = whole_facet(parted.space, id).corners;
      } else {
        const Part& part = parts.parts[id - mesh.facet_count()];
        member.corners.assign(parts.corners_of(part).begin(), parts.corners_of(part).end());
        member.cuts.assign(parts.cuts_of(part).begin(), parts.cuts_of(part).end());
      }
    }
    ordered[c] = order_cycle(points, screen.viewpoint(), members, cycles[c].pairs, most_cuts);
    fallbacks.local() += exact_fallbacks() - before;
  });
  fallbacks.combine_each([&](unsigned long long n) { statistics.predicate_fallbacks += n; });

  std::size_t triangles = parted.triangles;
  filled_order.clear();
  DistinctPoints made(points);
  std::vector<PartCorner> corners;
  const std::size_t points_before = points.size();
  for (const std::uint32_t entry : order) {
    if ((entry & cycle_mark) == 0) {
      filled_order.push_back(entry);
      continue;
    }
    const Cycle& cycle = cycles[entry & ~cycle_mark];
    const OrderedCycle& result = ordered[entry & ~cycle_mark];
    const std::size_t added = 2 * count_new_corners(result.points, result.pieces, points_before);
    if (result.gave_up || triangles + added > limit) {
      for (const std::uint32_t element : cycle.elements) filled_order.push_back(elements.draw_id[element]);
      for (const HidingPair& pair : cycle.pairs) statistics.unordered_pairs += pair.first > pair.second;
      continue;
    }
    triangles += added;
    statistics.view_cuts += result.cuts;
    for (const OrderedPart& part : result.order) {
      if (part.is_whole) {
        filled_order.push_back(elements.draw_id[cycle.elements[part.member]]);
        continue;
      }
      const Part& piece = result.pieces.parts[part.piece];
      corners.assign(result.pieces.corners_of(piece).begin(), result.pieces.corners_of(piece).end());
      for (PartCorner& corner : corners) {
        if (corner.point >= points_before) corner.point = made.id_of(result.points.definition(corner.point));
      }
      filled_order.push_back(static_cast<std::uint32_t>(mesh.facet_count() + parts.parts.size()));
      parts.add(piece.facet, corners, result.pieces.cuts_of(piece));
      pieces.push_back(piece_of(parts.parts.back()));
    }
  }
  std::swap(order, filled_order);
  filled_order.reserve(order.capacity());  // so that either will do for the next view
}

void ExactSorter::State::order_from_tree(const Eye& eye) {
  Stopwatch stopwatch;
  order.assign(without_area.begin(), without_area.end());
  screen.look(points, elements, eye, keys);
  statistics.project_ms = stopwatch.lap();
  const Relation relation(points, parts, elements, screen);
  rejoined_order.find(tree_walk, relation, screen, elements, order);
  const RejoiningCounts& counts = rejoined_order.counts();
  statistics.candidate_pairs = counts.candidate_pairs;
  statistics.searches = counts.tried;
  statistics.predicate_fallbacks = counts.fallbacks;
  statistics.rejoined_cuts = counts.rejoined;
  statistics.view_cuts = statistics.tree_cuts - statistics.rejoined_cuts;
  triangles_counted = false;
  statistics.order_ms = stopwatch.lap();
}

void ExactSorter::State::order_from_pairs(const Eye& eye) {
  Stopwatch stopwatch;
  screen.look(points, elements, eye, keys);
  const Relation relation(points, parts, elements, screen);
  screen.prepare_search(elements);
  statistics.project_ms = stopwatch.lap();
  precedence.find(relation, screen, elements, key_sort.sort(keys));
  statistics.candidate_pairs = precedence.candidate_pairs();
  statistics.constraints = precedence.broken();
  statistics.searches = precedence.searches();
  statistics.predicate_fallbacks = precedence.fallbacks();
  statistics.pairs_ms = stopwatch.lap();
  walk();
  statistics.order_ms = stopwatch.lap();
  fill_in_cycles();
  statistics.cut_ms = stopwatch.lap();
  triangles_counted = statistics.view_cuts == 0;
  statistics.triangles = parted.triangles;
}

OrderFrom order_from(Method method) {
  return method == Method::exact        ? OrderFrom::pairs
         : method == Method::exact_tree ? OrderFrom::tree
                                        : OrderFrom::presorted;
}

ExactSorter::ExactSorter(const MeshView& mesh, const ExactOptions& options)
    : state_(std::make_unique<State>(mesh, options)) {
  state_->prepare();
}

ExactSorter::ExactSorter(const PresortedView& presorted) : state_(std::make_unique<State>(presorted)) {
  state_->prepare();
}

ExactSorter::ExactSorter(ExactSorter&&) noexcept = default;
ExactSorter& ExactSorter::operator=(ExactSorter&&) noexcept = default;
ExactSorter::~ExactSorter() = default;

std::span<const std::uint32_t> ExactSorter::sort(const SortView& view) {
  State& state = *state_;
  state.last_eye = view.eye;
  if (state.presorted) {
    Stopwatch stopwatch;
    const std::span<const std::uint32_t> order = state.presorted->read(view.eye);
    state.statistics.order_ms = stopwatch.lap();
    state.statistics.pieces = order.size();
    return order;
  }
  state.forget_last_view();
  if (state.tree) {
    state.order_from_tree(view.eye);
  } else {
    state.order_from_pairs(view.eye);
  }
  state.statistics.pieces = state.order.size();
  return state.order;
}

bool ExactSorter::keeps_order(const SortView& view) {
  State& state = *state_;
  if (!state.last_eye) return false;
  return *state.last_eye == view.eye || (state.presorted && state.presorted->keeps_order(view.eye));
}

Pieces ExactSorter::pieces() const {
  if (state_->presorted) return state_->presorted->pieces();
  return {state_->pieces, state_->parts.cuts, state_->points.added_planes()};
}

const ExactStatistics& ExactSorter::statistics() const {
  State& state = *state_;
  if (!state.triangles_counted) {
    state.statistics.triangles = count_triangles(state.points, state.parts, state.order);
    state.triangles_counted = true;
  }
  return state.statistics;
}

OrderedTriangles ExactSorter::triangles() const {
  if (state_->presorted) return state_->presorted->triangles();
  return triangulate(state_->points, state_->parts, state_->order);
}

std::size_t ExactSorter::prepared_bytes() const {
  return state_->prepared_bytes;
}

std::size_t ExactSorter::memory_bytes() const {
  const State& state = *state_;
  return state.bytes_held() + state.screen.memory_bytes() + state.key_sort.memory_bytes() +
         state.tree_walk.memory_bytes() - state.tree_walk.prepared_bytes() + state.rejoined_order.memory_bytes() -
         state.rejoined_order.prepared_bytes() + state.precedence.memory_bytes() +
         state.component_finder.memory_bytes() + bytes_of(state.keys, state.order, state.filled_order);
}

}  // namespace facetsort
