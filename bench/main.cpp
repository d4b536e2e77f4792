// facetsort-bench: Google Benchmark's options, and an exit status of 1 where a result was wrong.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/report/machine.h"

namespace {

// Shows what the reporter chosen on the command line shows, and remembers errors: Google Benchmark exits with 0.
class ErrorWatch : public benchmark::BenchmarkReporter {
 public:
  explicit ErrorWatch(std::unique_ptr<benchmark::BenchmarkReporter> shown) : shown_(std::move(shown)) {}

  bool ReportContext(const Context& context) override { return shown_->ReportContext(context); }
  void ReportRuns(const std::vector<Run>& runs) override {
    failed_ |= std::any_of(runs.begin(), runs.end(), [](const Run& run) { return run.error_occurred; });
    shown_->ReportRuns(runs);
  }
  void Finalize() override { shown_->Finalize(); }
  bool failed() const { return failed_; }

 private:
  std::unique_ptr<benchmark::BenchmarkReporter> shown_;
  bool failed_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  benchmark::AddCustomContext("command", facetsort::quoted_command_line(argc, argv));
  benchmark::AddCustomContext("machine", facetsort::describe_machine());
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  facetsort::bench::register_sort_benchmarks();
  facetsort::bench::register_floor_benchmarks();
  facetsort::bench::register_peer_benchmarks();
  facetsort::bench::register_exact_benchmarks();
  facetsort::bench::register_presorted_file_benchmarks();
  facetsort::bench::register_presorted_benchmarks();
#ifdef FACETSORT_BENCH_VTK
  facetsort::bench::register_vtk_benchmarks();
#endif
  facetsort::bench::register_draw_benchmarks();
#ifdef FACETSORT_BENCH_LLVMPIPE
  facetsort::bench::register_llvmpipe_benchmarks();
#endif
  facetsort::bench::register_fragment_benchmarks();
  facetsort::bench::register_index_buffers_benchmarks();
  facetsort::bench::register_scene_benchmarks();
  std::unique_ptr<benchmark::BenchmarkReporter> shown(benchmark::CreateDefaultDisplayReporter());
  ErrorWatch watch(std::move(shown));
  const std::size_t ran = benchmark::RunSpecifiedBenchmarks(&watch);
  return ran == 0 || watch.failed() ? 1 : 0;
}
