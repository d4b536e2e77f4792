#include "facetsort/blend/coverage.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "facetsort/base/parallel.h"
#include "facetsort/blend/facet_kernels.h"
#include "facetsort/exact/plane_points.h"
#include "facetsort/exact/predicates.h"

namespace facetsort::blend_internal {
namespace {

constexpr std::size_t vertices_per_task = 16384;

// Of an edge function against the product of its corners' magnitudes: product, difference, and evaluation at a pixel.
constexpr double edge_roundings = 8 * rounding;

double largest_component(const glm::dvec3& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

// A corner relative to an origin on the screen, its magnitude over the extent, and the rounding of that.
struct RelativeVertex {
  double x, y, w, magnitude, error;
};

// How RelativeVertex::error follows from `reach`.
double relative_error_factor(const ViewBounds& bounds, const glm::dvec2& origin, double extent) {
  return projection_roundings *
         (bounds.x + bounds.y + (std::abs(origin.x) + std::abs(origin.y) + extent) * bounds.w);
}

RelativeVertex relative_vertex(const ProjectedVertex& vertex, const glm::dvec2& origin, double extent,
                               double error_factor) {
  const double x = vertex.x - origin.x * vertex.w;
  const double y = vertex.y - origin.y * vertex.w;
  return {x, y, vertex.w, std::abs(x) + std::abs(y) + extent * std::abs(vertex.w), error_factor * vertex.reach};
}

// Every term of E is a product of one component of each corner, so the products of magnitudes bound it.
double edge_error(const RelativeVertex& p, const RelativeVertex& q) {
  return p.error * q.magnitude + p.magnitude * q.error + edge_roundings * p.magnitude * q.magnitude;
}

// Of a cut's function against the product of one edge function and one volume: product, two sums, and evaluation.
constexpr double cut_roundings = 8 * rounding;

// How far the value of a cut's term strays that is the product of an edge function, of magnitude at most `reach`, and
// of a volume.
double cut_term_error(double reach, double edge_rounding, double volume, double volume_error) {
  return edge_rounding * (std::abs(volume) + volume_error) + reach * (volume_error + cut_roundings * std::abs(volume));
}

// E_i at one pixel centre, and its error.
struct EdgeValues {
  double value[3], error[3];
};

EdgeValues edges_at_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y) {
  const glm::dvec2 centre(x + 0.5, y + 0.5);
  const double factor = relative_error_factor(projected.bounds, centre, 0);
  RelativeVertex corner[3];
  for (int i = 0; i < 3; ++i) {
    corner[i] = relative_vertex(projected.vertices[projected.mesh.triangles[facet][i]], centre, 0, factor);
  }
  EdgeValues edges;
  for (int i = 0; i < 3; ++i) {
    const RelativeVertex& p = corner[(i + 1) % 3];
    const RelativeVertex& q = corner[(i + 2) % 3];
    edges.value[i] = -facing * (p.x * q.y - p.y * q.x);
    edges.error[i] = edge_error(p, q);
  }
  return edges;
}

std::array<glm::vec3, 3> positions_of(const MeshView& mesh, const glm::uvec3& vertices) {
  return {mesh.positions[vertices.x], mesh.positions[vertices.y], mesh.positions[vertices.z]};
}

int clamp_pixel(double value, int highest) {
  return static_cast<int>(std::clamp(value, -1.0, static_cast<double>(highest) + 1.0));
}

// The pixels around points, with a margin for their rounding.
class PixelBounds {
 public:
  void include(const ViewBounds& bounds, double x, double y, double w, double reach) {
    const double px = x / w, py = y / w;
    x0_ = std::min(x0_, px);
    x1_ = std::max(x1_, px);
    y0_ = std::min(y0_, py);
    y1_ = std::max(y1_, py);
    const double terms = bounds.x + bounds.y + (std::abs(px) + std::abs(py)) * bounds.w;
    margin_ = std::max(margin_, 4 * projection_roundings * terms * reach / w);
  }

