#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/view.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr int picture_size = 512;

void collect_frames(benchmark::State& state, const Subject& subject, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<View> frames = frames_around(mesh, picture_size);
  FragmentLists lists = collect_fragments(mesh.view(), frames.back());
  std::size_t frame = 0, fragments = 0;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    for (auto _ : state) {
      lists = collect_fragments(mesh.view(), frames[frame++ % frames.size()]);
      fragments += lists.fragments.size();
    }
  });
  FragmentLists again;
  tbb::task_arena other(other_thread_count(threads));
  other.execute([&] { again = collect_fragments(mesh.view(), frames[(frame + frames.size() - 1) % frames.size()]); });
  if (checksum(lists) != checksum(again)) state.SkipWithError("other lists with another thread count");
  state.SetItemsProcessed(static_cast<std::int64_t>(fragments));
}

}  // namespace

void register_fragment_benchmarks() {
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& knot : knots(1000, 1000000)) subjects.push_back(knot);
  for (const Subject& subject : subjects) {
    register_per_thread_count("collect_fragments/" + subject.name(), [=](benchmark::State& state, int threads) {
      collect_frames(state, subject, threads);
    });
  }
}

}  // namespace facetsort::bench
