#include "facetsort/scene/exact_groups.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "facetsort/base/memory.h"
#include "facetsort/base/parallel.h"
#include "facetsort/base/stopwatch.h"

namespace facetsort::scene_internal {
namespace {

Slabs slabs_of_object(const MergedMesh& merged, std::size_t k) {
  const MergedObject& object = merged.objects[k];
  return slabs_of(std::span(merged.mesh.triangles).subspan(object.first_facet, object.facet_count),
                  merged.mesh.positions);
}

}  // namespace

// Some objects as a mesh of their own, and its sorter.
struct ExactGroups::Group {
  Mesh mesh;
  std::vector<std::uint32_t> facets, vertices;  // of the merged mesh
  std::optional<ExactSorter> sorter;
  std::uint64_t last_used = 0;

  // Of the last sort.
  std::span<const std::uint32_t> order;
  OrderedTriangles triangles;
  bool is_cut = false;

  Group(const MergedMesh& merged, std::span<const std::uint32_t> objects);
  void sort(const SortView& view);
  void append_to(MergedOrder& to, std::size_t merged_vertices) const;
};

ExactGroups::Group::Group(const MergedMesh& merged, std::span<const std::uint32_t> objects) {
  for (const std::uint32_t k : objects) {
    const MergedObject& object = merged.objects[k];
    const auto first_vertex = static_cast<std::uint32_t>(vertices.size());
    for (std::uint32_t v = object.first_vertex; v < object.first_vertex + object.vertex_count; ++v) {
      vertices.push_back(v);
      mesh.positions.push_back(merged.mesh.positions[v]);
    }
    for (std::uint32_t f = object.first_facet; f < object.first_facet + object.facet_count; ++f) {
      facets.push_back(f);
      mesh.triangles.push_back(merged.mesh.triangles[f] - object.first_vertex + first_vertex);
    }
  }
}

void ExactGroups::Group::sort(const SortView& view) {
  order = sorter->sort(view);
  is_cut = !sorter->pieces().pieces.empty();
  if (is_cut) triangles = sorter->triangles();
}

void ExactGroups::Group::append_to(MergedOrder& to, std::size_t merged_vertices) const {
  if (!is_cut) {
    for (const std::uint32_t facet : order) {
      const glm::uvec3& t = mesh.triangles[facet];
      to.triangles.emplace_back(vertices[t.x], vertices[t.y], vertices[t.z]);
      to.facets.push_back(facets[facet]);
    }
    return;
  }
  const auto first_cut_vertex = static_cast<std::uint32_t>(merged_vertices + to.cut_vertices.size());
  const auto own_vertices = static_cast<std::uint32_t>(vertices.size());
  const auto merged_vertex = [&](std::uint32_t v) {
    return v < own_vertices ? vertices[v] : first_cut_vertex + (v - own_vertices);
  };
  for (const glm::uvec3& t : triangles.triangles) {
    to.triangles.emplace_back(merged_vertex(t.x), merged_vertex(t.y), merged_vertex(t.z));
  }
  for (const std::uint32_t facet : triangles.source) to.facets.push_back(facets[facet]);
  for (CutVertex vertex : triangles.vertices) {
    vertex.facet = facets[vertex.facet];
    to.cut_vertices.push_back(vertex);
  }
}

ExactGroups::ExactGroups(const MergedMesh& merged, const ExactOptions& options) : options_(options) {
  for (std::size_t k = 0; k < merged.objects.size(); ++k) slabs_.push_back(slabs_of_object(merged, k));
}

ExactGroups::~ExactGroups() = default;

void ExactGroups::update(const MergedMesh& merged, std::uint32_t k) {
  slabs_[k] = slabs_of_object(merged, k);
  slabs_changed_ = true;
  std::erase_if(prepared_,
                [&](const auto& entry) { return std::binary_search(entry.first.begin(), entry.first.end(), k); });
}

// Groups that cycles make come and go with the eye: the least recently used go where they take more than the scene
// does.
void ExactGroups::drop_unused(std::size_t facets) {
  std::size_t held = 0;
  for (const auto& [objects, group] : prepared_) held += group->facets.size();
  while (held > 2 * facets) {
    const auto oldest = std::min_element(prepared_.begin(), prepared_.end(), [](const auto& a, const auto& b) {
      return a.second->last_used < b.second->last_used;
    });
    if (oldest->second->last_used == sorts_) return;
    held -= oldest->second->facets.size();
    prepared_.erase(oldest);
  }
}

ExactGroups::Found ExactGroups::sort(const MergedMesh& merged, const SortView& view, MergedOrder& order) {
  Found found;
  Stopwatch stopwatch;
  ++sorts_;
  if (std::exchange(slabs_changed_, false)) object_groups_.set_slabs(slabs_);
  const auto& groups_found = object_groups_.find(view.eye);
  // Kept once they are ready, whatever may be thrown before.
  std::vector<std::pair<std::vector<std::uint32_t>, std::unique_ptr<Group>>> made;
  for (const std::vector<std::uint32_t>& objects : groups_found) {
    if (!prepared_.contains(objects)) made.emplace_back(objects, std::make_unique<Group>(merged, objects));
  }
  parallel_ranges(made.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) made[i].second->sorter.emplace(made[i].second->mesh.view(), options_);
  });
  found.prepared_groups = made.size();
  for (auto& [objects, group] : made) prepared_.emplace(std::move(objects), std::move(group));
  std::vector<Group*> groups;
  for (const std::vector<std::uint32_t>& objects : groups_found) {
    groups.push_back(prepared_.at(objects).get());
    groups.back()->last_used = sorts_;
  }
  found.groups = groups.size();
  found.prepare_ms = stopwatch.lap();
  parallel_ranges(groups.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) groups[i]->sort(view);
  });
  order.triangles.clear();
  order.facets.clear();
  order.cut_vertices.clear();
  for (const Group* group : groups) group->append_to(order, merged.mesh.positions.size());
  drop_unused(merged.mesh.triangles.size());
  found.sort_ms = stopwatch.lap();
  return found;
}

std::size_t ExactGroups::memory_bytes() const {
  std::size_t bytes = bytes_of(slabs_);
  for (const auto& [objects, group] : prepared_) {
    bytes += bytes_of(group->mesh.positions, group->mesh.triangles, group->facets, group->vertices) +
             group->sorter->memory_bytes();
  }
  return bytes;
}

}  // namespace facetsort::scene_internal
