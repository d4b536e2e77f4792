#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <iterator>
#include <limits>
#include <new>
#include <string>
#include <vector>

#include "facetsort/base/parallel.h"
#include "facetsort/mesh/inspect.h"
#include "facetsort/order/presorted_mesh.h"

namespace facetsort {
namespace {

constexpr std::size_t elements_per_task = 16384;
constexpr std::uint64_t most_elements = 0xfffffffeu;
// Of a unit vector's squared length: float32 leaves much less.
constexpr float length_tolerance = 1e-4f;

std::string numbered(const char* name, std::size_t number) {
  return std::string(name) + ' ' + std::to_string(number);
}

// The first i below `count` for which is_sound(i) is false, or `count`. A block is judged as a whole before the fault
// is looked for, so that simple checks become vector instructions.
template <typename IsSound>
std::size_t first_fault(std::size_t count, const IsSound& is_sound) {
  const auto first_in = [&](const tbb::blocked_range<std::size_t>& range, std::size_t first) {
    if (first < range.begin()) return first;
    std::uint32_t faults = 0;
    for (std::size_t i = range.begin(); i < range.end(); ++i) faults |= is_sound(i) ? 0u : 1u;
    if (faults == 0) return first;
    std::size_t i = range.begin();
    while (is_sound(i)) ++i;
    return i;
  };
  const tbb::blocked_range<std::size_t> all(0, count, elements_per_task);
  if (count <= elements_per_task) return first_in(all, count);
  return tbb::parallel_reduce(all, count, first_in, [](std::size_t a, std::size_t b) { return std::min(a, b); });
}

// Of value(i), of a type that 0 makes a zero of.
template <typename Value>
auto sum_of(std::size_t count, const Value& value) {
  using Sum = decltype(value(0));
  return tbb::parallel_reduce(
      tbb::blocked_range<std::size_t>(0, count, elements_per_task), Sum(0),
      [&](const tbb::blocked_range<std::size_t>& range, Sum sum) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) sum += value(i);
        return sum;
      },
      std::plus<>());
}

// The numbers of vectors one after another: loops over them become vector instructions.
template <typename Number>
std::span<const Number> numbers_of(std::span<const glm::vec<3, Number>> vectors) {
  return {reinterpret_cast<const Number*>(vectors.data()), 3 * vectors.size()};
}

// Infinity less itself is no number.
bool is_finite(float value) {
  return value - value == 0;
}

bool is_finite(const glm::vec3& p) {
  return is_finite(p.x) && is_finite(p.y) && is_finite(p.z);
}

// The first that is not finite, or their number.
std::size_t first_infinite(std::span<const glm::vec3> points) {
  const auto coordinates = numbers_of(points);
  return first_fault(coordinates.size(), [&](std::size_t i) { return is_finite(coordinates[i]); }) / 3;
}

// The view under test, and what several of the tests ask of it.
class Checker {
 public:
  explicit Checker(const PresortedView& view)
      : view_(view),
        facets_(view.mesh.facet_count()),
        vertices_(view.mesh.vertex_count()),
        positions_finite_(first_infinite(view.mesh.positions) == vertices_) {}

  Status check_tree() const;
  Status check_buffers(const IndexBuffers& buffers) const;
  Status check_mesh() const;

 private:
  bool has_tree() const;
  Status check_made_vertices() const;
  Status check_nodes() const;
  Status check_pieces() const;
  Status check_coverage() const;
  Status check_triangles() const;
  Status check_cuts() const;
  Status check_planes() const;
  Status check_directions(const IndexBuffers& buffers) const;

  // Whether all are below `limit` and have finite positions: vertices that no facet uses may be anywhere, and made ones
  // are judged by themselves.
  bool are_usable(const glm::uvec3& v, std::size_t limit) const {
    return std::max(std::max(v.x, v.y), v.z) < limit &&
           (positions_finite_ || (is_somewhere(v.x) && is_somewhere(v.y) && is_somewhere(v.z)));
  }
  bool is_somewhere(std::uint32_t vertex) const {
    return vertex >= vertices_ || is_finite(view_.mesh.positions[vertex]);
  }
  // The first triple that are_usable() is not true of, or their number.
  std::size_t first_unusable(std::span<const glm::uvec3> triples, std::size_t limit) const;
  Status bad_vertex(const std::string& place) const;

