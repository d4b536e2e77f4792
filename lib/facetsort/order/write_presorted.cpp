#include <array>
#include <bit>
#include <new>
#include <ostream>
#include <string>
#include <vector>

#include "facetsort/base/new_file.h"
#include "facetsort/order/crc32.h"
#include "facetsort/order/presorted_format.h"
#include "facetsort/order/presorted_mesh.h"

namespace facetsort {
namespace {

using namespace order_internal;
using Bytes = std::span<const std::byte>;

constexpr std::array<std::byte, section_alignment> zeros{};

// A file as it will be: what stands in memory stays there.
struct File {
  FileHeader header{file_magic, file_version, 0, 0, 0, 0};
  std::vector<SectionEntry> table;
  std::vector<Bytes> sections;  // of each entry
};

// Calls take(bytes) for one part after another, from `header_begin` of the header on.
template <typename Take>
void for_each_part(const File& file, std::size_t header_begin, const Take& take) {
  take(std::as_bytes(std::span(&file.header, 1)).subspan(header_begin));
  take(std::as_bytes(std::span(file.table)));
  std::size_t end = sizeof(FileHeader) + file.table.size() * sizeof(SectionEntry);
  for (std::size_t i = 0; i < file.table.size(); ++i) {
    take(Bytes(zeros).first(static_cast<std::size_t>(file.table[i].offset) - end));
    take(file.sections[i]);
    end = static_cast<std::size_t>(file.table[i].offset + file.table[i].size);
  }
}

File lay_out(const FileArrays& arrays) {
  File file;
  visit_sections(arrays, [&](std::uint32_t id, std::uint32_t flags, const auto& array) {
    if (array.empty()) return;
    file.table.push_back({id, flags, 0, array.size_bytes(), array.size()});
    file.sections.push_back(std::as_bytes(array));
  });
  std::uint64_t end = sizeof(FileHeader) + file.table.size() * sizeof(SectionEntry);
  for (SectionEntry& entry : file.table) {
    entry.offset = (end + section_alignment - 1) / section_alignment * section_alignment;
    end = entry.offset + entry.size;
  }
  file.header.file_size = end;
  file.header.section_count = static_cast<std::uint32_t>(file.table.size());
  return file;
}

BufferFacts facts_of(const IndexBuffers& buffers) {
  return {static_cast<std::uint32_t>(buffers.buffer_count), buffers.needs_culling ? 1u : 0u, buffers.mean_inverted_rate,
          buffers.worst_inverted_rate};
}

// `facts` are those of the buffers, which may be null.
FileArrays arrays_of(const PresortedView& view, const IndexBuffers* buffers, const BufferFacts& facts) {
  if (buffers == nullptr) return {view, {}, {}, {}, {}};
  return {view, {&facts, 1}, buffers->facets, buffers->directions, buffers->buffer_of_direction};
}

// Calls take(bytes) for one part of the file after another.
template <typename Take>
Status write_parts(const PresortedView& view, const IndexBuffers* buffers, const Take& take) {
  if constexpr (std::endian::native != std::endian::little) {
    return {Fault::unsupported_format, "can be written on little-endian machines only"};
  }
  if (Status status = validate_presorted(view, buffers); !status.ok()) return status;
  try {
    const BufferFacts facts = buffers != nullptr ? facts_of(*buffers) : BufferFacts{};
    File file = lay_out(arrays_of(view, buffers, facts));
    std::uint32_t checksum = 0;
    for_each_part(file, checksum_begin, [&](Bytes part) { checksum = crc32(part, checksum); });
    file.header.checksum = checksum;
    for_each_part(file, 0, take);
    return {};
  } catch (const std::bad_alloc&) {
    return {Fault::out_of_memory, "not enough memory to write a presorted mesh"};
  }
}

}  // namespace

std::uint64_t fsort_file_size(const PresortedView& view, const IndexBuffers* buffers) {
  const BufferFacts facts{};
  return lay_out(arrays_of(view, buffers, facts)).header.file_size;
}

Status write_presorted(std::ostream& stream, const PresortedView& view, const IndexBuffers* buffers) {
  Status status = write_parts(view, buffers, [&](Bytes part) {
    stream.write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(part.size()));
  });
  if (status.ok() && !stream.flush()) status = {Fault::cannot_write, "the stream takes no more bytes"};
  return status;
}

Status write_presorted(const std::filesystem::path& path, const PresortedView& view, const IndexBuffers* buffers) {
  NewFile file(path);
  Status status = write_parts(view, buffers, [&](Bytes part) { file.write(part); });
  if (status.ok()) return file.finish();
  status.message = path.string() + ": " + status.message;
  return status;
}

}  // namespace facetsort
