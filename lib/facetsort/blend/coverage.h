// Internal to blend: exact coverage of pixel centres by facets, with homogeneous edge functions.
//
// Olano and Greer, "Triangle Scan Conversion using 2D Homogeneous Coordinates" (1997). With corners as homogeneous
// pixels h = (X, Y, W) (see Camera), the edge from h1 to h2 is the line L = h1 x h2, and E(p) = dot(L, (p.x, p.y, 1))
// has the sign of the side of it on which the pixel p lies. A facet covers p when its three edges agree with
// det[h0 h1 h2]; that holds for corners in front of, behind and across the eye plane alike, so nothing is clipped.
//
// Signs are decided three times over: in float, close to the facet, with a bound (place_facets-inl.h and
// covered_rows-inl.h); where that fails, in double with a bound; where that fails too, in exact integers. A centre
// exactly on an edge belongs to the facet to its right, or below it (top-left rule), which is the same as moving the
// centre by an infinitesimal amount to the right and a yet smaller one down: hence every pixel of a closed surface is
// covered exactly once a layer, at edges and corners too.
//
// A piece of a facet also covers only what lies on the given side of each of its cuts' planes. The point seen at p has
// weights E_i(p) of the facet's corners, so the plane's value there is C(p) = sum(E_i(p) s_i) up to a positive factor,
// with s_i the signed volume of the plane's corners and corner i: linear in p, one more edge function, decided in the
// same ways (in double at once where the facet is small) and by the same tie rule. Hence the two sides of a cut share
// no pixel and miss none.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/blend/view.h"
#include "facetsort/facets/pieces.h"
#include "facetsort/mesh/mesh_view.h"

namespace facetsort::blend_internal {

// What one rounding to double costs, relatively. The factors in front of it count roundings along the longest path and
// are rounded up; second-order terms are far below what the rounding up leaves.
inline constexpr double rounding = 0x1p-53;
// Of X, Y and W against the magnitude of their terms: difference, product, three sums, and the rounding of the input.
inline constexpr double projection_roundings = 8 * rounding;

// A corner in homogeneous pixels, and `reach`, which bounds the terms that X, Y and W are sums of (see ViewBounds).
struct ProjectedVertex {
  double x, y, w, reach;
};

// A corner's place on the screen in units of 2^-grid_bits pixels, so that distances on the screen are small integers.
// Each coordinate is within one unit of the true one; both are off_grid where that can't be had, or where the corner is
// nearer than the near plane.
struct GridPoint {
  std::int32_t x, y;
};
inline constexpr int grid_bits = 16;
inline constexpr std::int32_t off_grid = std::numeric_limits<std::int32_t>::min();

// The terms of X, Y and W have magnitudes that sum to at most x * reach, y * reach and w * reach.
struct ViewBounds {
  double x, y, w;
  double offset_reach;  // what the camera's constant offset adds to every reach
};

// All that coverage needs of a mesh in a view.
struct ProjectedMesh {
  MeshView mesh;
  View view;
  Camera camera{View{}};
  ViewBounds bounds{};
  std::vector<ProjectedVertex> vertices;
  std::vector<GridPoint> grid_points;  // of the vertices

  // Parallel in the caller's task arena. Keeps its storage.
  void project(const MeshView& mesh_in, const View& view_in);
};

// One facet's edge functions, oriented so that they are positive inside, in coordinates relative to an origin: a small
// origin-to-pixel distance is what keeps their rounding small. E_i(p) = a p.x + b p.y + c; edge i is opposite corner i.
struct FacetEdges {
  double a[3], b[3], c[3];
  double error[3];  // bound on the rounding of E_i wherever |p.x| and |p.y| are at most the extent asked for
};

// +1 front, -1 back, 0 seen edge-on (covers nothing). Exact.
int facet_facing(const ProjectedMesh& projected, std::uint32_t facet);

// Precondition: `facing` is the facet's, and not 0.
FacetEdges facet_edges(const ProjectedMesh& projected, std::uint32_t facet, int facing, const glm::dvec2& origin,
                       double extent);

// One cut of one facet: the plane's value at corner i is measured.volume[i]. The same for every view.
struct FacetCut {
  MeasuredCut measured;
  CutPlane plane;
  std::int32_t side;
};
// A cut of a piece, by its place in pieces.cuts: as it was measured before, or else measured now. And with its plane.
MeasuredCut measured_cut(const MeshView& mesh, const Pieces& pieces, const Piece& piece, std::size_t cut);
FacetCut facet_cut(const MeshView& mesh, const Pieces& pieces, std::size_t cut, const MeasuredCut& measured);

// A cut's edge function in the coordinates of `edges`, positive on the piece's side, and the bound on its rounding
// within `extent`, the one that `edges` was asked for.
struct CutLine {
  double a, b, c, error;
};
CutLine cut_line(const FacetEdges& edges, const MeasuredCut& cut, double extent);

// Whether the facet, or the piece of it that `cuts` leave, covers the pixel (x, y). Exact. Precondition as above.
bool covers_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, std::span<const FacetCut> cuts,
                  int x, int y);

// Pixels whose centres the facet may cover, inclusive, within the picture; empty where it covers none. Conservative.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;
  bool crosses_near = false;  // some of its fragments may be nearer than the near plane

  bool empty() const { return x0 > x1 || y0 > y1; }
};
PixelBox facet_pixels(const ProjectedMesh& projected, std::uint32_t facet);

// Pixels of something small: bit 8 r + c stands for column c of row r of a square of eight by eight.
using PixelSquare = std::uint64_t;
inline constexpr int square_size = 8;

// Of the pixels that a facet covers, in the square from (x, y) on, those that a piece of it does. Exact. Precondition:
// `facing` is the facet's, and not 0.
PixelSquare piece_pixels(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece, int facing, int x,
                         int y, PixelSquare of_facet);

// Finds which of a piece's cuts matter, and where. Keeps its scratch.
class PieceClipper {
 public:
  // Returns the pixels that the piece may cover, within `facet_box`, the facet's, and unless there are none appends to
  // `kept` those of the piece's cuts that the ones before them do not make needless. Conservative: a convex polygon in
  // double is clipped beside the cuts, by more than all rounding.
  PixelBox clip(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece, const PixelBox& facet_box,
                std::vector<FacetCut>& kept);

 private:
  std::pair<double, double> find_values(const MeasuredCut& cut);
  void cut_off_below(double lowest_kept);

  std::vector<glm::dvec3> polygon_, clipped_;  // corners, as weights of the facet's
  std::vector<double> values_;                 // of a cut at the polygon's corners
};

// Depth along the pixel's ray, as Ray has it, and a bound on its rounding. From barycentric weights, so that it lies
// between the corners' depths however thin the facet is. Precondition: the facet covers the pixel.
struct PixelDepth {
  double depth, error;
};
PixelDepth depth_at_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y);

}  // namespace facetsort::blend_internal