  const PresortedView& view_;
  std::size_t facets_, vertices_;
  bool positions_finite_;
};

Status Checker::bad_vertex(const std::string& place) const {
  return {Fault::index_out_of_range, place + " names a vertex that is not among the mesh's " +
                                         std::to_string(vertices_) + ", or whose position is not finite"};
}

std::size_t Checker::first_unusable(std::span<const glm::uvec3> triples, std::size_t limit) const {
  if (!positions_finite_) {
    return first_fault(triples.size(), [&](std::size_t t) { return are_usable(triples[t], limit); });
  }
  const auto vertices = numbers_of(triples);
  const auto end = static_cast<std::uint32_t>(limit);
  return first_fault(vertices.size(), [&](std::size_t i) { return vertices[i] < end; }) / 3;
}

// With no facet all is well: the empty mesh has an order too.
Status Checker::check_mesh() const {
  const MeshView& mesh = view_.mesh;
  const bool colours_fit = (mesh.facet_colours.empty() || mesh.facet_colours.size() == facets_) &&
                           (mesh.vertex_colours.empty() || mesh.vertex_colours.size() == vertices_);
  if (facets_ == 0) {
    if (colours_fit && vertices_ <= most_elements) return {};
    return {Fault::size_mismatch, std::to_string(mesh.facet_colours.size()) + " facet colours and " +
                                      std::to_string(mesh.vertex_colours.size()) + " vertex colours for 0 facets and " +
                                      std::to_string(vertices_) + " vertices"};
  }
  const bool is_sound = facets_ <= most_elements && vertices_ <= most_elements && colours_fit &&
                        first_unusable(mesh.triangles, vertices_) == facets_;
  return is_sound ? Status{} : validate(mesh);
}

bool Checker::has_tree() const {
  return !(view_.made_vertices.empty() && view_.made_positions.empty() && view_.nodes.empty() && view_.pieces.empty() &&
           view_.triangles.empty() && view_.cuts.empty() && view_.planes.empty());
}

Status Checker::check_tree() const {
  if (!has_tree()) return {};
  const std::size_t ids[] = {vertices_ + view_.made_vertices.size(),
                             facets_ + view_.planes.size(),
                             view_.nodes.size(),
                             view_.pieces.size(),
                             view_.triangles.size(),
                             view_.cuts.size()};
  if (*std::max_element(std::begin(ids), std::end(ids)) > most_elements) {
    return {Fault::too_many_facets, "ids have 32 bits: at most " + std::to_string(most_elements) +
                                        " vertices, planes, nodes, pieces, triangles and cuts"};
  }
  using Check = Status (Checker::*)() const;
  for (const Check check :
       {&Checker::check_made_vertices, &Checker::check_nodes, &Checker::check_pieces, &Checker::check_coverage,
        &Checker::check_triangles, &Checker::check_cuts, &Checker::check_planes}) {
    if (Status status = (this->*check)(); !status.ok()) return status;
  }
  return {};
}

Status Checker::check_made_vertices() const {
  const auto vertices = view_.made_vertices;
  const auto positions = view_.made_positions;
  if (positions.size() != vertices.size()) {
    return {Fault::size_mismatch,
            std::to_string(positions.size()) + " positions for " + std::to_string(vertices.size()) + " made vertices"};
  }
  const std::size_t infinite = first_infinite(positions);
  if (infinite != positions.size()) {
    return {Fault::non_finite_position, numbered("made vertex", infinite) + ": its position is not finite"};
  }
  const std::size_t fault = first_fault(vertices.size(), [&](std::size_t v) {
    return vertices[v].facet < facets_ && is_finite(vertices[v].barycentric);
  });
  if (fault == vertices.size()) return {};
  const std::string place = numbered("made vertex", fault);
  if (vertices[fault].facet >= facets_) {
    return {Fault::index_out_of_range,
            place + " is in " + numbered("facet", vertices[fault].facet) + " of " + std::to_string(facets_)};
  }
  return {Fault::malformed, place + ": its barycentric coordinates are not finite"};
}

