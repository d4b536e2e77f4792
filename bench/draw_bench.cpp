#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/blend/view.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

constexpr int picture_size = 1024;

constexpr const char* order_independent[] = {"depth_peeling",   "dual_depth_peeling",   "depth_peeling:5",
                                             "dual_depth_peeling:5", "additive",   "weighted_blended",
                                             "moment_based:4",  "moment_based:6", "multi_layer:4",
                                             "multi_layer:64",  "stochastic:8",   "stochastic:64"};

void draw_frames(benchmark::State& state, const Subject& subject, const Strategy& strategy, PixelFormat format,
                 int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<View> frames = frames_around(mesh, picture_size);
  StrategyRenderer renderer(mesh.view(), strategy);
  Image picture;
  std::size_t frame = 0;
  tbb::task_arena arena(threads);
  arena.execute([&] {
    // The sort is another benchmark's: only drawing is timed.
    for (const View& view : frames) {  // the scratch grows to what the largest frame needs
      renderer.order(view);
      renderer.draw(view, format, picture);
    }
    for (auto _ : state) {
      const View& view = frames[frame++ % frames.size()];
      renderer.order(view);
      const auto begin = std::chrono::steady_clock::now();
      renderer.draw(view, format, picture);
      state.SetIterationTime(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
    }
  });
  Image again;
  tbb::task_arena other(other_thread_count(threads));
  other.execute([&] { renderer.draw(frames[(frame + frames.size() - 1) % frames.size()], format, again); });
  if (checksum(picture) != checksum(again)) state.SkipWithError("another picture with another thread count");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_draw_benchmarks() {
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& knot : knots(1000, 1000000)) subjects.push_back(knot);
  const auto add = [](const std::string& stage, const Subject& subject, const Strategy& strategy, PixelFormat format) {
    const auto run = [=](benchmark::State& state, int threads) {
      draw_frames(state, subject, strategy, format, threads);
    };
    register_per_thread_count(stage + (format == PixelFormat::rgba8 ? "/rgba8/" : "/rgba32f/") + subject.name(), run,
                              Clock::manual);
  };
  for (const Subject& subject : subjects) {
    for (const PixelFormat format : {PixelFormat::rgba32f, PixelFormat::rgba8}) {
      add("draw", subject, {StrategyKind::facet_sort, Method::centroid_distance}, format);
    }
  }
  for (const Subject& subject : shipped_meshes()) {
    for (const char* name : order_independent) {
      add(name, subject, strategy_from_name(name).value(), PixelFormat::rgba32f);
    }
  }
}

}  // namespace facetsort::bench
