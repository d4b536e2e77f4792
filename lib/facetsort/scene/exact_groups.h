// Internal to scene: the exact order of a merged mesh, group by group of its objects.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "facetsort/exact/exact_sorter.h"
#include "facetsort/order/sorter.h"
#include "facetsort/scene/merge.h"
#include "facetsort/scene/object_groups.h"

namespace facetsort::scene_internal {

// An order of the merged mesh. Corners from the mesh's vertex count on are cut vertices.
struct MergedOrder {
  std::vector<glm::uvec3> triangles;
  std::vector<std::uint32_t> facets;
  std::vector<CutVertex> cut_vertices;
};

class ExactGroups {
 public:
  ExactGroups(const MergedMesh& merged, const ExactOptions& options);
  ~ExactGroups();

  // Object k of the merged mesh has new positions.
  void update(const MergedMesh& merged, std::uint32_t k);

  struct Found {
    std::size_t groups = 0, prepared_groups = 0;
    double prepare_ms = 0, sort_ms = 0;
  };
  Found sort(const MergedMesh& merged, const SortView& view, MergedOrder& order);

  std::size_t memory_bytes() const;

 private:
  struct Group;
  void drop_unused(std::size_t facets);

  ExactOptions options_;
  std::vector<Slabs> slabs_;
  bool slabs_changed_ = true;
  ObjectGroups object_groups_;
  std::map<std::vector<std::uint32_t>, std::unique_ptr<Group>> prepared_;  // by their objects
  std::uint64_t sorts_ = 0;
};

}  // namespace facetsort::scene_internal
