#include "facetsort/order/sorter.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "facetsort/base/parallel.h"

namespace facetsort {
namespace {

constexpr std::size_t facets_per_task = 32768;

// key = dot(q, constant + linear * q), q being the facet's point in the mesh's frame.
struct KeyForm {
  glm::vec3 constant;
  float linear;
};

// Straight distance: |q + f|^2 = |f|^2 + dot(q, q + 2 f), f being the vector from the eye to the frame's origin. The
// first term is the same for all facets and is left out, and with it the digits that a far eye would cost.
KeyForm distance_form(const FacetFrame& frame, const glm::vec4& eye) {
  const glm::dvec3 to_centre = (frame.origin - glm::dvec3(eye)) * frame.scale;
  const double largest = std::max({std::abs(to_centre.x), std::abs(to_centre.y), std::abs(to_centre.z)});
  // A power of two changes no comparison, and keeps the products finite for an eye at 1e38.
  const double shrink = largest > 1 ? std::ldexp(1.0, -std::ilogb(largest)) : 1.0;
  return {glm::vec3(2.0 * shrink * to_centre), static_cast<float>(shrink)};
}

KeyForm axis_form(const glm::vec3& direction) {
  const glm::dvec3 axis(direction);
  const double largest = std::max({std::abs(axis.x), std::abs(axis.y), std::abs(axis.z)});
  return {glm::vec3(axis * std::ldexp(1.0, -std::ilogb(largest))), 0.0f};
}

float key_of(const KeyForm& form, float x, float y, float z) {
  return x * (form.constant.x + form.linear * x) + y * (form.constant.y + form.linear * y) +
         z * (form.constant.z + form.linear * z);
}

}  // namespace

Sorter::Sorter(const MeshView& mesh, Method method) : method_(method), frame_(facet_frame(facet_bounds(mesh))) {
  switch (method) {
    case Method::centroid_distance:
    case Method::centroid_depth:
      points_[0] = facet_centroids(mesh, frame_);
      break;
    case Method::bounds_centre:
      points_[0] = facet_bounds_centres(mesh, frame_);
      break;
    case Method::first_vertex:
      points_[0] = facet_corners(mesh, 0, frame_);
      break;
    case Method::nearest_vertex:
    case Method::farthest_vertex:
      for (int i = 0; i < 3; ++i) points_[i] = facet_corners(mesh, i, frame_);
      break;
    case Method::exact:
      assert(false && "not a depth key");
  }
}

void Sorter::compute_keys(const SortView& view) {
  const bool orthographic = view.eye.w == 0.0f;
  const KeyForm form = method_ == Method::centroid_distance && !orthographic
                           ? distance_form(frame_, view.eye)
                           : axis_form(orthographic ? -glm::vec3(view.eye) : view.forward);
  const auto keys_of_corner = [&](int corner, std::size_t begin, std::size_t end, const auto& combine) {
    const PointArrays& points = points_[corner];
    for (std::size_t facet = begin; facet < end; ++facet) {
      // + 0 turns -0 into 0: equal depths must have equal bits.
      const float key = key_of(form, points.x[facet], points.y[facet], points.z[facet]) + 0.0f;
      keys_[facet] = combine(keys_[facet], key);
    }
  };
  keys_.resize(points_[0].size());
  parallel_ranges(keys_.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    keys_of_corner(0, begin, end, [](float, float key) { return key; });
    for (int corner = 1; corner < 3 && points_[corner].size() != 0; ++corner) {
      if (method_ == Method::nearest_vertex) {
        keys_of_corner(corner, begin, end, [](float a, float b) { return std::min(a, b); });
      } else {
        keys_of_corner(corner, begin, end, [](float a, float b) { return std::max(a, b); });
      }
    }
  });
}

std::span<const std::uint32_t> Sorter::sort(const SortView& view) {
  compute_keys(view);
  return key_sort_.sort(keys_);
}

void Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                          std::span<std::uint32_t> indices) {
  write_indices(view, triangles, indices);
}

void Sorter::sort_indices(const SortView& view, std::span<const glm::uvec3> triangles,
                          std::span<std::uint16_t> indices) {
  write_indices(view, triangles, indices);
}

template <typename Index>
void Sorter::write_indices(const SortView& view, std::span<const glm::uvec3> triangles, std::span<Index> indices) {
  assert(triangles.size() == points_[0].size() && indices.size() == 3 * triangles.size());
  const std::span<const std::uint32_t> order = sort(view);
  parallel_ranges(order.size(), facets_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const glm::uvec3& triangle = triangles[order[k]];
      for (int i = 0; i < 3; ++i) indices[3 * k + i] = static_cast<Index>(triangle[i]);
    }
  });
}

std::size_t Sorter::prepared_bytes() const {
  std::size_t bytes = 0;
  for (const PointArrays& points : points_) {
    bytes += (points.x.capacity() + points.y.capacity() + points.z.capacity()) * sizeof(float);
  }
  return bytes;
}

std::size_t Sorter::memory_bytes() const {
  return prepared_bytes() + keys_.capacity() * sizeof(float) + key_sort_.memory_bytes();
}

std::vector<std::uint32_t> sort_facets(const MeshView& mesh, const SortView& view, Method method) {
  Sorter sorter(mesh, method);
  const std::span<const std::uint32_t> order = sorter.sort(view);
  return {order.begin(), order.end()};
}

}  // namespace facetsort
