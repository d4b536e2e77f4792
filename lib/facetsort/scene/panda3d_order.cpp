#include "facetsort/scene/panda3d_order.h"

#include <cstddef>
#include <map>
#include <string_view>

#include "facetsort/scene/comparator_sort.h"

namespace facetsort {
namespace {

using Objects = std::vector<Panda3DObject>;

void sort_bin(Panda3DBinType type, Objects& objects) {
  using scene_internal::sort_by_comparator;
  switch (type) {
    case Panda3DBinType::fixed:
      return sort_by_comparator(objects, panda3d_compare_fixed);
    case Panda3DBinType::state_sorted:
      return sort_by_comparator(objects, panda3d_compare_state_sorted);
    case Panda3DBinType::back_to_front:
      return sort_by_comparator(objects, panda3d_compare_back_to_front);
    case Panda3DBinType::front_to_back:
      return sort_by_comparator(objects, panda3d_compare_front_to_back);
    case Panda3DBinType::unsorted:
      return;
  }
}

// Places in `bins` of those in the order in which they are drawn.
std::vector<std::size_t> bin_sequence(std::span<const Panda3DBin> bins) {
  std::vector<std::size_t> sequence(bins.size());
  for (std::size_t i = 0; i < bins.size(); ++i) sequence[i] = i;
  scene_internal::sort_by_comparator(
      sequence, [&](std::size_t a, std::size_t b) { return static_cast<double>(bins[a].sort) - bins[b].sort; });
  return sequence;
}

ObjectDraw draw_of(std::uint32_t index, const Panda3DItem& item) {
  return {.item = index,
          .faces = item.two_sided ? Faces::all : Faces::front,
          .depth_test = item.depth_test,
          .depth_write = item.depth_write};
}

}  // namespace

std::vector<Panda3DBin> panda3d_default_bins() {
  return {{"background", 10, Panda3DBinType::fixed},
          {"opaque", 20, Panda3DBinType::state_sorted},
          {"transparent", 30, Panda3DBinType::back_to_front},
          {"fixed", 40, Panda3DBinType::fixed},
          {"unsorted", 50, Panda3DBinType::unsorted}};
}

const std::string& panda3d_bin_name(const Panda3DItem& item) {
  static const std::string opaque = "opaque", transparent = "transparent";
  if (item.bin) return *item.bin;
  return item.transparency ? transparent : opaque;
}

double panda3d_distance(const Panda3DItem& item, const Panda3DCamera& camera) {
  const glm::dvec3 to_centre = item.bounds_centre - camera.position;
  return to_centre.x * camera.forward.x + to_centre.y * camera.forward.y + to_centre.z * camera.forward.z;
}

double panda3d_compare_fixed(const Panda3DObject& a, const Panda3DObject& b) {
  return static_cast<double>(a.draw_order) - b.draw_order;
}

double panda3d_compare_state_sorted(const Panda3DObject& a, const Panda3DObject& b) {
  return static_cast<double>(a.state) - b.state;
}

double panda3d_compare_back_to_front(const Panda3DObject& a, const Panda3DObject& b) {
  return b.distance - a.distance;
}

double panda3d_compare_front_to_back(const Panda3DObject& a, const Panda3DObject& b) {
  return a.distance - b.distance;
}

Result<std::vector<ObjectDraw>> panda3d_draw_order(std::span<const Panda3DItem> items, const Panda3DCamera& camera,
                                                   std::span<const Panda3DBin> bins) {
  std::map<std::string_view, Objects> objects_of;
  for (const Panda3DBin& bin : bins) {
    if (!objects_of.try_emplace(bin.name).second) return Status{Fault::bad_argument, "two bins named " + bin.name};
  }
  for (std::size_t i = 0; i < items.size(); ++i) {
    const Panda3DItem& item = items[i];
    const auto bin = objects_of.find(panda3d_bin_name(item));
    if (bin == objects_of.end()) {
      return Status{Fault::bad_argument, "item " + std::to_string(i) + ": no bin named " + panda3d_bin_name(item)};
    }
    bin->second.push_back({static_cast<std::uint32_t>(i), item.draw_order, item.state, panda3d_distance(item, camera)});
  }

  std::vector<ObjectDraw> draws;
  draws.reserve(items.size());
  for (const std::size_t place : bin_sequence(bins)) {
    Objects& objects = objects_of.at(bins[place].name);
    sort_bin(bins[place].type, objects);
    for (const Panda3DObject& object : objects) draws.push_back(draw_of(object.item, items[object.item]));
  }
  return draws;
}

}  // namespace facetsort
