#include "facetsort/exact/relation.h"

namespace facetsort::exact_internal {

SeenPart Relation::seen_part(std::uint32_t element) const {
  return {elements_.facet[element], screen_.facing(element), elements_.corners(element)};
}

// Where `element` is a piece that a cut along the plane of `other` bounds: +1 when it lies beyond that plane, -1 when
// it lies before it; 0 where there is no such cut.
int Relation::behind_by_cut(std::uint32_t element, std::uint32_t other) const {
  if (elements_.is_whole(element)) return 0;
  const PointSpace& space = points_.space();
  const FacetId facet = elements_.facet[other];
  for (const Cut& cut : parts_.cuts_of(parts_.parts[elements_.draw_id[element] - space.mesh.facet_count()])) {
    if (cut.plane != space.plane_of_facet[facet]) continue;
    return cut.side * screen_.facing(other) * (space.faces_away[facet] != 0 ? -1 : 1) < 0 ? 1 : -1;
  }
  return 0;
}

bool Relation::overlap(std::uint32_t element, const Candidate& other) const {
  const std::vector<FacetId>& plane = points_.space().plane_of_facet;
  if (plane[elements_.facet[element]] == plane[elements_.facet[other.element]]) return false;
  if (other.overlap == Seen::overlapping) return true;
  const Seen::Overlap seen = screen_.overlap(elements_, element, other.element);
  if (seen == Seen::overlapping || seen == Seen::apart) return seen == Seen::overlapping;
  return exact_internal::overlap(points_, screen_.viewpoint(), seen_part(element), seen_part(other.element));
}

bool Relation::is_behind(const ElementPair& pair, bool first) const {
  const std::vector<FacetId>& plane = points_.space().plane_of_facet;
  if (plane[elements_.facet[pair.a]] == plane[elements_.facet[pair.b]]) return false;
  const int sign = first ? 1 : -1;
  if (pair.seen.behind == -sign) return false;
  if (pair.seen.behind == sign && pair.seen.overlap == Seen::overlapping) return true;
  const int by_cut = behind_by_cut(pair.a, pair.b) - behind_by_cut(pair.b, pair.a);
  if (by_cut == -sign) return false;
  Seen seen = pair.seen;
  if (seen.overlap != Seen::overlapping) seen = screen_.compare(elements_, pair.a, pair.b, sign);
  if (by_cut != 0) seen.behind = static_cast<std::int8_t>(by_cut);
  if (seen.overlap == Seen::overlapping && seen.behind == 0 && !screen_.viewpoint().surrounded) {
    seen.behind = static_cast<std::int8_t>(screen_.behind_where_edges_cross(elements_, pair.a, pair.b));
  }
  if (seen.overlap == Seen::apart || seen.behind == -sign) return false;
  if (seen.overlap == Seen::overlapping && seen.behind == sign) return true;
  const Hiding relation = (seen.overlap == Seen::overlapping ? hiding_of_overlapping : hiding)(
      points_, screen_.viewpoint(), seen_part(pair.a), seen_part(pair.b));
  return relation == (first ? Hiding::first_behind_second : Hiding::second_behind_first);
}

}  // namespace facetsort::exact_internal
