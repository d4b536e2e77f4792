// The order by depth, mended where it is wrong.
//
// Facets come in the order of a depth key, as in a painter's algorithm (Newell, Newell and Sancha 1972, "A Solution to
// the Hidden Surface Problem"), but what must come before what is decided exactly. Pairs that overlap on the screen and
// in depth are tested; of the constraints they make, only those are kept that the key order breaks: a part is behind one
// that comes before it. Then the key order is walked, depth first into what a part needs to have been drawn before it.
// A part visited so, ahead of its turn, may also have to come after parts that are all of them deeper, yet not drawn
// because their turn is to come: those are searched for in the hierarchy, by its box and the span of keys in question.
// With these searches the walk is Tarjan's algorithm on the graph of all constraints, of which it never sees more than
// it needs. The components that it finds are cycles, and are cut.
#include "facetsort/exact/exact_sorter.h"

#include <tbb/combinable.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/crossings.h"
#include "facetsort/exact/cycles.h"
#include "facetsort/exact/elements.h"
#include "facetsort/exact/positions.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/exact/screen.h"
#include "facetsort/exact/triangulation.h"
#include "facetsort/order/key_sort.h"

namespace facetsort {

using namespace exact_internal;

namespace {

constexpr std::size_t facets_per_task = 4096;
constexpr std::size_t leaves_per_task = 64;

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

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
    const auto same = std::find_if(distinct.begin(), distinct.end(), [&](FacetId other) { return coplanar(other, facet); });
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

// `behind` must be drawn before `before`, whose turn by depth is earlier.
struct Broken {
  std::uint32_t before, behind;  // elements

  auto operator<=>(const Broken&) const = default;
};

// A place in the order as it is found: a draw id, or a cycle to be filled in.
constexpr std::uint32_t cycle_mark = 0x80000000u;

struct Cycle {
  std::vector<std::uint32_t> elements;  // farthest first
  std::vector<HidingPair> pairs;        // by place in `elements`
};

}  // namespace

struct ExactSorter::State {
  State(const MeshView& mesh_in, const ExactOptions& options_in)
      : mesh(mesh_in),
        options(options_in),
        space{mesh_in, identify_positions(mesh_in), {}, {}, {}, {}},
        degenerate(find_degenerate_facets(mesh_in)),
        points(with_planes()) {}

  const PointSpace& with_planes() {
    space.plane_of_facet = find_planes(mesh, degenerate);
    space.faces_away = find_facing_away(mesh, space.plane_of_facet);
    space.find_facets_around();
    return space;
  }

  std::size_t bytes_held() const;
  void prepare();
  void forget_last_view();
  void find_broken();
  void walk();
  void visit(std::uint32_t root);
  void edges_of(std::uint32_t element, std::uint32_t root);
  void finish_component(std::uint32_t element);
  void fill_in_cycles();
  bool comes_before(std::uint32_t a, std::uint32_t b) const;
  int behind_by_cut(std::uint32_t element, std::uint32_t other) const;
  bool is_behind(const ElementPair& pair, bool first) const;
  SeenPart seen_part(std::uint32_t element) const;
  std::size_t most_triangles() const;

  MeshView mesh;
  ExactOptions options;
  PointSpace space;
  std::vector<unsigned char> degenerate;
  Points points;                 // vertices, those of prepared pieces, then those of the last view
  PartList parts;                // prepared pieces, then those of the last view
  std::vector<Piece> pieces;     // the same, for drawing
  bool triangles_counted = false;  // of the last view
  std::size_t prepared_pieces = 0, prepared_points = 0, prepared_triangles = 0, prepared_bytes = 0;
  Elements elements;
  ExactStatistics statistics;

  Screen screen;
  std::vector<float> keys;  // by draw id
  KeySort key_sort;
  std::vector<Broken> broken;                  // sorted
  std::vector<std::uint32_t> first_broken;     // element: its first in `broken`, or no_element
  std::vector<std::uint32_t> order;            // draw ids and cycles
  std::vector<std::uint32_t> filled_order;
  std::vector<Cycle> cycles;

