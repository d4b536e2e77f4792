// The convex parts of a mesh, and whether an eye sees them side by side.
//
// A closed convex surface shows no ray more than one facet from behind and, before it, one from the front. So back
// faces and then front faces are in the right order, whatever the order of each, where no ray meets two such parts.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "facetsort/exact/facts.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort {

struct Sphere {
  glm::dvec3 centre{0};
  double radius = 0;
};

// Around all vertices that the facets use, centred in their box; grown by what rounding may cost.
Sphere bounding_sphere(const MeshView& mesh);

// Whether no ray from the eye (as SortView has it) meets both; false where that takes more than comparing their cones.
bool are_apart(const Sphere& first, const Sphere& second, const glm::vec4& eye);

class ConvexParts {
 public:
  // More parts than this are not looked at: each pair of them would be, in every view.
  static constexpr std::size_t most_parts = 64;

  // None where some facet of the mesh is of no convex closed component (see GeometryFacts), or two of them touch in a
  // vertex. Precondition: `facts` are the mesh's.
  static ConvexParts find(const MeshView& mesh, const GeometryFacts& facts);

  std::size_t count() const { return spheres_.size(); }
  // Whether no ray from the eye meets two of them.
  bool are_apart_from(const glm::vec4& eye) const;

 private:
  std::vector<Sphere> spheres_;
};

}  // namespace facetsort