  PixelBox box(const View& view) const {
    PixelBox box;
    box.x0 = std::max(0, clamp_pixel(std::ceil(x0_ - margin_ - 0.5), view.width));
    box.y0 = std::max(0, clamp_pixel(std::ceil(y0_ - margin_ - 0.5), view.height));
    box.x1 = std::min(view.width - 1, clamp_pixel(std::floor(x1_ + margin_ - 0.5), view.width));
    box.y1 = std::min(view.height - 1, clamp_pixel(std::floor(y1_ + margin_ - 0.5), view.height));
    return box;
  }

 private:
  double x0_ = INFINITY, x1_ = -INFINITY, y0_ = INFINITY, y1_ = -INFINITY, margin_ = 0;
};

glm::dmat3 camera_rows(const Camera& camera) { return {camera.row_x, camera.row_y, camera.row_w}; }

// The side of the point (x, y), moved by the infinitesimal amount that decides ties.
int shifted_sign(const EdgeSigns& signs) {
  return signs.at_pixel != 0 ? signs.at_pixel : signs.x != 0 ? signs.x : signs.y;
}

// Whether the point that the facet shows at a pixel where it lies within its edges is on the piece's side of a cut.
bool is_on_side(const ProjectedMesh& projected, std::uint32_t facet, int facing, const FacetCut& cut,
                const EdgeValues& edges, int x, int y) {
  double value = 0, error = 0;
  for (int i = 0; i < 3; ++i) {
    const MeasuredCut& measured = cut.measured;
    value += edges.value[i] * measured.volume[i];
    error += cut_term_error(std::abs(edges.value[i]), edges.error[i], measured.volume[i], measured.error);
  }
  if (std::abs(value) > error) return value > 0;
  const EdgeSigns signs =
      exact_cut_signs(positions_of(projected.mesh, projected.mesh.triangles[facet]),
                      points_of(projected.mesh, cut.plane), projected.view.eye, camera_rows(projected.camera),
                      projected.camera.offset, x + 0.5, y + 0.5);
  const int side = -facing * shifted_sign(signs);
  // A facet that lies in the plane is on its positive side, so that one of the two sides has it.
  return (side != 0 ? side : 1) == cut.side;
}

}  // namespace

void ProjectedMesh::project(const MeshView& mesh_in, const View& view_in) {
  mesh = mesh_in;
  view = view_in;
  camera = Camera(view);
  bounds.offset_reach = std::max(std::abs(camera.offset.x), std::abs(camera.offset.y)) /
                        std::max(largest_component(camera.row_x), largest_component(camera.row_y));
  const auto bound = [&](const glm::dvec3& row, double offset) {
    const double from_offset = bounds.offset_reach > 0 ? std::abs(offset) / bounds.offset_reach : 0.0;
    return std::max(largest_component(row), from_offset);
  };
  bounds.x = bound(camera.row_x, camera.offset.x);
  bounds.y = bound(camera.row_y, camera.offset.y);
  bounds.w = bound(camera.row_w, camera.offset.z);

  vertices.resize(mesh.vertex_count());
  grid_points.resize(mesh.vertex_count());
  parallel_ranges(vertices.size(), vertices_per_task, [&](std::size_t begin, std::size_t end) {
    project_vertices(*this, begin, end);
  });
}

int facet_facing(const ProjectedMesh& projected, std::uint32_t facet) {
  const glm::vec3 a = projected.mesh.corner(facet, 0);
  const glm::vec3 b = projected.mesh.corner(facet, 1);
  const glm::vec3 c = projected.mesh.corner(facet, 2);
  // det[h0 h1 h2] is the determinant of the camera's rows times that of the corners relative to the eye.
  if (projected.camera.perspective) return side_of_plane(a, b, c, glm::vec4(projected.view.eye, 1.0f));

  // Orthographic: W is 1, and the determinant is that of the two edges from corner a, on the screen.
  const Camera& camera = projected.camera;
  const glm::dvec3 ab = glm::dvec3(b) - glm::dvec3(a), ac = glm::dvec3(c) - glm::dvec3(a);
  const double determinant = glm::dot(camera.row_x, ab) * glm::dot(camera.row_y, ac) -
                             glm::dot(camera.row_y, ab) * glm::dot(camera.row_x, ac);
  const double magnitude = 2 * largest_component(camera.row_x) * largest_component(camera.row_y) *
                           (std::abs(ab.x) + std::abs(ab.y) + std::abs(ab.z)) *
                           (std::abs(ac.x) + std::abs(ac.y) + std::abs(ac.z));
  if (std::abs(determinant) > 2 * projection_roundings * magnitude) return determinant < 0 ? 1 : -1;
  return -exact_facing(a, b, c, projected.view.eye, camera_rows(camera), camera.offset);
}

FacetEdges facet_edges(const ProjectedMesh& projected, std::uint32_t facet, int facing, const glm::dvec2& origin,
                       double extent) {
  const double factor = relative_error_factor(projected.bounds, origin, extent);
  RelativeVertex corner[3];
  for (int i = 0; i < 3; ++i) {
    corner[i] = relative_vertex(projected.vertices[projected.mesh.triangles[facet][i]], origin, extent, factor);
  }
  FacetEdges edges;
  for (int i = 0; i < 3; ++i) {
    const RelativeVertex& p = corner[(i + 1) % 3];
    const RelativeVertex& q = corner[(i + 2) % 3];
    edges.a[i] = -facing * (p.y * q.w - p.w * q.y);
    edges.b[i] = -facing * (p.w * q.x - p.x * q.w);
    edges.c[i] = -facing * (p.x * q.y - p.y * q.x);
    edges.error[i] = edge_error(p, q);
  }
  return edges;
}

MeasuredCut measured_cut(const MeshView& mesh, const Pieces& pieces, const Piece& piece, std::size_t cut) {
  if (cut < pieces.measured.size()) return pieces.measured[cut];
  const PlanePoints points = points_of(mesh, pieces.plane_of(pieces.cuts[cut], mesh.triangles));
  MeasuredCut made{{}, 0};
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    const SignedVolume volume = signed_volume(points, mesh.corner(piece.facet, i));
    made.volume[i] = pieces.cuts[cut].side * volume.value;
    made.error = std::max(made.error, volume.error);
    largest = std::max(largest, std::abs(volume.value));
  }
  int exponent = 0;
  std::frexp(largest, &exponent);
  for (double& volume : made.volume) volume = std::ldexp(volume, -exponent);
  made.error = std::ldexp(made.error, -exponent);
  return made;
}

