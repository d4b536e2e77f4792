// How a verb ends: with an exit status, or with a Failure that main() turns into one line and exit status 2.
#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include "facetsort/base/status.h"

namespace facetsort {

enum class ExitStatus {
  done = 0,
  answer_is_no = 1,  // of a check
  failed = 2,        // bad usage, bad input, or an output that can't be written
};

// The message names the file or option, the fault and the place.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline void require(const Status& status) {
  if (!status.ok()) throw Failure(status.message);
}

template <typename T>
T require(Result<T> result) {
  if (!result.ok()) throw Failure(result.status().message);
  return std::move(result).value();
}

}  // namespace facetsort
