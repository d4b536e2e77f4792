#include "facetsort/scene/read_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "facetsort/mesh/write.h"
#include "mesh/temporary_folder.h"
#include "scene/gltf_text.h"
#include "scene/random_scene.h"
#include "scene/small_png.h"

namespace facetsort {
namespace {

class ReadScene : public testing::Test {
 protected:
  Scene read(const std::string& bytes, const char* name = "scene.gltf") {
    Result<Scene> scene = read_scene(folder_.write(name, bytes));
    if (!scene.ok()) {
      ADD_FAILURE() << scene.status().message;
      return {};
    }
    EXPECT_TRUE(validate(scene.value()).ok());
    return std::move(scene).value();
  }
  void expect_fault(const std::string& bytes, Fault fault, const std::string& words) {
    const std::filesystem::path path = folder_.write("bad.gltf", bytes);
    const Result<Scene> scene = read_scene(path);
    ASSERT_FALSE(scene.ok()) << words;
    EXPECT_EQ(scene.status().fault, fault) << scene.status().message;
    EXPECT_TRUE(scene.status().message.starts_with(path.string() + ": ")) << scene.status().message;
    EXPECT_NE(scene.status().message.find(words), std::string::npos) << scene.status().message;
    EXPECT_EQ(scene.status().message.find('\n'), std::string::npos);
  }

  TemporaryFolder folder_;
};

void expect_near(const glm::dmat4& found, const glm::dmat4& expected) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) EXPECT_NEAR(found[column][row], expected[column][row], 1e-12);
  }
}

TEST_F(ReadScene, OneTriangleAsTextAndBinary) {
  const GltfText text = one_triangle();
  for (const bool binary : {false, true}) {
    const Scene scene = binary ? read(text.glb(), "scene.GLB") : read(text.gltf());
    ASSERT_EQ(scene.objects.size(), 1u);
    EXPECT_EQ(scene.objects[0].name, "node");
    EXPECT_EQ(scene.objects[0].world, glm::dmat4(1));
    ASSERT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(scene.meshes[0].name, "triangle");
    EXPECT_EQ(scene.meshes[0].positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(scene.meshes[0].triangles, (std::vector<glm::uvec3>{{0, 1, 2}}));
    // What glTF says of primitives without a material.
    const Material& material = scene.material_of(0).material;
    EXPECT_EQ(material.alpha_mode, AlphaMode::opaque);
    EXPECT_FALSE(material.double_sided);
    EXPECT_EQ(material.base_colour, glm::vec4(1));
    EXPECT_TRUE(scene.notes.empty());
  }
}

TEST_F(ReadScene, PlacesNodesDownTheTree) {
  GltfText text = one_triangle();
  // A quarter turn around z, then twice as large, then moved; the child is moved in its parent's space.
  text.nodes =
      R"({"name":"parent","mesh":0,"translation":[10,0,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476],
                   "scale":[2,2,2],"children":[1]},
                  {"name":"child","mesh":0,"matrix":[1,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1]})";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.meshes.size(), 1u);  // shared
  const glm::dmat4 parent(glm::dvec4(0, 2, 0, 0), glm::dvec4(-2, 0, 0, 0), glm::dvec4(0, 0, 2, 0),
                          glm::dvec4(10, 0, 0, 1));
  expect_near(scene.objects[0].world, parent);
  glm::dmat4 child = parent;
  child[3] = glm::dvec4(10 - 4, 2, 6, 1);
  expect_near(scene.objects[1].world, child);
}

TEST_F(ReadScene, ShowsTheDefaultScenesNodesOnly) {
  GltfText text = one_triangle();
  text.nodes = R"({"name":"shown","mesh":0},{"name":"not shown","mesh":0})";
  ASSERT_EQ(read(text.gltf()).objects.size(), 1u);
  EXPECT_EQ(read(text.gltf()).objects[0].name, "shown");
}