FacetCut facet_cut(const MeshView& mesh, const Pieces& pieces, std::size_t cut, const MeasuredCut& measured) {
  return {measured, pieces.plane_of(pieces.cuts[cut], mesh.triangles), pieces.cuts[cut].side};
}

CutLine cut_line(const FacetEdges& edges, const MeasuredCut& cut, double extent) {
  CutLine line{0, 0, 0, 0};
  for (int i = 0; i < 3; ++i) {
    line.a += edges.a[i] * cut.volume[i];
    line.b += edges.b[i] * cut.volume[i];
    line.c += edges.c[i] * cut.volume[i];
    const double reach = (std::abs(edges.a[i]) + std::abs(edges.b[i])) * extent + std::abs(edges.c[i]);
    line.error += cut_term_error(reach, edges.error[i], cut.volume[i], cut.error);
  }
  return line;
}

bool covers_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, std::span<const FacetCut> cuts,
                  int x, int y) {
  const EdgeValues edges = edges_at_pixel(projected, facet, facing, x, y);
  for (int i = 0; i < 3; ++i) {
    if (edges.value[i] < -edges.error[i]) return false;
  }
  for (int i = 0; i < 3; ++i) {
    if (edges.value[i] > edges.error[i]) continue;
    const int side = shifted_sign(exact_edge_signs(
        projected.mesh.corner(facet, (i + 1) % 3), projected.mesh.corner(facet, (i + 2) % 3), projected.view.eye,
        camera_rows(projected.camera), projected.camera.offset, x + 0.5, y + 0.5));
    if (-facing * side < 0) return false;
  }
  for (const FacetCut& cut : cuts) {
    if (!is_on_side(projected, facet, facing, cut, edges, x, y)) return false;
  }
  return true;
}

