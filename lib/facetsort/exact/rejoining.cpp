#include "facetsort/exact/rejoining.h"

#include <algorithm>
#include <utility>

namespace facetsort::exact_internal {
namespace {

// Where more would have to go along, a part stays cut: it is then likely part of a cycle, and the search gets long.
constexpr std::size_t most_moved_along = 24;

bool overlap(const ScreenBox& a, const ScreenBox& b) {
  for (std::size_t d = 0; d < PlaceBlock::dimensions; ++d) {
    if (a.lowest[d] > b.highest[d] || b.lowest[d] > a.highest[d]) return false;
  }
  return true;
}

}  // namespace

// Takes `other` along, where an element that is on its way past can't pass it. (In the order as it is, neither hides
// one that comes later: so it is enough that they overlap.) Returns false where it can't go along.
bool Rejoining::take_if_passed(std::uint32_t element, const Candidate& other, std::uint32_t target,
                               std::size_t most_moved) {
  if (moving_[other.element] != 0 || !relation_.overlap(element, other)) return true;
  if (other.element == target || scratch_.moved.size() == most_moved) return false;
  moving_[other.element] = 1;
  scratch_.moved.push_back(other.element);
  return true;
}

// The same for those of one place, `from` one of them on before another, or before the end.
bool Rejoining::take_in_place(std::uint32_t element, std::uint32_t from, std::uint32_t to, std::uint32_t target,
                              std::size_t most_moved) {
  for (std::uint32_t other = from; other != to; other = row_.next(other)) {
    if (!overlap(screen_.box(element), screen_.box(other))) continue;
    if (!take_if_passed(element, {other, Seen::not_compared}, target, most_moved)) return false;
  }
  return true;
}

// Takes along what an element can't pass on its way past the target.
bool Rejoining::take_along(Way way, std::uint32_t element, std::uint32_t target, std::size_t most_moved) {
  const std::uint32_t first = way == Way::later ? element : target, last = way == Way::later ? target : element;
  const std::uint32_t first_place = row_.place_of(first), last_place = row_.place_of(last);
  // The target is passed, the element itself is not.
  const std::uint32_t from = way == Way::later ? row_.next(first) : first;
  const std::uint32_t to = way == Way::later ? row_.next(last) : last;
  if (first_place == last_place) return take_in_place(element, from, to, target, most_moved);
  if (!take_in_place(element, from, Row::none, target, most_moved)) return false;
  const RowView view = row_.view();
  const ScreenBox box = screen_.box(element);
  for (std::size_t at = first_place + 1; at < last_place;) {
    scratch_.candidates.clear();
    at = collect_in_row(outlines_, view, element, box, at, last_place, scratch_.candidates);
    scratch_.counts.candidate_pairs += scratch_.candidates.size();
    for (const Candidate& other : scratch_.candidates) {
      if (!take_if_passed(element, other, target, most_moved)) return false;
    }
  }
  return take_in_place(element, row_.first_at(last_place), to, target, most_moved);
}

// Leaves what has to move in `moved`, the half first.
bool Rejoining::can_move(Way way, std::uint32_t half, std::uint32_t target, std::size_t most_moved) {
  std::vector<std::uint32_t>& moved = scratch_.moved;
  moved.assign(1, half);
  moving_[half] = 1;
  bool can = true;
  for (std::size_t i = 0; i < moved.size() && can; ++i) can = take_along(way, moved[i], target, most_moved);
  if (!can) {
    for (const std::uint32_t element : moved) moving_[element] = 0;
  }
  return can;
}

// Moves what can_move() found, in the order in which it is, and puts the whole in the place of the target.
void Rejoining::move(Way way, std::uint32_t whole, std::uint32_t target) {
  std::vector<std::uint32_t>& moved = scratch_.moved;
  std::sort(moved.begin() + 1, moved.end(),
            [&](std::uint32_t a, std::uint32_t b) { return row_.place_of(a) < row_.place_of(b); });
  for (std::size_t begin = 1, end; begin < moved.size(); begin = end) {
    const std::uint32_t place = row_.place_of(moved[begin]);
    end = begin;
    for (std::uint32_t element = row_.first_at(place); element != Row::none; element = row_.next(element)) {
      if (moving_[element] != 0 && element != moved[0]) moved[end++] = element;
    }
  }
  for (const std::uint32_t element : moved) {
    moving_[element] = 0;
    row_.remove(element);
  }
  row_.insert_before(whole, target);
  row_.remove(target);
  std::uint32_t before = whole;
  for (std::size_t i = 1; i < moved.size(); ++i) {
    if (way == Way::later) {
      row_.insert_after(moved[i], before);
      before = moved[i];
    } else {
      row_.insert_before(moved[i], whole);
    }
  }
}

bool Rejoining::rejoin(std::uint32_t whole, std::uint32_t first, std::uint32_t second) {
  if (row_.place_of(first) == Row::none || row_.place_of(second) == Row::none) return false;
  ++scratch_.counts.tried;
  if (row_.comes_before(second, first)) std::swap(first, second);
  for (const std::size_t most_moved : {std::size_t{1}, 1 + most_moved_along}) {
    for (const Way way : {Way::later, Way::earlier}) {
      const std::uint32_t half = way == Way::later ? first : second, target = way == Way::later ? second : first;
      if (!can_move(way, half, target, most_moved)) continue;
      move(way, whole, target);
      ++scratch_.counts.rejoined;
      return true;
    }
  }
  return false;
}

}  // namespace facetsort::exact_internal
