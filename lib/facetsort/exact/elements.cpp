#include "facetsort/exact/elements.h"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/positions.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t elements_per_task = 4096;
constexpr std::size_t leaf_size = 8;

struct Item {
  float centre[3];
  float radius;        // a large facet is kept apart from small ones: it would bloat their box
  std::uint32_t part;  // facet count + piece, or facet
};

// Splits at multiples of whole subtrees of leaves, along the widest of the three coordinates and the radius.
void sort_items(Item* begin, Item* end) {
  const std::size_t count = static_cast<std::size_t>(end - begin);
  if (count <= leaf_size) return;
  const auto coordinate = [](const Item& item, int axis) { return axis < 3 ? item.centre[axis] : item.radius; };
  float lowest[4], highest[4];
  std::fill_n(lowest, 4, std::numeric_limits<float>::max());
  std::fill_n(highest, 4, std::numeric_limits<float>::lowest());
  for (const Item* item = begin; item != end; ++item) {
    for (int axis = 0; axis < 4; ++axis) {
      lowest[axis] = std::min(lowest[axis], coordinate(*item, axis));
      highest[axis] = std::max(highest[axis], coordinate(*item, axis));
    }
  }
  int widest = 0;
  for (int axis = 1; axis < 4; ++axis) {
    if (highest[axis] - lowest[axis] > highest[widest] - lowest[widest]) widest = axis;
  }
  const std::size_t leaves = (count + leaf_size - 1) / leaf_size;
  Item* middle = begin + std::bit_ceil(leaves) / 2 * leaf_size;
  std::nth_element(begin, middle, end, [&](const Item& a, const Item& b) {
    const float x = coordinate(a, widest), y = coordinate(b, widest);
    return x < y || (x == y && a.part < b.part);
  });
  if (count > elements_per_task) {
    tbb::parallel_invoke([&] { sort_items(begin, middle); }, [&] { sort_items(middle, end); });
  } else {
    sort_items(begin, middle);
    sort_items(middle, end);
  }
}

template <typename Visit>
void for_each_corner(const Points& points, const PartList& pieces, std::uint32_t part, const Visit& visit) {
  const std::size_t facets = points.space().mesh.facet_count();
  if (part < facets) {
    for (int i = 0; i < 3; ++i) visit(points.space().corner(part, i));
  } else {
    for (const PartCorner& corner : pieces.corners_of(pieces.parts[part - facets])) visit(corner.point);
  }
}

glm::dvec3 in_frame(const Points& points, const FacetFrame& frame, PointId point) {
  return (points.position(point) - frame.origin) * frame.scale;
}

class Builder {
 public:
  Builder(const Points& points, const PartList& pieces, const std::vector<unsigned char>& degenerate)
      : points_(points), mesh_(points.space().mesh), pieces_(pieces), degenerate_(degenerate) {}

  Elements build(std::span<const std::uint32_t> parts, bool with_fans) {
    elements_.frame = facet_frame(facet_bounds(mesh_));
    lay_out(parts);
    elements_.fan_begin.assign(elements_.slot_point.size() + 1, 0);
    if (with_fans) find_fans();
    return std::move(elements_);
  }

 private:
  std::size_t facets() const { return mesh_.facet_count(); }

