#include "facetsort/scene/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "scene/random_scene.h"

namespace facetsort {
namespace {

Fault fault_after(void (*damage)(Scene&), const char* words) {
  Scene scene = random_scene(4, 2, 1);
  scene.textures.push_back({.width = 2, .height = 1, .texels = {glm::vec4(1), glm::vec4(0)}});
  scene.materials[0].material.texture = 0;
  EXPECT_TRUE(validate(scene).ok());
  damage(scene);
  const Status status = validate(scene);
  EXPECT_NE(status.message.find(words), std::string::npos) << status.message;
  return status.fault;
}

TEST(Scene, NamesWhatIsWrong) {
  EXPECT_EQ(fault_after([](Scene& s) { s.objects[2].mesh = 9; }, "object 2 names mesh 9 of 4"),
            Fault::index_out_of_range);
  EXPECT_EQ(fault_after([](Scene& s) { s.meshes[1].material = 1; }, "mesh 1 names material 1 of 1"),
            Fault::index_out_of_range);
  EXPECT_EQ(fault_after([](Scene& s) { s.materials[0].material.texture = 1; }, "material 0 names texture 1 of 1"),
            Fault::index_out_of_range);
  EXPECT_EQ(fault_after([](Scene& s) { s.textures[0].texels.pop_back(); }, "texture 0 has 1 texels for 2 x 1"),
            Fault::size_mismatch);
  EXPECT_EQ(fault_after([](Scene& s) { s.meshes[0].triangles[3].y = 8; }, "mesh 0: facet 3 names vertex 8 of 8"),
            Fault::index_out_of_range);
  EXPECT_EQ(fault_after([](Scene& s) { s.meshes[3].triangles.clear(); }, "mesh 3: no facet"), Fault::empty_mesh);
  EXPECT_EQ(fault_after([](Scene& s) { s.objects[0].world[0][3] = 1e-9; }, "object 0"), Fault::bad_argument);
  EXPECT_EQ(fault_after([](Scene& s) { s.objects[1].world[3][0] = std::nan(""); }, "object 1"), Fault::bad_argument);
  EXPECT_EQ(fault_after([](Scene& s) { s.meshes[0].texture_coordinates.assign(3, glm::vec2(0)); }, "mesh 0"),
            Fault::size_mismatch);
  EXPECT_EQ(fault_after(
                [](Scene& s) {
                  s.meshes[0].texture_coordinates.assign(8, glm::vec2(std::numeric_limits<float>::infinity()));
                },
                "mesh 0"),
            Fault::non_finite_position);
  EXPECT_EQ(fault_after([](Scene& s) { s.objects[3].settings.three.render_order = std::nan(""); }, "object 3"),
            Fault::bad_argument);
  EXPECT_EQ(fault_after([](Scene& s) { s.objects[3].settings.babylon.rendering_group_id = 64; },
                        "object 3 is in rendering group 64 of 64"),
            Fault::bad_argument);
  EXPECT_EQ(
      fault_after([](Scene& s) { s.objects[3].settings.panda3d.bin = "late"; }, "object 3: no bin is called 'late'"),
      Fault::bad_argument);
  EXPECT_EQ(
      fault_after([](Scene& s) { s.panda3d_bins = {{.name = "opaque", .sort = 1}}; }, "two bins are called 'opaque'"),
      Fault::bad_argument);
}

TEST(Scene, BlendedObjectsAreThoseWhoseMaterialIs) {
  Scene scene = random_scene(8, 2, 3);
  scene.materials.push_back({.name = "stone", .material = {.alpha_mode = AlphaMode::opaque}});
  scene.materials.push_back({.name = "leaf", .material = {.alpha_mode = AlphaMode::mask}});
  for (std::uint32_t i = 0; i < 8; ++i) scene.objects[i].mesh = i % 4;
  scene.meshes[1].material = 1;
  scene.meshes[2].material = 2;
  EXPECT_EQ(blended_objects(scene), (std::vector<std::uint32_t>{0, 3, 4, 7}));
}

}  // namespace
}  // namespace facetsort
