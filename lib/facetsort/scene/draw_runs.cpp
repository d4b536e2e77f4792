// Every tile of the screen has its triangles in a chain, in the order drawn. A triangle may be drawn when it is the
// first left of all its chains: a topological order, found as in Kahn's "Topological sorting of large networks" (1962),
// with one queue an object.
#include "facetsort/scene/draw_runs.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/facets/facets.h"
#include "facetsort/scene/footprints.h"

namespace facetsort {

using namespace scene_internal;

namespace {

constexpr std::uint32_t none = 0xffffffffu;
constexpr std::uint32_t in_several_charts = Charts::most;
constexpr std::size_t triangles_per_task = 8192;
// Finer tiles part more triangles, and cost more.
constexpr std::uint32_t most_tiles_across = 1024;
constexpr double wanted_tiles_per_triangle = 3;
constexpr std::size_t most_tiles_per_triangle = 8;
constexpr std::size_t tiles_in_any_case = 16384;  // for few triangles, at little cost

// In which all triangles together may lie: a triangle counts on each tile that it reaches.
std::size_t most_tiles(std::size_t triangles) {
  return most_tiles_per_triangle * triangles + tiles_in_any_case;
}

// Tiles in a row of a chart that [lowest, highest] reaches.
struct TileRange {
  std::uint32_t first, last;

  std::size_t size() const { return last - first + std::size_t{1}; }
};

TileRange tiles_of(float lowest, float highest, std::uint32_t across) {
  const auto tile = [across](float coordinate) {
    const float most = static_cast<float>(across - 1);
    return static_cast<std::uint32_t>(std::clamp((coordinate + 1) * 0.5f * static_cast<float>(across), 0.0f, most));
  };
  return {tile(lowest), tile(highest)};
}

// All of a triangle that putting in order looks at, in one place: triangles come up in any order.
struct Waiting {
  std::uint32_t first_edge;  // to a triangle that waits for this one
  std::uint32_t waits_for;   // so many others
  std::uint32_t object;
};
struct Edge {
  std::uint32_t to, next;
};

// An object's part of `queued`: every triangle is queued once.
struct Queue {
  std::uint32_t next, end;  // those that are ready

  std::uint32_t size() const { return end - next; }
};

}  // namespace

struct RunGrouper::State {
  std::vector<Footprint> footprints;        // of each triangle, or in_several_charts and then lowest.x is not used
  std::vector<Footprint> further;           // of those in several charts, one triangle after the other
  std::vector<std::uint32_t> further_ends;  // where in `further` those of each such triangle end
  std::vector<std::uint32_t> last_on_tile;
  std::vector<Waiting> waiting;  // of each triangle
  std::vector<Edge> edges;
  std::vector<std::uint32_t> queued;  // triangles that wait for nothing, now or before, object by object
  std::vector<Queue> queues;          // of each object
  std::vector<std::uint32_t> ready_objects;
  std::vector<std::uint32_t> order;

  void find_footprints(const Charts& charts, const DrawnTriangles& drawn);
  template <typename Body>
  void for_each_footprint(const Body& body) const;
  std::uint32_t choose_tiles(std::uint32_t charts) const;
  std::size_t count_tiles(std::uint32_t across) const;
  void link(std::uint32_t charts, std::uint32_t across);
  void lay_out_queues(std::size_t objects);
  void fetch_ahead(const Queue& queue) const;
  std::uint32_t take_fullest();
  void put_in_order();
};

void RunGrouper::State::find_footprints(const Charts& charts, const DrawnTriangles& drawn) {
  const auto corners_of = [&](std::size_t k) {
    const glm::uvec3& t = drawn.triangles[k];
    return Corners{drawn.positions[t.x], drawn.positions[t.y], drawn.positions[t.z]};
  };
  footprints.resize(drawn.triangles.size());
  parallel_ranges(footprints.size(), triangles_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!charts.find_one(corners_of(k), footprints[k])) footprints[k].chart = in_several_charts;
    }
  });
  further.clear();
  further_ends.clear();
  if (charts.count() == 1) return;
  for (std::size_t k = 0; k < footprints.size(); ++k) {
    if (footprints[k].chart != in_several_charts) continue;
    charts.find_all(corners_of(k), further);
    further_ends.push_back(static_cast<std::uint32_t>(further.size()));
  }
}

