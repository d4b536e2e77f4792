// glTF files that are cut, spoiled or lying: each gets a valid scene, or one line that names the file.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "facetsort/scene/read_scene.h"
#include "mesh/temporary_folder.h"
#include "scene/gltf_text.h"
#include "scene/small_png.h"

namespace facetsort {
namespace {

// A bit of everything.
GltfText rich_file() {
  GltfText text;
  text.add_positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
  text.add_accessor(text.add_view(std::vector<std::uint16_t>{0, 1, 2, 2, 1, 3}), 6, "SCALAR", 5123);
  text.add_accessor(text.add_view(std::vector<float>{0, 0, 1, 0, 0, 1, 1, 1}), 4, "VEC2", 5126);
  text.add_accessor(text.add_view(std::vector<std::uint8_t>(16, 200)), 4, "VEC4", 5121, R"(,"normalized":true)");
  const int indices = text.add_view(std::vector<std::uint8_t>{3});
  const int values = text.add_view(std::vector<float>{1, 1, 1});
  text.add_raw_accessor(
      R"({"bufferView":0,"count":4,"type":"VEC3","componentType":5126,"sparse":{"count":1,"indices":{"bufferView":)" +
      std::to_string(indices) + R"(,"componentType":5121},"values":{"bufferView":)" + std::to_string(values) + "}}}");
  const std::string png = small_png(2, 2, std::vector<std::uint8_t>(16, 99));
  const int picture = text.add_view(std::vector<char>(png.begin(), png.end()));
  text.images = R"({"mimeType":"image/png","bufferView":)" + std::to_string(picture) + "}";
  text.textures = R"({"source":0,"sampler":0})";
  text.samplers = R"({"wrapS":10497,"wrapT":33071})";
  text.materials = R"({"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.5],
      "baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[2,2]}}}}})";
  text.meshes = R"({"name":"m","primitives":[
      {"attributes":{"POSITION":0,"TEXCOORD_0":2,"COLOR_0":3},"indices":1,"material":0},
      {"attributes":{"POSITION":4},"mode":5}]})";
  text.nodes = R"({"mesh":0,"children":[1],"rotation":[0,0,0,1]},{"mesh":0,"scale":[1,2,3]},{"camera":0})";
  text.scene_nodes = "0,2";
  text.cameras = R"({"type":"perspective","perspective":{"yfov":1,"znear":0.1}})";
  return text;
}

class DamagedScene : public testing::TestWithParam<const char*> {
 protected:
  std::string whole() const { return std::string(GetParam()) == ".glb" ? rich_file().glb() : rich_file().gltf(); }
  // True where a scene came out.
  bool expect_scene_or_line(const std::string& bytes) const {
    const std::filesystem::path path = folder_.write(std::string("bad") + GetParam(), bytes);
    const Result<Scene> scene = read_scene(path);
    if (scene.ok()) {
      EXPECT_TRUE(validate(scene.value()).ok());
      return true;
    }
    const std::string& message = scene.status().message;
    EXPECT_NE(scene.status().fault, Fault::none);
    EXPECT_TRUE(message.starts_with(path.string() + ": ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return false;
  }

  TemporaryFolder folder_;
};

TEST_P(DamagedScene, WholeItIsRead) {
  EXPECT_TRUE(expect_scene_or_line(whole()));
}

TEST_P(DamagedScene, CutAnywhere) {
  const std::string bytes = whole();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_FALSE(expect_scene_or_line(bytes.substr(0, size))) << size;
  }
}

TEST_P(DamagedScene, FlippedBits) {
  const std::string bytes = whole();
  std::mt19937 random(7);
  std::size_t read = 0;
  for (int trial = 0; trial < 6000; ++trial) {
    std::string spoiled = bytes;
    for (auto flips = 1 + random() % 3; flips > 0; --flips) {
      spoiled[random() % spoiled.size()] ^= static_cast<char>(1 << random() % 8);
    }
    read += expect_scene_or_line(spoiled);
  }
  EXPECT_GT(read, 100u);  // names, colours and numbers may be anything
}

// Every number of the JSON in turn becomes one that lies.
TEST_P(DamagedScene, LyingNumbers) {
  const std::string bytes = rich_file().gltf();
  const std::size_t end = bytes.find("\"buffers\"");
  for (std::size_t at = 0; at < end; ++at) {
    const bool begins = std::isdigit(static_cast<unsigned char>(bytes[at])) != 0 &&
                        (bytes[at - 1] == ':' || bytes[at - 1] == ',' || bytes[at - 1] == '[');
    if (!begins) continue;
    std::size_t last = at;
    while (std::isdigit(static_cast<unsigned char>(bytes[last])) != 0) ++last;
    for (const char* lie : {"-1", "7", "4294967295", "2147483648", "18446744073709551615", "1e300", "1e999", "0",
                            "null", "[]", "\"x\""}) {
      expect_scene_or_line(bytes.substr(0, at) + lie + bytes.substr(last));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, DamagedScene, testing::Values(".gltf", ".glb"),
                         [](const auto& format) { return std::string(format.param).substr(1); });

TEST(DamagedScene, BuffersAreInTheFolderOfTheFile) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path() / "inner" / "deep");
  const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
  const std::string bytes(reinterpret_cast<const char*>(corners.data()), sizeof(float) * corners.size());
  for (const char* place : {"data.bin", "inner/data.bin", "inner/deep/data.bin"}) folder.write(place, bytes);
  const auto read = [&](const std::string& uri) {
    return read_scene(folder.write(
        "inner/a.gltf",
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":")" + uri + "\"}]}"));
  };
  for (const char* uri : {"data.bin", "deep/data.bin", "./data.bin", "deep/../data.bin"}) {
    EXPECT_TRUE(read(uri).ok()) << uri << ": " << read(uri).status().message;
  }
  for (const std::string& uri : {std::string("../data.bin"), std::string("deep/../../data.bin"),
                                 (folder.path() / "data.bin").string(), std::string("../inner/../data.bin")}) {
    const Result<Scene> scene = read(uri);
    ASSERT_FALSE(scene.ok()) << uri;
    EXPECT_EQ(scene.status().fault, Fault::cannot_read) << scene.status().message;
  }
}

TEST(DamagedScene, ManyBuffersOfOneChunk) {
  const TemporaryFolder folder;
  GltfText text = one_triangle();
  text.buffer.resize(1 << 20);
  std::string json = text.json("");
  std::string buffers = "\"buffers\":[{\"byteLength\":1048576}";
  for (int i = 0; i < 20000; ++i) buffers += ",{\"byteLength\":1048576}";
  json.replace(json.find("\"buffers\":["), std::string("\"buffers\":[{\"byteLength\":1048576}").size(), buffers);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string file = "glTF" + GltfText::word(2) + GltfText::word(28 + json.size() + text.buffer.size()) +
                           GltfText::word(json.size()) + "JSON" + json + GltfText::word(text.buffer.size()) +
                           std::string("BIN\0", 4) + text.buffer;
  const Result<Scene> scene = read_scene(folder.write("many.glb", file));
  ASSERT_FALSE(scene.ok());
  EXPECT_NE(scene.status().message.find("20001 buffers for one binary chunk"), std::string::npos)
      << scene.status().message;
}

}  // namespace
}  // namespace facetsort
