// What hides what is in the tree (Fuchs, Kedem and Naylor 1980, "On Visible Surface Generation by A Priori Tree
// Structures"), and how many triangles are on either side of each plane is known: once the sides that the eye is on
// are, every triangle's place follows from sums down the tree. First each block, a small subtree, finds its own order,
// which it keeps for as long as the eye is nearer to where it was than to any of the block's planes; then the nodes
// above them put the blocks in order; then triangles are copied, in the order in which they are drawn.
#include "facetsort/order/presorted_reader.h"

#include <hwy/cache_control.h>

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cstring>
#include <optional>
#include <utility>
#include <vector>

#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/order/presorted_blocks.h"
#include "facetsort/order/presorted_kernels.h"

namespace facetsort {

using namespace order_internal;

namespace {

// So many, and a task is worth its start.
constexpr std::size_t blocks_per_task = 256;

// Where float would round what an eye's way adds up to by more than margins allow for.
constexpr double longest_way = 4;

constexpr std::size_t line_bytes = 64;  // of the cache

constexpr std::uint32_t no_draw_id = 0xffffffffu;

// Where a row of triangles goes, how many of the memory's there are from there on, and triangles that will be asked for
// soon.
struct Run {
  const glm::uvec3* from;
  std::uint32_t* to;
  std::size_t readable, writable;
  const glm::uvec3* soon;
};

// Of any memory, there or not.
void prefetch(const void* base, std::size_t offset) {
  hwy::Prefetch(reinterpret_cast<const char*>(reinterpret_cast<std::uintptr_t>(base) + offset));
}

// Writes from[order[k]] for each k below count. Where there is room, four words at a time: what is one word too many
// the next triangle overwrites, and what is up to three triangles too many, the next block. As many as are written are
// fetched ahead, line by line: a core waits for no more than some twenty lines at once.
void write_triangles(const Run& run, const std::uint8_t* order, std::size_t count) {
  static_assert(triangles_at_a_time == 4);
  if (run.readable > most_block_triangles + triangles_at_a_time && run.writable > count + triangles_at_a_time) {
    for (std::size_t k = 0; k < count; k += triangles_at_a_time) {
      prefetch(run.soon, k / triangles_at_a_time * line_bytes);
      for (std::size_t i = k; i < k + triangles_at_a_time; ++i) {
        std::uint32_t words[4];
        std::memcpy(words, run.from + order[i], sizeof words);
        std::memcpy(run.to + 3 * i, words, sizeof words);
      }
    }
  } else {
    for (std::size_t k = 0; k < count; ++k) std::memcpy(run.to + 3 * k, run.from + order[k], sizeof(glm::uvec3));
  }
}

}  // namespace

struct PresortedReader::State {
  State(const PresortedView& mesh_in, const PresortedReaderOptions& options)
      : mesh(mesh_in),
        blocks(make_blocks(mesh_in, options.cull_back_faces)),
        block_states(blocks.blocks.size()),
        kept(blocks.blocks.size()),
        orders(blocks.spots.size()),
        top_sides((blocks.top.size() + 7) / 8),
        last_top_sides(top_sides.size()),
        places(blocks.top.size() + blocks.blocks.size() + 1),
        block_at(blocks.blocks.size()),
        offsets(blocks.blocks.size() + 1) {
    parallel_ranges(blocks.blocks.size(), blocks_per_task, [&](std::size_t begin, std::size_t end) {
      for (std::size_t b = begin; b < end; ++b) order_block(blocks, b, block_orders());
    });
    order_top();
  }

  BlockOrders block_orders() { return {block_states.data(), kept.data(), orders.data()}; }
  std::size_t drawn() const { return offsets.back(); }

  void go_to(const glm::vec4& eye);
  BlockChanges order_all_blocks(const FrameEye& eye);
  bool find_top_sides(const FrameEye& eye);
  void order_top();
  template <typename Write>
  void for_blocks_drawn(const Write& write) const;
  void find_facets();
  void find_draw_ids();

