#include "facetsort/order/presorted_mesh.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <new>
#include <set>
#include <string>

#include "facetsort/base/file_bytes.h"
#include "facetsort/order/crc32.h"
#include "facetsort/order/presorted_format.h"

namespace facetsort {
namespace {

using namespace order_internal;
using Bytes = std::span<const std::byte>;

template <typename Record>
Record record_at(Bytes file, std::size_t offset) {
  Record record;
  std::memcpy(&record, file.data() + offset, sizeof record);
  return record;
}

Status check_magic(Bytes file) {
  const Bytes magic = std::as_bytes(std::span(file_magic));
  const std::size_t known = std::min(file.size(), magic.size());
  if (!std::equal(magic.begin(), magic.begin() + known, file.begin())) {
    return {Fault::unsupported_format, "is no .fsort file"};
  }
  if (file.size() >= sizeof(FileHeader)) return {};
  return {Fault::truncated, "truncated: " + std::to_string(file.size()) + " bytes, the header alone has " +
                                std::to_string(sizeof(FileHeader))};
}

// Precondition: check_magic() is ok.
Status check_header(Bytes file) {
  const auto header = record_at<FileHeader>(file, 0);
  if (header.version != file_version) {
    return {Fault::unsupported_format, "has version " + std::to_string(header.version) +
                                           " of the format, only version " + std::to_string(file_version) +
                                           " can be read"};
  }
  if (header.file_size != file.size()) {
    const bool is_short = header.file_size > file.size();
    return {is_short ? Fault::truncated : Fault::malformed,
            std::string(is_short ? "truncated: " : "") + std::to_string(file.size()) + " bytes, its header says " +
                std::to_string(header.file_size)};
  }
  if (crc32(file.subspan(checksum_begin)) != header.checksum) {
    return {Fault::malformed, "is damaged: its bytes do not give the checksum in its header"};
  }
  if (header.reserved != 0) return {Fault::unsupported_format, "its header uses a reserved field"};
  if (header.section_count > (file.size() - sizeof(FileHeader)) / sizeof(SectionEntry)) {
    return {Fault::malformed, "its header says " + std::to_string(header.section_count) +
                                  " sections, whose table is longer than the file"};
  }
  return {};
}

// Hands out the sections of a file whose header is sound.
class SectionReader {
 public:
  explicit SectionReader(Bytes file) : file_(file) {}

  Status read_all(FileArrays& arrays) {
    const auto count = record_at<FileHeader>(file_, 0).section_count;
    end_ = sizeof(FileHeader) + count * sizeof(SectionEntry);
    for (std::size_t i = 0; i < count; ++i) {
      const auto entry = record_at<SectionEntry>(file_, sizeof(FileHeader) + i * sizeof(SectionEntry));
      Status status = check_place(entry);
      if (status.ok()) status = read(entry, arrays);
      if (!status.ok()) return {status.fault, "section " + std::to_string(i) + ' ' + status.message};
    }
    return {};
  }

 private:
  // Sections follow each other, none over another or over the table.
  Status check_place(const SectionEntry& entry) {
    if ((entry.flags & ~section_required) != 0) return {Fault::unsupported_format, "has flags that are not known"};
    if (entry.offset % section_alignment != 0) {
      return {Fault::malformed, "does not begin at a multiple of " + std::to_string(section_alignment)};
    }
    if (entry.offset < end_) return {Fault::malformed, "begins before the end of what stands before it"};
    if (entry.offset > file_.size() || entry.size > file_.size() - entry.offset) {
      return {Fault::malformed, "is not inside the file"};
    }
    end_ = entry.offset + entry.size;
    return {};
  }

  Status read(const SectionEntry& entry, FileArrays& arrays) {
    Status status;
    bool is_known = false;
    visit_sections(arrays, [&](std::uint32_t id, std::uint32_t, auto& array) {
      if (id != entry.id) return;
      is_known = true;
      status = read_array(entry, array);
    });
    if (is_known && !seen_.insert(entry.id).second) return {Fault::malformed, "is the second of its kind"};
    if (!is_known && (entry.flags & section_required) != 0) {
      return {Fault::unsupported_format, "is required and of a kind that is not known"};
    }
    return status;
  }

