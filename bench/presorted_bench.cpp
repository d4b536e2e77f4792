#include <benchmark/benchmark.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "benchmarks.h"
#include "facetsort/exact/predicates.h"
#include "facetsort/exact/presort.h"
#include "facetsort/order/presorted_reader.h"
#include "facetsort/order/sorter.h"
#include "sort_subjects.h"
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

// By a stack, node after node: indices in the order that the tree gives.
std::vector<std::uint32_t> walk(const PresortedView& mesh, const glm::vec4& eye) {
  std::vector<std::size_t> end{0};  // triangles up to each node's, from those without a node on
  std::size_t in_nodes = 0, piece = 0;
  for (const PresortedNode& node : mesh.nodes) in_nodes += node.piece_count;
  while (piece < mesh.pieces.size() - in_nodes) end.back() += mesh.pieces[piece++].triangle_count;
  for (const PresortedNode& node : mesh.nodes) {
    end.push_back(end.back());
    for (std::uint32_t k = 0; k < node.piece_count; ++k) end.back() += mesh.pieces[piece++].triangle_count;
  }
  std::vector<std::uint32_t> indices;
  const auto draw = [&](std::size_t first, std::size_t last) {
    for (std::size_t t = first; t < last; ++t) {
      for (int i = 0; i < 3; ++i) indices.push_back(mesh.triangles[t][i]);
    }
  };
  draw(0, end[0]);
  struct Visit {
    std::size_t node;
    bool beyond_is_drawn;
  };
  std::vector<Visit> left;
  if (!mesh.nodes.empty()) left.push_back({0, false});
  while (!left.empty()) {
    const Visit visit = left.back();
    left.pop_back();
    if (visit.beyond_is_drawn) {
      draw(end[visit.node], end[visit.node + 1]);
      continue;
    }
    const PresortedNode& node = mesh.nodes[visit.node];
    const glm::vec3* p = mesh.mesh.positions.data();
    const bool in_front = side_of_plane(p[node.plane.x], p[node.plane.y], p[node.plane.z], eye) >= 0;
    const auto visit_side = [&](bool front) {
      if ((front ? node.front_nodes : node.back_nodes) == 0) return;
      left.push_back({visit.node + 1 + (front ? 0 : node.front_nodes), false});
    };
    visit_side(in_front);
    left.push_back({visit.node, true});
    visit_side(!in_front);
  }
  return indices;
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
    if (indices != walk(data.view(), eye)) state.SkipWithError("another order than the tree's");
    state.counters["prepared_bytes"] = static_cast<double>(reader.memory_bytes());
  });
  state.counters["triangles"] = static_cast<double>(data.triangles.size());
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

// The same from eye to eye by the facet sort, of facets as they are.
void sort_frames(benchmark::State& state, const Subject& subject, int threads) {
  const Mesh& mesh = subject.mesh();
  const std::vector<SortView> views = sort_views(mesh);
  std::vector<std::uint32_t> indices(3 * mesh.triangles.size());
  tbb::task_arena arena(threads);
  arena.execute([&] {
    Sorter sorter(mesh.view());
    sorter.sort_indices(views.back(), mesh.triangles, indices);
    std::size_t frame = 0;
    for (auto _ : state) {
      sorter.sort_indices(views[frame++ % views.size()], mesh.triangles, indices);
      benchmark::ClobberMemory();
    }
    const SortView& last = views[frame == 0 ? views.size() - 1 : (frame - 1) % views.size()];
    if (!has_corners_in_order(indices, mesh.triangles, sorter.sort(last))) state.SkipWithError("not in order");
  });
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
    register_per_thread_count("read_presorted_facet_sort/" + subject.name(),
                              [=](benchmark::State& state, int threads) { sort_frames(state, subject, threads); });
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