PixelBox facet_pixels(const ProjectedMesh& projected, std::uint32_t facet) {
  const ViewBounds& bounds = projected.bounds;
  const double near_distance = projected.camera.near_distance;
  const ProjectedVertex* corner[3];
  int beyond_near = 0;
  for (int i = 0; i < 3; ++i) {
    corner[i] = &projected.vertices[projected.mesh.triangles[facet][i]];
    beyond_near += !projected.camera.perspective || corner[i]->w >= near_distance;
  }
  if (beyond_near == 0) return {};

  PixelBounds pixels;
  for (int i = 0; i < 3; ++i) {
    const ProjectedVertex& p = *corner[i];
    const ProjectedVertex& q = *corner[(i + 1) % 3];
    const bool p_beyond = beyond_near == 3 || p.w >= near_distance;
    if (p_beyond) pixels.include(bounds, p.x, p.y, p.w, p.reach);
    if (beyond_near == 3 || p_beyond == (q.w >= near_distance)) continue;
    const double t = (near_distance - p.w) / (q.w - p.w);
    pixels.include(bounds, p.x + t * (q.x - p.x), p.y + t * (q.y - p.y), near_distance, p.reach + q.reach);
  }
  PixelBox box = pixels.box(projected.view);
  box.crosses_near = beyond_near != 3;
  return box;
}

PixelSquare piece_pixels(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece, int facing, int x,
                         int y, PixelSquare of_facet) {
  constexpr double extent = square_size - 1;
  const FacetEdges edges = facet_edges(projected, piece.facet, facing, {x + 0.5, y + 0.5}, extent);
  PixelSquare covered = of_facet;
  for (std::size_t i = piece.first_cut; i < piece.first_cut + piece.cut_count && covered != 0; ++i) {
    const MeasuredCut measured = measured_cut(projected.mesh, pieces, piece, i);
    const CutLine line = cut_line(edges, measured, extent);
    for (PixelSquare left = covered; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left), column = bit % square_size, row = bit / square_size;
      const double value = line.a * column + line.b * row + line.c;
      bool is_inside = value > 0;
      if (std::abs(value) <= line.error) {
        is_inside =
            is_on_side(projected, piece.facet, facing, facet_cut(projected.mesh, pieces, i, measured),
                       edges_at_pixel(projected, piece.facet, facing, x + column, y + row), x + column, y + row);
      }
      if (!is_inside) covered &= ~(PixelSquare{1} << bit);
    }
  }
  return covered;
}

// Of a cut at the polygon's corners; returns the lowest and the highest.
std::pair<double, double> PieceClipper::find_values(const MeasuredCut& cut) {
  const glm::dvec3 volume(cut.volume[0], cut.volume[1], cut.volume[2]);
  double lowest = INFINITY, highest = -INFINITY;
  values_.resize(polygon_.size());
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    values_[i] = glm::dot(volume, polygon_[i]);
    lowest = std::min(lowest, values_[i]);
    highest = std::max(highest, values_[i]);
  }
  return {lowest, highest};
}

