// Presorted meshes as values and as files. FSORT.md describes the file byte by byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/order/presorted_data.h"

namespace facetsort {

// Checks what every reader of a presorted mesh takes for granted: that arrays fit each other, that what they name is
// there, that the tree's nodes nest, that positions are finite, that each facet has a piece where there is a tree, and
// that each of the buffers, which may be null, is a permutation of the facets. Faults, with the first place that has
// it: too_many_facets, size_mismatch, index_out_of_range, non_finite_position, malformed, out_of_memory.
//
// A plane whose three vertices differ but lie on one line passes: every eye is in it, which makes the order around it
// arbitrary but leaves no piece out and draws none twice.
//
// Linear time, at most four bytes of memory a facet. Parallel in the caller's task arena, as is all below. Thread-safe.
Status validate_presorted(const PresortedView& view, const IndexBuffers* buffers = nullptr);

// A presorted mesh that passed validate_presorted(). Immutable: copies share it, and any thread may read.
class PresortedMesh {
 public:
  // Maps the file where the platform can: it must not be shortened or written over while a copy of this lives. To
  // replace it by another of the same name (as write_presorted() does) is safe. Where that can't be promised, read it
  // and use from_bytes(). Faults, further to those above: cannot_read, unsupported_format (no .fsort file, another
  // version, a required section that is not known here, a big-endian machine), truncated. The message names the file.
  static Result<PresortedMesh> open(const std::filesystem::path& path);
  // A file's content.
  static Result<PresortedMesh> from_bytes(std::vector<std::byte> bytes);
  static Result<PresortedMesh> from_data(PresortedData data, std::optional<IndexBuffers> buffers = std::nullopt);

  // Valid as long as a copy of this is.
  const PresortedView& view() const { return contents_->view; }
  // Whether orders can be read from it: a file of index buffers alone has no tree, and a reader of it draws nothing.
  bool has_tree() const { return !contents_->view.pieces.empty(); }
  // Null where there are none.
  const IndexBuffers* index_buffers() const { return contents_->buffers ? &*contents_->buffers : nullptr; }

 private:
  // View and buffers, with what the view looks at.
  struct Contents {
    std::shared_ptr<const void> owner;
    PresortedView view;
    std::optional<IndexBuffers> buffers;
  };
  explicit PresortedMesh(std::shared_ptr<const Contents> contents) : contents_(std::move(contents)) {}
  static Result<PresortedMesh> checked(Contents contents);
  static Result<PresortedMesh> parse(std::span<const std::byte> bytes, std::shared_ptr<const void> owner);

  std::shared_ptr<const Contents> contents_;
};

// Writes a .fsort file: the same bytes for the same mesh. `buffers` may be null. Faults: those of
// validate_presorted(), cannot_write, unsupported_format (a big-endian machine).
// To a path: beside it under a temporary name, then renamed; a failure leaves what stood there untouched.
Status write_presorted(const std::filesystem::path& path, const PresortedView& view,
                       const IndexBuffers* buffers = nullptr);
Status write_presorted(std::ostream& stream, const PresortedView& view, const IndexBuffers* buffers = nullptr);
// How many bytes that file has.
std::uint64_t fsort_file_size(const PresortedView& view, const IndexBuffers* buffers = nullptr);

}  // namespace facetsort