// Calls body(triangle, footprint) in the order drawn.
template <typename Body>
void RunGrouper::State::for_each_footprint(const Body& body) const {
  std::size_t at = 0, several = 0;
  for (std::size_t k = 0; k < footprints.size(); ++k) {
    if (footprints[k].chart != in_several_charts) {
      body(static_cast<std::uint32_t>(k), footprints[k]);
      continue;
    }
    for (const std::size_t end = further_ends[several++]; at < end; ++at)
      body(static_cast<std::uint32_t>(k), further[at]);
  }
}

std::size_t RunGrouper::State::count_tiles(std::uint32_t across) const {
  std::size_t count = 0;
  for_each_footprint([&](std::uint32_t, const Footprint& f) {
    count += tiles_of(f.lowest.x, f.highest.x, across).size() * tiles_of(f.lowest.y, f.highest.y, across).size();
  });
  return count;
}

// As fine as the triangles allow. In one thread: a sum must not depend on how it was shared out.
std::uint32_t RunGrouper::State::choose_tiles(std::uint32_t charts) const {
  double count = 0, sides = 0, area = 0;
  for_each_footprint([&](std::uint32_t, const Footprint& f) {
    const glm::vec2 size = glm::min(f.highest - f.lowest, glm::vec2(2));
    count += 1;
    sides += static_cast<double>(size.x + size.y);
    area += static_cast<double>(size.x * size.y);
  });
  const double wanted = wanted_tiles_per_triangle * count + static_cast<double>(tiles_in_any_case);
  std::uint32_t across = most_tiles_across / (charts == 1 ? 1 : 2);
  while (across > 1) {
    const double tiles_per_unit = 0.5 * across;
    if (count + tiles_per_unit * sides + tiles_per_unit * tiles_per_unit * area <= wanted) break;
    across /= 2;
  }
  // The estimate above is of the mean: footprints may lie across more tiles than that.
  while (across > 1 && count_tiles(across) > most_tiles(footprints.size())) across /= 2;
  return across;
}

// Precondition: `waiting` has each triangle's object.
void RunGrouper::State::link(std::uint32_t charts, std::uint32_t across) {
  last_on_tile.assign(std::size_t{charts} * across * across, none);
  edges.clear();
  edges.reserve(most_tiles(waiting.size()));
  for_each_footprint([&](std::uint32_t triangle, const Footprint& f) {
    const TileRange columns = tiles_of(f.lowest.x, f.highest.x, across);
    const TileRange rows = tiles_of(f.lowest.y, f.highest.y, across);
    for (std::uint32_t row = rows.first; row <= rows.last; ++row) {
      for (std::uint32_t column = columns.first; column <= columns.last; ++column) {
        std::uint32_t& last = last_on_tile[(std::size_t{f.chart} * across + row) * across + column];
        const std::uint32_t before = last;
        last = triangle;
        if (before == none || before == triangle) continue;
        std::uint32_t& latest = waiting[before].first_edge;
        if (latest != none && edges[latest].to == triangle) continue;  // from another tile
        edges.push_back({triangle, latest});
        latest = static_cast<std::uint32_t>(edges.size() - 1);
        ++waiting[triangle].waits_for;
      }
    }
  });
}

// Precondition: `waiting` has each triangle's object.
void RunGrouper::State::lay_out_queues(std::size_t objects) {
  queued.resize(waiting.size());
  queues.assign(objects, {0, 0});
  for (const Waiting& triangle : waiting) ++queues[triangle.object].end;
  std::uint32_t begin = 0;
  for (Queue& queue : queues) {
    const std::uint32_t size = queue.end;
    queue = {begin, begin};
    begin += size;
  }
  ready_objects.clear();
  ready_objects.reserve(objects + 1);
}

// Of the objects that have triangles ready, that with the most; the smaller number where several have. Those that have
// none leave the list.
std::uint32_t RunGrouper::State::take_fullest() {
  std::size_t kept = 0;
  std::uint32_t fullest = none;
  for (const std::uint32_t object : ready_objects) {
    const std::uint32_t size = queues[object].size();
    if (size == 0) continue;
    ready_objects[kept++] = object;
    if (fullest == none || size > queues[fullest].size() || (size == queues[fullest].size() && object < fullest)) {
      fullest = object;
    }
  }
  ready_objects.resize(kept);
  return fullest;
}