TEST_F(ReadScene, IndicesOfEveryType) {
  const std::vector<std::uint8_t> bytes{2, 1, 0};
  const std::vector<std::uint16_t> shorts{2, 1, 0};
  const std::vector<std::uint32_t> words{2, 1, 0};
  for (const int component : {5121, 5123, 5125}) {
    GltfText text = one_triangle();
    const int view = component == 5121   ? text.add_view(bytes)
                     : component == 5123 ? text.add_view(shorts)
                                         : text.add_view(words);
    text.add_accessor(view, 3, "SCALAR", component);
    text.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1}]})";
    EXPECT_EQ(read(text.gltf()).meshes[0].triangles, (std::vector<glm::uvec3>{{2, 1, 0}})) << component;
  }
}

TEST_F(ReadScene, StripsAndFans) {
  GltfText text;
  text.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0});
  text.meshes =
      R"({"name":"m","primitives":[{"attributes":{"POSITION":0},"mode":5},{"attributes":{"POSITION":0},"mode":6},
                    {"attributes":{"POSITION":0},"mode":0}]})";
  text.nodes = R"({"mesh":0})";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.meshes.size(), 2u);
  EXPECT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.meshes[0].name, "m.0");
  // As the specification lists them: every other triangle of a strip is turned.
  EXPECT_EQ(scene.meshes[0].triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
  EXPECT_EQ(scene.meshes[1].triangles, (std::vector<glm::uvec3>{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(scene.notes[0].starts_with("1 primitives without facets")) << scene.notes[0];
}

TEST_F(ReadScene, StridedPositionsAndNormalisedColours) {
  GltfText text;
  const std::vector<float> interleaved{0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0, 9};
  text.add_accessor(text.add_view(interleaved, 16), 3, "VEC3", 5126);
  const std::vector<std::uint8_t> bytes{255, 0, 51, 102, 0, 255, 0, 255, 0, 0, 0, 0};
  text.add_accessor(text.add_view(bytes), 3, "VEC4", 5121, R"(,"normalized":true)");
  const std::vector<std::uint16_t> shorts{65535, 0, 13107, 0, 65535, 0, 0, 0, 0};
  text.add_accessor(text.add_view(shorts), 3, "VEC3", 5123, R"(,"normalized":true)");
  text.meshes =
      R"({"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1}},{"attributes":{"POSITION":0,"COLOR_0":2}}]})";
  text.nodes = R"({"mesh":0})";
  const Scene scene = read(text.gltf());
  EXPECT_EQ(scene.meshes[0].positions[2], glm::vec3(0, 1, 0));
  EXPECT_EQ(scene.meshes[0].vertex_colours[0], glm::vec4(1, 0, 0.2f, 0.4f));
  EXPECT_EQ(scene.meshes[1].vertex_colours[0], glm::vec4(1, 0, 0.2f, 1));
  EXPECT_EQ(scene.meshes[1].vertex_colours[1], glm::vec4(0, 1, 0, 1));
}

TEST_F(ReadScene, SparseAccessors) {
  GltfText text;
  const int dense = text.add_view(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
  const int indices = text.add_view(std::vector<std::uint16_t>{2});
  const int values = text.add_view(std::vector<float>{0, 5, 6});
  const std::string sparse = R"("sparse":{"count":1,"indices":{"bufferView":)" + std::to_string(indices) +
                             R"(,"componentType":5123},"values":{"bufferView":)" + std::to_string(values) + "}}";
  text.add_raw_accessor(R"({"bufferView":)" + std::to_string(dense) +
                        R"(,"count":3,"type":"VEC3","componentType":5126,)" + sparse + "}");
  text.add_raw_accessor(R"({"count":3,"type":"VEC3","componentType":5126,)" + sparse + "}");
  text.meshes = R"({"primitives":[{"attributes":{"POSITION":0}},{"attributes":{"POSITION":1}}]})";
  text.nodes = R"({"mesh":0})";
  const Scene scene = read(text.gltf());
  EXPECT_EQ(scene.meshes[0].positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 5, 6}}));
  EXPECT_EQ(scene.meshes[1].positions, (std::vector<glm::vec3>{{0, 0, 0}, {0, 0, 0}, {0, 5, 6}}));
}

