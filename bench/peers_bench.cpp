// What one would write instead of a Sorter: float keys from centroids, a sort of (key, id) pairs, an index buffer.
// Each on one thread, with its memory kept from frame to frame.
#include <benchmark/benchmark.h>
#ifdef FACETSORT_BENCH_VQSORT
#include <hwy/contrib/sort/vqsort.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "sort_subjects.h"

namespace facetsort::bench {
namespace {

// Keys are squares and so not negative: their bits ascend with them.
std::uint64_t descending_entry(float key, std::size_t id) {
  return static_cast<std::uint64_t>(~std::bit_cast<std::uint32_t>(key)) << 32 | id;
}

class Frame {
 public:
  explicit Frame(const Mesh& mesh)
      : mesh_(mesh),
        points_(facet_centroids(mesh.view(), {})),
        keys_(mesh.triangles.size()),
        order_(keys_.size()),
        indices_(3 * keys_.size()) {}

  void compute_keys(const SortView& view) {
    const glm::vec3 eye(view.eye);
    for (std::size_t facet = 0; facet < keys_.size(); ++facet) {
      const float x = points_.x[facet] - eye.x, y = points_.y[facet] - eye.y, z = points_.z[facet] - eye.z;
      keys_[facet] = x * x + y * y + z * z;
    }
  }
  template <typename IdAt>
  void write_indices(const IdAt& id_at) {
    for (std::size_t k = 0; k < keys_.size(); ++k) {
      order_[k] = id_at(k);
      const glm::uvec3& triangle = mesh_.triangles[order_[k]];
      for (int corner = 0; corner < 3; ++corner) indices_[3 * k + corner] = triangle[corner];
    }
  }
  const std::vector<float>& keys() const { return keys_; }
  bool is_right() const {
    return is_back_to_front(order_, keys_) && has_corners_in_order(indices_, mesh_.triangles, order_);
  }

 private:
  const Mesh& mesh_;
  PointArrays points_;
  std::vector<float> keys_;
  std::vector<std::uint32_t> order_, indices_;
};

class StdSort {
 public:
  void operator()(Frame& frame) {
    pairs_.resize(frame.keys().size());
    for (std::size_t id = 0; id < pairs_.size(); ++id) pairs_[id] = {-frame.keys()[id], static_cast<std::uint32_t>(id)};
    std::sort(pairs_.begin(), pairs_.end());
    frame.write_indices([&](std::size_t k) { return pairs_[k].second; });
  }

 private:
  std::vector<std::pair<float, std::uint32_t>> pairs_;
};

#ifdef FACETSORT_BENCH_VQSORT
class VqSort {
 public:
  void operator()(Frame& frame) {
    entries_.resize(frame.keys().size());
    for (std::size_t id = 0; id < entries_.size(); ++id) entries_[id] = descending_entry(frame.keys()[id], id);
    sorter_(entries_.data(), entries_.size(), hwy::SortAscending());
    frame.write_indices([&](std::size_t k) { return static_cast<std::uint32_t>(entries_[k]); });
  }

 private:
  hwy::Sorter sorter_;
  std::vector<std::uint64_t> entries_;
};
#endif

// The radix sort of thirty lines: least significant digit first, three passes of eleven bits.
class RadixSort {
 public:
  void operator()(Frame& frame) {
    const std::size_t count = frame.keys().size();
    entries_.resize(count);
    scratch_.resize(count);
    for (std::size_t id = 0; id < count; ++id) entries_[id] = descending_entry(frame.keys()[id], id);
    std::array<std::array<std::uint32_t, 2048>, 3> ends{};
    for (const std::uint64_t entry : entries_) {
      for (int pass = 0; pass < 3; ++pass) ++ends[pass][digit(entry, pass)];
    }
    for (auto& histogram : ends) {
      std::uint32_t sum = 0;
      for (std::uint32_t& bucket : histogram) sum += std::exchange(bucket, sum);
    }
    for (int pass = 0; pass < 3; ++pass) {
      for (const std::uint64_t entry : entries_) scratch_[ends[pass][digit(entry, pass)]++] = entry;
      entries_.swap(scratch_);
    }
    frame.write_indices([&](std::size_t k) { return static_cast<std::uint32_t>(entries_[k]); });
  }

 private:
  static std::size_t digit(std::uint64_t entry, int pass) { return entry >> (32 + 11 * pass) & 2047; }
  std::vector<std::uint64_t> entries_, scratch_;
};

template <typename Sort>
void sort_frames(benchmark::State& state, const Subject& subject) {
  const std::vector<SortView> views = sort_views(subject.mesh());
  Frame frame(subject.mesh());
  Sort sort;
  const auto run = [&](const SortView& view) {
    frame.compute_keys(view);
    sort(frame);
    benchmark::ClobberMemory();
  };
  run(views.back());
  std::size_t next = 0;
  for (auto _ : state) run(views[next++ % views.size()]);
  if (!frame.is_right()) state.SkipWithError("not back to front");
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(subject.mesh().triangles.size()));
}

}  // namespace

void register_peer_benchmarks() {
  for (const Subject& subject : sort_subjects()) {
    const auto add = [&](const std::string& name, void (*run)(benchmark::State&, const Subject&)) {
      benchmark::RegisterBenchmark((name + "/" + subject.name()).c_str(), run, subject)
          ->UseRealTime()
          ->Unit(benchmark::kMillisecond);
    };
    add("peer_std_sort", sort_frames<StdSort>);
    add("peer_radix_sort", sort_frames<RadixSort>);
#ifdef FACETSORT_BENCH_VQSORT
    add("peer_vqsort", sort_frames<VqSort>);
#endif
  }
}

}  // namespace facetsort::bench
