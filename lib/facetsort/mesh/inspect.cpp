#include "facetsort/mesh/inspect.h"

#include <tbb/parallel_sort.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

namespace facetsort {
namespace {

bool is_finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// A vertex under the bits of its position, which sort cheaply; the order they give has no meaning but equality.
struct PositionKey {
  std::array<std::uint32_t, 3> bits;
  std::uint32_t vertex;

  bool operator<(const PositionKey& other) const { return bits < other.bits; }
};

// -0 + 0 is +0, so that both zeros have the same bits.
std::array<std::uint32_t, 3> position_bits(const glm::vec3& p) {
  return {std::bit_cast<std::uint32_t>(p.x + 0.0f), std::bit_cast<std::uint32_t>(p.y + 0.0f),
          std::bit_cast<std::uint32_t>(p.z + 0.0f)};
}

constexpr std::uint32_t unused = std::numeric_limits<std::uint32_t>::max();

// For each vertex the number of its position, from 0 to distinct_positions - 1; `unused` where no facet names it.
std::vector<std::uint32_t> number_positions(const MeshView& mesh, MeshFacts& facts) {
  std::vector<std::uint32_t> position_of_vertex(mesh.vertex_count(), unused);
  std::vector<PositionKey> keys;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      if (position_of_vertex[triangle[i]] != unused) continue;
      position_of_vertex[triangle[i]] = 0;
      keys.push_back({position_bits(mesh.positions[triangle[i]]), triangle[i]});
    }
  }
  facts.lowest = facts.highest = mesh.positions[keys.front().vertex];
  for (const PositionKey& key : keys) {
    facts.lowest = glm::min(facts.lowest, mesh.positions[key.vertex]);
    facts.highest = glm::max(facts.highest, mesh.positions[key.vertex]);
  }
  tbb::parallel_sort(keys.begin(), keys.end());
  std::uint32_t position = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (i > 0 && keys[i - 1].bits != keys[i].bits) ++position;
    position_of_vertex[keys[i].vertex] = position;
  }
  facts.distinct_positions = position + std::size_t{1};
  return position_of_vertex;
}

bool is_collapsed(const glm::uvec3& corners) {
  return corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0];
}

std::size_t count_duplicates(const std::vector<glm::uvec3>& facets) {
  std::vector<std::array<std::uint32_t, 3>> sorted(facets.size());
  for (std::size_t f = 0; f < facets.size(); ++f) {
    sorted[f] = {facets[f].x, facets[f].y, facets[f].z};
    std::sort(sorted[f].begin(), sorted[f].end());
  }
  tbb::parallel_sort(sorted.begin(), sorted.end());
  std::size_t duplicates = 0;
  for (std::size_t f = 1; f < sorted.size(); ++f) duplicates += sorted[f] == sorted[f - 1];
  return duplicates;
}

// One side of a facet. Both directions of an edge have the same `ends`.
struct FacetEdge {
  std::uint64_t ends;
  std::uint32_t facet;
  bool forward;  // runs from the smaller position number to the larger

  bool operator<(const FacetEdge& other) const { return ends < other.ends; }
};

// Disjoint sets of facets; union by smaller id with path halving.
class FacetSets {
 public:
  explicit FacetSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::uint32_t{0});
  }

  // Whether the two were in different sets.
  bool unite(std::uint32_t a, std::uint32_t b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    parent_[std::max(a, b)] = std::min(a, b);
    return true;
  }

 private:
  std::uint32_t root(std::uint32_t facet) {
    while (parent_[facet] != facet) facet = parent_[facet] = parent_[parent_[facet]];
    return facet;
  }

  std::vector<std::uint32_t> parent_;
};

// `facets` has position numbers for corners.
void count_edges(const std::vector<glm::uvec3>& facets, MeshFacts& facts) {
  std::vector<FacetEdge> sides;
  sides.reserve(3 * (facets.size() - facts.collapsed_facets));
  for (std::size_t f = 0; f < facets.size(); ++f) {
    if (is_collapsed(facets[f])) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t from = facets[f][i], to = facets[f][(i + 1) % 3];
      sides.push_back(
          {std::uint64_t{std::min(from, to)} << 32 | std::max(from, to), static_cast<std::uint32_t>(f), from < to});
    }
  }
  tbb::parallel_sort(sides.begin(), sides.end());

  FacetSets sets(facets.size());
  facts.components = facets.size() - facts.collapsed_facets;
  bool every_edge_even = true;
  for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
    for (end = begin + 1; end < sides.size() && sides[end].ends == sides[begin].ends; ++end) {
      if (sets.unite(sides[begin].facet, sides[end].facet)) --facts.components;
    }
    const std::size_t facets_on_edge = end - begin;
    ++facts.edges;
    facts.boundary_edges += facets_on_edge == 1;
    facts.non_manifold_edges += facets_on_edge > 2;
    facts.misoriented_edges += facets_on_edge == 2 && sides[begin].forward == sides[begin + 1].forward;
    every_edge_even &= facets_on_edge % 2 == 0;
  }
  facts.closed = facts.edges > 0 && every_edge_even;
  facts.oriented = facts.misoriented_edges == 0 && facts.non_manifold_edges == 0;
}

Status validate_colours(std::span<const glm::vec4> colours, const char* of) {
  const auto bad = std::find_if_not(colours.begin(), colours.end(), is_colour);
  if (bad == colours.end()) return {};
  return not_a_colour(of + std::to_string(bad - colours.begin()));
}