// A thousand primitives often share one list of vertices.
TEST_F(ReadScene, TakesOnlyTheVerticesUsedOfALongList) {
  GltfText text;
  std::vector<float> many;
  for (int i = 0; i < 50; ++i) many.insert(many.end(), {static_cast<float>(i), static_cast<float>(i * i), 0});
  text.add_positions(many);
  text.add_accessor(text.add_view(std::vector<std::uint8_t>{40, 7, 20}), 3, "SCALAR", 5121);
  text.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1}]})";
  text.nodes = R"({"mesh":0})";
  const SceneMesh mesh = read(text.gltf()).meshes[0];
  EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{{7, 49, 0}, {20, 400, 0}, {40, 1600, 0}}));
  EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{2, 0, 1}}));
}

TEST_F(ReadScene, Materials) {
  GltfText text = one_triangle();
  text.materials = R"({"name":"solid"},
    {"name":"leaf","alphaMode":"MASK","alphaCutoff":0.25,"doubleSided":true},
    {"name":"glass","alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[0.25,0.5,0.75,0.125]}},
    {"name":"lens","extensions":{"KHR_materials_transmission":{"transmissionFactor":0.5}}},
    {"name":"dull","extensions":{"KHR_materials_transmission":{"transmissionFactor":0}}})";
  text.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"material":2}]})";
  text.more = R"(,"extensionsUsed":["KHR_materials_transmission"],"extensionsRequired":["KHR_materials_transmission"])";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.materials.size(), 5u);
  EXPECT_EQ(scene.materials[0].name, "solid");
  EXPECT_EQ(scene.materials[0].material.alpha_mode, AlphaMode::opaque);
  EXPECT_FALSE(scene.materials[0].material.double_sided);
  EXPECT_EQ(scene.materials[1].material.alpha_mode, AlphaMode::mask);
  EXPECT_EQ(scene.materials[1].material.alpha_cutoff, 0.25f);
  EXPECT_TRUE(scene.materials[1].material.double_sided);
  EXPECT_EQ(scene.material_of(0).name, "glass");
  EXPECT_EQ(scene.material_of(0).material.base_colour, glm::vec4(0.25f, 0.5f, 0.75f, 0.125f));
  EXPECT_EQ(blended_objects(scene), (std::vector<std::uint32_t>{0}));
  EXPECT_FALSE(scene.materials[2].transmissive);
  EXPECT_TRUE(scene.materials[3].transmissive);
  EXPECT_FALSE(scene.materials[4].transmissive);
}

// A triangle with coordinates in sets 0 and 1 and a picture of two texels.
GltfText textured(const std::string& info) {
  GltfText text = one_triangle();
  text.add_accessor(text.add_view(std::vector<float>{0, 0, 1, 0, 0, 1}), 3, "VEC2", 5126);
  text.add_accessor(text.add_view(std::vector<std::uint16_t>{65535, 0, 0, 65535, 13107, 13107}), 3, "VEC2", 5123,
                    R"(,"normalized":true)");
  text.meshes = R"({"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2},"material":0}]})";
  text.materials = R"({"pbrMetallicRoughness":{"baseColorTexture":{"index":0)" + info + "}}}";
  text.textures = R"({"source":0,"sampler":0})";
  text.samplers = R"({"wrapS":33071,"wrapT":33648})";
  text.images = R"({"uri":"data:image/png;base64,)" + base64(small_png(2, 1, {255, 0, 188, 255, 0, 10, 0, 51})) + "\"}";
  return text;
}

