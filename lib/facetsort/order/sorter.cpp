// What does not depend on the view is computed once; of a view, the form of its keys. Sorting is FacetSort's.
#include "facetsort/order/sorter.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/order/depth_kernels.h"
#include "facetsort/order/facet_sort.h"

namespace facetsort {

using namespace order_internal;

namespace {

constexpr std::size_t facets_per_task = 16384;

// The largest of a vector's components brought into [1, 2) by a power of two, which changes no comparison and keeps
// products finite for an eye at 1e38.
double exact_shrink(const glm::dvec3& v) {
  return std::ldexp(1.0, -std::ilogb(std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)})));
}

// Straight distance. Near the mesh, differences to the eye are exact enough: their error is a rounding of the distance.
// Far from it, |q + f|^2 = |f|^2 + dot(q, q + 2 f), f being the vector from the eye to the frame's origin: the first
// term is the same for all facets and is left out, and with it the digits that a far eye would cost.
KeyForm distance_form(const FacetFrame& frame, const glm::vec4& eye) {
  // In units of the frame, in which the mesh reaches to 2: where the two forms' errors meet.
  constexpr double near = 4;
  const glm::dvec3 to_centre = (frame.origin - glm::dvec3(eye)) * frame.scale;
  const double largest = std::max({std::abs(to_centre.x), std::abs(to_centre.y), std::abs(to_centre.z)});
  if (largest < near) return {.kind = KeyForm::Kind::distance, .eye = glm::vec3(-to_centre)};
  const double shrink = exact_shrink(to_centre);
  return {.kind = KeyForm::Kind::polynomial,
          .constant = glm::vec3(2.0 * shrink * to_centre),
          .linear = static_cast<float>(shrink)};
}

KeyForm axis_form(const glm::vec3& direction) {
  const glm::dvec3 axis(direction);
  return {.kind = KeyForm::Kind::polynomial, .constant = glm::vec3(axis * exact_shrink(axis))};
}

FacingTest facing_test(const FacetFrame& frame, const glm::vec4& eye) {
  FacingTest test;
  const glm::dvec3 to_eye = eye.w == 0.0f ? glm::dvec3(eye) : (glm::dvec3(eye) - frame.origin) * frame.scale;
  const double shrink = eye.w == 0.0f || glm::length(to_eye) > 1 ? exact_shrink(to_eye) : 1.0;
  test.eye = glm::vec3(to_eye * shrink);
  test.scale = eye.w == 0.0f ? 0.0f : static_cast<float>(shrink);
  return test;
}

// Of unit normal, in the frame.
glm::vec4 plane_in_frame(const FacetFrame& frame, const glm::vec4& plane) {
  const glm::dvec3 normal(plane);
  const double length = glm::length(normal);
  const double offset = (glm::dot(normal, frame.origin) + static_cast<double>(plane.w)) * frame.scale / length;
  constexpr double limit = 1e30;
  return {glm::vec3(normal / length), static_cast<float>(std::clamp(offset, -limit, limit))};
}

// Sixteen bits are enough for a test that errs on one side: see FacingTest.
struct Normals {
  std::vector<std::int16_t> x, y, z;
};

// Of the facets [first, last).
void compute_normals(std::span<const glm::uvec3> triangles, const StridedPositions& positions, std::size_t first,
                     std::size_t last, Normals& normals) {
  for (auto* component : {&normals.x, &normals.y, &normals.z}) component->resize(triangles.size());
  parallel_ranges(last - first, facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t facet = first + begin; facet < first + end; ++facet) {
      const glm::uvec3& t = triangles[facet];
      const glm::dvec3 a(positions[t.x]);
      const glm::dvec3 normal = glm::cross(glm::dvec3(positions[t.y]) - a, glm::dvec3(positions[t.z]) - a);
      const double largest = std::max({std::abs(normal.x), std::abs(normal.y), std::abs(normal.z)});
      const glm::dvec3 steps = largest > 0 ? normal * (32767.0 / largest) : glm::dvec3(0);
      normals.x[facet] = static_cast<std::int16_t>(std::lround(steps.x));
      normals.y[facet] = static_cast<std::int16_t>(std::lround(steps.y));
      normals.z[facet] = static_cast<std::int16_t>(std::lround(steps.z));
    }
  });
}

std::size_t blocks_of(std::size_t facets) {
  return (facets + block_facets - 1) / block_facets;
}