// Each node's children fill the nodes that it counts, and the root's are all: by induction from the root, every node is
// below it in exactly one place.
Status Checker::check_nodes() const {
  const auto nodes = view_.nodes;
  const auto size = [&](std::uint64_t node) {
    return std::uint64_t{1} + nodes[node].front_nodes + nodes[node].back_nodes;
  };
  const auto holds_child = [&](std::uint64_t child, std::uint64_t child_size) {
    return child_size == 0 || (child < nodes.size() && size(child) == child_size);
  };
  const auto nests = [&](std::size_t i) {
    const std::uint64_t front = nodes[i].front_nodes;
    return holds_child(i + 1, front) && holds_child(i + 1 + front, nodes[i].back_nodes);
  };
  if (!nodes.empty() && size(0) != nodes.size()) {
    return {Fault::malformed,
            "node 0, the root, counts " + std::to_string(size(0)) + " nodes of " + std::to_string(nodes.size())};
  }
  const auto is_plane = [&](const glm::uvec3& plane) {
    return are_usable(plane, vertices_) && plane.x != plane.y && plane.y != plane.z && plane.z != plane.x;
  };
  const std::size_t fault =
      first_fault(nodes.size(), [&](std::size_t i) { return nests(i) && is_plane(nodes[i].plane); });
  if (fault == nodes.size()) return {};
  const std::string place = numbered("node", fault);
  if (!nests(fault)) return {Fault::malformed, place + ": the nodes on its sides are not those that it counts"};
  if (!are_usable(nodes[fault].plane, vertices_)) return bad_vertex(place);
  return {Fault::malformed, place + ": its plane names a vertex twice"};
}

Status Checker::check_pieces() const {
  const auto pieces = view_.pieces;
  const std::size_t fault = first_fault(
      pieces.size(), [&](std::size_t p) { return pieces[p].facet < facets_ && pieces[p].triangle_count != 0; });
  if (fault != pieces.size()) {
    const std::string place = numbered("piece", fault);
    if (pieces[fault].facet < facets_) return {Fault::malformed, place + " has no triangle"};
    return {Fault::index_out_of_range,
            place + " is of " + numbered("facet", pieces[fault].facet) + " of " + std::to_string(facets_)};
  }
  const auto mismatch = [](const char* who, std::uint64_t sum, const char* what, std::size_t count) {
    return Status{Fault::size_mismatch,
                  std::string(who) + " count " + std::to_string(sum) + ' ' + what + " of " + std::to_string(count)};
  };
  const std::uint64_t in_nodes =
      sum_of(view_.nodes.size(), [&](std::size_t i) { return std::uint64_t{view_.nodes[i].piece_count}; });
  if (in_nodes > pieces.size()) return mismatch("nodes", in_nodes, "pieces", pieces.size());
  const glm::u64vec2 counted =
      sum_of(pieces.size(), [&](std::size_t p) { return glm::u64vec2(pieces[p].triangle_count, pieces[p].cut_count); });
  if (counted.x != view_.triangles.size()) return mismatch("pieces", counted.x, "triangles", view_.triangles.size());
  if (counted.y != view_.cuts.size()) return mismatch("pieces", counted.y, "cuts", view_.cuts.size());
  return {};
}

// Precondition: the pieces' facets are in range.
Status Checker::check_coverage() const {
  std::vector<std::uint8_t> covered(facets_);
  parallel_ranges(view_.pieces.size(), elements_per_task, [&](std::size_t begin, std::size_t end) {
    for (const PresortedPiece& piece : view_.pieces.subspan(begin, end - begin)) {
      // Pieces of one facet may meet here in several threads.
      std::atomic_ref(covered[piece.facet]).store(1, std::memory_order_relaxed);
    }
  });
  const std::size_t fault = first_fault(facets_, [&](std::size_t f) { return covered[f] != 0; });
  if (fault == facets_) return {};
  return {Fault::malformed, numbered("facet", fault) + " has no piece"};
}

Status Checker::check_triangles() const {
  const auto triangles = view_.triangles;
  const std::size_t fault = first_unusable(triangles, vertices_ + view_.made_vertices.size());
  if (fault == triangles.size()) return {};
  return {Fault::index_out_of_range,
          numbered("triangle", fault) + " names a vertex that is not among the " + std::to_string(vertices_) + " and " +
              std::to_string(view_.made_vertices.size()) + " made, or whose position is not finite"};
}

