// Internal to exact: elements in an order that changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/exact/pair_kernels.h"
#include "facetsort/exact/screen.h"

namespace facetsort::exact_internal {

// Elements in a row of places, each place with a list of them. Over the places are boxes on the screen, in which those
// between two elements that one of them may overlap are found fast. Threads may work at once on different blocks of
// places and the elements there.
class Row {
 public:
  static constexpr std::uint32_t none = RowView::none;
  static constexpr std::size_t block_size = 512;  // places; what a block of boxes around 64 of them bounds

  // `places`: a multiple of block_size. What is in the row is not known until places are cleared. Keeps its storage.
  // The screen has to stay.
  void resize(const Screen& screen, std::size_t places, std::size_t elements);
  // Empties places from the beginning to the end of blocks.
  void clear(std::size_t begin, std::size_t end);
  // Puts an element into an empty place, to be bounded.
  void put(std::uint32_t element, std::uint32_t place);
  // Bounds what was put.
  void bound(std::size_t begin, std::size_t end);

  void remove(std::uint32_t element);
  // An element that is not in the row is put next to one that is.
  void insert_before(std::uint32_t element, std::uint32_t other);
  void insert_after(std::uint32_t element, std::uint32_t other);

  // Those not in the row have no place once they are told to be absent.
  void set_absent(std::uint32_t element) { place_of_[element] = none; }
  std::uint32_t place_of(std::uint32_t element) const { return place_of_[element]; }
  std::uint32_t first_at(std::size_t place) const { return first_at_[place]; }
  std::uint32_t next(std::uint32_t element) const { return next_[element]; }
  // Of two in the row.
  bool comes_before(std::uint32_t element, std::uint32_t other) const;
  std::size_t places() const { return first_at_.size(); }

  RowView view() const { return {first_at_, next_, boxes_, eights_, sixty_fours_}; }
  std::size_t memory_bytes() const { return bytes_of(first_at_, next_, place_of_, boxes_, eights_, sixty_fours_); }

 private:
  std::uint32_t& link_to(std::uint32_t element);
  void insert(std::uint32_t element, std::uint32_t& link, std::uint32_t place);

  const Screen* screen_ = nullptr;
  std::vector<std::uint32_t> first_at_;         // by place
  std::vector<std::uint32_t> next_, place_of_;  // by element
  std::vector<PlaceBlock> boxes_, eights_, sixty_fours_;
};

}  // namespace facetsort::exact_internal