// Leaves of the polygon what has a value of at least `lowest_kept` (Sutherland and Hodgman 1974, "Reentrant Polygon
// Clipping").
void PieceClipper::cut_off_below(double lowest_kept) {
  clipped_.clear();
  for (std::size_t i = 0; i < polygon_.size(); ++i) {
    const std::size_t next = i + 1 < polygon_.size() ? i + 1 : 0;
    const double here = values_[i] - lowest_kept, there = values_[next] - lowest_kept;
    if (here >= 0) clipped_.push_back(polygon_[i]);
    if ((here >= 0) != (there >= 0)) {
      clipped_.push_back(polygon_[i] + here / (here - there) * (polygon_[next] - polygon_[i]));
    }
  }
  polygon_.swap(clipped_);
}

PixelBox PieceClipper::clip(const ProjectedMesh& projected, const Pieces& pieces, const Piece& piece,
                            const PixelBox& facet_box, std::vector<FacetCut>& kept) {
  // Values are at most 1, weights sum to 1: each clip adds a few roundings to what the polygon's corners are worth.
  constexpr double clip_margin = 0x1p-20;
  const std::size_t kept_before = kept.size();
  polygon_ = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (std::size_t i = piece.first_cut; i < piece.first_cut + piece.cut_count; ++i) {
    const MeasuredCut measured = measured_cut(projected.mesh, pieces, piece, i);
    const double margin = std::max(clip_margin, 2 * measured.error);
    const auto [lowest, highest] = find_values(measured);
    if (highest < -margin) {
      kept.resize(kept_before);
      return {};
    }
    if (lowest > margin) continue;
    kept.push_back(facet_cut(projected.mesh, pieces, i, measured));
    cut_off_below(-margin);
  }
  // Where the facet crosses the near plane its corners need not be in front of the eye.
  if (facet_box.crosses_near) return facet_box;

  double reach = 0;
  glm::dvec3 x, y, w;
  for (int i = 0; i < 3; ++i) {
    const ProjectedVertex& corner = projected.vertices[projected.mesh.triangles[piece.facet][i]];
    x[i] = corner.x;
    y[i] = corner.y;
    w[i] = corner.w;
    reach += corner.reach;
  }
  PixelBounds bounds;
  for (const glm::dvec3& weights : polygon_) {
    bounds.include(projected.bounds, glm::dot(x, weights), glm::dot(y, weights), glm::dot(w, weights), 2 * reach);
  }
  PixelBox box = bounds.box(projected.view);
  box.x0 = std::max(box.x0, facet_box.x0);
  box.y0 = std::max(box.y0, facet_box.y0);
  box.x1 = std::min(box.x1, facet_box.x1);
  box.y1 = std::min(box.y1, facet_box.y1);
  if (box.empty()) kept.resize(kept_before);
  return box;
}

PixelDepth depth_at_pixel(const ProjectedMesh& projected, std::uint32_t facet, int facing, int x, int y) {
  const EdgeValues edges = edges_at_pixel(projected, facet, facing, x, y);
  const Ray ray = projected.camera.pixel_ray(x, y);
  double weights = 0, error = 0, weighted_depth = 0, nearest = INFINITY, farthest = -INFINITY, reach = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 q = glm::dvec3(projected.mesh.corner(facet, i)) - ray.origin;
    const double depth = glm::dot(q, ray.direction);
    const double weight = std::max(edges.value[i], 0.0);
    weights += weight;
    weighted_depth += weight * depth;
    error += edges.error[i];
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
    reach = std::max(reach, std::abs(q.x) + std::abs(q.y) + std::abs(q.z));
  }
  // Wrong weights move the depth between the corners' depths; the corners' own depths carry a dot product's rounding.
  const double spread = farthest - nearest;
  const double of_corners = 2 * projection_roundings * reach;
  if (weights <= error) return {(nearest + farthest) / 2, spread + of_corners};
  return {weighted_depth / weights, spread * std::min(1.0, error / (weights - error)) + of_corners};
}

}  // namespace facetsort::blend_internal