Status validate_materials(const MeshView& mesh) {
  if (mesh.facet_materials.empty()) return {};
  const std::size_t facets = mesh.facet_count(), vertices = mesh.vertex_count();
  if (mesh.facet_materials.size() != facets) {
    return {Fault::size_mismatch,
            std::to_string(mesh.facet_materials.size()) + " facet materials for " + std::to_string(facets) + " facets"};
  }
  if (!mesh.texture_coordinates.empty() && mesh.texture_coordinates.size() != vertices) {
    return {Fault::size_mismatch, std::to_string(mesh.texture_coordinates.size()) + " texture coordinates for " +
                                      std::to_string(vertices) + " vertices"};
  }
  if (Status status = validate(mesh.textures); !status.ok()) return status;
  for (std::size_t i = 0; i < mesh.materials.size(); ++i) {
    if (!is_colour(mesh.materials[i].base_colour)) return not_a_colour("material " + std::to_string(i));
  }
  for (std::size_t f = 0; f < facets; ++f) {
    const std::uint32_t material = mesh.facet_materials[f];
    if (material >= mesh.materials.size()) {
      return {Fault::index_out_of_range, "facet " + std::to_string(f) + " names material " + std::to_string(material) +
                                             " of " + std::to_string(mesh.materials.size())};
    }
    const std::uint32_t texture = mesh.materials[material].texture;
    if (texture == Material::no_texture) continue;
    if (texture >= mesh.textures.size()) {
      return {Fault::index_out_of_range, "material " + std::to_string(material) + " names texture " +
                                             std::to_string(texture) + " of " + std::to_string(mesh.textures.size())};
    }
    if (mesh.texture_coordinates.empty()) {
      return {Fault::size_mismatch, "facet " + std::to_string(f) + " has a texture and no texture coordinates"};
    }
    for (int i = 0; i < 3; ++i) {
      const glm::vec2& at = mesh.texture_coordinates[mesh.triangles[f][i]];
      if (!std::isfinite(at.x) || !std::isfinite(at.y)) {
        return {Fault::non_finite_position, "facet " + std::to_string(f) + " uses vertex " +
                                                std::to_string(mesh.triangles[f][i]) +
                                                ", whose texture coordinates are not finite"};
      }
    }
  }
  return {};
}

}  // namespace

bool is_colour(const glm::vec4& straight) {
  constexpr float most = std::numeric_limits<float>::max();
  const auto is_within = [](float value, float highest) { return value >= 0 && value <= highest; };  // no NaN is
  return is_within(straight.r, most) && is_within(straight.g, most) && is_within(straight.b, most) &&
         is_within(straight.a, 1);
}

Status not_a_colour(const std::string& owner) {
  return {Fault::bad_argument, owner + " has a colour below 0, not finite or of an alpha above 1"};
}

Status validate(std::span<const Texture> textures) {
  for (std::size_t i = 0; i < textures.size(); ++i) {
    const Texture& texture = textures[i];
    if (texture.width <= 0 || texture.height <= 0 ||
        texture.texels.size() != static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height)) {
      return {Fault::size_mismatch, "texture " + std::to_string(i) + " has " + std::to_string(texture.texels.size()) +
                                        " texels for " + std::to_string(texture.width) + " x " +
                                        std::to_string(texture.height)};
    }
  }
  return {};
}

Status validate(const MeshView& mesh) {
  constexpr std::size_t most = std::numeric_limits<std::uint32_t>::max() - std::size_t{1};
  const std::size_t facets = mesh.facet_count(), vertices = mesh.vertex_count();
  if (facets == 0) return {Fault::empty_mesh, "no facet"};
  if (facets > most || vertices > most) {
    return {Fault::too_many_facets, std::to_string(facets) + " facets and " + std::to_string(vertices) +
                                        " vertices: ids have 32 bits, at most " + std::to_string(most) + " of each"};
  }
  if (!mesh.facet_colours.empty() && mesh.facet_colours.size() != facets) {
    return {Fault::size_mismatch,
            std::to_string(mesh.facet_colours.size()) + " facet colours for " + std::to_string(facets) + " facets"};
  }
  if (!mesh.vertex_colours.empty() && mesh.vertex_colours.size() != vertices) {
    return {Fault::size_mismatch, std::to_string(mesh.vertex_colours.size()) + " vertex colours for " +
                                      std::to_string(vertices) + " vertices"};
  }
  for (std::size_t f = 0; f < facets; ++f) {
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t vertex = mesh.triangles[f][i];
      if (vertex >= vertices) {
        return {Fault::index_out_of_range, "facet " + std::to_string(f) + " names vertex " + std::to_string(vertex) +
                                               " of " + std::to_string(vertices)};
      }
      if (!is_finite(mesh.positions[vertex])) {
        return {Fault::non_finite_position, "facet " + std::to_string(f) + " uses vertex " + std::to_string(vertex) +
                                                ", whose position is not finite"};
      }
    }
  }
  if (Status status = validate_colours(mesh.facet_colours, "facet "); !status.ok()) return status;
  if (Status status = validate_colours(mesh.vertex_colours, "vertex "); !status.ok()) return status;
  return validate_materials(mesh);
}

MeshFacts inspect(const MeshView& mesh) {
  MeshFacts facts;
  facts.facets = mesh.facet_count();
  facts.vertices = mesh.vertex_count();
  const std::vector<std::uint32_t> position_of_vertex = number_positions(mesh, facts);
  facts.bounding_radius = 0.5 * glm::length(glm::dvec3(facts.highest) - glm::dvec3(facts.lowest));

  std::vector<glm::uvec3> facets(facts.facets);
  for (std::size_t f = 0; f < facets.size(); ++f) {
    for (int i = 0; i < 3; ++i) facets[f][i] = position_of_vertex[mesh.triangles[f][i]];
    facts.collapsed_facets += is_collapsed(facets[f]);
  }
  facts.duplicate_facets = count_duplicates(facets);
  count_edges(facets, facts);
  return facts;
}

}  // namespace facetsort