// Triangles of a queue lie anywhere in memory, and so do those that wait for them: fetched a few places ahead.
void RunGrouper::State::fetch_ahead(const Queue& queue) const {
  constexpr std::uint32_t far = 16, near = 8, nearest = 4;
  if (queue.size() > far) __builtin_prefetch(&waiting[queued[queue.next + far]]);
  if (queue.size() > near) {
    const std::uint32_t edge = waiting[queued[queue.next + near]].first_edge;
    if (edge != none) __builtin_prefetch(&edges[edge]);
  }
  if (queue.size() > nearest) {
    const std::uint32_t edge = waiting[queued[queue.next + nearest]].first_edge;
    if (edge != none) __builtin_prefetch(&waiting[edges[edge].to], 1);
  }
}

void RunGrouper::State::put_in_order() {
  order.clear();
  order.reserve(waiting.size());
  const auto make_ready = [&](std::uint32_t triangle) { queued[queues[waiting[triangle].object].end++] = triangle; };
  const auto make_object_ready = [&](std::uint32_t triangle) {
    const std::uint32_t object = waiting[triangle].object;
    if (queues[object].size() == 0) ready_objects.push_back(object);
    make_ready(triangle);
  };
  for (std::uint32_t k = 0; k < waiting.size(); ++k) {
    if (waiting[k].waits_for == 0) make_object_ready(k);
  }
  for (std::uint32_t object; (object = take_fullest()) != none;) {
    Queue& queue = queues[object];
    while (queue.size() > 0) {
      fetch_ahead(queue);
      const std::uint32_t triangle = queued[queue.next++];
      order.push_back(triangle);
      for (std::uint32_t edge = waiting[triangle].first_edge; edge != none; edge = edges[edge].next) {
        const std::uint32_t next = edges[edge].to;
        if (--waiting[next].waits_for > 0) continue;
        // The object that is drawn stays in the list until it has none.
        if (waiting[next].object == object) {
          make_ready(next);
        } else {
          make_object_ready(next);
        }
      }
    }
  }
  assert(order.size() == waiting.size());
}

RunGrouper::RunGrouper() : state_(std::make_unique<State>()) {}
RunGrouper::RunGrouper(RunGrouper&&) noexcept = default;
RunGrouper& RunGrouper::operator=(RunGrouper&&) noexcept = default;
RunGrouper::~RunGrouper() = default;

std::size_t RunGrouper::memory_bytes() const {
  const State& s = *state_;
  return bytes_of(s.footprints, s.further, s.further_ends, s.last_on_tile, s.waiting, s.edges, s.queued, s.queues,
                  s.ready_objects, s.order);
}

std::span<const std::uint32_t> RunGrouper::group(const glm::vec4& eye, const DrawnTriangles& drawn,
                                                 std::size_t object_count) {
  State& state = *state_;
  assert(drawn.objects.size() == drawn.triangles.size());
  if (drawn.triangles.empty()) return {};
  const Charts charts(eye, facet_bounds(drawn.triangles, drawn.positions));
  state.find_footprints(charts, drawn);
  const std::uint32_t across = state.choose_tiles(charts.count());
  state.waiting.resize(drawn.objects.size());
  for (std::size_t k = 0; k < drawn.objects.size(); ++k) state.waiting[k] = {none, 0, drawn.objects[k]};
  state.link(charts.count(), across);
  state.lay_out_queues(object_count);
  state.put_in_order();
  return state.order;
}

std::size_t count_draw_runs(std::span<const std::uint32_t> objects) {
  std::size_t runs = 0;
  for (std::size_t k = 0; k < objects.size(); ++k) runs += k == 0 || objects[k] != objects[k - 1];
  return runs;
}

void find_draw_runs(std::span<const std::uint32_t> objects, std::vector<DrawRun>& runs) {
  runs.clear();
  for (std::size_t k = 0; k < objects.size(); ++k) {
    if (runs.empty() || runs.back().object != objects[k]) {
      runs.push_back({objects[k], static_cast<std::uint32_t>(3 * k), 0});
    }
    runs.back().index_count += 3;
  }
}

}  // namespace facetsort
