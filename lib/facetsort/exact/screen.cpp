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

// On the screen all of the mesh, which is about 1 in size, lies within 75 degrees of the axis and no nearer to the
// eye's plane than this.
constexpr double nearest_depth = 0x1p-6;

double magnitude(double x, double y) {
  return std::abs(x) + std::abs(y);
}

int eye_side(const MeshView& mesh, const FilteredPlane& plane, FacetId facet, const Eye& eye) {
  return eye_side(plane, mesh.corner(facet, 0), mesh.corner(facet, 1), mesh.corner(facet, 2), eye);
}

// A unit vector.
glm::dvec3 perpendicular_to(const glm::dvec3& axis) {
  const glm::dvec3 a = glm::abs(axis);
  const glm::dvec3 other = a.x <= a.y && a.x <= a.z ? glm::dvec3(1, 0, 0)
                           : a.y <= a.z             ? glm::dvec3(0, 1, 0)
                                                    : glm::dvec3(0, 0, 1);
  return glm::normalize(glm::cross(axis, other));
}

}  // namespace

void Screen::choose_projection(const Elements& elements, const Eye& eye) {
  perspective_ = eye.w != 0;
  viewpoint_ = {eye, false};
  if (!perspective_) {
    const glm::dvec3 towards_viewer(eye);
    const double largest =
        std::max({std::abs(towards_viewer.x), std::abs(towards_viewer.y), std::abs(towards_viewer.z)});
    forward_ = -glm::normalize(towards_viewer / largest);
  } else {
    eye_ = (glm::dvec3(eye) - elements.frame.origin) * elements.frame.scale;
    const double distance = glm::length(eye_);
    const double widest = 0.25;  // the cosine of 75 degrees
    forward_ = distance > 0 ? -eye_ / distance : glm::dvec3(0, 0, -1);
    for (int corner = 0; corner < 8; ++corner) {
      const glm::dvec3 p = elements.extent * glm::dvec3(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
      const glm::dvec3 q = p - eye_;
      const double depth = glm::dot(forward_, q);
      if (!(depth > widest * glm::length(q)) || !(depth > nearest_depth)) viewpoint_.surrounded = true;
    }
  }
  right_ = perpendicular_to(forward_);
  down_ = glm::cross(forward_, right_);
  // Depths are off by some 2^-49 and the error of constructed points.
  rounding_ = 0x1p-48 + 2 * elements.largest_error;
  if (viewpoint_.surrounded) return;
  unit_ = largest_ = 1;
  double nearest = 1;
  if (perspective_) {
    const double distance = glm::length(eye_);
    nearest = distance - glm::dot(glm::abs(forward_), elements.extent);
    unit_ = std::max(distance, 1.0);  // so that a far eye's screen is about as large as the mesh
    largest_ = unit_ / nearest;
  }
  largest_ *= std::max(sum_of_magnitudes(elements.extent), 1.0);
  rounding_ *= 4 * largest_ / std::min(nearest, 1.0);
}

void Screen::see_points(const Elements& elements) {
  seen_.resize(elements.slot_position.size());
  const double distance = glm::length(eye_);
  const double nearest_known = std::max(nearest_squared * (1 + glm::dot(elements.extent, elements.extent)),
                                        0x1p+46 * elements.largest_error * elements.largest_error);
  screen_points_.resize(seen_.size());
  parallel_ranges(seen_.size(), slots_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t slot = begin; slot < end; ++slot) {
      const glm::dvec3 p = elements.slot_position[slot];
      if (viewpoint_.surrounded) {
        const glm::dvec3 q = p - eye_;
        const double squared = glm::dot(q, q);
        const bool known = squared > nearest_known;
        const glm::vec3 direction(known ? q / std::sqrt(squared) : glm::dvec3(unknown_direction));
        seen_[slot] = {direction.x, direction.y, direction.z, static_cast<float>(squared)};
        screen_points_[slot] = {q.x, q.y, q.z};
      } else {
        // The eye is left out where right and down are across the axis through it: far eyes cost no digits.
        const double depth = glm::dot(forward_, p);
        const double scale = perspective_ ? unit_ / (depth + distance) : 1.0;
        const double x = glm::dot(right_, p) * scale, y = glm::dot(down_, p) * scale;
        // For a far eye reciprocal depths are all alike: relative to that of the centre, times the distance.
        const double nearness = -depth * scale;
        seen_[slot] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(-nearness),
                       static_cast<float>(depth)};
        screen_points_[slot] = {x, y, nearness};
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
  keys_.resize(count);
  const std::size_t outlines = viewpoint_.surrounded ? 0 : count + elements.first_extra_patch.back();
  const bool as_patches = elements.outline_ids.empty();
  patches_.resize(as_patches ? outlines : 0);
  outline_places_.resize(as_patches ? 0 : outlines);
  spans_.resize(outline_places_.empty() ? 0 : count);
  const bool surrounded = viewpoint_.surrounded;
  const MeshView& mesh = points.space().mesh;
  const auto screen_margin = static_cast<float>(4 * float_rounding * (surrounded ? 1 : largest_) + 2 * rounding_);
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
          const auto slots = elements.slots(element);
          for (const std::uint32_t slot : slots) {
            const SeenPoint& p = seen_[slot];
            const float c[box_dimensions] = {
                p.x, p.y, surrounded ? p.z : p.x + p.y, p.x - p.y, surrounded ? p.depth : p.z, p.depth};
            for (std::size_t d = 0; d < box_dimensions; ++d) {
              lowest[d] = std::min(lowest[d], c[d]);
              highest[d] = std::max(highest[d], c[d]);
            }
          }
          // The same for duplicates, however their corners are turned round; + 0 for equal depths to have equal bits.
          keys_[i] = 0.5f * lowest[of_key] + 0.5f * highest[of_key] + 0.0f;
          lowest[of_key] = highest[of_key] = keys_[i];
          keys[elements.draw_id[i]] = keys_[i];
          int facing = 0;
          if (elements.has_area[i]) facing = eye_side(mesh, elements.plane[i], elements.facet[i], viewpoint_.eye);
          facing_[i] = static_cast<std::int8_t>(facing);
          if (surrounded) {
            bound_on_sphere(elements, element, lowest, highest);
          } else if (as_patches) {
            place_patches(elements, element);
          } else {
            place_outlines(elements, element);
            spans_[element] = (highest[across] - lowest[across]) + (highest[down] - lowest[down]);
          }
          const float depth_margin =
              surrounded ? 4 * static_cast<float>(float_rounding) * highest[in_depth] : screen_margin;
          for (std::size_t d = 0; d < of_key; ++d) {
            const float margin = d < in_depth ? screen_margin : depth_margin;
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

void Screen::place_patches(const Elements& elements, std::uint32_t element) {
  const auto slots = elements.slots(element);
  const int facing = facing_[element];
  const std::size_t count = slots.size();
  const auto corner = [&](std::size_t i) {
    const std::uint32_t slot = slots[facing > 0 ? i : count - 1 - i];
    const SeenPoint& p = seen_[slot];
    return Patch::Corner{p.x, p.y, -p.z, slot};
  };
  Patch& own = patches_[element];
  if (facing == 0) {
    own.corner[0].slot = Patch::unknown;
    return;
  }
  for_each_patch(elements, element, [&](std::size_t patch, const auto& corners) {
    for (int k = 0; k < 4; ++k) patches_[patch].corner[k] = corner(corners[k]);
  });
  if (count > 4) {
    const std::uint32_t first = elements.first_extra_patch[element];
    own.corner[0].slot = Patch::several;
    own.corner[1].slot = static_cast<std::uint32_t>(elements.count()) + first;
    own.corner[2].slot = elements.first_extra_patch[element + 1] - first;
  }
}

void Screen::place_outlines(const Elements& elements, std::uint32_t element) {
  const auto slots = elements.slots(element);
  for_each_patch(elements, element, [&](std::size_t outline, const auto& corners) {
    OutlinePlaces& places = outline_places_[outline];
    for (int k = 0; k < 4; ++k) {
      const SeenPoint& p = seen_[slots[corners[k]]];
      places.x[k] = p.x;
      places.y[k] = p.y;
    }
  });
  if (slots.size() > 4) {  // the origin of comparisons with its several outlines
    outline_places_[element].x[0] = seen_[slots[0]].x;
    outline_places_[element].y[0] = seen_[slots[0]].y;
  }
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
  const bool unknown = highest[across] == unknown_direction;
  const float bulge = unknown ? 2 * unknown_direction : chord < 2.5f ? chord / 2.9f : 2.0f;
  for (std::size_t d = 0; d < in_depth; ++d) {
    const float margin = d == other_diagonal ? 2 * bulge : bulge;
    lowest[d] -= margin;
    highest[d] += margin;
  }
  if (unknown) lowest[in_depth] = std::numeric_limits<float>::lowest() / 2;
  lowest[in_depth] -= elements.longest_edge_squared[element] / 2.9f;
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
  // With u = 2^-24 and coordinates up to m, those of a patch are off by u m, by 4 u m when taken relative to another,
  // and differences of such by 10 u m. A sum of two products of two of these is off by less than 34 u m times their
  // reach, which is within four times this.
  patch_rounding_ = static_cast<float>(6 * float_rounding * largest_ + 4 * rounding_);
  place_elements(points, elements, keys);
}

void Screen::prepare_search(const Elements& elements) {
  bound_levels();
  find_flat_fans(elements);
}

namespace {

enum class Edges { part, do_not_part, unsure };

// Of two parts that share an edge of both: they overlap if and only if the rest of both is on one side of it, which
// follows from how they are wound and face. Either, where they share no edge.
template <std::size_t a_extent, std::size_t b_extent>
Seen::Overlap overlap_across_edge(std::span<const std::uint32_t, a_extent> a, int a_facing,
                                  std::span<const std::uint32_t, b_extent> b, int b_facing) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::uint32_t from = a[i], to = a[i + 1 == a.size() ? 0 : i + 1];
    if (from == to) continue;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::uint32_t b_from = b[j], b_to = b[j + 1 == b.size() ? 0 : j + 1];
      if (from == b_to && to == b_from) return a_facing == b_facing ? Seen::apart : Seen::overlapping;
      if (from == b_from && to == b_to) return a_facing == b_facing ? Seen::overlapping : Seen::apart;
    }
  }
  return Seen::either;
}

}  // namespace

Seen Screen::compare(const Elements& elements, std::uint32_t a, std::uint32_t b, int behind) const {
  const auto a_slots = elements.slots(a), b_slots = elements.slots(b);
  if (a_slots.size() == 3 && b_slots.size() == 3) {
    return compare_parts(a_slots.first<3>(), facing_[a], b_slots.first<3>(), facing_[b], behind);
  }
  return compare_parts(a_slots, facing_[a], b_slots, facing_[b], behind);
}

Seen::Overlap Screen::overlap(const Elements& elements, std::uint32_t a, std::uint32_t b) const {
  const auto is_on_line = [&](std::uint32_t slot, bool of_a, std::size_t edge) {
    return elements.is_on_line(slot, elements.lines(of_a ? a : b)[edge]);
  };
  return overlap_of(elements.slots(a), facing_[a], elements.slots(b), facing_[b], is_on_line);
}

// Where each has corners on both sides of the other's plane, some two of their edges cross on the screen, and the one
// that is farther there tells: the sign of the volume that the four ends span.
int Screen::behind_where_edges_cross(const Elements& elements, std::uint32_t a, std::uint32_t b) const {
  const double error = 4 * rounding_;
  const auto a_slots = elements.slots(a), b_slots = elements.slots(b);
  struct End {
    double x, y, nearness;
  };
  const auto difference = [&](std::uint32_t from, std::uint32_t to) {
    const ScreenPoint &p = screen_points_[from], &q = screen_points_[to];
    return End{q.x - p.x, q.y - p.y, q.nearness - p.nearness};
  };
  const auto turn = [&](const End& u, const End& v) {  // 0: can't tell
    const double value = u.x * v.y - u.y * v.x;
    const double bound = error * (magnitude(u.x, u.y) + magnitude(v.x, v.y) + error);
    return value > bound ? 1 : value < -bound ? -1 : 0;
  };
  const auto size = [&](const End& u) { return magnitude(u.x, u.y) + std::abs(u.nearness) + error; };
  for (std::size_t i = 0; i < a_slots.size(); ++i) {
    const std::uint32_t p = a_slots[i], q = a_slots[i + 1 == a_slots.size() ? 0 : i + 1];
    const End edge = difference(p, q);
    End from = difference(p, b_slots.back());
    int from_side = turn(edge, from);
    std::uint32_t r = b_slots.back();
    for (const std::uint32_t s : b_slots) {
      const End to = difference(p, s);
      const int to_side = turn(edge, to);
      if (from_side * to_side < 0) {
        const End other = difference(r, s);
        if (turn(other, difference(r, p)) * turn(other, difference(r, q)) < 0) {
          const double volume = (from.y * to.nearness - from.nearness * to.y) * edge.x +
                                (from.nearness * to.x - from.x * to.nearness) * edge.y +
                                (from.x * to.y - from.y * to.x) * edge.nearness;
          const double su = size(edge), sv = size(from), sw = size(to);
          const double bound = 2 * error * (su * sv + (su + sv) * sw) + 0x1p-48 * su * sv * sw;
          if (std::abs(volume) > bound) return volume > 0 ? from_side : -from_side;
        }
      }
      from = to;
      from_side = to_side;
      r = s;
    }
  }
  return 0;
}

template <std::size_t a_extent, std::size_t b_extent>
Seen Screen::compare_parts(std::span<const std::uint32_t, a_extent> a_slots, int a_facing,
                           std::span<const std::uint32_t, b_extent> b_slots, int b_facing, int behind) const {
  const double error = 4 * rounding_;  // of a difference of coordinates, with its own rounding

  const auto at = [&](std::uint32_t slot) {
    const ScreenPoint& p = screen_points_[slot];
    return glm::dvec3(p.x, p.y, p.nearness);
  };

  // +1: all corners of the other are certainly nearer than the plane, or shared; -1: all farther; 0: neither. On the
  // screen, y points down and what is seen counter-clockwise turns clockwise.
  const double towards_eye = viewpoint_.surrounded ? 1 : -1;
  const auto side = [&](const auto& slots, int facing, const auto& others) {
    const std::size_t count = slots.size();
    const glm::dvec3 origin = at(slots[0]);
    const glm::dvec3 u = at(slots[count / 3]) - origin, v = at(slots[2 * count / 3]) - origin;
    const glm::dvec3 normal = towards_eye * facing * glm::cross(u, v);
    const double su = sum_of_magnitudes(u) + error, sv = sum_of_magnitudes(v) + error;
    bool nearer = true, farther = true;
    for (const std::uint32_t slot : others) {
      if (std::find(slots.begin(), slots.end(), slot) != slots.end()) continue;
      const glm::dvec3 w = at(slot) - origin;
      const double sw = sum_of_magnitudes(w) + error;
      const double value = glm::dot(normal, w), bound = 2 * error * (su * sv + (su + sv) * sw) + 0x1p-48 * su * sv * sw;
      nearer = nearer && value > bound;
      farther = farther && value < -bound;
      if (!nearer && !farther) return 0;
    }
    return nearer == farther ? 0 : nearer ? 1 : -1;
  };
  int known = side(a_slots, a_facing, b_slots);
  if (known == 0) known = -side(b_slots, b_facing, a_slots);
  if (known == -behind) return {Seen::either, static_cast<std::int8_t>(known)};
  const auto is_on_line = [](std::uint32_t, bool, std::size_t) { return false; };  // as far as is known
  return {overlap_of(a_slots, a_facing, b_slots, b_facing, is_on_line), static_cast<std::int8_t>(known)};
}

// is_on_line(slot, of_a, i): whether a slot is known to lie on the line of edge i of the first part, or of the second.
template <std::size_t a_extent, std::size_t b_extent, typename IsOnLine>
Seen::Overlap Screen::overlap_of(std::span<const std::uint32_t, a_extent> a_slots, int a_facing,
                                 std::span<const std::uint32_t, b_extent> b_slots, int b_facing,
                                 const IsOnLine& is_on_line) const {
  const double error = 4 * rounding_;  // of a difference of coordinates, with its own rounding

  const auto at = [&](std::uint32_t slot) {
    const ScreenPoint& p = screen_points_[slot];
    return glm::dvec3(p.x, p.y, p.nearness);
  };

  // How far a point is on the outer side of an edge, and a bound on the error of that: on the screen, or for the plane
  // through the edge and the eye.
  struct ScreenEdge {
    double x, y, from_x, from_y, magnitude_of_edge, error;

    std::pair<double, double> outward(const ScreenPoint& point) const {
      const double rx = point.x - from_x, ry = point.y - from_y;
      return {x * ry - y * rx, error * (magnitude_of_edge + magnitude(rx, ry) + error)};
    }
  };
  struct EyePlane {
    glm::dvec3 normal;
    double relative_error, error;

    std::pair<double, double> outward(const ScreenPoint& point) const {
      const glm::dvec3 r(point.x, point.y, point.nearness);
      return {glm::dot(normal, r), relative_error * sum_of_magnitudes(r) + error};
    }
  };

  // Whether some edge of one has all of the other on its outer side. Corners that they share lie on the edge, and so do
  // those that are known to be on its line.
  const auto edges_part = [&](bool of_a, const auto& slots, int facing, const auto& others, const auto& make_edge) {
    Edges result = Edges::do_not_part;
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const std::uint32_t from = slots[i], to = slots[i + 1 == slots.size() ? 0 : i + 1];
      if (from == to) continue;
      const auto edge = make_edge(from, to, facing);
      bool certain = true, inside = false;
      for (const std::uint32_t slot : others) {
        if (slot == from || slot == to) continue;
        const auto [outward, bound] = edge.outward(screen_points_[slot]);
        if (outward < -bound) {
          inside = true;
          break;
        }
        certain = certain && (outward > bound || is_on_line(slot, of_a, i));
      }
      if (inside) continue;
      if (certain) return Edges::part;
      result = Edges::unsure;
    }
    return result;
  };
  const auto edge_on_screen = [&](std::uint32_t from, std::uint32_t to, int facing) {
    const ScreenPoint &p = screen_points_[from], &q = screen_points_[to];
    const double x = facing * (q.x - p.x), y = facing * (q.y - p.y);
    return ScreenEdge{x, y, p.x, p.y, magnitude(x, y), error};
  };
  const auto plane_through_eye = [&](std::uint32_t from, std::uint32_t to, int facing) {
    const glm::dvec3 p = at(from), q = at(to);
    const double sp = sum_of_magnitudes(p) + error, sq = sum_of_magnitudes(q) + error;
    return EyePlane{static_cast<double>(facing) * glm::cross(p, q), 0x1p-48 * sp * sq + error * (sp + sq),
                    error * sp * sq};
  };
  const auto part = [&](const auto& make_edge) {
    const Edges by_a = edges_part(true, a_slots, a_facing, b_slots, make_edge);
    if (by_a == Edges::part) return by_a;
    const Edges by_b = edges_part(false, b_slots, b_facing, a_slots, make_edge);
    return by_b == Edges::do_not_part ? by_a : by_b;
  };
  Seen::Overlap overlap = overlap_across_edge(a_slots, a_facing, b_slots, b_facing);
  if (overlap == Seen::either) {
    const Edges edges = viewpoint_.surrounded ? part(plane_through_eye) : part(edge_on_screen);
    if (edges == Edges::part) overlap = Seen::apart;
    // Around the eye, parts may be apart though none of their edges tells.
    if (edges == Edges::do_not_part && !viewpoint_.surrounded) overlap = Seen::overlapping;
  }
  return overlap;
}

std::size_t Screen::memory_bytes() const {
  std::size_t bytes = seen_.capacity() * sizeof(SeenPoint) + facing_.capacity() + flat_fan_.capacity() +
                      screen_points_.capacity() * sizeof(ScreenPoint) + patches_.capacity() * sizeof(Patch) +
                      outline_places_.capacity() * sizeof(OutlinePlaces) + spans_.capacity() * sizeof(float) +
                      keys_.capacity() * sizeof(float);
  for (const std::vector<BoxBlock>& level : levels_) bytes += level.capacity() * sizeof(BoxBlock);
  return bytes;
}

}  // namespace facetsort::exact_internal