// Calls body(block) for the blocks that facets [first, last) are in.
template <typename Body>
void for_blocks(std::size_t first, std::size_t last, const Body& body) {
  const std::size_t first_block = first / block_facets;
  parallel_ranges(blocks_of(last) - first_block, facets_per_task / block_facets,
                  [&](std::size_t begin, std::size_t end) {
                    for (std::size_t block = begin; block < end; ++block) body(first_block + block);
                  });
}

// Of normals as they are tested, and so as they were rounded; of the blocks that facets [begin, end) are in.
void compute_cones(const Normals& normals, const PointArrays& points, std::size_t begin, std::size_t end,
                   std::vector<NormalCone>& cones) {
  constexpr double outwards = 0x1p-20;
  const std::size_t facets = normals.x.size();
  cones.resize(blocks_of(facets));
  for_blocks(begin, end, [&](std::size_t block) {
    std::array<glm::dvec3, block_facets> directions;
    const std::size_t first = block * block_facets, count = std::min(block_facets, facets - first);
    glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest = -lowest, sum(0);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t facet = first + i;
      const glm::dvec3 point(points.x[facet], points.y[facet], points.z[facet]);
      const glm::dvec3 normal(normals.x[facet], normals.y[facet], normals.z[facet]);
      lowest = glm::min(lowest, point);
      highest = glm::max(highest, point);
      directions[i] = normal / std::max(glm::length(normal), 1.0);
      sum += directions[i];
    }
    const glm::dvec3 axis = sum / std::max(glm::length(sum), 1e-6);
    double cosine = 1;
    for (std::size_t i = 0; i < count; ++i) cosine = std::min(cosine, glm::dot(directions[i], axis));
    cosine -= outwards;
    const bool is_cone = cosine > 0;
    const glm::dvec3 centre = (lowest + highest) / 2.0;
    cones[block] = {.centre = glm::vec3(centre),
                    .radius = static_cast<float>(glm::length(highest - centre) + outwards),
                    .axis = glm::vec3(axis),
                    .cosine = is_cone ? static_cast<float>(cosine) : 0,
                    .sine = is_cone ? static_cast<float>(std::sqrt(1 - cosine * cosine) + outwards) : 1};
  });
}

void compute_blocks(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const FacetFrame& frame,
                    const PointArrays& points, std::size_t begin, std::size_t end, std::vector<FacetBlock>& blocks) {
  constexpr double outwards = 0x1p-21;  // beyond the rounding of a coordinate below 2
  blocks.resize(blocks_of(triangles.size()));
  for_blocks(begin, end, [&](std::size_t block) {
    const std::size_t first = block * block_facets, last = std::min(first + block_facets, triangles.size());
    glm::dvec3 lowest(std::numeric_limits<double>::infinity()), highest = -lowest;
    double reach = 0;
    for (std::size_t facet = first; facet < last; ++facet) {
      const glm::dvec3 point(points.x[facet], points.y[facet], points.z[facet]);
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 corner = (glm::dvec3(positions[triangles[facet][i]]) - frame.origin) * frame.scale;
        lowest = glm::min(lowest, corner);
        highest = glm::max(highest, corner);
        reach = std::max(reach, glm::length(corner - point));
      }
    }
    blocks[block] = {glm::vec3(lowest - outwards), glm::vec3(highest + outwards), static_cast<float>(reach + outwards)};
  });
}

bool contains(const Box& box, const Box& inner) {
  return glm::all(glm::lessThanEqual(box.lowest, inner.lowest)) &&
         glm::all(glm::greaterThanEqual(box.highest, inner.highest));
}

}  // namespace

struct Sorter::State {
  SorterOptions options;
  Box box;  // of all facets when they were last all new, which makes the frame
  FacetFrame frame;
  PointArrays points[3];  // one set for the keys of one point a facet; three corners for nearest and farthest
  PointArrays centroids;  // to cull by, where points[0] lies beside the facet's plane
  Normals normals;
  std::vector<NormalCone> cones;  // of the normals, a block each
  std::vector<FacetBlock> blocks;

  FacetSort facet_sort;
  Scratch<float> asked_keys;

  // What was sorted last.
  bool has_view = false;
  SortView view;
  std::array<glm::vec4, most_clip_planes> view_planes{};
  std::size_t facets_in_ids = 0;
  bool ids_hold_order = false, asked_keys_are_current = false;

