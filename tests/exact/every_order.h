// The ways to find an exact order, for tests of what holds for each of them.
#pragma once

#include <string>

#include "facetsort/exact/exact_sorter.h"

namespace facetsort {

inline constexpr OrderFrom every_order[] = {OrderFrom::pairs, OrderFrom::tree, OrderFrom::presorted};

// As part of a test's name.
inline std::string name_of(OrderFrom from) {
  return from == OrderFrom::pairs ? "Pairs" : from == OrderFrom::tree ? "Tree" : "Presorted";
}

}  // namespace facetsort
