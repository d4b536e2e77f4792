// The exact order of any mesh for one view: no fragment is drawn after one that it should hide behind.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <vector>

#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/order/presorted_data.h"
#include "facetsort/order/sorter.h"

namespace facetsort {

// What the order of each view is found from.
enum class OrderFrom {
  // Pairs of facets that overlap on the screen, and cuts of what hides each other in cycles: few pieces, and nothing
  // but facets that intersect has to be looked at before the first view.
  pairs,
  // A tree of planes over all facets, built once (a binary space partition). What its planes cut is put together again
  // as far as the view allows. For meshes with many intersections and cycles, in positions that stay.
  tree,
  // The same tree, and facets left in the pieces that it cuts (see presort()): by far the fastest, with the most pieces.
  presorted,
};

// Of an exact method. Precondition: is_exact(method).
OrderFrom order_from(Method method);

struct ExactOptions {
  // Most triangles out over facets in. Where it is reached, facets that intersect or hide each other in a cycle stay
  // whole, and are counted as unordered.
  double max_growth = 64;
  // Pairs in any case where max_growth leaves facets unordered, or is too little for a tree.
  OrderFrom from = OrderFrom::pairs;
};

// What was done, in the manner of a solver's log. Times are wall clock.
struct ExactStatistics {
  // Once a mesh.
  std::size_t crossing_pairs = 0;        // pairs of facets that pass through each other
  std::size_t crossing_pairs_uncut = 0;  // of those, left because of max_growth: a lower bound of the conflicts
  std::size_t prepared_cuts = 0;         // cuts that part them
  std::size_t prepared_pieces = 0;       // pieces and whole facets after these cuts
  std::size_t tree_nodes = 0;            // of the tree; 0: there is none
  std::size_t tree_cuts = 0;             // cuts by its planes
  double prepare_ms = 0;

  // For the last view.
  std::size_t candidate_pairs = 0;  // boxes overlap on the screen and in depth
  std::size_t constraints = 0;      // constraints that the order by depth breaks
  std::size_t searches = 0;         // searches for what else must come before a piece that was drawn earlier
  std::size_t components = 0;       // groups of pieces that hide each other in cycles
  std::size_t pieces_in_cycles = 0;
  std::size_t largest_component = 0;
  std::size_t rejoined_cuts = 0;        // cuts by the tree's planes whose halves come together
  std::size_t view_cuts = 0;            // cuts that break cycles; of the tree's, those whose halves stay apart
  std::size_t unordered_pairs = 0;      // constraints left broken because of max_growth
  std::size_t predicate_fallbacks = 0;  // decisions that took multiple-precision integers
  std::size_t pieces = 0;               // pieces and whole facets drawn
  std::size_t triangles = 0;            // that they make, cracks closed
  double project_ms = 0, pairs_ms = 0, order_ms = 0, cut_ms = 0;
};

// A vertex made by a cut. Facets that share the edge it lies on each have their own, at bit-identical positions.
struct CutVertex {
  glm::vec3 position;
  std::uint32_t facet;
  glm::vec3 barycentric;  // weights of the facet's corners; they sum to 1 up to rounding
};

// The order as plain triangles, for a GPU: index i below the mesh's vertex count is a vertex of the mesh, vertex count
// + i is vertices[i], to be appended to the caller's buffer. Facets beside a cut take part in its vertices, so that no
// T-junction is left.
struct OrderedTriangles {
  std::vector<glm::uvec3> triangles;  // back to front
  std::vector<std::uint32_t> source;  // the facet that each triangle is, or is part of
  std::vector<CutVertex> vertices;
};

// Construction does what does not depend on the view: facets that pass through each other are cut apart, and a
// hierarchy over all pieces is built, or a tree. sort() then finds pairs that overlap on the screen and in depth,
// decides each by exact signs, orders them, and cuts only what hides each other in a cycle; or it walks the tree.
//
// Facets without area and facets seen edge-on hide nothing and are hidden by nothing: from pairs, they come by their
// depth alone; from a tree or presorted, those without area first. Facets in one plane, duplicates among them,
// make no constraint either: from pairs, they come by depth, then by smaller id. The order is the same for any thread
// count and instruction set.
//
// One thread at a time; works in parallel in the caller's task arena. The mesh's arrays must outlive it.
class ExactSorter {
 public:
  // Precondition: validate(mesh) is ok.
  explicit ExactSorter(const MeshView& mesh, const ExactOptions& options = {});
  // Reads the orders of a mesh presorted before, whose arrays must outlive it. Precondition: the view is sound.
  explicit ExactSorter(const PresortedView& presorted);
  ExactSorter(ExactSorter&&) noexcept;
  ExactSorter& operator=(ExactSorter&&) noexcept;
  ~ExactSorter();

  // Draw ids (see Pieces), back to front, exactly one for each facet that is whole and each piece of one that is not.
  // Only view.eye matters. The span is valid until the next call. Keeps its scratch from call to call.
  // Precondition: view.eye is finite; w = 1, or w = 0 and not a zero direction.
  std::span<const std::uint32_t> sort(const SortView& view);

  // Whether the last sort() gave an order that is right for this view too, as far as is known without sorting: its eye is
  // the same, or, of a presorted mesh, no plane of the tree lies between the two eyes. False before the first.
  bool keeps_order(const SortView& view);

  // Of the last sort(). The first call of statistics() after a sort() that cut something counts triangles, which takes
  // time.
  Pieces pieces() const;
  const ExactStatistics& statistics() const;
  OrderedTriangles triangles() const;

  // Bytes held beyond the mesh: what construction made, and with the scratch of sort().
  std::size_t prepared_bytes() const;
  std::size_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace facetsort