  // Tarjan's algorithm.
  struct Visit {
    std::uint32_t element;
    std::size_t next, end;  // in `edges`
  };
  std::vector<std::uint32_t> number, lowest;  // element; 0: not visited
  std::vector<unsigned char> drawn;
  std::uint32_t visited = 0;
  std::vector<Visit> visits;
  std::vector<std::uint32_t> open;
  std::vector<std::uint32_t> edges;  // what is behind
  std::vector<ElementPair> nearby;
  std::vector<std::pair<std::size_t, std::size_t>> edge_range;  // of visited elements, by number - first_number
  std::uint32_t first_number = 0;
};

namespace {

Piece piece_of(const Part& part) { return {part.facet, part.first_cut, part.cut_count}; }

}  // namespace

std::size_t ExactSorter::State::most_triangles() const {
  const double most = options.max_growth * static_cast<double>(mesh.facet_count());
  return most < 1e18 ? static_cast<std::size_t>(most) : std::size_t{1} << 60;
}

void ExactSorter::State::prepare() {
  const Clock::time_point start = Clock::now();
  PartedFacets parted = part_crossing_facets(points, degenerate, most_triangles());
  parts = std::move(parted.pieces);
  prepared_pieces = parts.parts.size();
  prepared_points = points.size();
  statistics.crossing_pairs = parted.crossing_pairs;
  statistics.crossing_pairs_uncut = parted.uncut_pairs;
  statistics.prepared_cuts = parted.cuts;
  elements = make_elements(points, parts, degenerate, parted.uncut_pairs > 0);
  statistics.prepared_pieces = elements.count();
  for (const Part& part : parts.parts) pieces.push_back(piece_of(part));
  first_broken.assign(elements.count(), no_element);
  number.assign(elements.count(), 0);
  lowest.assign(elements.count(), 0);
  drawn.assign(elements.count(), 0);
  order = filled_order = elements.draw_id;
  prepared_triangles = count_triangles(points, parts, order);
  prepared_bytes = bytes_held();
  statistics.prepare_ms = milliseconds_since(start);
}

void ExactSorter::State::forget_last_view() {
  parts.truncate(prepared_pieces);
  pieces.resize(prepared_pieces);
  points.truncate(prepared_points);
}

// What construction made.
std::size_t ExactSorter::State::bytes_held() const {
  return points.memory_bytes() + parts.memory_bytes() + elements.memory_bytes() +
         bytes_of(space.position_of_vertex, space.plane_of_facet, space.faces_away, space.around_begin, space.around,
                  degenerate, pieces, first_broken, number, lowest, drawn);
}

// Whether a comes first by depth; ties go to the smaller draw id.
bool ExactSorter::State::comes_before(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t a_id = elements.draw_id[a], b_id = elements.draw_id[b];
  const float a_key = screen.key(a), b_key = screen.key(b);
  return a_key > b_key || (a_key == b_key && a_id < b_id);
}

SeenPart ExactSorter::State::seen_part(std::uint32_t element) const {
  return {elements.facet[element], screen.facing(element), elements.corners(element)};
}

// Where `element` is a piece that a cut along the plane of `other` bounds: +1 when it lies beyond that plane, -1 when it
// lies before it; 0 where there is no such cut.
int ExactSorter::State::behind_by_cut(std::uint32_t element, std::uint32_t other) const {
  const std::uint32_t id = elements.draw_id[element];
  if (id < mesh.facet_count()) return 0;
  const FacetId facet = elements.facet[other];
  for (const Cut& cut : parts.cuts_of(parts.parts[id - mesh.facet_count()])) {
    if (cut.plane != space.plane_of_facet[facet]) continue;
    return cut.side * screen.facing(other) * (space.faces_away[facet] != 0 ? -1 : 1) < 0 ? 1 : -1;
  }
  return 0;
}

// Whether the first (or else the second) of a pair is behind the other. Exact; the filters decide nearly all.
bool ExactSorter::State::is_behind(const ElementPair& pair, bool first) const {
  const FacetId a_facet = elements.facet[pair.a], b_facet = elements.facet[pair.b];
  if (space.plane_of_facet[a_facet] == space.plane_of_facet[b_facet]) return false;
  const int sign = first ? 1 : -1;
  if (pair.seen.behind == -sign) return false;
  if (pair.seen.behind == sign && pair.seen.overlap == Seen::overlapping) return true;
  const int by_cut = behind_by_cut(pair.a, pair.b) - behind_by_cut(pair.b, pair.a);
  if (by_cut == -sign) return false;
  Seen seen = pair.seen;
  if (seen.overlap != Seen::overlapping) seen = screen.compare(elements, pair.a, pair.b, sign);
  if (by_cut != 0) seen.behind = static_cast<std::int8_t>(by_cut);
  if (seen.overlap == Seen::overlapping && seen.behind == 0 && !screen.viewpoint().surrounded) {
    seen.behind = static_cast<std::int8_t>(screen.behind_where_edges_cross(elements, pair.a, pair.b));
  }
  if (seen.overlap == Seen::apart || seen.behind == -sign) return false;
  if (seen.overlap == Seen::overlapping && seen.behind == sign) return true;
  const Hiding relation = (seen.overlap == Seen::overlapping ? hiding_of_overlapping : hiding)(
      points, screen.viewpoint(), seen_part(pair.a), seen_part(pair.b));
  return relation == (first ? Hiding::first_behind_second : Hiding::second_behind_first);
}

void ExactSorter::State::find_broken() {
  struct Found {
    std::vector<Broken> broken;
    std::vector<ElementPair> pairs;
    std::size_t candidates = 0;
    unsigned long long fallbacks = 0;
  };
  tbb::combinable<Found> found;
  const Screenful screenful = screen.screenful(elements);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, screen.leaves(), leaves_per_task),
                    [&](const tbb::blocked_range<std::size_t>& range) {
    Found& mine = found.local();
    const unsigned long long fallbacks = exact_fallbacks();
    for (std::size_t leaf = range.begin(); leaf < range.end(); ++leaf) {
      mine.pairs.clear();
      mine.candidates += collect_pairs(screenful, leaf, mine.pairs);
      for (const ElementPair& pair : mine.pairs) {
        const bool a_first = comes_before(pair.a, pair.b);
        if (!is_behind(pair, !a_first)) continue;
        mine.broken.push_back(a_first ? Broken{pair.a, pair.b} : Broken{pair.b, pair.a});
      }
    }
    mine.fallbacks += exact_fallbacks() - fallbacks;
  });
  for (const Broken& b : broken) first_broken[b.before] = no_element;  // of the last view
  broken.clear();
  statistics.candidate_pairs = 0;
  found.combine_each([&](const Found& part) {
    broken.insert(broken.end(), part.broken.begin(), part.broken.end());
    statistics.candidate_pairs += part.candidates;
    statistics.predicate_fallbacks += part.fallbacks;
  });
  tbb::parallel_sort(broken);
  for (std::size_t i = broken.size(); i-- > 0;) first_broken[broken[i].before] = static_cast<std::uint32_t>(i);
  statistics.constraints = broken.size();
}