  void lay_out(std::span<const std::uint32_t> parts) {
    const std::size_t count = parts.size();
    Elements& e = elements_;
    e.facet.resize(count);
    e.draw_id.resize(count);
    e.has_area.resize(count);
    e.plane.resize(count);
    e.longest_edge_squared.resize(count);
    e.first_corner.assign(1, 0);
    e.first_extra_patch.assign(1, 0);
    e.element_of_draw_id.assign(facets() + pieces_.parts.size(), no_element);
    const std::vector<PointId> same = identify_points(points_);
    std::vector<std::uint32_t> slot_of(points_.size(), no_element);
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t part = parts[i];
      e.facet[i] = part < facets() ? part : pieces_.parts[part - facets()].facet;
      e.draw_id[i] = part;
      e.element_of_draw_id[part] = i;
      for_each_corner(points_, pieces_, part, [&](PointId point) {
        std::uint32_t& slot = slot_of[same[point]];
        if (slot == no_element) {
          slot = static_cast<std::uint32_t>(e.slot_point.size());
          e.slot_point.push_back(same[point]);
        }
        e.corner_point.push_back(point);
        e.corner_slot.push_back(slot);
      });
      e.first_corner.push_back(static_cast<std::uint32_t>(e.corner_point.size()));
      const auto corners = static_cast<std::uint32_t>(e.corners(i).size());
      e.first_extra_patch.push_back(e.first_extra_patch.back() + (corners > 4 ? (corners - 1) / 2 : 0));
    }
    e.slot_blocks.resize((count + BoxBlock::size - 1) / BoxBlock::size);
    for (std::uint32_t i = 0; i < e.slot_blocks.size() * BoxBlock::size; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        e.slot_blocks[i / BoxBlock::size].slot[k][i % BoxBlock::size] =
            i < count && e.is_whole(i) ? e.slots(i)[k] : SlotBlock::no_slot;
      }
    }
    e.slot_position.resize(e.slot_point.size());
    for (std::size_t slot = 0; slot < e.slot_point.size(); ++slot) {
      e.slot_position[slot] = in_frame(points_, e.frame, e.slot_point[slot]);
      e.extent = glm::max(e.extent, glm::abs(e.slot_position[slot]));
      e.largest_error = std::max(e.largest_error, points_.error(e.slot_point[slot]) * e.frame.scale);
    }
    parallel_ranges(count, elements_per_task, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        e.has_area[i] = !degenerate_[e.facet[i]];
        const FacetId f = e.facet[i];
        e.plane[i] = filtered_plane(mesh_.corner(f, 0), mesh_.corner(f, 1), mesh_.corner(f, 2));
        const auto slots = e.slots(static_cast<std::uint32_t>(i));
        double longest = 0;
        for (const std::uint32_t a : slots) {
          for (const std::uint32_t b : slots) {
            const glm::dvec3 edge = e.slot_position[a] - e.slot_position[b];
            longest = std::max(longest, glm::dot(edge, edge));
          }
        }
        e.longest_edge_squared[i] = std::nextafter(static_cast<float>(longest), INFINITY);
      }
    });
  }

  void find_fans() {
    Elements& e = elements_;
    const std::size_t slots = e.slot_point.size();
    std::vector<std::uint32_t> begin(slots + 1), around(e.corner_slot.size());
    for (const std::uint32_t slot : e.corner_slot) ++begin[slot + 1];
    for (std::size_t slot = 0; slot < slots; ++slot) begin[slot + 1] += begin[slot];
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    for (std::uint32_t i = 0; i < e.count(); ++i) {
      for (const std::uint32_t slot : e.slots(i)) around[next[slot]++] = i;
    }
    std::vector<unsigned char> simple(slots);
    parallel_ranges(slots, elements_per_task, [&](std::size_t first, std::size_t last) {
      for (std::size_t slot = first; slot < last; ++slot) {
        simple[slot] = is_simple_fan(static_cast<std::uint32_t>(slot),
                                     std::span(around).subspan(begin[slot], begin[slot + 1] - begin[slot]));
      }
    });
    for (std::size_t slot = 0; slot < slots; ++slot) {
      if (simple[slot]) {
        e.fan_element.insert(e.fan_element.end(), around.begin() + begin[slot], around.begin() + begin[slot + 1]);
      }
      e.fan_begin[slot + 1] = static_cast<std::uint32_t>(e.fan_element.size());
    }
  }

  bool is_simple_fan(std::uint32_t slot, std::span<const std::uint32_t> around) const {
    constexpr std::size_t most_facets = 32;
    const std::size_t count = around.size();
    if (count < 3 || count > most_facets) return false;
    std::uint32_t out[most_facets],
        in[most_facets];  // each facet runs from the fan's vertex to `out`, to `in`, and back
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t element = around[i];
      if (elements_.draw_id[element] >= facets() || !elements_.has_area[element]) return false;
      const auto corner = elements_.slots(element);
      const int place = corner[0] == slot ? 0 : corner[1] == slot ? 1 : 2;
      out[i] = corner[(place + 1) % 3];
      in[i] = corner[(place + 2) % 3];
    }
    // From each facet over its edge to the next, once round.
    std::size_t at = 0, visited = 0;
    std::size_t sequence[most_facets];
    do {
      sequence[visited++] = at;
      std::size_t found = count, matches = 0;
      for (std::size_t i = 0; i < count; ++i) {
        if (out[i] == in[at]) {
          found = i;
          ++matches;
        }
      }
      if (matches != 1) return false;
      at = found;
    } while (at != 0 && visited < count);
    if (at != 0 || visited != count) return false;
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = i + 2; j < count; ++j) {
        if (i == 0 && j == count - 1) continue;
        const FacetId f = elements_.facet[around[sequence[i]]];
        const std::size_t g = sequence[j];
        if (points_.side(f, elements_.slot_point[out[g]]) == 0 && points_.side(f, elements_.slot_point[in[g]]) == 0) {
          return false;
        }
      }
    }
    return true;
  }

  const Points& points_;
  const MeshView mesh_;
  const PartList& pieces_;
  const std::vector<unsigned char>& degenerate_;
  Elements elements_;
};

}  // namespace

