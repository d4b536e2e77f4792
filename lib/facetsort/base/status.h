// Errors as values. Nothing in the library throws on bad input, prints or exits.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace facetsort {

// What is wrong with an input. A new fault gets a new name here, so that callers can tell them apart.
enum class Fault {
  none,
  bad_argument,          // a parameter outside its documented range
  cannot_read,           // the file is missing, is a directory or may not be read
  cannot_write,          // the output can't be created, written in full or renamed into place
  unsupported_format,    // the file's extension or header is none that we read or write
  malformed,             // the file breaks its own format
  truncated,             // the file ends before what its header promises
  empty_mesh,            // no facet
  too_many_facets,       // facet or vertex ids would not fit in 32 bits
  size_mismatch,         // a colour list that is neither empty nor one a facet (or a vertex)
  index_out_of_range,    // a facet names a vertex that is not there
  non_finite_position,   // a vertex that a facet uses is NaN or infinite
  out_of_memory,
};

// Outcome of a call: ok, or a fault with one line of text that names the file (where there is one), the fault and
// the place. Cheap to pass; safe to hold.
struct [[nodiscard]] Status {
  Fault fault = Fault::none;
  std::string message;

  bool ok() const { return fault == Fault::none; }
};

// A value, or the Status that says why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}
  Result(Status status) : state_(std::move(status)) { assert(!std::get<Status>(state_).ok()); }

  bool ok() const { return std::holds_alternative<T>(state_); }
  // Precondition: ok().
  T& value() & { return std::get<T>(state_); }
  const T& value() const& { return std::get<T>(state_); }
  T&& value() && { return std::get<T>(std::move(state_)); }
  // Precondition: !ok().
  const Status& status() const { return std::get<Status>(state_); }

 private:
  std::variant<T, Status> state_;
};

}  // namespace facetsort
