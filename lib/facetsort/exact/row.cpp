#include "facetsort/exact/row.h"

#include <algorithm>
#include <limits>

namespace facetsort::exact_internal {
namespace {

void clear_box(PlaceBlock& block, std::size_t lane) {
  for (std::size_t d = 0; d < PlaceBlock::dimensions; ++d) {
    block.lowest[d][lane] = std::numeric_limits<float>::max();
    block.highest[d][lane] = std::numeric_limits<float>::lowest();
  }
}

void extend_box(PlaceBlock& block, std::size_t lane, const ScreenBox& box) {
  for (std::size_t d = 0; d < PlaceBlock::dimensions; ++d) {
    block.lowest[d][lane] = std::min(block.lowest[d][lane], box.lowest[d]);
    block.highest[d][lane] = std::max(block.highest[d][lane], box.highest[d]);
  }
}

// Makes box `lane` of a block bound all of another.
void bound_block(const PlaceBlock& inner, PlaceBlock& outer, std::size_t lane) {
  for (std::size_t d = 0; d < PlaceBlock::dimensions; ++d) {
    outer.lowest[d][lane] = *std::min_element(inner.lowest[d], inner.lowest[d] + PlaceBlock::size);
    outer.highest[d][lane] = *std::max_element(inner.highest[d], inner.highest[d] + PlaceBlock::size);
  }
}

}  // namespace

void Row::resize(const Screen& screen, std::size_t places, std::size_t elements) {
  screen_ = &screen;
  first_at_.resize(places);
  boxes_.resize(places / 8);
  eights_.resize(places / 64);
  sixty_fours_.resize(places / 512);
  next_.resize(elements);
  place_of_.resize(elements, none);
}

void Row::clear(std::size_t begin, std::size_t end) {
  std::fill(first_at_.begin() + static_cast<std::ptrdiff_t>(begin),
            first_at_.begin() + static_cast<std::ptrdiff_t>(end), none);
  for (std::size_t block = begin / 8; block < end / 8; ++block) {
    for (std::size_t lane = 0; lane < PlaceBlock::size; ++lane) clear_box(boxes_[block], lane);
  }
}

void Row::put(std::uint32_t element, std::uint32_t place) {
  first_at_[place] = element;
  next_[element] = none;
  place_of_[element] = place;
  extend_box(boxes_[place / 8], place % 8, screen_->box(element));
}

void Row::bound(std::size_t begin, std::size_t end) {
  for (std::size_t block = begin / 8; block < end / 8; ++block)
    bound_block(boxes_[block], eights_[block / 8], block % 8);
  for (std::size_t block = begin / 64; block < end / 64; ++block) {
    bound_block(eights_[block], sixty_fours_[block / 8], block % 8);
  }
}

bool Row::comes_before(std::uint32_t element, std::uint32_t other) const {
  if (place_of_[element] != place_of_[other]) return place_of_[element] < place_of_[other];
  std::uint32_t at = first_at_[place_of_[element]];
  while (at != element && at != other) at = next_[at];
  return at == element;
}

// What leads to the element in its place.
std::uint32_t& Row::link_to(std::uint32_t element) {
  std::uint32_t* link = &first_at_[place_of_[element]];
  while (*link != element) link = &next_[*link];
  return *link;
}

void Row::insert(std::uint32_t element, std::uint32_t& link, std::uint32_t place) {
  next_[element] = link;
  link = element;
  place_of_[element] = place;
  const ScreenBox box = screen_->box(element);
  extend_box(boxes_[place / 8], place % 8, box);
  extend_box(eights_[place / 64], place / 8 % 8, box);
  extend_box(sixty_fours_[place / 512], place / 64 % 8, box);
}

// The boxes around more than one place stay as they are: larger than need be.
void Row::remove(std::uint32_t element) {
  const std::uint32_t place = place_of_[element];
  link_to(element) = next_[element];
  place_of_[element] = none;
  clear_box(boxes_[place / 8], place % 8);
  for (std::uint32_t left = first_at_[place]; left != none; left = next_[left]) {
    extend_box(boxes_[place / 8], place % 8, screen_->box(left));
  }
}

void Row::insert_before(std::uint32_t element, std::uint32_t other) {
  insert(element, link_to(other), place_of_[other]);
}

void Row::insert_after(std::uint32_t element, std::uint32_t other) {
  insert(element, next_[other], place_of_[other]);
}

}  // namespace facetsort::exact_internal