  std::size_t facet_count() const { return points[0].size(); }
  void prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions);
  void prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions, std::size_t begin,
               std::size_t end);
  bool is_sorted_for(const SortView& other) const;
  void remember(const SortView& sorted_view);
  void forget_view() { has_view = ids_hold_order = asked_keys_are_current = false; }
  KeySource source() const;
  Keys keys() const { return options.precision == Precision::whole ? Keys::whole : Keys::quantised; }
  std::size_t sort_all(const SortView& view, const Output& output);
  template <typename Index>
  std::size_t sort_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<Index> indices,
                           std::span<std::uint32_t> ids_out);
  template <typename Index>
  void sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles, std::span<const FacetRange> ranges,
                   std::span<Index> indices, std::span<std::uint32_t> counts_out, std::span<std::uint32_t> ids_out);
  std::size_t prepared_bytes() const;
};

void Sorter::State::prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  box = facet_bounds(triangles, positions);
  frame = facet_frame(box);
  prepare(triangles, positions, 0, triangles.size());
}

// Facets [begin, end), in the frame that there is.
void Sorter::State::prepare(std::span<const glm::uvec3> triangles, const StridedPositions& positions, std::size_t begin,
                            std::size_t end) {
  const auto compute = [&](FacetPoint point, PointArrays& to) {
    for (auto* component : {&to.x, &to.y, &to.z}) component->resize(triangles.size());
    compute_facet_points(triangles, positions, point, frame, begin, end, to);
  };
  switch (options.method) {
    case Method::centroid_distance:
    case Method::centroid_depth:
      compute(FacetPoint::centroid, points[0]);
      break;
    case Method::bounds_centre:
      compute(FacetPoint::bounds_centre, points[0]);
      if (options.cull_back_faces) compute(FacetPoint::centroid, centroids);
      break;
    case Method::first_vertex:
      compute(FacetPoint::corner_0, points[0]);
      break;
    case Method::nearest_vertex:
    case Method::farthest_vertex:
      compute(FacetPoint::corner_0, points[0]);
      compute(FacetPoint::corner_1, points[1]);
      compute(FacetPoint::corner_2, points[2]);
      break;
    case Method::exact:
    case Method::exact_tree:
    case Method::presorted:
      assert(false && "not a depth key");
  }
  const PointArrays& culled_by = centroids.size() == 0 ? points[0] : centroids;
  if (options.cull_back_faces) {
    compute_normals(triangles, positions, begin, end, normals);
    compute_cones(normals, culled_by, begin, end, cones);
  }
  if (options.cull_by_clip_planes) compute_blocks(triangles, positions, frame, culled_by, begin, end, blocks);
  forget_view();
}

bool Sorter::State::is_sorted_for(const SortView& other) const {
  if (!has_view || view.eye != other.eye) return false;
  const bool uses_axis = options.method != Method::centroid_distance && view.eye.w != 0;
  if (uses_axis && view.forward != other.forward) return false;
  return !options.cull_by_clip_planes || std::equal(view.clip_planes.begin(), view.clip_planes.end(),
                                                    other.clip_planes.begin(), other.clip_planes.end());
}

void Sorter::State::remember(const SortView& sorted_view) {
  has_view = true;
  asked_keys_are_current = false;
  view = sorted_view;
  view.clip_planes = {};
  if (!options.cull_by_clip_planes) return;
  assert(sorted_view.clip_planes.size() <= view_planes.size());
  const std::size_t planes = std::min(sorted_view.clip_planes.size(), view_planes.size());
  std::copy_n(sorted_view.clip_planes.begin(), planes, view_planes.begin());
  view.clip_planes = std::span(view_planes).first(planes);
}

// Of the view remembered.
KeySource Sorter::State::source() const {
  const bool orthographic = view.eye.w == 0.0f;
  const auto of = [](const PointArrays& from) {
    return KeySource::Points{from.x.data(), from.y.data(), from.z.data()};
  };
  KeySource made;
  for (int i = 0; i < 3; ++i) made.points[i] = of(points[i]);
  made.culled_by = of(centroids.size() == 0 ? points[0] : centroids);
  made.form = options.method == Method::centroid_distance && !orthographic
                  ? distance_form(frame, view.eye)
                  : axis_form(orthographic ? -glm::vec3(view.eye) : view.forward);
  made.combine = options.method == Method::nearest_vertex    ? Combine::nearest
                 : options.method == Method::farthest_vertex ? Combine::farthest
                                                             : Combine::none;
  made.sign = options.direction == Direction::front_to_back ? -1.0f : 1.0f;
  if (options.cull_back_faces) {
    made.facing = facing_test(frame, view.eye);
    made.facing.cones = cones.data();
    made.facing.x = normals.x.data();
    made.facing.y = normals.y.data();
    made.facing.z = normals.z.data();
  }
  if (options.cull_by_clip_planes) {
    made.blocks = blocks.data();
    for (const glm::vec4& plane : view.clip_planes) made.planes[made.plane_count++] = plane_in_frame(frame, plane);
  }
  return made;
}

