#include "facetsort/exact/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "facetsort/base/parallel.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::exact_internal {
namespace {

constexpr std::size_t slots_per_task = 4096;
constexpr std::size_t blocks_per_task = 256;

// Of float32, twice over: SeenPoint's coordinates are rounded once, and computed in double before.
constexpr double float_rounding = 0x1p-23;

// A point so near to the eye, over the size of the mesh, that rounding in double may turn its direction. It gets one
// outside the sphere.
constexpr double nearest_squared = 0x1p-48;
constexpr float unknown_direction = 4;

double sum_of_magnitudes(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

int eye_side(const Points& points, const FilteredPlane& plane, FacetId facet, const Eye& eye) {
  const glm::dvec3 d = eye.w == 0 ? glm::dvec3(eye) : glm::dvec3(eye) - glm::dvec3(plane.corner);
  const double value = glm::dot(plane.normal, d);
  if (std::abs(value) > plane.error * sum_of_magnitudes(d)) return value > 0 ? 1 : -1;
  const MeshView& mesh = points.space().mesh;
  return side_of_plane(mesh.corner(facet, 0), mesh.corner(facet, 1), mesh.corner(facet, 2), eye);
}

// A unit vector across `axis`.
glm::dvec3 across(const glm::dvec3& axis) {
  const glm::dvec3 a = glm::abs(axis);
  const glm::dvec3 other = a.x <= a.y && a.x <= a.z ? glm::dvec3(1, 0, 0) : a.y <= a.z ? glm::dvec3(0, 1, 0)
                                                                                      : glm::dvec3(0, 0, 1);
  return glm::normalize(glm::cross(axis, other));
}

}  // namespace

ScreenBox Screen::everywhere() {
  ScreenBox box;
  box.lowest.fill(-std::numeric_limits<float>::max());
  box.highest.fill(std::numeric_limits<float>::max());
  return box;
}

void Screen::choose_projection(const Elements& elements, const Eye& eye) {
  perspective_ = eye.w != 0;
  viewpoint_ = {eye, false};
  if (!perspective_) {
    const glm::dvec3 towards_viewer(eye);
    const double largest = std::max({std::abs(towards_viewer.x), std::abs(towards_viewer.y), std::abs(towards_viewer.z)});
    forward_ = -glm::normalize(towards_viewer / largest);
  } else {
    eye_ = (glm::dvec3(eye) - elements.frame.origin) * elements.frame.scale;
    const double distance = glm::length(eye_);
    // On the screen if all of the mesh lies within 75 degrees of the axis.
    const double widest = 0.25;
    forward_ = distance > 0 ? -eye_ / distance : glm::dvec3(0, 0, -1);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p = elements.extent * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const glm::dvec3 q = p - eye_;
      if (!(glm::dot(forward_, q) > widest * glm::length(q))) viewpoint_.surrounded = true;
    }
  }
  right_ = across(forward_);
  down_ = glm::cross(forward_, right_);
}

void Screen::see_points(const Elements& elements) {
  seen_.resize(elements.slot_position.size());
  const double distance = glm::length(eye_);
  parallel_ranges(seen_.size(), slots_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      const glm::dvec3 p = elements.slot_position[slot];
      if (viewpoint_.surrounded) {
        const glm::dvec3 q = p - eye_;
        const double squared = glm::dot(q, q);
        const bool known = squared > nearest_squared * (1 + glm::dot(elements.extent, elements.extent));
        const glm::vec3 direction(known ? q / std::sqrt(squared) : glm::dvec3(unknown_direction));
        seen_[slot] = {direction.x, direction.y, direction.z, static_cast<float>(squared)};
      } else {
        // The eye is left out where right and down are across the axis through it: far eyes cost no digits.
        const double depth = glm::dot(forward_, p);
        const double scale = perspective_ ? 1 / (depth + distance) : 1.0;
        seen_[slot] = {static_cast<float>(glm::dot(right_, p) * scale), static_cast<float>(glm::dot(down_, p) * scale),
                       0, static_cast<float>(depth)};
      }
    }
  });
}

void Screen::place_elements(const Points& points, const Elements& elements, std::vector<float>& keys) {
  const std::size_t count = elements.count();
  facing_.resize(count);
  keys.resize(elements.element_of_draw_id.size());
  const std::size_t blocks = (count + BoxBlock::size - 1) / BoxBlock::size;
  levels_.resize(std::max<std::size_t>(levels_.size(), 1));
  levels_[0].resize(blocks);
  const bool surrounded = viewpoint_.surrounded;
  const float screen_margin = rounding_;
  const auto depth_rounding = static_cast<float>(4 * float_rounding * sum_of_magnitudes(elements.extent));
  parallel_ranges(blocks, blocks_per_task, [&](std::size_t first, std::size_t last) {
    for (std::size_t block = first; block < last; ++block) {
      BoxBlock& boxes = levels_[0][block];
      for (std::size_t lane = 0; lane < BoxBlock::size; ++lane) {
        const std::size_t i = block * BoxBlock::size + lane;
        float lowest[box_dimensions], highest[box_dimensions];
        std::fill_n(lowest, box_dimensions, std::numeric_limits<float>::max());
        std::fill_n(highest, box_dimensions, std::numeric_limits<float>::lowest());
        if (i < count) {
          const auto element = static_cast<std::uint32_t>(i);
          float depths = 0;
          const auto slots = elements.slots(element);
          for (const std::uint32_t slot : slots) {
            const SeenPoint& p = seen_[slot];
            const float c[box_dimensions] = {p.x, p.y, p.z, p.depth};
            for (std::size_t d = 0; d < box_dimensions; ++d) {
              lowest[d] = std::min(lowest[d], c[d]);
              highest[d] = std::max(highest[d], c[d]);
            }
            depths += p.depth;
          }
          const float key = depths / static_cast<float>(slots.size());
          keys[elements.draw_id[i]] = std::clamp(key, lowest[3], highest[3]) + 0.0f;
          int facing = 0;
          if (elements.has_area[i]) facing = eye_side(points, elements.plane[i], elements.facet[i], viewpoint_.eye);
          facing_[i] = static_cast<std::int8_t>(facing);
          if (surrounded) bound_on_sphere(elements, element, lowest, highest);
          const float depth_margin = surrounded ? 4 * static_cast<float>(float_rounding) * highest[3]
                                                : depth_rounding;
          for (std::size_t d = 0; d < box_dimensions; ++d) {
            const float margin = d < 3 ? screen_margin : depth_margin;
            lowest[d] -= margin;
            highest[d] += margin;
          }
          if (facing == 0) {
            std::fill_n(lowest, box_dimensions, std::numeric_limits<float>::max());
            std::fill_n(highest, box_dimensions, std::numeric_limits<float>::lowest());
          }
        }
        for (std::size_t d = 0; d < box_dimensions; ++d) {
          boxes.lowest[d][lane] = lowest[d];
          boxes.highest[d][lane] = highest[d];
        }
      }
    }
  });
}

