// Internal to exact: where elements appear to an eye, conservatively: boxes on the screen and in depth, and a hierarchy
// over them that proposes pairs.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "facetsort/exact/elements.h"
#include "facetsort/exact/pair_kernels.h"
#include "facetsort/exact/visibility.h"

namespace facetsort::exact_internal {

// A point as the eye sees it, rounded. Where a plane has all of the mesh in front of the eye, x and y are on it, z is
// minus the nearness of ScreenPoint, and depth is along its axis. Otherwise (x, y, z) is the direction on the unit
// sphere, and depth the squared distance.
struct SeenPoint {
  float x, y, z, depth;
};

// The same on the plane, in double: x and y, and how near the point is, in a measure that is linear on the screen for
// points of a plane: the reciprocal depth in perspective, the depth itself towards an orthographic eye. Where there is
// no such plane, the three coordinates relative to the eye.
struct ScreenPoint {
  double x, y, nearness;
};

class Screen {
 public:
  // Places all elements; `keys` gets their keys by draw id.
  // Parallel in the caller's task arena; the same for any thread count. Keeps its storage.
  void look(const Points& points, const Elements& elements, const Eye& eye, std::vector<float>& keys);
  // What collect_pairs() and collect_passed() need beyond that.
  void prepare_search(const Elements& elements);

  const Viewpoint& viewpoint() const { return viewpoint_; }
  // The side of its facet's plane that the eye is on; 0 where it has no area or is seen edge-on.
  int facing(std::uint32_t element) const { return facing_[element]; }
  // A depth of the element, within its depth range: larger is farther.
  float key(std::uint32_t element) const { return keys_[element]; }
  // What a filter in double is sure of. Whether they overlap is left open where the answer is not the one asked for:
  // that the first is behind (+1) or the second (-1). Precondition: parts of different facets, neither seen edge-on,
  // that do not cross.
  Seen compare(const Elements& elements, std::uint32_t a, std::uint32_t b, int behind) const;
  // The same, of whether they overlap. Precondition: the lines of the elements' edges are known.
  Seen::Overlap overlap(const Elements& elements, std::uint32_t a, std::uint32_t b) const;
  // Of two that overlap, which is behind: +1 the first, -1 the second, 0 where this filter can't tell. Precondition: as
  // above, and viewpoint().surrounded is false.
  int behind_where_edges_cross(const Elements& elements, std::uint32_t a, std::uint32_t b) const;
  ScreenBox box(std::uint32_t element) const {
    return levels_[0][element / BoxBlock::size].box(element % BoxBlock::size);
  }

  // Elements come in leaves of eight.
  std::size_t leaves() const { return levels_[0].size(); }
  // For collect_pairs() and its like.
  Screenful screenful(const Elements& elements) const {
    return {levels_, elements.slot_blocks, patches_, keys_, flat_fan_, patch_rounding_};
  }

  // For collect_in_row().
  Outlines outlines(const Elements& elements) const {
    return {elements.outline_ids, outline_places_, elements.first_extra_patch, facing_, spans_, patch_rounding_};
  }

  std::size_t memory_bytes() const;

 private:
  template <std::size_t a_extent, std::size_t b_extent>
  Seen compare_parts(std::span<const std::uint32_t, a_extent> a_slots, int a_facing,
                     std::span<const std::uint32_t, b_extent> b_slots, int b_facing, int behind) const;
  template <std::size_t a_extent, std::size_t b_extent, typename IsOnLine>
  Seen::Overlap overlap_of(std::span<const std::uint32_t, a_extent> a_slots, int a_facing,
                           std::span<const std::uint32_t, b_extent> b_slots, int b_facing,
                           const IsOnLine& is_on_line) const;
  void choose_projection(const Elements& elements, const Eye& eye);
  void see_points(const Elements& elements);
  void place_elements(const Points& points, const Elements& elements, std::vector<float>& keys);
  void place_patches(const Elements& elements, std::uint32_t element);
  void place_outlines(const Elements& elements, std::uint32_t element);
  void bound_levels();
  void bound_on_sphere(const Elements& elements, std::uint32_t element, float (&lowest)[box_dimensions],
                       float (&highest)[box_dimensions]) const;
  void find_flat_fans(const Elements& elements);

  Viewpoint viewpoint_{};
  glm::dvec3 eye_{0};  // in the frame; orthographic: unused
  glm::dvec3 right_{0}, down_{0}, forward_{0};
  bool perspective_ = false;
  double unit_ = 1;     // of the screen's coordinates
  double largest_ = 1;  // of their magnitudes
  double rounding_ = 0;
  std::vector<SeenPoint> seen_;
  std::vector<ScreenPoint> screen_points_;
  std::vector<std::int8_t> facing_;
  std::vector<unsigned char> flat_fan_;
  std::vector<Patch> patches_;
  std::vector<OutlinePlaces> outline_places_;
  std::vector<float> spans_;
  float patch_rounding_ = 0;
  std::vector<float> keys_;
  std::vector<std::vector<BoxBlock>> levels_;  // [0]: elements; [k]: blocks of [k - 1]
};

}  // namespace facetsort::exact_internal
