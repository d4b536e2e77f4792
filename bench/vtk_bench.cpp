// vtkDepthSortPolyData, what VTK offers to put translucent triangles in order: by a point of each facet, approximately.
// Timed until its output holds the cells in order, all its own copying included; it runs on one thread.
#include <benchmark/benchmark.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkDepthSortPolyData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "benchmarks.h"
#include "sort_subjects.h"

namespace facetsort::bench {
namespace {

// All facets, by the depth of their first corners along the view, which is what the filter goes by.
bool is_sorted(vtkPolyData& sorted, const Mesh& mesh, const View& view) {
  std::vector<std::array<vtkIdType, 3>> drawn, expected;
  const glm::dvec3 forward = glm::normalize(glm::dvec3(view.at) - glm::dvec3(view.eye));
  double last = std::numeric_limits<double>::infinity();
  bool in_order = true;
  vtkCellArray* cells = sorted.GetPolys();
  cells->InitTraversal();
  vtkIdType count;
  for (const vtkIdType* corners; cells->GetNextCell(count, corners) != 0;) {
    if (count != 3) return false;
    drawn.push_back({corners[0], corners[1], corners[2]});
    const glm::dvec3 first(mesh.positions[static_cast<std::size_t>(corners[0])]);
    const double depth = glm::dot(first - glm::dvec3(view.eye), forward);
    in_order = in_order && depth <= last + 1e-5 * std::abs(depth);
    last = depth;
  }
  for (const glm::uvec3& t : mesh.triangles) expected.push_back({t.x, t.y, t.z});
  std::sort(drawn.begin(), drawn.end());
  std::sort(expected.begin(), expected.end());
  return in_order && drawn == expected;
}

void sort_frames(benchmark::State& state, const Subject& subject) {
  const Mesh& mesh = subject.mesh();
  vtkNew<vtkPoints> points;
  for (const glm::vec3& p : mesh.positions) points->InsertNextPoint(p.x, p.y, p.z);
  vtkNew<vtkCellArray> cells;
  for (const glm::uvec3& t : mesh.triangles) {
    const vtkIdType corners[3] = {t.x, t.y, t.z};
    cells->InsertNextCell(3, corners);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(cells);
  vtkNew<vtkCamera> camera;
  vtkNew<vtkDepthSortPolyData> sort;
  sort->SetInputData(data);
  sort->SetCamera(camera);
  sort->SetDirectionToBackToFront();
  const std::vector<View> frames = frames_around(mesh, 1);
  std::size_t frame = 0;
  for (auto _ : state) {
    const View& view = frames[frame++ % frames.size()];
    camera->SetPosition(view.eye.x, view.eye.y, view.eye.z);
    camera->SetFocalPoint(view.at.x, view.at.y, view.at.z);
    sort->Modified();
    sort->Update();
    benchmark::DoNotOptimize(sort->GetOutput());
  }
  if (frame > 0 && !is_sorted(*sort->GetOutput(), mesh, frames[(frame - 1) % frames.size()])) {
    state.SkipWithError("not the facets, back to front by their first corners");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(mesh.triangles.size()));
}

}  // namespace

void register_vtk_benchmarks() {
  std::vector<Subject> subjects = shipped_meshes();
  for (const Subject& subject : spatial_subjects()) {
    if (subject.name().starts_with("knot_")) subjects.push_back(subject);
  }
  for (const Subject& subject : subjects) {
    benchmark::RegisterBenchmark(("vtk_depth_sort/" + subject.name()).c_str(), sort_frames, subject)
        ->UseRealTime()
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace facetsort::bench