// A spherical triangle bulges beyond its corners' box: a point of the flat triangle between directions whose chords are
// at most c lies within c^2 / 3 of the sphere. And a facet comes nearer to the eye than its corners: of points whose
// squared distances are at least s, a convex combination has at least s - e^2 / 3, e being the longest edge.
void Screen::bound_on_sphere(const Elements& elements, std::uint32_t element, float (&lowest)[box_dimensions],
                             float (&highest)[box_dimensions]) const {
  const auto slots = elements.slots(element);
  float chord = 0;
  for (std::size_t i = 0; i < slots.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const SeenPoint &p = seen_[slots[i]], &q = seen_[slots[j]];
      chord = std::max(chord, (p.x - q.x) * (p.x - q.x) + (p.y - q.y) * (p.y - q.y) + (p.z - q.z) * (p.z - q.z));
    }
  }
  const bool unknown = highest[0] == unknown_direction;
  const float bulge = unknown ? 2 * unknown_direction : chord < 2.5f ? chord / 2.9f : 2.0f;
  for (std::size_t d = 0; d < 3; ++d) {
    lowest[d] -= bulge;
    highest[d] += bulge;
  }
  if (unknown) lowest[3] = std::numeric_limits<float>::lowest() / 2;
  lowest[3] -= elements.longest_edge_squared[element] / 2.9f;
}

void Screen::bound_levels() {
  std::size_t level = 0;
  for (; levels_[level].size() > 1; ++level) {
    const std::size_t blocks = levels_[level].size();
    if (levels_.size() == level + 1) levels_.emplace_back();
    levels_[level + 1].resize((blocks + BoxBlock::size - 1) / BoxBlock::size);
    parallel_ranges(levels_[level + 1].size(), blocks_per_task, [&](std::size_t first, std::size_t last) {
      for (std::size_t parent = first; parent < last; ++parent) {
        BoxBlock& bounds = levels_[level + 1][parent];
        for (std::size_t lane = 0; lane < BoxBlock::size; ++lane) {
          const std::size_t child = parent * BoxBlock::size + lane;
          for (std::size_t d = 0; d < box_dimensions; ++d) {
            float lowest = std::numeric_limits<float>::max(), highest = std::numeric_limits<float>::lowest();
            if (child < blocks) {
              const BoxBlock& block = levels_[level][child];
              lowest = *std::min_element(block.lowest[d], block.lowest[d] + BoxBlock::size);
              highest = *std::max_element(block.highest[d], block.highest[d] + BoxBlock::size);
            }
            bounds.lowest[d][lane] = lowest;
            bounds.highest[d][lane] = highest;
          }
        }
      }
    });
  }
  levels_.resize(level + 1);
}

void Screen::find_flat_fans(const Elements& elements) {
  flat_fan_.resize(seen_.size());
  parallel_ranges(seen_.size(), slots_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      const std::uint32_t first = elements.fan_begin[slot], last = elements.fan_begin[slot + 1];
      bool flat = first != last && facing_[elements.fan_element[first]] != 0;
      for (std::uint32_t i = first + 1; i < last && flat; ++i) {
        flat = facing_[elements.fan_element[i]] == facing_[elements.fan_element[first]];
      }
      flat_fan_[slot] = flat;
    }
  });
}

void Screen::look(const Points& points, const Elements& elements, const Eye& eye, std::vector<float>& keys) {
  choose_projection(elements, eye);
  see_points(elements);
  double largest = 1;
  if (!viewpoint_.surrounded) {
    largest = 0;
    for (const SeenPoint& p : seen_) {
      largest = std::max({largest, static_cast<double>(std::abs(p.x)), static_cast<double>(std::abs(p.y))});
    }
  }
  rounding_ = static_cast<float>(2 * float_rounding * largest);
  place_elements(points, elements, keys);
  bound_levels();
  find_flat_fans(elements);
}

std::size_t Screen::memory_bytes() const {
  std::size_t bytes = seen_.capacity() * sizeof(SeenPoint) + facing_.capacity() + flat_fan_.capacity();
  for (const std::vector<BoxBlock>& level : levels_) bytes += level.capacity() * sizeof(BoxBlock);
  return bytes;
}

}  // namespace facetsort::exact_internal
