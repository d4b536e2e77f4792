// Internal to exact: orders of a presorted mesh in draw ids and in triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "facetsort/exact/exact_sorter.h"
#include "facetsort/exact/points.h"
#include "facetsort/exact/presort.h"
#include "facetsort/order/presorted_reader.h"

namespace facetsort::exact_internal {

class PresortedOrder {
 public:
  // The arrays of the view must outlive this.
  explicit PresortedOrder(const PresortedView& view);
  explicit PresortedOrder(Presorted&& presorted);
  PresortedOrder(const PresortedOrder&) = delete;
  PresortedOrder& operator=(const PresortedOrder&) = delete;

  // Draw ids. Does all of the work whatever the last eye was. Valid until the next call.
  std::span<const std::uint32_t> read(const Eye& eye);

  // Whether read() would give what it last gave (see PresortedReader).
  bool keeps_order(const Eye& eye) { return reader_.keeps_order(eye); }

  Pieces pieces() const { return {pieces_, view_.cuts, view_.planes}; }
  OrderedTriangles triangles() const;  // of the last eye
  const PresortedView& view() const { return view_; }
  // Of what was presorted here.
  const PresortStatistics& statistics() const { return statistics_; }
  std::size_t memory_bytes() const;

 private:
  PresortedData data_;  // nothing where the view is of others
  PresortedView view_;
  PresortStatistics statistics_;
  std::vector<Piece> pieces_;
  std::vector<std::uint32_t> order_;
  PresortedReader reader_;
};

}  // namespace facetsort::exact_internal