std::size_t Sorter::State::sort_all(const SortView& of_view, const Output& output) {
  remember(of_view);
  const std::size_t threads = facet_sort.reserve(facet_count());
  return facets_in_ids = facet_sort.sort(source(), 0, facet_count(), keys(), threads, 0, output);
}

template <typename Index>
Output output_to(std::span<const glm::uvec3> triangles, std::span<Index> indices, std::span<std::uint32_t> ids) {
  Output output;
  constexpr std::size_t fit_the_cache = 262144;  // 24 bytes each; measured
  output.corners = &triangles.data()->x;
  output.is_from_memory = triangles.size() > fit_the_cache;
  if constexpr (sizeof(Index) == sizeof(std::uint32_t)) {
    output.indices_32 = indices.data();
  } else {
    output.indices_16 = indices.data();
  }
  output.ids = ids.empty() ? nullptr : ids.data();
  return output;
}

template <typename Index>
std::size_t Sorter::State::sort_indices(const SortView& of_view, std::span<const glm::uvec3> triangles,
                                        std::span<Index> indices, std::span<std::uint32_t> ids_out) {
  assert(triangles.size() == facet_count() && indices.size() >= 3 * triangles.size());
  assert(ids_out.empty() || ids_out.size() >= triangles.size());
  ids_hold_order = false;
  return sort_all(of_view, output_to(triangles, indices, ids_out));
}

template <typename Index>
void Sorter::State::sort_ranges(const SortView& of_view, std::span<const glm::uvec3> triangles,
                                std::span<const FacetRange> ranges, std::span<Index> indices,
                                std::span<std::uint32_t> counts_out, std::span<std::uint32_t> ids_out) {
  assert(triangles.size() == facet_count() && indices.size() >= 3 * triangles.size());
  assert(ids_out.empty() || ids_out.size() >= triangles.size());
  assert(counts_out.size() == ranges.size());
  remember(of_view);
  has_view = ids_hold_order = false;  // no order of all facets
  const std::size_t threads = facet_sort.reserve(facet_count());
  const KeySource from = source();
  const Output output = output_to(triangles, indices, ids_out);
  const auto sort_one = [&](std::size_t range, std::size_t with_threads, std::size_t thread) {
    const FacetRange& r = ranges[range];
    assert(std::size_t{r.first} + r.count <= facet_count());
    counts_out[range] = static_cast<std::uint32_t>(facet_sort.sort(from, r.first, std::size_t{r.first} + r.count,
                                                                   keys(), with_threads, thread, output + r.first));
  };
  const auto is_large = [&](std::size_t range) { return facet_sort.is_large(ranges[range].count); };
  // A large range has work for all threads; the others are shared out.
  for (std::size_t range = 0; range < ranges.size(); ++range) {
    if (is_large(range)) sort_one(range, threads, 0);
  }
  std::atomic<std::size_t> next{0};
  for_threads(threads, [&](std::size_t thread) {
    for (std::size_t range; (range = next.fetch_add(1, std::memory_order_relaxed)) < ranges.size();) {
      if (!is_large(range)) sort_one(range, 1, thread);
    }
  });
}

std::size_t Sorter::State::prepared_bytes() const {
  const auto bytes = [](const auto& list) { return list.capacity() * sizeof(list[0]); };
  std::size_t sum = bytes(normals.x) + bytes(normals.y) + bytes(normals.z) + bytes(cones) + bytes(blocks);
  for (const PointArrays* of : {&points[0], &points[1], &points[2], &centroids}) {
    sum += bytes(of->x) + bytes(of->y) + bytes(of->z);
  }
  return sum;
}

std::array<glm::vec4, 6> clip_planes_of(const glm::mat4& clip_from_mesh) {
  const glm::mat4 rows = glm::transpose(clip_from_mesh);
  return {rows[3] + rows[0], rows[3] - rows[0], rows[3] + rows[1],
          rows[3] - rows[1], rows[3] + rows[2], rows[3] - rows[2]};
}

