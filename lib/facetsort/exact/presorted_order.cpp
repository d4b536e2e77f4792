#include "facetsort/exact/presorted_order.h"

#include <utility>

#include "facetsort/base/memory.h"

namespace facetsort::exact_internal {
namespace {

std::vector<Piece> pieces_with_cuts(const PresortedView& view) {
  std::vector<Piece> pieces;
  std::uint32_t first_cut = 0;
  for (const PresortedPiece& piece : view.pieces) {
    if (piece.cut_count > 0) pieces.push_back({piece.facet, first_cut, piece.cut_count});
    first_cut += piece.cut_count;
  }
  return pieces;
}

}  // namespace

PresortedOrder::PresortedOrder(const PresortedView& view)
    : view_(view), pieces_(pieces_with_cuts(view)), reader_(view) {
  statistics_.nodes = view.nodes.size();
  statistics_.pieces = view.pieces.size();
  statistics_.triangles = view.triangles.size();
}

PresortedOrder::PresortedOrder(Presorted&& presorted)
    : data_(std::move(presorted.data)),
      view_(data_.view()),
      statistics_(presorted.statistics),
      pieces_(pieces_with_cuts(view_)),
      reader_(view_) {}

std::span<const std::uint32_t> PresortedOrder::read(const Eye& eye) {
  order_.resize(view_.pieces.size());
  reader_.forget_eye();
  order_.resize(reader_.read_draw_ids(eye, order_));
  return order_;
}

OrderedTriangles PresortedOrder::triangles() const {
  struct Run {
    std::size_t first, count;
  };
  const std::size_t facets = view_.mesh.facet_count();
  std::vector<Run> run(facets + pieces_.size());  // by draw id
  std::size_t triangle = 0, next_piece = facets;
  for (const PresortedPiece& piece : view_.pieces) {
    run[piece.cut_count > 0 ? next_piece++ : piece.facet] = {triangle, piece.triangle_count};
    triangle += piece.triangle_count;
  }
  OrderedTriangles result;
  for (const std::uint32_t id : order_) {
    const std::span<const glm::uvec3> triangles = view_.triangles.subspan(run[id].first, run[id].count);
    result.triangles.insert(result.triangles.end(), triangles.begin(), triangles.end());
    result.source.insert(result.source.end(), triangles.size(), pieces().facet_of(id, facets));
  }
  for (std::size_t i = 0; i < view_.made_vertices.size(); ++i) {
    result.vertices.push_back(
        {view_.made_positions[i], view_.made_vertices[i].facet, view_.made_vertices[i].barycentric});
  }
  return result;
}

std::size_t PresortedOrder::memory_bytes() const {
  return bytes_of(data_.positions, data_.facets, data_.facet_colours, data_.vertex_colours, data_.made_vertices,
                  data_.made_positions, data_.nodes, data_.pieces, data_.triangles, data_.cuts, data_.planes, pieces_,
                  order_) +
         reader_.memory_bytes();
}

}  // namespace facetsort::exact_internal
