#include "facetsort/scene/scene_draw_order.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <utility>

#include "facetsort/scene/babylon_order.h"
#include "facetsort/scene/galacean_order.h"
#include "facetsort/scene/panda3d_order.h"
#include "facetsort/scene/three_order.h"

namespace facetsort {
namespace {

constexpr std::pair<DrawOrderRule, std::string_view> rules[] = {{DrawOrderRule::galacean, "galacean"},
                                                                {DrawOrderRule::babylon, "babylon"},
                                                                {DrawOrderRule::three, "three"},
                                                                {DrawOrderRule::panda3d, "panda3d"}};

struct DoubleBox {
  glm::dvec3 lowest{INFINITY}, highest{-INFINITY};

  void add(const glm::dvec3& point) {
    lowest = glm::min(lowest, point);
    highest = glm::max(highest, point);
  }
  glm::dvec3 centre() const { return (lowest + highest) / 2.0; }
};

// Of an object's vertices in its mesh's space: of what the engines bound, the vertices that no facet uses too.
Box own_box(const SceneMesh& mesh) {
  Box box{mesh.positions.front(), mesh.positions.front()};
  for (const glm::vec3& position : mesh.positions) {
    box.lowest = glm::min(box.lowest, position);
    box.highest = glm::max(box.highest, position);
  }
  return box;
}

// What the items of any engine are made of.
struct PlacedObjects {
  const Scene& scene;
  std::span<const MergedObject> objects;
  std::span<const Box> boxes;
};

glm::dvec3 placed(const glm::dmat4& world, const glm::dvec3& point) {
  return glm::dvec3(world * glm::dvec4(point, 1));
}

// Of the placed box's corners.
DoubleBox world_box(const SceneObject& object, const DoubleBox& own) {
  DoubleBox box;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::bvec3 is_high(corner & 1, corner & 2, corner & 4);
    box.add(placed(object.world, glm::mix(own.lowest, own.highest, is_high)));
  }
  return box;
}

glm::dvec3 forward_of(const SceneCamera& camera) {
  return glm::normalize(camera.at - camera.eye);
}

// One of an engine's items for each object, by make(object of the scene, its material, its own box).
template <typename Make>
auto items_of(const PlacedObjects& placed_objects, const Make& make) {
  const auto& [scene, objects, boxes] = placed_objects;
  std::vector<decltype(make(scene.objects[0], scene.materials[0], DoubleBox()))> items;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::uint32_t object = objects[i].object;
    const DoubleBox box{glm::dvec3(boxes[i].lowest), glm::dvec3(boxes[i].highest)};
    items.push_back(make(scene.objects[object], scene.material_of(object), box));
  }
  return items;
}

std::vector<ObjectDraw> galacean_draws(const PlacedObjects& placed_objects, const SceneCamera& camera) {
  const auto items =
      items_of(placed_objects, [](const SceneObject& object, const SceneMaterial& of, const DoubleBox& own) {
        const DoubleBox box = world_box(object, own);
        const Material& material = of.material;
        GalaceanItem item{
            .priority = object.settings.galacean.priority, .bounds_min = box.lowest, .bounds_max = box.highest};
        item.material.is_transparent = material.alpha_mode == AlphaMode::blend;
        item.material.alpha_cutoff =
            material.alpha_mode == AlphaMode::mask ? static_cast<double>(material.alpha_cutoff) : 0;
        item.material.render_face =
            material.double_sided ? GalaceanRenderFace::double_sided : GalaceanRenderFace::front;
        return item;
      });
  return galacean_draw_order(items, {camera.eye, forward_of(camera), !camera.perspective});
}

std::vector<ObjectDraw> babylon_draws(const PlacedObjects& placed_objects, const SceneCamera& camera) {
  auto items = items_of(placed_objects, [](const SceneObject& object, const SceneMaterial& of, const DoubleBox& own) {
    const Material& material = of.material;
    BabylonSubMesh item;
    item.bounding_sphere_centre_world = placed(object.world, own.centre());
    item.material.transparency_mode = material.alpha_mode == AlphaMode::opaque ? BabylonTransparencyMode::opaque
                                      : material.alpha_mode == AlphaMode::mask ? BabylonTransparencyMode::alpha_test
                                                                               : BabylonTransparencyMode::alpha_blend;
    item.material.alpha_cut_off = static_cast<double>(material.alpha_cutoff);
    item.material.back_face_culling = !material.double_sided;
    const EngineSettings::Babylon& settings = object.settings.babylon;
    item.rendering_group_id = settings.rendering_group_id;
    item.alpha_index = settings.alpha_index;
    item.material.need_depth_pre_pass = settings.need_depth_pre_pass;
    item.material.separate_culling_pass = settings.separate_culling_pass;
    item.material.force_depth_write = settings.force_depth_write;
    item.material.disable_depth_write = settings.disable_depth_write;
    return item;
  });
  BabylonScene scene{.camera_global_position = camera.eye};
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].mesh_unique_id = placed_objects.objects[i].object;
    items[i].mesh_material_unique_id = placed_objects.scene.mesh_of(placed_objects.objects[i].object).material;
    scene.rendering_groups.resize(
        std::max<std::size_t>(scene.rendering_groups.size(), items[i].rendering_group_id + 1));
  }
  return babylon_draw_order(items, scene);
}

