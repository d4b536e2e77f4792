// Sorting by the comparators of JavaScript engines. Internal to facetsort::scene.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

namespace facetsort::scene_internal {

// As V8 sorts short lists: the run that the list starts with (turned round where it falls strictly), then one element
// after the other into its place, found by halving.
template <typename Element, typename Compare>
void sort_short(std::span<Element> list, const Compare& compare) {
  if (list.size() < 2) return;
  const bool falling = compare(list[1], list[0]) < 0;
  std::size_t sorted = 2;
  while (sorted < list.size() && (compare(list[sorted], list[sorted - 1]) < 0) == falling) ++sorted;
  if (falling) std::reverse(list.begin(), list.begin() + sorted);
  for (; sorted < list.size(); ++sorted) {
    std::size_t low = 0, high = sorted;
    while (low < high) {
      const std::size_t middle = low + (high - low) / 2;
      if (compare(list[sorted], list[middle]) < 0) {
        high = middle;
      } else {
        low = middle + 1;
      }
    }
    std::rotate(list.begin() + low, list.begin() + sorted, list.begin() + sorted + 1);
  }
}

// Appends two sorted lists to `merged`; of equals, those of `first` come first.
template <typename Element, typename Compare>
void merge_into(std::span<const Element> first, std::span<const Element> second, std::vector<Element>& merged,
                const Compare& compare) {
  std::size_t i = 0, j = 0;
  while (i < first.size() && j < second.size()) {
    merged.push_back(compare(second[j], first[i]) < 0 ? second[j++] : first[i++]);
  }
  merged.insert(merged.end(), first.begin() + i, first.end());
  merged.insert(merged.end(), second.begin() + j, second.end());
}

// A stable sort by what `compare(a, b)` returns: below 0 where a comes first, above 0 where b does, else (NaN too) the
// order stays. A comparator that contradicts itself, which std::stable_sort must not be given, is allowed: the result
// is then some permutation, and the one that V8 (Node 20) gives where there are fewer than 64 elements.
template <typename Element, typename Compare>
void sort_by_comparator(std::vector<Element>& list, const Compare& compare) {
  constexpr std::size_t short_list = 64, part = 32;
  const std::size_t size = list.size();
  if (size < short_list) return sort_short(std::span(list), compare);

  for (std::size_t begin = 0; begin < size; begin += part) {
    sort_short(std::span(list).subspan(begin, std::min(part, size - begin)), compare);
  }
  std::vector<Element> merged;
  merged.reserve(size);
  for (std::size_t width = part; width < size; width *= 2) {
    merged.clear();
    for (std::size_t begin = 0; begin < size; begin += 2 * width) {
      const std::span<const Element> rest = std::span<const Element>(list).subspan(begin);
      const std::size_t first = std::min(width, rest.size()), second = std::min(width, rest.size() - first);
      merge_into(rest.first(first), rest.subspan(first, second), merged, compare);
    }
    std::swap(list, merged);
  }
}

}  // namespace facetsort::scene_internal
