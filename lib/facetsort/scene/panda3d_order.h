// The order in which Panda3D draws whole objects, by its manual: "How to Control Render Order" (cull bins, set_bin) and
// "Transparency and Blending", release 1.10.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/scene/object_draw.h"

namespace facetsort {

// CullBinManager's BT_... types: how a bin orders what is in it.
enum class Panda3DBinType {
  fixed,          // by the draw_order that set_bin gave, smaller first
  state_sorted,   // equal states after each other
  back_to_front,  // by distance from the camera plane, far to near
  front_to_back,  // near to far
  unsorted,       // as the scene graph is walked
};

struct Panda3DBin {
  std::string name;
  int sort = 0;  // smaller bins are drawn first
  Panda3DBinType type = Panda3DBinType::unsorted;

  bool operator==(const Panda3DBin&) const = default;
};

// background 10 fixed, opaque 20 state-sorted, transparent 30 back-to-front, fixed 40 fixed, unsorted 50 unsorted.
std::vector<Panda3DBin> panda3d_default_bins();

// A Geom and the render attributes that it ended up with.
struct Panda3DItem {
  std::optional<std::string> bin = {};  // set_bin(name, draw_order); unset: transparent or opaque, by transparency
  int draw_order = 0;                   // of set_bin; read in bins of type fixed
  bool transparency = false;            // set_transparency
  std::uint32_t state = 0;              // numbers render states; a state-sorted bin draws equal ones together
  glm::dvec3 bounds_centre{0};          // of the bounding volume, in world space
  bool depth_test = true;               // set_depth_test
  bool depth_write = true;              // set_depth_write; nothing but this turns it off
  bool two_sided = false;               // set_two_sided
};

struct Panda3DCamera {
  glm::dvec3 position{0};
  glm::dvec3 forward{0, 1, 0};  // unit vector along the view
};

// The bin that an item falls into.
const std::string& panda3d_bin_name(const Panda3DItem& item);

// From the plane through the camera across its view direction to the centre of the bounding volume; negative behind it.
// In double (the engine usually computes it in float32).
double panda3d_distance(const Panda3DItem& item, const Panda3DCamera& camera);

// What a bin sorts.
struct Panda3DObject {
  std::uint32_t item = 0;
  int draw_order = 0;
  std::uint32_t state = 0;
  double distance = 0;
};
// Below 0 where `a` is drawn first, above 0 where `b` is.
double panda3d_compare_fixed(const Panda3DObject& a, const Panda3DObject& b);
double panda3d_compare_state_sorted(const Panda3DObject& a, const Panda3DObject& b);
double panda3d_compare_back_to_front(const Panda3DObject& a, const Panda3DObject& b);
double panda3d_compare_front_to_back(const Panda3DObject& a, const Panda3DObject& b);

// The draws of a frame: bin after bin, each item once. Items are given in the order in which the scene graph is walked;
// ties go to the earlier item, where the engine's std::sort leaves them in any order; bins of equal sort are drawn in
// the order given. Refuses with bad_argument an item in a bin that is not among `bins`, and two bins of one name.
// Allocates; safe from several threads at once.
Result<std::vector<ObjectDraw>> panda3d_draw_order(std::span<const Panda3DItem> items, const Panda3DCamera& camera,
                                                   std::span<const Panda3DBin> bins = panda3d_default_bins());

}  // namespace facetsort