  template <typename Element>
  Status read_array(const SectionEntry& entry, std::span<const Element>& array) {
    if (entry.size % sizeof(Element) != 0 || entry.size / sizeof(Element) != entry.count) {
      return {Fault::size_mismatch, "has " + std::to_string(entry.size) + " bytes for " + std::to_string(entry.count) +
                                        " elements of " + std::to_string(sizeof(Element))};
    }
    const std::byte* const first = file_.data() + entry.offset;
    array = {reinterpret_cast<const Element*>(first), static_cast<std::size_t>(entry.count)};
    return {};
  }

  Bytes file_;
  std::uint64_t end_ = 0;  // of what has been read
  std::set<std::uint32_t> seen_;
};

template <typename Element>
std::vector<Element> copy_of(std::span<const Element> array) {
  return {array.begin(), array.end()};
}

Status copy_buffers(const FileArrays& arrays, std::optional<IndexBuffers>& buffers) {
  if (arrays.buffer_facts.empty()) {
    if (arrays.buffer_facets.empty() && arrays.directions.empty() && arrays.buffer_of_direction.empty()) return {};
    return {Fault::malformed, "index buffers: the section that counts them is missing"};
  }
  const BufferFacts& facts = arrays.buffer_facts.front();
  if (arrays.buffer_facts.size() != 1 || facts.needs_culling > 1) {
    return {Fault::malformed,
            "index buffers: the section that counts them is not one element, or culling neither 0 nor 1"};
  }
  buffers = IndexBuffers{facts.buffer_count,         copy_of(arrays.buffer_facets),
                         copy_of(arrays.directions), copy_of(arrays.buffer_of_direction),
                         facts.needs_culling == 1,   facts.mean_inverted_rate,
                         facts.worst_inverted_rate};
  return {};
}

Status read_arrays(Bytes file, FileArrays& arrays) {
  if constexpr (std::endian::native != std::endian::little) {
    return {Fault::unsupported_format, "can be read on little-endian machines only"};
  }
  Status status = check_magic(file);
  if (status.ok()) status = check_header(file);
  return status.ok() ? SectionReader(file).read_all(arrays) : status;
}

template <typename Make>
Result<PresortedMesh> unless_out_of_memory(const Make& make) {
  try {
    return make();
  } catch (const std::bad_alloc&) {
    return Status{Fault::out_of_memory, "not enough memory for a presorted mesh"};
  }
}

}  // namespace

Result<PresortedMesh> PresortedMesh::checked(Contents contents) {
  Status status = validate_presorted(contents.view, contents.buffers ? &*contents.buffers : nullptr);
  if (!status.ok()) return status;
  return PresortedMesh(std::make_shared<const Contents>(std::move(contents)));
}

Result<PresortedMesh> PresortedMesh::parse(Bytes bytes, std::shared_ptr<const void> owner) {
  FileArrays arrays;
  if (Status status = read_arrays(bytes, arrays); !status.ok()) return status;
  Contents contents{std::move(owner), arrays.view, std::nullopt};
  if (Status status = copy_buffers(arrays, contents.buffers); !status.ok()) return status;
  return checked(std::move(contents));
}

Result<PresortedMesh> PresortedMesh::from_data(PresortedData data, std::optional<IndexBuffers> buffers) {
  return unless_out_of_memory([&] {
    const auto owner = std::make_shared<const PresortedData>(std::move(data));
    return checked({owner, owner->view(), std::move(buffers)});
  });
}

Result<PresortedMesh> PresortedMesh::from_bytes(std::vector<std::byte> bytes) {
  return unless_out_of_memory([&] {
    const auto owner = std::make_shared<const std::vector<std::byte>>(std::move(bytes));
    return parse(*owner, owner);
  });
}

Result<PresortedMesh> PresortedMesh::open(const std::filesystem::path& path) {
  Result<FileBytes> file = FileBytes::open(path);
  if (!file.ok()) return file.status();
  Result<PresortedMesh> mesh = unless_out_of_memory([&] {
    const auto owner = std::make_shared<const FileBytes>(std::move(file).value());
    return parse(owner->bytes(), owner);
  });
  if (mesh.ok()) return mesh;
  return Status{mesh.status().fault, path.string() + ": " + mesh.status().message};
}

}  // namespace facetsort