Sorter::Sorter(const MeshView& mesh, Method method) : Sorter(mesh, SorterOptions{.method = method}) {}

Sorter::Sorter(const MeshView& mesh, const SorterOptions& options)
    : Sorter(mesh.triangles, StridedPositions(mesh.positions), options) {}

Sorter::Sorter(std::span<const glm::uvec3> triangles, const StridedPositions& positions, const SorterOptions& options)
    : state_(std::make_unique<State>()) {
  state_->options = options;
  state_->prepare(triangles, positions);
}

Sorter::Sorter(Sorter&&) noexcept = default;
Sorter& Sorter::operator=(Sorter&&) noexcept = default;
Sorter::~Sorter() = default;

void Sorter::set_positions(std::span<const glm::uvec3> triangles, const StridedPositions& positions) {
  assert(triangles.size() == state_->facet_count());
  state_->prepare(triangles, positions);
}

void Sorter::set_positions(std::span<const glm::uvec3> triangles, const StridedPositions& positions,
                           const FacetRange& changed) {
  assert(triangles.size() == state_->facet_count());
  assert(std::size_t{changed.first} + changed.count <= triangles.size());
  if (changed.count == 0) return;
  const Box box = facet_bounds(triangles.subspan(changed.first, changed.count), positions);
  if (!contains(state_->box, box)) return set_positions(triangles, positions);
  state_->prepare(triangles, positions, changed.first, std::size_t{changed.first} + changed.count);
}

std::span<const std::uint32_t> Sorter::sort(const SortView& view) {
  State& state = *state_;
  if (!(state.ids_hold_order && state.is_sorted_for(view))) {
    state.facet_sort.reserve(state.facet_count());
    Output output;
    output.ids = state.facet_sort.ids();
    state.sort_all(view, output);
    state.ids_hold_order = true;
  }
  return {state.facet_sort.ids(), state.facets_in_ids};
}

std::size_t Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                                 std::span<std::uint32_t> indices, std::span<std::uint32_t> ids) {
  return state_->sort_indices(view, triangles, indices, ids);
}

std::size_t Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                                 std::span<std::uint16_t> indices, std::span<std::uint32_t> ids) {
  return state_->sort_indices(view, triangles, indices, ids);
}

void Sorter::sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles,
                         std::span<const FacetRange> ranges, std::span<std::uint32_t> indices,
                         std::span<std::uint32_t> counts, std::span<std::uint32_t> ids) {
  state_->sort_ranges(view, triangles, ranges, indices, counts, ids);
}

void Sorter::sort_ranges(const SortView& view, std::span<const glm::uvec3> triangles,
                         std::span<const FacetRange> ranges, std::span<std::uint16_t> indices,
                         std::span<std::uint32_t> counts, std::span<std::uint32_t> ids) {
  state_->sort_ranges(view, triangles, ranges, indices, counts, ids);
}

bool Sorter::is_sorted_for(const SortView& view) const {
  return state_->is_sorted_for(view);
}

void Sorter::forget_view() {
  state_->forget_view();
}

std::span<const float> Sorter::keys() {
  State& state = *state_;
  float* keys = state.asked_keys.get(state.facet_count());
  if (!state.asked_keys_are_current) {
    const KeySource source = state.source();
    parallel_ranges(state.facet_count(), facets_per_task,
                    [&](std::size_t begin, std::size_t end) { compute_keys(source, begin, end, keys + begin); });
    state.asked_keys_are_current = true;
  }
  return {keys, state.facet_count()};
}

Method Sorter::method() const {
  return state_->options.method;
}

std::size_t Sorter::prepared_bytes() const {
  return state_->prepared_bytes();
}

std::size_t Sorter::memory_bytes() const {
  const State& state = *state_;
  return state.prepared_bytes() + state.facet_sort.bytes() + state.asked_keys.bytes();
}

int key_bits(Precision precision, std::size_t facets) {
  const std::size_t steps = precision == Precision::quantised ? steps_of_quantised_keys(facets) : 0;
  return steps == 0 ? std::numeric_limits<std::uint32_t>::digits : static_cast<int>(std::bit_width(steps - 1));
}

std::vector<std::uint32_t> sort_facets(const MeshView& mesh, const SortView& view, Method method) {
  Sorter sorter(mesh, {.method = method, .precision = Precision::whole});
  const std::span<const std::uint32_t> order = sorter.sort(view);
  return {order.begin(), order.end()};
}

}  // namespace facetsort