TEST_F(ReadScene, TexturesFromSrgbToLinear) {
  const Scene scene = read(textured("").gltf());
  ASSERT_EQ(scene.textures.size(), 1u);
  const Texture& texture = scene.textures[0];
  EXPECT_EQ(texture.width, 2);
  EXPECT_EQ(texture.height, 1);
  EXPECT_EQ(texture.wrap_u, Wrap::clamp_to_edge);
  EXPECT_EQ(texture.wrap_v, Wrap::mirrored_repeat);
  // By hand: ((188/255 + 0.055) / 1.055)^2.4, and 10/255 / 12.92 below the curve's straight part; alpha is linear.
  EXPECT_EQ(texture.texels[0].r, 1.0f);
  EXPECT_EQ(texture.texels[0].g, 0.0f);
  EXPECT_NEAR(texture.texels[0].b, 0.50288647f, 1e-6f);
  EXPECT_NEAR(texture.texels[1].g, 0.00303527f, 1e-8f);
  EXPECT_EQ(texture.texels[1].a, 0.2f);
  EXPECT_EQ(scene.materials[0].material.texture, 0u);
  EXPECT_EQ(scene.meshes[0].texture_coordinates, (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));
}

TEST_F(ReadScene, TextureCoordinatesOfTheSetAskedFor) {
  const Scene scene = read(textured(R"(,"texCoord":1)").gltf());
  EXPECT_EQ(scene.meshes[0].texture_coordinates, (std::vector<glm::vec2>{{1, 0}, {0, 1}, {0.2f, 0.2f}}));
}

// Scaled, then turned by a quarter (u' = v, v' = -u), then moved.
TEST_F(ReadScene, TextureTransform) {
  const Scene scene = read(textured(R"(,"extensions":{"KHR_texture_transform":{"offset":[0.5,0.25],
      "rotation":1.5707963267948966,"scale":[2,3]}})")
                               .gltf());
  const std::vector<glm::vec2> expected{{0.5f, 0.25f}, {0.5f, -1.75f}, {3.5f, 0.25f}};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(scene.meshes[0].texture_coordinates[i].x, expected[i].x, 1e-6f);
    EXPECT_NEAR(scene.meshes[0].texture_coordinates[i].y, expected[i].y, 1e-6f);
  }
  EXPECT_EQ(read(textured(R"(,"extensions":{"KHR_texture_transform":{"texCoord":1}})").gltf())
                .meshes[0]
                .texture_coordinates[0],
            glm::vec2(1, 0));
}

TEST_F(ReadScene, PicturesInBufferViewsAndBesideTheFile) {
  const std::string png = small_png(2, 1, {255, 0, 188, 255, 0, 10, 0, 51});
  GltfText inside = textured("");
  const int view = inside.add_view(std::vector<char>(png.begin(), png.end()));
  inside.images = R"({"mimeType":"image/png","bufferView":)" + std::to_string(view) + "}";
  EXPECT_EQ(read(inside.glb(), "inside.glb").textures[0].width, 2);
  folder_.write("the picture.png", png);
  GltfText beside = textured("");
  beside.images = R"({"uri":"the%20picture.png"})";
  EXPECT_EQ(read(beside.gltf()).textures[0].texels[0].r, 1.0f);
  beside.images = R"({"uri":"gone.png"})";
  expect_fault(beside.gltf(), Fault::cannot_read, "texture 0, picture 0: 'gone.png' can't be read");
  beside.images = R"({"uri":"data:image/png;base64,)" + base64("GIF89a...") + "\"}";
  expect_fault(beside.gltf(), Fault::unsupported_format, "neither PNG nor JPEG");
}

TEST_F(ReadScene, RefusesPicturesTooLargeToBelieve) {
  std::string png = small_png(2, 1, {255, 0, 188, 255, 0, 10, 0, 51});
  png.replace(16, 8, std::string("\0\1\0\0\0\1\0\0", 8));  // 65536 x 65536
  GltfText text = textured("");
  text.images = R"({"uri":"data:image/png;base64,)" + base64(png) + "\"}";
  expect_fault(text.gltf(), Fault::unsupported_format, "65536 x 65536 texels");
}

TEST_F(ReadScene, BuffersBesideTheFile) {
  const GltfText text = one_triangle();
  folder_.write("numbers.bin", text.buffer);
  EXPECT_EQ(read(text.json("numbers.bin")).meshes[0].positions[1], glm::vec3(1, 0, 0));
  expect_fault(text.json("gone.bin"), Fault::cannot_read, "gone.bin");
}

