// Internal to order: the records of a .fsort file, as FSORT.md describes them, and which section holds which array.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "facetsort/order/presorted_data.h"

namespace facetsort::order_internal {

constexpr std::array<unsigned char, 8> file_magic{0x89, 'F', 'S', 'O', 'R', 'T', '\r', '\n'};
constexpr std::uint32_t file_version = 1;
constexpr std::size_t section_alignment = 64;

struct FileHeader {
  std::array<unsigned char, 8> magic;
  std::uint32_t version;
  std::uint32_t checksum;  // of all that follows it
  std::uint64_t file_size;
  std::uint32_t section_count;
  std::uint32_t reserved;
};
constexpr std::size_t checksum_begin = offsetof(FileHeader, file_size);

constexpr std::uint32_t section_id(const char (&name)[5]) {
  std::uint32_t id = 0;
  for (int i = 0; i < 4; ++i) id |= static_cast<std::uint32_t>(static_cast<unsigned char>(name[i])) << 8 * i;
  return id;
}

// Who does not know a section that has it can't read the file.
constexpr std::uint32_t section_required = 1;

struct SectionEntry {
  std::uint32_t id;
  std::uint32_t flags;
  std::uint64_t offset, size;  // in bytes, from the file's first
  std::uint64_t count;         // of elements
};

struct BufferFacts {
  std::uint32_t buffer_count, needs_culling;
  double mean_inverted_rate, worst_inverted_rate;
};

// The arrays of a file where they lie.
struct FileArrays {
  PresortedView view;
  std::span<const BufferFacts> buffer_facts;  // one, or none
  std::span<const std::uint32_t> buffer_facets;
  std::span<const glm::vec3> directions;
  std::span<const std::uint32_t> buffer_of_direction;
};

// Calls visit(id, flags, array) for each in the order of the file.
template <typename Arrays, typename Visit>
void visit_sections(Arrays& arrays, const Visit& visit) {
  auto& view = arrays.view;
  visit(section_id("POSI"), section_required, view.mesh.positions);
  visit(section_id("FACE"), section_required, view.mesh.triangles);
  visit(section_id("FCOL"), section_required, view.mesh.facet_colours);
  visit(section_id("VCOL"), section_required, view.mesh.vertex_colours);
  visit(section_id("MVER"), section_required, view.made_vertices);
  visit(section_id("MPOS"), section_required, view.made_positions);
  visit(section_id("NODE"), section_required, view.nodes);
  visit(section_id("PIEC"), section_required, view.pieces);
  visit(section_id("TRIA"), section_required, view.triangles);
  visit(section_id("CUTS"), section_required, view.cuts);
  visit(section_id("PLAN"), section_required, view.planes);
  visit(section_id("BUFS"), 0u, arrays.buffer_facts);
  visit(section_id("BFAC"), 0u, arrays.buffer_facets);
  visit(section_id("BDIR"), 0u, arrays.directions);
  visit(section_id("BOFD"), 0u, arrays.buffer_of_direction);
}

// Records go to the file as they lie in memory.
template <typename Record, std::size_t size>
constexpr bool is_record = std::is_trivially_copyable_v<Record> && sizeof(Record) == size;
static_assert(is_record<FileHeader, 32> && is_record<SectionEntry, 32> && is_record<BufferFacts, 24>);
static_assert(is_record<glm::vec3, 12> && is_record<glm::vec4, 16> && is_record<glm::uvec3, 12>);
static_assert(is_record<PresortedVertex, 16> && is_record<PresortedNode, 24> && is_record<PresortedPiece, 12>);
static_assert(is_record<Cut, 8> && is_record<CutPlane, 20>);

}  // namespace facetsort::order_internal