// Appends to `edges` what is behind the element and not drawn.
void ExactSorter::State::edges_of(std::uint32_t element, std::uint32_t root) {
  const std::size_t begin = edges.size();
  if (first_broken[element] != no_element) {
    for (std::size_t i = first_broken[element]; i < broken.size() && broken[i].before == element; ++i) {
      if (!drawn[broken[i].behind]) edges.push_back(broken[i].behind);
    }
  }
  if (element != root) {
    ++statistics.searches;
    ScreenBox box = screen.box(element);
    box.lowest[of_key] = screen.key(element);
    box.highest[of_key] = screen.key(root);
    nearby.clear();
    collect_overlapping(screen.screenful(elements), element, box, drawn, nearby);
    for (const ElementPair& pair : nearby) {
      if (comes_before(pair.b, element) && is_behind(pair, false)) edges.push_back(pair.b);
    }
  }
  std::sort(edges.begin() + static_cast<std::ptrdiff_t>(begin), edges.end(),
            [&](std::uint32_t a, std::uint32_t b) { return comes_before(a, b); });
}

void ExactSorter::State::finish_component(std::uint32_t element) {
  if (open.back() == element) {
    open.pop_back();
    drawn[element] = 1;
    order.push_back(elements.draw_id[element]);
    return;
  }
  Cycle& cycle = cycles.emplace_back();
  std::uint32_t member;
  do {
    member = open.back();
    open.pop_back();
    drawn[member] = 1;
    cycle.elements.push_back(member);
  } while (member != element);
  std::sort(cycle.elements.begin(), cycle.elements.end(),
            [&](std::uint32_t a, std::uint32_t b) { return comes_before(a, b); });
  std::map<std::uint32_t, std::uint32_t> place;
  for (std::uint32_t i = 0; i < cycle.elements.size(); ++i) place[cycle.elements[i]] = i;
  for (std::uint32_t i = 0; i < cycle.elements.size(); ++i) {
    const auto [begin, end] = edge_range[number[cycle.elements[i]] - first_number];
    for (std::size_t e = begin; e < end; ++e) {
      const auto behind = place.find(edges[e]);
      if (behind != place.end()) cycle.pairs.push_back({behind->second, i});
    }
  }
  order.push_back(cycle_mark | static_cast<std::uint32_t>(cycles.size() - 1));
}

void ExactSorter::State::visit(std::uint32_t root) {
  edges.clear();
  edge_range.clear();
  first_number = visited + 1;
  const auto enter = [&](std::uint32_t element) {
    number[element] = lowest[element] = ++visited;
    open.push_back(element);
    const std::size_t begin = edges.size();
    edges_of(element, root);
    edge_range.push_back({begin, edges.size()});
    visits.push_back({element, begin, edges.size()});
  };
  enter(root);
  while (!visits.empty()) {
    Visit& top = visits.back();
    const std::uint32_t element = top.element;
    if (top.next < top.end) {
      const std::uint32_t behind = edges[top.next++];
      if (number[behind] == 0) {
        enter(behind);
      } else if (!drawn[behind]) {
        lowest[element] = std::min(lowest[element], number[behind]);
      }
      continue;
    }
    visits.pop_back();
    if (!visits.empty()) lowest[visits.back().element] = std::min(lowest[visits.back().element], lowest[element]);
    if (lowest[element] == number[element]) finish_component(element);
  }
}