  PresortedView mesh;
  PresortedBlocks blocks;
  std::vector<BlockOrders::State> block_states;
  std::vector<std::uint8_t> kept, orders;
  std::vector<std::uint8_t> top_sides, last_top_sides;
  std::vector<std::uint32_t> places;    // where each element begins, counted in blocks
  std::vector<std::uint32_t> block_at;  // blocks, back to front
  std::vector<std::uint32_t> offsets;   // triangles drawn before each of these, and all
  std::vector<std::uint32_t> facets;    // of each triangle, once asked for
  std::vector<std::uint32_t> draw_ids;  // of the piece that begins with it, or none; once asked for
  std::optional<FrameEye> last_eye;
  double way = 0;  // of the eye since blocks began to count it
  bool is_read = false;  // the order that is there now
};

void PresortedReader::State::go_to(const glm::vec4& eye) {
  if (last_eye && last_eye->eye == eye) return;
  const FrameEye next = frame_eye(blocks.frame, eye);
  if (last_eye) way += distance_between(*last_eye, next);
  if (!last_eye || way > longest_way) {
    way = 0;
    for (BlockOrders::State& state : block_states) state.valid_until = 0;
  }
  last_eye = next;
  const BlockChanges changes = order_all_blocks(next);
  const bool order_changed = find_top_sides(next);
  if (changes.counts || order_changed) order_top();
  is_read = is_read && !changes.orders && !order_changed;
}

BlockChanges PresortedReader::State::order_all_blocks(const FrameEye& eye) {
  const PlaneSource source{blocks.planes, mesh.nodes, mesh.mesh.positions};
  std::atomic<bool> new_orders = false, new_counts = false;
  parallel_ranges(blocks.blocks.size(), blocks_per_task, [&](std::size_t begin, std::size_t end) {
    const BlockChanges changes = order_blocks(blocks, source, begin, end, eye, way, block_orders());
    if (changes.orders) new_orders = true;
    if (changes.counts) new_counts = true;
  });
  return {new_orders, new_counts};
}

// Whether any has changed.
bool PresortedReader::State::find_top_sides(const FrameEye& eye) {
  const PlaneSource source{blocks.top_planes, mesh.nodes, mesh.mesh.positions};
  std::swap(top_sides, last_top_sides);
  find_sides(source, eye, top_sides);
  return top_sides != last_top_sides;
}

// As within a block, in blocks; then sums over the blocks as they are drawn.
void PresortedReader::State::order_top() {
  for (std::size_t b = 0; b < blocks.loose_blocks; ++b) block_at[b] = static_cast<std::uint32_t>(b);
  const std::size_t top_count = blocks.top.size();
  places[top_count > 0 ? 0 : blocks.loose_blocks] = static_cast<std::uint32_t>(blocks.loose_blocks);  // the root
  for (std::size_t i = 0; i < top_count; ++i) {
    const TopNode& node = blocks.top[i];
    const bool in_front = (top_sides[i / 8] >> i % 8 & 1) != 0;
    const std::uint32_t begin = places[i];
    std::uint32_t own = begin + (in_front ? node.back_blocks : node.front_blocks);
    const std::uint32_t last = own + node.own_count;
    places[node.front] = in_front ? last : begin;
    places[node.back] = in_front ? begin : last;
    for (std::uint32_t k = 0; k < node.own_count; ++k) places[top_count + node.first_own + k] = own++;
  }
  for (std::size_t b = blocks.loose_blocks; b < blocks.blocks.size(); ++b) {
    block_at[places[top_count + b]] = static_cast<std::uint32_t>(b);
  }
  std::uint32_t offset = 0;
  for (std::size_t k = 0; k < block_at.size(); ++k) {
    offsets[k] = offset;
    offset += kept[block_at[k]];
  }
  offsets.back() = offset;
}

// Calls write(block, order, count, offset, room, soon) for blocks as they are drawn, a task for blocks in a row: `count`
// triangles of its, from the `offset`-th drawn on; the task writes `room`; `soon` is a block that comes after the next.
template <typename Write>
void PresortedReader::State::for_blocks_drawn(const Write& write) const {
  constexpr std::size_t ahead = 2;
  parallel_ranges(block_at.size(), blocks_per_task, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const std::uint32_t b = block_at[k];
      const Block& block = blocks.blocks[b];
      const Block& soon = blocks.blocks[block_at[std::min(k + ahead, block_at.size() - 1)]];
      for (std::size_t at = 0; at < most_block_triangles; at += line_bytes) {
        prefetch(orders.data(), soon.first_spot + at);
      }
      write(block, orders.data() + block.first_spot, kept[b], offsets[k], offsets[end] - offsets[k], soon);
    }
  });
}

