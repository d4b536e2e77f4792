#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/order/presorted_mesh.h"
#include "mesh/temporary_folder.h"
#include "order/presorted_samples.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr std::uint32_t facets = 1200000;
// About what cuts leave on a scanned mesh.
constexpr std::uint32_t facets_per_made_vertex = 3;

// As large as a presorted mesh of a million facets: a file in memory, so that no disk is timed.
class File {
 public:
  File() : data_(stacked_facets(facets, TreeShape::balanced)) {
    for (PresortedPiece& piece : data_.pieces) piece.cut_count = 1;
    data_.cuts.assign(facets, {0, 1});
    data_.made_vertices.assign(facets / facets_per_made_vertex, {0, {0.5f, 0.25f, 0.25f}});
    data_.made_positions.resize(data_.made_vertices.size());
    written_ = write_presorted(path(), data_.view()).ok();
  }

  std::filesystem::path path() const { return folder_.path() / "stack.fsort"; }
  std::filesystem::path other_path() const { return folder_.path() / "other.fsort"; }
  const PresortedData& data() const { return data_; }
  bool is_written() const { return written_; }
  std::uintmax_t size() const { return std::filesystem::file_size(path()); }

 private:
  TemporaryFolder folder_;
  PresortedData data_;
  bool written_;
};

const File& the_file() {
  static const File file;
  return file;
}

void finish(benchmark::State& state, bool is_right) {
  if (!is_right) state.SkipWithError("not what was written");
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(the_file().size()));
}

void open_file(benchmark::State& state, int threads) {
  const File& file = the_file();
  bool is_right = file.is_written();
  tbb::task_arena arena(threads);
  arena.execute([&] {
    for (auto _ : state) {
      const Result<PresortedMesh> mesh = PresortedMesh::open(file.path());
      is_right &= mesh.ok() &&
                  std::ranges::equal(mesh.value().view().triangles.last(1), std::span(file.data().triangles).last(1));
    }
  });
  finish(state, is_right);
}

void write_file(benchmark::State& state, int threads) {
  const File& file = the_file();
  bool is_right = file.is_written();
  tbb::task_arena arena(threads);
  arena.execute([&] {
    for (auto _ : state) is_right &= write_presorted(file.other_path(), file.data().view()).ok();
  });
  finish(state, is_right && std::filesystem::file_size(file.other_path()) == file.size());
}

// What a reader that copies would begin with.
void read_file(benchmark::State& state, int) {
  const File& file = the_file();
  std::vector<std::byte> bytes(file.size());
  bool is_right = file.is_written();
  for (auto _ : state) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> stream(std::fopen(file.path().c_str(), "rb"), &std::fclose);
    is_right &= stream != nullptr && std::fread(bytes.data(), 1, bytes.size(), stream.get()) == bytes.size();
  }
  finish(state, is_right);
}

}  // namespace

void register_presorted_file_benchmarks() {
  const std::string subject = "/stack_" + std::to_string(facets);
  register_per_thread_count("open_fsort" + subject, open_file);
  register_per_thread_count("write_fsort" + subject, write_file);
  register_per_thread_count("read_bytes" + subject, read_file, Clock::wall, {1});
}

}  // namespace facetsort::bench
