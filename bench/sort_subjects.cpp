#include "sort_subjects.h"

#include <algorithm>
#include <random>

#include "facetsort/order/spatial_order.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort::bench {
namespace {

Mesh in_spatial_order(Mesh mesh) {
  const std::vector<glm::uvec3> triangles = mesh.triangles;
  const std::vector<std::uint32_t> order = spatial_order(mesh.view());
  std::transform(order.begin(), order.end(), mesh.triangles.begin(), [&](std::uint32_t id) { return triangles[id]; });
  mesh.facet_colours.clear();
  return mesh;
}

Mesh shuffled(Mesh mesh) {
  std::shuffle(mesh.triangles.begin(), mesh.triangles.end(), std::mt19937(1));
  mesh.facet_colours.clear();
  return mesh;
}

struct Source {
  std::string name;
  std::function<Mesh()> make;
  bool from_file;
};

std::vector<Source> sources() {
  std::vector<Source> list;
  for (const std::size_t facets : {1000, 5000, 20000, 50000, 100000, 200000, 500000, 1000000, 2000000, 4000000}) {
    list.push_back({"knot_" + std::to_string(facets), [facets] { return shapes::torus_knot(facets); }, false});
  }
  for (const char* name : {"bunny_70k", "dragon_871k"}) {
    if (has_mesh(name)) list.push_back({name, [name] { return load(name); }, true});
  }
  return list;
}

}  // namespace

std::vector<Subject> sort_subjects() {
  std::vector<Subject> subjects;
  for (const Source& source : sources()) {
    subjects.emplace_back(source.name, [=] { return in_spatial_order(source.make()); });
    subjects.emplace_back(source.name + "_random", [=] { return shuffled(source.make()); });
    if (source.from_file) subjects.emplace_back(source.name + "_as_read", source.make);
  }
  return subjects;
}

std::vector<Subject> spatial_subjects() {
  std::vector<Subject> subjects;
  for (const Source& source : sources()) {
    subjects.emplace_back(source.name, [=] { return in_spatial_order(source.make()); });
  }
  return subjects;
}

std::vector<SortView> sort_views(const Mesh& mesh) {
  std::vector<SortView> views;
  for (const View& view : frames_around(mesh, 1)) views.push_back({view.homogeneous_eye(), view.forward()});
  return views;
}

bool is_back_to_front(std::span<const std::uint32_t> order, std::span<const float> keys) {
  if (order.size() != keys.size()) return false;
  std::vector<unsigned char> seen(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (order[i] >= order.size() || seen[order[i]]++) return false;
    if (i == 0) continue;
    const std::uint32_t before = order[i - 1], here = order[i];
    if (!(keys[before] > keys[here] || (keys[before] == keys[here] && before < here))) return false;
  }
  return true;
}

bool has_corners_in_order(std::span<const std::uint32_t> indices, std::span<const glm::uvec3> triangles,
                          std::span<const std::uint32_t> order) {
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      if (indices[3 * i + corner] != triangles[order[i]][corner]) return false;
    }
  }
  return true;
}

}  // namespace facetsort::bench
