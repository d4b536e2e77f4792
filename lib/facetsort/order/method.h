// The ways to find an order, by name.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace facetsort {

// All but the exact ones are depth keys of a facet: centroid_distance is straight to the eye, the others are along the
// camera axis; with an orthographic eye all are along the view direction.
enum class Method {
  centroid_distance,  // Babylon.js, facet depth sort
  centroid_depth,     // libigl sort_triangles; VTK's parametric centre is the same on triangles
  bounds_centre,      // VTK: centre of the facet's axis-aligned box
  first_vertex,       // VTK: the facet's first corner
  nearest_vertex,     // the corner nearest to the eye plane
  farthest_vertex,    // the corner farthest from it (Newell, Newell and Sancha 1972 start from this order)
  exact,              // who hides whom, decided for each pair; cuts where facets cross or hide each other in a cycle
  exact_tree,         // the same from a tree of planes built once, what these cut put together again for each view
  presorted,      // read from the same tree with all that its planes cut left cut: fastest, and most pieces
};

// In the order of the enum.
std::span<const Method> all_methods();
// Those that a Sorter takes.
std::span<const Method> depth_key_methods();
bool is_exact(Method method);
std::string_view method_name(Method method);
// Knows the names above and the alias "parametric_centre" (centroid_depth).
std::optional<Method> method_from_name(std::string_view name);

}  // namespace facetsort
