// Internal to exact: judging the planes that might divide a set of parts.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>

namespace facetsort::exact_internal {

// How parts lie with respect to a plane.
struct SideCounts {
  std::uint32_t front = 0, back = 0;         // reach to this side; those cut, to both
  std::uint32_t cut = 0, cut_at_corner = 0;  // the latter through a corner of theirs, which gives fewer triangles

  SideCounts& operator+=(const SideCounts& other) {
    front += other.front;
    back += other.back;
    cut += other.cut;
    cut_at_corner += other.cut_at_corner;
    return *this;
  }
};

// Some of the parts of a set, rounded: a cost need not be exact. In arrays, for vectors of any length; what is found
// does not depend on the instruction set.
class PartSample {
 public:
  static constexpr std::size_t most_parts = 4096, most_corners = 4, rough_parts = 256;

  // Forgets what it holds. `all`: the parts of the set; lowest, highest: their box.
  void begin(std::size_t all, const glm::dvec3& lowest, const glm::dvec3& highest);
  // The corners of a part; of more than most_corners, some. Precondition: fewer than most_parts were added since.
  void add(std::span<const glm::dvec3> part);

  // Cuts for what the tree gains by the plane of this normal, of any length, through `origin`: the logarithm of the
  // number of orders that the parts can still come in falls by about the entropy of how the plane distributes them.
  // Infinite where it distributes nothing. Where some of the parts show that it is far above `least`, that is all it
  // tells.
  double cost(const glm::dvec3& normal, const glm::dvec3& origin, double least) const;
  // Whether a cost is near that of a plane that cuts nothing and has half of the parts on either side.
  bool is_hard_to_beat(double cost) const;

 private:
  double cost_of(const SideCounts& counts, std::size_t seen) const;

  glm::dvec3 origin_{0};
  double scale_ = 1, all_ = 0, log_all_ = 0;
  std::size_t count_ = 0, corners_ = 3;
  alignas(64) float rough_[most_corners][3][rough_parts] = {};  // of the first parts
  alignas(64) double coordinates_[most_corners][3][most_parts] = {};
};

}  // namespace facetsort::exact_internal
