#include "facetsort/exact/visibility.h"

#include <algorithm>

namespace facetsort::exact_internal {
namespace {

PointId next_corner(const SeenPart& part, std::size_t i) {
  return part.corners[i + 1 == part.corners.size() ? 0 : i + 1];
}

// Whether the plane through the eye and some edge of `a` has all of `b` on its outer side, some of it strictly: an edge
// between two names of one point has no plane.
bool parted_by_edge(const Points& points, const Eye& eye, const SeenPart& a, const SeenPart& b) {
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    const PointId from = a.corners[i], to = next_corner(a, i);
    bool inside = false, outside = false;
    for (std::size_t j = 0; j < b.corners.size() && !inside; ++j) {
      if (b.corners[j] == from || b.corners[j] == to) continue;
      const int turn = points.turn(from, to, b.corners[j], eye);
      inside = turn == a.facing;
      outside = outside || turn == -a.facing;
    }
    if (!inside && outside) return true;
  }
  return false;
}

// Whether a plane through the eye, a corner of `a` and a corner of `b` parts them. Two convex cones with one apex are
// apart where such a plane or one through an edge of either parts them; where some plane has both in front, the edges
// suffice, as they do for polygons in a plane.
bool parted_by_corners(const Points& points, const Eye& eye, const SeenPart& a, const SeenPart& b) {
  for (const PointId p : a.corners) {
    for (const PointId q : b.corners) {
      int side_of_a = 0, side_of_b = 0;
      const auto on_one_side = [&](std::span<const PointId> corners, int& side) {
        for (const PointId corner : corners) {
          if (corner == p || corner == q) continue;
          const int turn = points.turn(p, q, corner, eye);
          if (turn == 0) continue;
          if (side != 0 && turn != side) return false;
          side = turn;
        }
        return side != 0;
      };
      if (p == q || !on_one_side(a.corners, side_of_a) || !on_one_side(b.corners, side_of_b)) continue;
      if (side_of_a != side_of_b) return true;
    }
  }
  return false;
}

// Which side of the plane of `plane` the other part is on: +1 all of it on the eye's, or in the plane, -1 all of it
// beyond, 0 both or neither.
int side_of_part(const Points& points, const SeenPart& plane, const SeenPart& part, bool& coplanar) {
  bool near = false, far = false;
  for (const PointId corner : part.corners) {
    const int side = points.side(plane.facet, corner) * plane.facing;
    near = near || side > 0;
    far = far || side < 0;
    if (near && far) return 0;
  }
  coplanar = !near && !far;
  return near ? 1 : far ? -1 : 0;
}

// Of two edges that cross as seen from the eye: +1 where the second is nearer, -1 where the first is, 0 where they do
// not cross, only touch, or lie on opposite sides of the eye.
int nearer_edge(const Points& points, const Viewpoint& from, PointId p, PointId q, PointId r, PointId s) {
  if (p == r || p == s || q == r || q == s) return 0;
  const int r_side = points.turn(p, q, r, from.eye), s_side = points.turn(p, q, s, from.eye);
  if (r_side * s_side >= 0) return 0;
  const int p_side = points.turn(r, s, p, from.eye), q_side = points.turn(r, s, q, from.eye);
  if (p_side * q_side >= 0) return 0;
  if (from.surrounded && p_side == r_side) return 0;  // det[p, r, s] and det[r, p, q], seen from the eye
  // In the plane of p, q, r, the edge from r to s goes to the side of s, and is nearer where the eye is there too.
  return points.orientation(p, q, r, s) * r_side;
}

// Of a corner of `inner` that `outer` surrounds as seen from the eye: +1 where it is nearer than the plane of `outer`,
// -1 where it is farther; 0 where there is none, or they are all in the plane.
int side_of_surrounded_corner(const Points& points, const Viewpoint& from, const SeenPart& outer,
                              const SeenPart& inner) {
  for (const PointId corner : inner.corners) {
    bool inside = true;
    for (std::size_t i = 0; i < outer.corners.size() && inside; ++i) {
      inside = points.turn(outer.corners[i], next_corner(outer, i), corner, from.eye) != -outer.facing;
    }
    if (!inside) continue;
    const int side = points.side(outer.facet, corner) * outer.facing;
    if (side != 0) return side;
  }
  return 0;
}

Hiding from_sign(int second_in_front) {
  return second_in_front > 0   ? Hiding::first_behind_second
         : second_in_front < 0 ? Hiding::second_behind_first
                               : Hiding::none;
}

}  // namespace

bool overlap(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b) {
  if (parted_by_edge(points, from.eye, a, b) || parted_by_edge(points, from.eye, b, a)) return false;
  return !from.surrounded || !parted_by_corners(points, from.eye, a, b);
}

Hiding hiding_of_overlapping(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b) {
  bool coplanar = false;
  const int b_side = side_of_part(points, a, b, coplanar);
  if (b_side != 0) return from_sign(b_side);
  if (coplanar) return Hiding::none;
  const int a_side = side_of_part(points, b, a, coplanar);
  if (a_side != 0) return from_sign(-a_side);
  // Each has corners on both sides of the other's plane, yet they do not cross: some corner of what they share on the
  // screen tells.
  for (std::size_t i = 0; i < a.corners.size(); ++i) {
    for (std::size_t j = 0; j < b.corners.size(); ++j) {
      const int nearer = nearer_edge(points, from, a.corners[i], next_corner(a, i), b.corners[j], next_corner(b, j));
      if (nearer != 0) return from_sign(nearer);
    }
  }
  const int b_corner = side_of_surrounded_corner(points, from, a, b);
  return from_sign(b_corner != 0 ? b_corner : -side_of_surrounded_corner(points, from, b, a));
}

Hiding hiding(const Points& points, const Viewpoint& from, const SeenPart& a, const SeenPart& b) {
  if (points.same_plane(a.facet) == points.same_plane(b.facet)) return Hiding::none;
  return overlap(points, from, a, b) ? hiding_of_overlapping(points, from, a, b) : Hiding::none;
}

}  // namespace facetsort::exact_internal
