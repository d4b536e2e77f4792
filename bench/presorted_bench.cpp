#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/exact/presort.h"
#include "facetsort/order/presorted_reader.h"
#include "order/presorted_samples.h"
#include "sort_bench.h"
#include "subjects.h"
#include "thread_counts.h"

namespace facetsort::bench {
namespace {

// A mesh, presorted once it is asked for.
class PresortedSubject {
 public:
  explicit PresortedSubject(Subject subject) : subject_(std::move(subject)) {}

  const Mesh& mesh() const { return subject_.mesh(); }
  const PresortedData& data() const {
    if (!*data_) *data_ = presort(mesh().view())->data;
    return **data_;
  }

 private:
  Subject subject_;
  std::shared_ptr<std::optional<PresortedData>> data_ = std::make_shared<std::optional<PresortedData>>();
};

// Node after node, each decided exactly.
bool is_the_trees_order(const std::vector<std::uint32_t>& indices, const PresortedView& mesh, const glm::vec4& eye) {
  const std::vector<glm::uvec3> expected = walked_by_sides(
      mesh,
      [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) { return side_of_plane(a, b, c, eye) >= 0; });
  return std::ranges::equal(std::as_bytes(std::span(indices)), std::as_bytes(std::span(expected)));
}

// A camera that turns by so much a frame.
void read_orbit(benchmark::State& state, const PresortedSubject& subject, double degrees, int threads) {
  const Mesh& mesh = subject.mesh();
  const PresortedData& data = subject.data();
  const Box box = facet_bounds(mesh.view());
  double angle = 0;
  const auto next_eye = [&] {
    angle += degrees * 3.14159265358979323846 / 180;
    const glm::dvec3 direction = glm::normalize(glm::dvec3(std::sin(angle), 0.25, std::cos(angle)));
    return glm::vec4(glm::vec3(glm::dvec3(box.centre()) + 2.5 * static_cast<double>(box.radius()) * direction), 1);
  };
  std::vector<std::uint32_t> indices(3 * data.triangles.size());
  tbb::task_arena arena(threads);
  arena.execute([&] {
    PresortedReader reader(data.view());
    glm::vec4 eye = next_eye();
    reader.read_indices(eye, indices);
    for (auto _ : state) {
      eye = next_eye();
      reader.read_indices(eye, indices);
      benchmark::ClobberMemory();
    }
    if (!is_the_trees_order(indices, data.view(), eye)) state.SkipWithError("another order than the tree's");
    state.counters["prepared_bytes"] = static_cast<double>(reader.memory_bytes());
  });
  state.counters["triangles"] = static_cast<double>(data.triangles.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_presorted_benchmarks() {
  struct Orbit {
    const char* name;
    double degrees;
  };
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& knot : knots(10000, 1000000)) subjects.push_back(knot);
  for (const Subject& subject : subjects) {
    register_per_thread_count("read_presorted_facet_sort/" + subject.name(), [=](benchmark::State& state, int threads) {
      sort_index_buffers(state, subject, {}, threads);
    });
    const PresortedSubject presorted(subject);
    for (const Orbit& orbit : {Orbit{"read_presorted", 67}, Orbit{"read_presorted_orbit_2", 2},
                               Orbit{"read_presorted_orbit_0.5", 0.5}, Orbit{"read_presorted_orbit_0.1", 0.1}}) {
      register_per_thread_count(
          std::string(orbit.name) + "/" + subject.name(),
          [=](benchmark::State& state, int threads) { read_orbit(state, presorted, orbit.degrees, threads); });
    }
  }
}

}  // namespace facetsort::bench