std::size_t Elements::memory_bytes() const {
  return bytes_of(facet, draw_id, has_area, plane, longest_edge_squared, first_corner, corner_point, corner_slot,
                  corner_line, slot_line_begin, slot_line, first_extra_patch, slot_blocks, outline_ids, slot_point,
                  slot_position, fan_begin, fan_element, element_of_draw_id);
}

Elements make_elements(const Points& points, const PartList& pieces, const std::vector<unsigned char>& degenerate,
                       std::span<const std::uint32_t> parts, bool with_fans) {
  return Builder(points, pieces, degenerate).build(parts, with_fans);
}

namespace {

// The line of an edge: two vertices, or two planes and a bit that tells them from vertices.
using LineKey = std::uint64_t;

LineKey key_of(std::uint32_t a, std::uint32_t b) {
  return LineKey{std::min(a, b)} << 32 | std::max(a, b);
}

LineKey key_of_planes(const Points& points, PlaneId a, PlaneId b) {
  return key_of(points.same_plane(a), points.same_plane(b)) | LineKey{1} << 63;
}

// Calls visit(key) for lines through a point that was made, as its definition has them.
template <typename Visit>
void for_each_line_of(const Points& points, const PointDefinition& definition, const Visit& visit) {
  const std::uint32_t a = definition.a, b = definition.b, c = definition.c;
  if (definition.kind == PointDefinition::three_planes) {
    visit(key_of_planes(points, a, b));
    visit(key_of_planes(points, b, c));
    visit(key_of_planes(points, a, c));
    return;
  }
  visit(key_of(a, b));
  points.space().any_facet_with_edge(a, b, [&](FacetId facet) {
    visit(key_of_planes(points, facet, c));
    return false;
  });
}

// The lines of edges that are known to go through a slot, each once: of edges that begin or end there, and by how its
// points are defined.
void list_lines_of_slots(const Points& points, std::span<const LineKey> lines, Elements& elements) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;  // slot, line
  pairs.reserve(2 * elements.corner_slot.size());
  std::vector<unsigned char> is_listed(points.size());
  for (std::uint32_t i = 0; i < elements.count(); ++i) {
    const auto slots = elements.slots(i), edges = elements.lines(i);
    const auto corners = elements.corners(i);
    for (std::size_t k = 0; k < slots.size(); ++k) {
      pairs.push_back({slots[k], edges[k]});
      pairs.push_back({slots[k + 1 == slots.size() ? 0 : k + 1], edges[k]});
      if (points.is_vertex(corners[k]) || std::exchange(is_listed[corners[k]], 1) != 0) continue;
      for_each_line_of(points, points.definition(corners[k]), [&](LineKey key) {
        const auto found = std::lower_bound(lines.begin(), lines.end(), key);
        if (found == lines.end() || *found != key) return;
        pairs.push_back({slots[k], static_cast<std::uint32_t>(found - lines.begin())});
      });
    }
  }
  tbb::parallel_sort(pairs);
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  elements.slot_line_begin.assign(elements.slot_point.size() + 1, 0);
  elements.slot_line.reserve(pairs.size());
  for (const auto& [slot, line] : pairs) {
    ++elements.slot_line_begin[slot + 1];
    elements.slot_line.push_back(line);
  }
  std::partial_sum(elements.slot_line_begin.begin(), elements.slot_line_begin.end(), elements.slot_line_begin.begin());
}

}  // namespace

