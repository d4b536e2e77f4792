// Presorted meshes made by hand, and the plainest walk of one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/order/presorted_data.h"

namespace facetsort {

// Facet 0 in the plane z = 0, facet 1 in x = 0 cut in two by it, and facet 2 without area. Every array has something.
inline PresortedData crossing_facets() {
  PresortedData data;
  data.positions = {{-2, -2, 0}, {2, -2, 0}, {0, 2, 0}, {0, -1, -1}, {0, -1, 1}, {0, 1, 0}};
  data.facets = {{0, 1, 2}, {3, 4, 5}, {0, 1, 1}};
  data.facet_colours = {{1, 0, 0, 0.5f}, {0, 1, 0, 0.25f}, {0, 0, 1, 1}};
  data.vertex_colours = std::vector<glm::vec4>(6, {0.5f, 0.25f, 0.125f, 1});
  data.made_vertices = {{1, {0.5f, 0.5f, 0}}};
  data.made_positions = {{0, -1, 0}};
  data.nodes = {{{0, 1, 2}, 1, 1, 1}, {{3, 4, 5}, 1, 0, 0}, {{3, 4, 5}, 1, 0, 0}};
  data.pieces = {{2, 1, 0}, {0, 1, 0}, {1, 1, 1}, {1, 1, 2}};
  data.triangles = {{0, 1, 1}, {0, 1, 2}, {6, 4, 5}, {3, 6, 5}};
  data.cuts = {{0, 1}, {3, -1}, {4, -1}};
  data.planes = {{0, 1, 2}, {0, 1, 3, 4, 0}};
  return data;
}

// For the three facets above.
inline IndexBuffers two_buffers() {
  IndexBuffers buffers;
  buffers.buffer_count = 2;
  buffers.facets = {0, 1, 2, 2, 1, 0};
  buffers.directions = {{0, 0, 1}, {0, 0, -1}, {0.6f, 0.8f, 0}};
  buffers.buffer_of_direction = {0, 1, 0};
  buffers.needs_culling = true;
  buffers.mean_inverted_rate = 0.125;
  buffers.worst_inverted_rate = 0.25;
  return buffers;
}

// Facet i in the plane z = i. The tree is balanced or, with a node for each facet and all the others before it, as
// deep as it has nodes.
enum class TreeShape { balanced, chain };
inline PresortedData stacked_facets(std::uint32_t count, TreeShape shape) {
  PresortedData data;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float z = static_cast<float>(i);
    data.positions.emplace_back(0, 0, z);
    data.positions.emplace_back(1, 0, z);
    data.positions.emplace_back(0, 1, z);
    data.facets.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ranges{{0, count}};
  while (!ranges.empty()) {
    const auto [begin, end] = ranges.back();
    ranges.pop_back();
    if (begin == end) continue;
    const std::uint32_t middle = shape == TreeShape::balanced ? begin + (end - begin) / 2 : begin;
    data.nodes.push_back({data.facets[middle], 1, end - middle - 1, middle - begin});
    data.pieces.push_back({middle, 1, 0});
    data.triangles.push_back(data.facets[middle]);
    ranges.push_back({begin, middle});
    ranges.push_back({middle + 1, end});
  }
  return data;
}

// Each facet once in each of `count` buffers.
inline IndexBuffers rotated_buffers(std::uint32_t facets, std::uint32_t count) {
  IndexBuffers buffers;
  buffers.buffer_count = count;
  for (std::uint32_t buffer = 0; buffer < count; ++buffer) {
    for (std::uint32_t i = 0; i < facets; ++i) buffers.facets.push_back((i + buffer) % facets);
    buffers.directions.push_back({0, 0, 1});
    buffers.buffer_of_direction.push_back(buffer);
  }
  return buffers;
}

// The triangles back to front, as FSORT.md says. `is_in_front` tells of three points whether the eye is in front of
// their plane, or in it.
template <typename IsInFront>
std::vector<glm::uvec3> walked_by_sides(const PresortedView& view, const IsInFront& is_in_front) {
  std::vector<std::size_t> first_triangle(view.pieces.size() + 1);
  for (std::size_t p = 0; p < view.pieces.size(); ++p) {
    first_triangle[p + 1] = first_triangle[p] + view.pieces[p].triangle_count;
  }
  std::size_t piece = view.pieces.size();
  for (const PresortedNode& node : view.nodes) piece -= node.piece_count;
  std::vector<std::size_t> first_of_node{first_triangle[piece]};  // and the end of the last
  for (const PresortedNode& node : view.nodes) first_of_node.push_back(first_triangle[piece += node.piece_count]);

  std::vector<glm::uvec3> walked(view.triangles.size());
  const auto copy = [&](std::size_t begin, std::size_t end, std::size_t place) {
    for (; begin < end; ++begin, ++place) walked[place] = view.triangles[begin];
  };
  copy(0, first_of_node[0], 0);
  std::vector<std::size_t> place(view.nodes.size() + 1, first_of_node[0]);
  for (std::size_t i = 0; i < view.nodes.size(); ++i) {
    const PresortedNode& node = view.nodes[i];
    const std::span<const glm::vec3> points = view.mesh.positions;
    const bool from_front = is_in_front(points[node.plane.x], points[node.plane.y], points[node.plane.z]);
    const std::size_t front = i + 1, back = front + node.front_nodes, end = back + node.back_nodes;
    const std::size_t own = first_of_node[front] - first_of_node[i];
    const std::size_t in_front = first_of_node[back] - first_of_node[front];
    const std::size_t behind = first_of_node[end] - first_of_node[back];
    const std::size_t far = from_front ? behind : in_front, start = place[i];
    copy(first_of_node[i], first_of_node[front], start + far);
    if (node.front_nodes != 0) place[front] = from_front ? start + far + own : start;
    if (node.back_nodes != 0) place[back] = from_front ? start : start + far + own;
  }
  return walked;
}

// The same for a homogeneous eye; sides in plain double, so exact on the small whole numbers of the meshes above.
inline std::vector<glm::uvec3> walked_triangles(const PresortedView& view, const glm::dvec4& eye) {
  return walked_by_sides(view, [&](const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    return glm::dot(glm::cross(b - a, c - a), glm::dvec3(eye) - a * eye.w) >= 0;
  });
}

}  // namespace facetsort