TEST_F(ReadScene, NotesSkinsAndMorphTargets) {
  GltfText text = one_triangle();
  text.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"targets":[{"POSITION":0}]}]})";
  text.nodes = R"({"mesh":0,"skin":0})";
  text.more = R"(,"skins":[{"joints":[0]}])";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.notes.size(), 2u);
  EXPECT_NE(scene.notes[0].find("skinned"), std::string::npos);
  EXPECT_NE(scene.notes[1].find("morph"), std::string::npos);
}

TEST_F(ReadScene, Cameras) {
  GltfText text = one_triangle();
  text.scene_nodes = "0,1,2";
  text.nodes += R"(,{"name":"eye","camera":0,"translation":[1,2,3]},{"camera":1,"rotation":[0,1,0,0]})";
  text.cameras = R"({"type":"perspective","perspective":{"yfov":1.5707963267948966,"znear":0.5}},
                    {"name":"map","type":"orthographic","orthographic":{"xmag":2,"ymag":3,"znear":0.25,"zfar":9}})";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].name, "eye");
  EXPECT_EQ(scene.cameras[0].eye, glm::dvec3(1, 2, 3));
  EXPECT_EQ(scene.cameras[0].at, glm::dvec3(1, 2, 2));
  EXPECT_NEAR(scene.cameras[0].vertical_fov_degrees, 90, 1e-9);
  EXPECT_EQ(scene.cameras[0].near_distance, 0.5);
  EXPECT_FALSE(scene.cameras[1].perspective);
  EXPECT_EQ(scene.cameras[1].height_in_units, 6);
  EXPECT_NEAR(scene.cameras[1].at.z, 1, 1e-12);  // turned around
}