void find_outline_ids(const Points& points, const PartList& pieces, Elements& elements) {
  const PointSpace& space = points.space();
  const std::size_t facets = space.mesh.facet_count();
  std::vector<LineKey> line_of_edge(elements.corner_slot.size());
  parallel_ranges(elements.count(), elements_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::uint32_t part = elements.draw_id[i];
      LineKey* line = &line_of_edge[elements.first_corner[i]];
      if (part < facets) {
        for (int k = 0; k < 3; ++k) *line++ = key_of(space.corner(part, k), space.corner(part, (k + 1) % 3));
        continue;
      }
      const Part& piece = pieces.parts[part - facets];
      for (const PartCorner& corner : pieces.corners_of(piece)) {
        if (is_facet_edge(corner.line)) {
          const auto [a, b] = edge_vertices(space, piece.facet, corner.line);
          *line++ = key_of(a, b);
        } else {
          *line++ = key_of_planes(points, piece.facet, corner.line);
        }
      }
    }
  });
  std::vector<LineKey> lines = line_of_edge;
  tbb::parallel_sort(lines);
  lines.erase(std::unique(lines.begin(), lines.end()), lines.end());

  elements.outline_ids.resize(elements.count() + elements.first_extra_patch.back());
  elements.corner_line.resize(line_of_edge.size());
  parallel_ranges(elements.count(), elements_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto slots = elements.slots(static_cast<std::uint32_t>(i));
      const std::size_t count = slots.size();
      const std::span line = std::span(elements.corner_line).subspan(elements.first_corner[i], count);
      for (std::size_t k = 0; k < count; ++k) {
        const LineKey key = line_of_edge[elements.first_corner[i] + k];
        line[k] = static_cast<std::uint32_t>(std::lower_bound(lines.begin(), lines.end(), key) - lines.begin());
      }
      for_each_patch(elements, static_cast<std::uint32_t>(i), [&](std::size_t outline, const auto& corners) {
        OutlineIds& ids = elements.outline_ids[outline];
        for (int k = 0; k < 4; ++k) {
          const std::size_t corner = corners[k], next = corners[(k + 1) % 4];
          ids.slot[k] = slots[corner];
          ids.after[k] = line[corner];
          ids.before[k] = line[(corner + count - 1) % count];
          ids.edge[k] = next == (corner + 1) % count ? line[corner] : OutlineIds::no_line;
        }
      });
    }
  });
  list_lines_of_slots(points, lines, elements);
}

std::vector<std::uint32_t> parts_to_draw(const PartList& pieces, std::size_t facet_count) {
  std::vector<unsigned char> is_cut(facet_count);
  for (const Part& piece : pieces.parts) is_cut[piece.facet] = 1;
  std::vector<std::uint32_t> parts;
  for (std::uint32_t facet = 0; facet < facet_count; ++facet) {
    if (!is_cut[facet]) parts.push_back(facet);
  }
  for (std::size_t piece = 0; piece < pieces.parts.size(); ++piece) {
    parts.push_back(static_cast<std::uint32_t>(facet_count + piece));
  }
  return parts;
}

void sort_spatially(const Points& points, const PartList& pieces, std::vector<std::uint32_t>& parts) {
  const FacetFrame frame = facet_frame(facet_bounds(points.space().mesh));
  std::vector<Item> items(parts.size());
  parallel_ranges(items.size(), elements_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      glm::dvec3 lowest(INFINITY), highest(-INFINITY);
      for_each_corner(points, pieces, parts[i], [&](PointId point) {
        lowest = glm::min(lowest, in_frame(points, frame, point));
        highest = glm::max(highest, in_frame(points, frame, point));
      });
      const glm::vec3 centre((lowest + highest) / 2.0);
      items[i] = {{centre.x, centre.y, centre.z}, static_cast<float>(glm::length(highest - lowest) / 2), parts[i]};
    }
  });
  sort_items(items.data(), items.data() + items.size());
  for (std::size_t i = 0; i < parts.size(); ++i) parts[i] = items[i].part;
}

}  // namespace facetsort::exact_internal