void ExactSorter::State::walk() {
  order.clear();
  cycles.clear();
  std::fill(number.begin(), number.end(), 0u);
  std::fill(drawn.begin(), drawn.end(), static_cast<unsigned char>(0));
  visited = 0;
  statistics.searches = 0;
  const unsigned long long fallbacks = exact_fallbacks();
  for (const std::uint32_t id : key_sort.sort(keys)) {
    const std::uint32_t element = elements.element_of_draw_id[id];
    if (element == no_element || drawn[element]) continue;
    if (first_broken[element] == no_element) {
      drawn[element] = 1;
      order.push_back(id);
    } else {
      visit(element);
    }
  }
  statistics.predicate_fallbacks += exact_fallbacks() - fallbacks;
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
  const std::size_t limit = most_triangles();
  const std::size_t most_cuts = limit > prepared_triangles ? (limit - prepared_triangles) / 2 : 0;
  tbb::combinable<unsigned long long> fallbacks;
  tbb::parallel_for(std::size_t{0}, cycles.size(), [&](std::size_t c) {
    const unsigned long long before = exact_fallbacks();
    std::vector<CycleMember> members;
    for (const std::uint32_t element : cycles[c].elements) {
      const std::uint32_t id = elements.draw_id[element];
      CycleMember& member = members.emplace_back(CycleMember{elements.facet[element], screen.facing(element), {}, {}});
      if (id < mesh.facet_count()) {
        member.corners = whole_facet(space, id).corners;
      } else {
        const Part& part = parts.parts[id - mesh.facet_count()];
        member.corners.assign(parts.corners_of(part).begin(), parts.corners_of(part).end());
        member.cuts.assign(parts.cuts_of(part).begin(), parts.cuts_of(part).end());
      }
    }
    ordered[c] = order_cycle(points, screen.viewpoint(), std::move(members), cycles[c].pairs, most_cuts);
    fallbacks.local() += exact_fallbacks() - before;
  });
  fallbacks.combine_each([&](unsigned long long n) { statistics.predicate_fallbacks += n; });

  std::size_t triangles = prepared_triangles;
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

ExactSorter::ExactSorter(const MeshView& mesh, const ExactOptions& options)
    : state_(std::make_unique<State>(mesh, options)) {
  state_->prepare();
}

ExactSorter::ExactSorter(ExactSorter&&) noexcept = default;
ExactSorter& ExactSorter::operator=(ExactSorter&&) noexcept = default;
ExactSorter::~ExactSorter() = default;

std::span<const std::uint32_t> ExactSorter::sort(const SortView& view) {
  State& state = *state_;
  ExactStatistics& statistics = state.statistics;
  state.forget_last_view();

  Clock::time_point start = Clock::now();
  const auto lap = [&](double& milliseconds) {
    milliseconds = milliseconds_since(start);
    start = Clock::now();
  };
  statistics.predicate_fallbacks = 0;
  state.screen.look(state.points, state.elements, view.eye, state.keys);
  lap(statistics.project_ms);
  state.find_broken();
  lap(statistics.pairs_ms);
  state.walk();
  lap(statistics.order_ms);
  state.fill_in_cycles();
  lap(statistics.cut_ms);
  statistics.pieces = state.order.size();
  state.triangles_counted = statistics.view_cuts == 0;
  statistics.triangles = state.prepared_triangles;
  return state.order;
}

Pieces ExactSorter::pieces() const { return {state_->pieces, state_->parts.cuts, state_->points.added_planes()}; }

const ExactStatistics& ExactSorter::statistics() const {
  State& state = *state_;
  if (!state.triangles_counted) {
    state.statistics.triangles = count_triangles(state.points, state.parts, state.order);
    state.triangles_counted = true;
  }
  return state.statistics;
}

OrderedTriangles ExactSorter::triangles() const { return triangulate(state_->points, state_->parts, state_->order); }

std::size_t ExactSorter::prepared_bytes() const { return state_->prepared_bytes; }

std::size_t ExactSorter::memory_bytes() const {
  const State& state = *state_;
  return state.bytes_held() + state.screen.memory_bytes() + state.key_sort.memory_bytes() +
         bytes_of(state.keys, state.broken, state.order, state.filled_order, state.visits, state.open, state.edges,
                  state.nearby, state.edge_range);
}

}  // namespace facetsort