TEST_F(ReadScene, NamesWhatItRefuses) {
  const auto with = [](void (*change)(GltfText&)) {
    GltfText text = one_triangle();
    change(text);
    return text.gltf();
  };
  expect_fault(with([](GltfText& t) { t.more = R"(,"extensionsRequired":["KHR_draco_mesh_compression"])"; }),
               Fault::unsupported_format, "KHR_draco_mesh_compression");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":3})"; }), Fault::index_out_of_range,
               "node 0 names mesh 3 of 1");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":0,"children":[1]},{"children":[0]})"; }), Fault::malformed,
               "node 0 is reached twice");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":0,"children":[0]})"; }), Fault::malformed,
               "node 0 is reached twice");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":0,"children":[7]})"; }), Fault::index_out_of_range,
               "names node 7 of 1");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":0,"translation":[1,2]})"; }), Fault::malformed,
               "node 0: a translation of 2 numbers");
  expect_fault(with([](GltfText& t) { t.nodes = R"({"mesh":0,"matrix":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]})"; }),
               Fault::malformed, "node 0: a place");
  expect_fault(with([](GltfText& t) { t.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"material":2}]})"; }),
               Fault::index_out_of_range, "mesh 0, primitive 0 names material 2 of 0");
  expect_fault(with([](GltfText& t) { t.materials = R"({"alphaMode":"GLASS"})"; }), Fault::malformed, "'GLASS'");
  expect_fault(with([](GltfText& t) { t.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"mode":1}]})"; }),
               Fault::empty_mesh, "no node shows a facet");
  expect_fault(with([](GltfText& t) {
                 t.add_accessor(t.add_view(std::vector<std::uint8_t>{0, 1, 3}), 3, "SCALAR", 5121);
                 t.meshes = R"({"primitives":[{"attributes":{"POSITION":0},"indices":1}]})";
               }),
               Fault::index_out_of_range, "mesh 0, primitive 0: index 2 names vertex 3 of 3");
  expect_fault(with([](GltfText& t) {
                 t.add_accessor(0, 1000000000, "VEC3", 5126);
                 t.meshes = R"({"primitives":[{"attributes":{"POSITION":1}}]})";
               }),
               Fault::truncated, "POSITION, accessor 1: 1000000000 elements end after buffer view 0");
  expect_fault(with([](GltfText& t) {
                 t.add_accessor(0, 3, "VEC3", 5126, R"(,"byteOffset":18446744073709551612)");
                 t.meshes = R"({"primitives":[{"attributes":{"POSITION":1}}]})";
               }),
               Fault::truncated, "accessor 1");
  expect_fault(with([](GltfText& t) {
                 t.add_raw_accessor(R"({"count":4000000000,"type":"VEC3","componentType":5126})");
                 t.meshes = R"({"primitives":[{"attributes":{"POSITION":1}}]})";
               }),
               Fault::malformed, "4000000000 elements without a buffer view");
  expect_fault(with([](GltfText& t) {
                 t.add_positions({0, 0, 0, std::nanf(""), 0, 0, 0, 1, 0});
                 t.meshes = R"({"primitives":[{"attributes":{"POSITION":1}}]})";
               }),
               Fault::non_finite_position, "mesh 0: facet 0 uses vertex 1");
  expect_fault(with([](GltfText& t) { t.more = ",\"extras\":" + std::string(100000, '[') + std::string(100000, ']'); }),
               Fault::malformed, "nested");
  const auto with_settings = [](const std::string& settings) {
    GltfText text = one_triangle();
    text.nodes = R"({"mesh":0,"extras":{"others":3,"facetsort":)" + settings + "}}";
    return text.gltf();
  };
  expect_fault(with_settings("3"), Fault::malformed, "node 0: extras.facetsort is no object");
  expect_fault(with_settings(R"({"unity":{}})"), Fault::malformed, "node 0: extras: no engine is 'unity'");
  expect_fault(with_settings(R"({"three":null})"), Fault::malformed, "node 0: extras: three is no object");
  expect_fault(with_settings(R"({"three":{"renderOder":1}})"), Fault::malformed,
               "node 0 extras, three: no setting is 'renderOder'");
  expect_fault(with_settings(R"({"three":{"depthWrite":1}})"), Fault::malformed,
               "three.depthWrite is of the wrong type");
  expect_fault(with_settings(R"({"babylon":{"renderingGroupId":1.5}})"), Fault::malformed, "babylon.renderingGroupId");
  expect_fault(with_settings(R"({"three":{"renderOder":null}})"), Fault::malformed, "no setting is 'renderOder'");
  expect_fault(with_settings(R"({"babylon":{"renderingGroupId":4294967296}})"), Fault::malformed,
               "babylon.renderingGroupId");
  expect_fault(with_settings(R"({"panda3d":{"drawOrder":2147483648}})"), Fault::malformed, "panda3d.drawOrder");
  expect_fault(with_settings(R"({"babylon":{"renderingGroupId":-1}})"), Fault::malformed, "babylon.renderingGroupId");
  expect_fault(with_settings(R"({"babylon":{"renderingGroupId":64}})"), Fault::bad_argument,
               "rendering group 64 of 64");
  expect_fault(with_settings(R"({"panda3d":{"bin":"late"}})"), Fault::bad_argument, "no bin is called 'late'");
  const auto with_bins = [](const std::string& bins) {
    GltfText text = one_triangle();
    text.scene_nodes += R"(],"extras":{"facetsort":{"panda3d":{"bins":)" + bins + R"(}}},"x":[)";
    return text.gltf();
  };
  expect_fault(with_bins(R"({"name":"late"})"), Fault::malformed, "scene 0: extras: panda3d.bins is no list");
  expect_fault(with_bins(R"([{"name":"late","sort":60}])"), Fault::malformed,
               "scene 0 extras, bin 0: a bin without a type");
  expect_fault(with_bins(R"([{"name":"late","sort":60,"type":"random"}])"), Fault::malformed,
               "no type of bins is 'random'");
  expect_fault(with_bins(R"([{"name":"fixed","sort":60,"type":"fixed"}])"), Fault::bad_argument,
               "two bins are called 'fixed'");
  expect_fault("{\"asset\":", Fault::malformed, "");
  expect_fault("", Fault::malformed, "");
}