Status Checker::check_cuts() const {
  const auto cuts = view_.cuts;
  const std::size_t planes = facets_ + view_.planes.size();
  const std::size_t fault = first_fault(
      cuts.size(), [&](std::size_t c) { return cuts[c].plane < planes && (cuts[c].side == 1 || cuts[c].side == -1); });
  if (fault == cuts.size()) return {};
  const std::string place = numbered("cut", fault);
  if (cuts[fault].plane < planes) {
    return {Fault::malformed, place + ": its side is " + std::to_string(cuts[fault].side) + ", neither 1 nor -1"};
  }
  return {Fault::index_out_of_range,
          place + " is along " + numbered("plane", cuts[fault].plane) + " of " + std::to_string(planes)};
}

Status Checker::check_planes() const {
  const auto planes = view_.planes;
  const std::size_t fault = first_fault(planes.size(), [&](std::size_t p) {
    const CutPlane& plane = planes[p];
    const bool third_is_sound = plane.is_join()
                                    ? are_usable(glm::uvec3(plane.edge_end), vertices_) && plane.facet < facets_
                                    : plane.facet == CutPlane::none;
    return are_usable({plane.first, plane.second, plane.third}, vertices_) && third_is_sound;
  });
  if (fault == planes.size()) return {};
  return {Fault::index_out_of_range, numbered("plane", facets_ + fault) +
                                         " names a vertex or a facet that is not there, or a vertex whose position is "
                                         "not finite"};
}

Status Checker::check_directions(const IndexBuffers& buffers) const {
  const auto& directions = buffers.directions;
  const auto& buffer_of = buffers.buffer_of_direction;
  if (directions.empty() || directions.size() != buffer_of.size()) {
    return {Fault::size_mismatch, "index buffers: " + std::to_string(buffer_of.size()) + " choices for " +
                                      std::to_string(directions.size()) + " directions"};
  }
  for (std::size_t i = 0; i < directions.size(); ++i) {
    // Written so that NaN fails.
    if (!(std::abs(glm::dot(directions[i], directions[i]) - 1) <= length_tolerance)) {
      return {Fault::malformed, numbered("direction", i) + " is no unit vector"};
    }
    if (buffer_of[i] >= buffers.buffer_count) {
      return {Fault::index_out_of_range, numbered("direction", i) + " takes " + numbered("buffer", buffer_of[i]) +
                                             " of " + std::to_string(buffers.buffer_count)};
    }
  }
  for (const double rate : {buffers.mean_inverted_rate, buffers.worst_inverted_rate}) {
    if (!(rate >= 0 && rate <= 1))
      return {Fault::malformed, "index buffers: a rate of inverted pixels is not in 0 to 1"};
  }
  return {};
}

Status Checker::check_buffers(const IndexBuffers& buffers) const {
  if (Status status = check_directions(buffers); !status.ok()) return status;
  const auto& facets = buffers.facets;
  const bool fits = buffers.buffer_count <= most_elements && facets.size() == buffers.buffer_count * facets_;
  if (!fits) {
    return {Fault::size_mismatch, std::to_string(buffers.buffer_count) + " index buffers of " +
                                      std::to_string(facets_) + " facets have " + std::to_string(facets.size()) +
                                      " facets in all"};
  }
  if (facets_ == 0) return {};
  const std::size_t fault = first_fault(facets.size(), [&](std::size_t i) { return facets[i] < facets_; });
  if (fault != facets.size()) {
    return {Fault::index_out_of_range, numbered("buffer", fault / facets_) + " has " +
                                           numbered("facet", facets[fault]) + " of " + std::to_string(facets_)};
  }
  std::vector<std::uint32_t> last_buffer_with(facets_);  // counted from 1
  for (std::size_t i = 0; i < facets.size(); ++i) {
    const auto buffer = static_cast<std::uint32_t>(i / facets_ + 1);
    if (last_buffer_with[facets[i]] == buffer) {
      return {Fault::malformed, numbered("buffer", buffer - 1) + " has " + numbered("facet", facets[i]) + " twice"};
    }
    last_buffer_with[facets[i]] = buffer;
  }
  return {};
}

}  // namespace

Status validate_presorted(const PresortedView& view, const IndexBuffers* buffers) {
  try {
    const Checker checker(view);
    if (Status status = checker.check_mesh(); !status.ok()) return status;
    if (Status status = checker.check_tree(); !status.ok()) return status;
    return buffers != nullptr ? checker.check_buffers(*buffers) : Status{};
  } catch (const std::bad_alloc&) {
    return {Fault::out_of_memory, "not enough memory to check a presorted mesh"};
  }
}

}  // namespace facetsort
