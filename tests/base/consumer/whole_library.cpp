// Every stage once, through the header that includes them all: write and read a tetrahedron, sort, draw and judge it,
// alone and as a scene.
#include <array>
#include <cstdio>
#include <glm/glm.hpp>
#include <utility>

#include "facetsort/facetsort.h"

int main() {
  using namespace facetsort;
  const std::array<glm::vec3, 4> positions{glm::vec3(1, 1, 1), glm::vec3(1, -1, -1), glm::vec3(-1, 1, -1),
                                           glm::vec3(-1, -1, 1)};
  const std::array<glm::uvec3, 4> triangles{glm::uvec3(0, 1, 2), glm::uvec3(0, 3, 1), glm::uvec3(0, 2, 3),
                                            glm::uvec3(1, 3, 2)};
  if (!write_ply("tetrahedron.ply", {positions, triangles, {}, {}}).ok()) return 1;
  const Result<Mesh> mesh = read_mesh("tetrahedron.ply");
  if (!mesh.ok() || inspect(mesh.value().view()).facets != 4) return 1;

  const MeshView tetrahedron = mesh.value().view();
  View view = default_view(facet_bounds(tetrahedron), {3, 4, 5});
  view.width = view.height = 64;
  StrategyRenderer renderer(tetrahedron, {StrategyKind::facet_sort, Method::centroid_distance});
  renderer.order(view);
  Image picture;
  if (renderer.draw(view, PixelFormat::rgba32f, picture).facets_drawn != 4) return 1;
  if (!write_image("tetrahedron.png", picture).ok()) return 1;

  if (three_draw_order(std::array<ThreeItem, 2>{}, {}).size() != 2) return 1;

  const Result<EmbreeReferee> referee = EmbreeReferee::create(tetrahedron);
  if (!referee.ok()) return 1;
  const Result<RayHits> hits = referee.value().cast(view);
  if (!hits.ok()) return 1;
  const Verdict verdict = judge_drawing(hits.value().lists, renderer.ranks(view, hits.value().lists), {});
  if (verdict.covered_pixels == 0 || verdict.inverted_pixels != 0) return 1;

  const Result<Scene> scene = read_scene("tetrahedron.ply");
  if (!scene.ok()) return 1;
  Result<SceneSorter> sorter = SceneSorter::create(scene.value(), blended_objects(scene.value()));
  if (!sorter.ok()) return 1;
  const SceneOrder order = sorter.value().sort({view.homogeneous_eye(), view.forward()});
  if (order.runs.size() != 1 || order.indices.size() != 12) return 1;
  if (!write_scene("tetrahedron.glb", scene.value(),
                   object_orders(scene.value(), sorter.value().merged(), order.facets))
           .ok()) {
    return 1;
  }
  if (!write_csv("comparison.csv", {}).ok()) return 1;
  std::puts("sorted, drawn and judged");
  return 0;
}