TEST_F(ReadScene, SettingsOfEngines) {
  GltfText text = one_triangle();
  text.nodes = R"({"children":[1],"extras":{"facetsort":{"three":{"groupOrder":3}}}},)"
               R"({"mesh":0,"extras":{"facetsort":{"three":{"renderOrder":3000000000}}}})";
  const Scene scene = read(text.gltf());
  ASSERT_EQ(scene.objects.size(), 1u);
  EXPECT_EQ(scene.objects[0].settings.three.render_order, 3e9);
  EXPECT_EQ(scene.objects[0].settings.three.group_order, 0);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_NE(scene.notes[0].find("do not inherit"), std::string::npos);
}

TEST_F(ReadScene, FilesOfAFolderShareBinsOrNameTheOneThatDiffers) {
  const auto with_bin = [](const char* sort) {
    GltfText text = one_triangle();
    text.scene_nodes += R"(],"extras":{"facetsort":{"panda3d":{"bins":[{"name":"late","type":"fixed","sort":)" +
                        std::string(sort) + R"(}]}}},"x":[)";
    return text.gltf();
  };
  const std::filesystem::path first = folder_.write("a.gltf", with_bin("60")),
                              same = folder_.write("b.gltf", with_bin("60")),
                              other = folder_.write("c.gltf", with_bin("61"));
  const Result<Scene> shared = read_scene(std::vector{first, same});
  ASSERT_TRUE(shared.ok()) << shared.status().message;
  EXPECT_EQ(shared.value().panda3d_bins.size(), 1u);
  const Result<Scene> differing = read_scene(std::vector{first, other});
  ASSERT_FALSE(differing.ok());
  EXPECT_TRUE(differing.status().message.starts_with(other.string() + ": the bin 'late'"));
}

TEST_F(ReadScene, AFolderIsAScene) {
  Mesh box = shapes::box();
  Mesh coloured = shapes::box();
  coloured.facet_colours.assign(12, glm::vec4(1, 0, 0, 0.25f));
  ASSERT_TRUE(write_ply(folder_.path() / "b.ply", box.view()).ok());
  ASSERT_TRUE(write_ply(folder_.path() / "c.ply", coloured.view()).ok());
  GltfText text = textured("");
  folder_.write("a.gltf", text.gltf());
  folder_.write("d.gltf", text.gltf());
  folder_.write("notes.txt", "not a mesh");
  const Result<Scene> result = read_scene(folder_.path());
  ASSERT_TRUE(result.ok()) << result.status().message;
  const Scene& scene = result.value();
  EXPECT_TRUE(validate(scene).ok());
  ASSERT_EQ(scene.objects.size(), 4u);
  EXPECT_EQ(scene.objects[1].name, "b.ply");
  EXPECT_EQ(scene.material_of(1).material.base_colour, glm::vec4(1, 1, 1, 0.5f));
  EXPECT_EQ(scene.material_of(1).material.alpha_mode, AlphaMode::blend);
  EXPECT_EQ(scene.material_of(2).material.base_colour, glm::vec4(1));
  EXPECT_EQ(scene.mesh_of(2).facet_colours.size(), 12u);
  // Numbers of the second glTF file go on from those of the first.
  EXPECT_EQ(scene.textures.size(), 2u);
  EXPECT_EQ(scene.material_of(3).material.texture, 1u);
}

TEST_F(ReadScene, NamesTheFileOfAFolderThatItRefuses) {
  folder_.write("a.glb", one_triangle().glb());
  const std::filesystem::path bad = folder_.write("b.off", "OFF\n1 1 0\n0 0 0\n3 0 0 7\n");
  const Result<Scene> scene = read_scene(folder_.path());
  ASSERT_FALSE(scene.ok());
  EXPECT_TRUE(scene.status().message.starts_with(bad.string())) << scene.status().message;
  const TemporaryFolder empty;
  EXPECT_EQ(read_scene(empty.path()).status().fault, Fault::empty_mesh);
  EXPECT_EQ(read_scene(empty.path() / "gone.glb").status().fault, Fault::cannot_read);
}

}  // namespace
}  // namespace facetsort