void PresortedReader::State::find_facets() {
  if (facets.size() == mesh.triangles.size()) return;
  facets.reserve(mesh.triangles.size());
  for (const PresortedPiece& piece : mesh.pieces) facets.insert(facets.end(), piece.triangle_count, piece.facet);
}

void PresortedReader::State::find_draw_ids() {
  if (draw_ids.size() == mesh.triangles.size()) return;
  draw_ids.reserve(mesh.triangles.size());
  auto next_cut = static_cast<std::uint32_t>(mesh.mesh.facet_count());
  for (const PresortedPiece& piece : mesh.pieces) {
    draw_ids.push_back(piece.cut_count == 0 ? piece.facet : next_cut++);
    draw_ids.insert(draw_ids.end(), piece.triangle_count - 1, no_draw_id);
  }
}

PresortedReader::PresortedReader(const PresortedView& mesh, const PresortedReaderOptions& options)
    : state_(std::make_unique<State>(mesh, options)) {}
PresortedReader::PresortedReader(PresortedReader&&) noexcept = default;
PresortedReader& PresortedReader::operator=(PresortedReader&&) noexcept = default;
PresortedReader::~PresortedReader() = default;

std::size_t PresortedReader::read_indices(const glm::vec4& eye, std::span<std::uint32_t> indices,
                                          std::span<std::uint32_t> ids) {
  State& state = *state_;
  assert(indices.size() >= 3 * state.mesh.triangles.size());
  assert(ids.empty() || ids.size() >= state.mesh.triangles.size());
  state.go_to(eye);
  if (!ids.empty()) state.find_facets();
  const std::span<const glm::uvec3> triangles = state.mesh.triangles;
  state.for_blocks_drawn(
      [&](const Block& block, const std::uint8_t* order, std::size_t count, std::size_t offset, std::size_t room,
          const Block& soon) {
        const std::size_t first = block.first_triangle;
        write_triangles({triangles.data() + first, indices.data() + 3 * offset, triangles.size() - first, room,
                         triangles.data() + soon.first_triangle},
                        order, count);
        if (ids.empty()) return;
        for (std::size_t k = 0; k < count; ++k) ids[offset + k] = state.facets[first + order[k]];
      });
  state.is_read = true;
  return state.drawn();
}

std::size_t PresortedReader::read_draw_ids(const glm::vec4& eye, std::span<std::uint32_t> ids) {
  State& state = *state_;
  assert(ids.size() >= state.mesh.pieces.size());
  state.go_to(eye);
  state.find_draw_ids();
  std::size_t count = 0;
  for (std::size_t k = 0; k < state.block_at.size(); ++k) {
    const Block& block = state.blocks.blocks[state.block_at[k]];
    for (std::size_t i = 0; i < state.kept[state.block_at[k]]; ++i) {
      const std::uint32_t id = state.draw_ids[block.first_triangle + state.orders[block.first_spot + i]];
      if (id != no_draw_id) ids[count++] = id;
    }
  }
  state.is_read = true;
  return count;
}

bool PresortedReader::is_read_for(const glm::vec4& eye) const {
  return state_->is_read && state_->last_eye && state_->last_eye->eye == eye;
}

bool PresortedReader::keeps_order(const glm::vec4& eye) {
  state_->go_to(eye);
  return state_->is_read;
}

void PresortedReader::forget_eye() {
  state_->last_eye.reset();
}

std::size_t PresortedReader::memory_bytes() const {
  const State& state = *state_;
  return state.blocks.memory_bytes() + bytes_of(state.block_states, state.kept, state.orders, state.top_sides,
                                             state.last_top_sides, state.places, state.block_at, state.offsets,
                                             state.facets, state.draw_ids);
}

}  // namespace facetsort