std::vector<ObjectDraw> three_draws(const PlacedObjects& placed_objects, const SceneCamera& camera) {
  auto items = items_of(placed_objects, [](const SceneObject& object, const SceneMaterial& of, const DoubleBox& own) {
    const Material& material = of.material;
    const EngineSettings::Three& settings = object.settings.three;
    ThreeItem item{.group_order = settings.group_order,
                   .render_order = settings.render_order,
                   .matrix_world = object.world,
                   .bounding_sphere_centre = own.centre()};
    item.material.depth_test = settings.depth_test;
    item.material.depth_write = settings.depth_write;
    item.material.force_single_pass = settings.force_single_pass;
    item.material.transmission = of.transmissive ? 1 : 0;
    item.material.transparent = material.alpha_mode == AlphaMode::blend;
    item.material.side = material.double_sided ? ThreeSide::double_side : ThreeSide::front;
    item.material.alpha_test = material.alpha_mode == AlphaMode::mask ? static_cast<double>(material.alpha_cutoff) : 0;
    return item;
  });
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].id = placed_objects.objects[i].object;
    items[i].material.id = placed_objects.scene.mesh_of(placed_objects.objects[i].object).material;
  }
  // Clip-space z grows with the distance along the axis wherever near and far are.
  constexpr double nearest = 1e-3, farthest = 1e3;
  const double half_height = camera.height_in_units / 2;
  ThreeCamera engine_camera;
  engine_camera.projection_matrix =
      camera.perspective ? glm::perspective(glm::radians(camera.vertical_fov_degrees), 1.0, nearest, farthest)
                         : glm::ortho(-half_height, half_height, -half_height, half_height, nearest, farthest);
  // How the camera is turned about its axis does not matter, and its own up may lie along that.
  const glm::dvec3 up = std::abs(forward_of(camera).y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
  engine_camera.matrix_world_inverse = glm::lookAt(camera.eye, camera.at, up);
  return three_draw_order(items, engine_camera);
}

std::vector<ObjectDraw> panda3d_draws(const PlacedObjects& placed_objects, const SceneCamera& camera) {
  auto items = items_of(placed_objects, [](const SceneObject& object, const SceneMaterial& of, const DoubleBox& own) {
    const Material& material = of.material;
    const EngineSettings::Panda3D& settings = object.settings.panda3d;
    return Panda3DItem{.bin = settings.bin,
                       .draw_order = settings.draw_order,
                       .transparency = material.alpha_mode == AlphaMode::blend,
                       .bounds_centre = world_box(object, own).centre(),
                       .depth_test = settings.depth_test,
                       .depth_write = settings.depth_write,
                       .two_sided = material.double_sided};
  });
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i].state = placed_objects.scene.mesh_of(placed_objects.objects[i].object).material;
  }
  std::vector<Panda3DBin> bins = panda3d_default_bins();
  bins.insert(bins.end(), placed_objects.scene.panda3d_bins.begin(), placed_objects.scene.panda3d_bins.end());
  return panda3d_draw_order(items, {camera.eye, forward_of(camera)}, bins).value();  // validate() has seen the bins
}

}  // namespace

std::vector<DrawOrderRule> all_draw_order_rules() {
  std::vector<DrawOrderRule> all;
  for (const auto& [rule, name] : rules) all.push_back(rule);
  return all;
}

std::string_view draw_order_rule_name(DrawOrderRule rule) {
  return std::find_if(std::begin(rules), std::end(rules), [&](const auto& entry) { return entry.first == rule; })
      ->second;
}

std::optional<DrawOrderRule> draw_order_rule_from_name(std::string_view name) {
  for (const auto& [rule, known] : rules) {
    if (known == name) return rule;
  }
  return std::nullopt;
}

SceneDrawOrder::SceneDrawOrder(const Scene& scene, std::span<const MergedObject> objects)
    : scene_(&scene), objects_(objects) {
  for (const MergedObject& object : objects) boxes_.push_back(own_box(scene.mesh_of(object.object)));
}

std::vector<ObjectDraw> SceneDrawOrder::find(DrawOrderRule rule, const SceneCamera& camera) const {
  const PlacedObjects placed_objects{*scene_, objects_, boxes_};
  std::vector<ObjectDraw> draws;
  switch (rule) {
    case DrawOrderRule::galacean:
      draws = galacean_draws(placed_objects, camera);
      break;
    case DrawOrderRule::babylon:
      draws = babylon_draws(placed_objects, camera);
      break;
    case DrawOrderRule::three:
      draws = three_draws(placed_objects, camera);
      break;
    case DrawOrderRule::panda3d:
      draws = panda3d_draws(placed_objects, camera);
      break;
  }
  std::erase_if(draws, [](const ObjectDraw& draw) { return draw.transmission_pass; });
  return draws;
}

}  // namespace facetsort
