#include "facetsort/presort/write_gltf.h"

#include <gtest/gtest.h>
#include <tiny_gltf.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "facetsort/presort/index_buffers.h"
#include "mesh/temporary_folder.h"
#include "shapes.h"

namespace facetsort {
namespace {

// For any mesh: each order begins one facet later.
IndexBuffers turned_orders(const MeshView& mesh, std::size_t count) {
  IndexBuffers buffers;
  buffers.buffer_count = count;
  const std::size_t facets = mesh.facet_count();
  for (std::size_t i = 0; i < count * facets; ++i) {
    buffers.facets.push_back(static_cast<std::uint32_t>((i + i / facets) % facets));
  }
  buffers.directions = {{1, 0, 0}, {0, 0.6f, -0.8f}, {0, 1, 0}};
  buffers.buffer_of_direction = {0, static_cast<std::uint32_t>(count - 1), 0};
  buffers.mean_inverted_rate = 0.1;
  buffers.worst_inverted_rate = 0.25;
  return buffers;
}

tinygltf::Model read_back(const std::filesystem::path& path) {
  tinygltf::Model model;
  std::string errors, warnings;
  tinygltf::TinyGLTF reader;
  const bool read = path.extension() == ".gltf" ? reader.LoadASCIIFromFile(&model, &errors, &warnings, path.string())
                                                : reader.LoadBinaryFromFile(&model, &errors, &warnings, path.string());
  EXPECT_TRUE(read);
  EXPECT_EQ(errors + warnings, "");
  return model;
}

template <typename T>
std::vector<T> values_of(const tinygltf::Model& model, int accessor_id) {
  const tinygltf::Accessor& accessor = model.accessors.at(static_cast<std::size_t>(accessor_id));
  const tinygltf::BufferView& view = model.bufferViews.at(static_cast<std::size_t>(accessor.bufferView));
  std::vector<T> values(view.byteLength / sizeof(T));
  std::memcpy(values.data(), model.buffers.at(0).data.data() + view.byteOffset, view.byteLength);
  return values;
}

// The corners that the file draws are those of the buffers' facets, with their colours.
void expect_drawn_alike(const tinygltf::Model& model, const MeshView& mesh, const IndexBuffers& buffers) {
  ASSERT_EQ(model.meshes.size(), 1u);
  ASSERT_EQ(model.meshes[0].primitives.size(), buffers.buffer_count);
  const bool has_colours = !mesh.facet_colours.empty() || !mesh.vertex_colours.empty();
  std::size_t first = 0;
  for (const tinygltf::Primitive& primitive : model.meshes[0].primitives) {
    EXPECT_EQ(primitive.mode, TINYGLTF_MODE_TRIANGLES);
    const auto positions = values_of<glm::vec3>(model, primitive.attributes.at("POSITION"));
    const auto indices = values_of<std::uint32_t>(model, primitive.indices);
    ASSERT_EQ(primitive.attributes.contains("COLOR_0"), has_colours);
    std::vector<glm::vec4> colours;
    if (has_colours) colours = values_of<glm::vec4>(model, primitive.attributes.at("COLOR_0"));
    ASSERT_EQ(indices.size(), 3 * mesh.facet_count());
    for (std::size_t k = 0; k < indices.size(); ++k) {
      const std::uint32_t facet = buffers.facets[first + k / 3];
      const int corner = static_cast<int>(k % 3);
      ASSERT_LT(indices[k], positions.size());
      EXPECT_EQ(positions[indices[k]], mesh.corner(facet, corner));
      if (!mesh.facet_colours.empty()) {
        EXPECT_EQ(colours.at(indices[k]), mesh.facet_colours[facet]);
      } else if (has_colours) {
        EXPECT_EQ(colours.at(indices[k]), mesh.vertex_colours[mesh.triangles[facet][corner]]);
      }
    }
    first += mesh.facet_count();
  }
}

void expect_table(const tinygltf::Model& model, const IndexBuffers& buffers) {
  ASSERT_EQ(model.nodes.size(), 1u);
  const tinygltf::Value& table = model.nodes[0].extras;
  ASSERT_EQ(table.Get("directions").ArrayLen(), 3 * buffers.directions.size());
  ASSERT_EQ(table.Get("buffers").ArrayLen(), buffers.directions.size());
  for (int i = 0; i < static_cast<int>(buffers.directions.size()); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const double number = table.Get("directions").Get(3 * i + axis).GetNumberAsDouble();
      EXPECT_EQ(static_cast<float>(number), buffers.directions[static_cast<std::size_t>(i)][axis]);
    }
    const std::uint32_t buffer = buffers.buffer_of_direction[static_cast<std::size_t>(i)];
    EXPECT_EQ(table.Get("buffers").Get(i).GetNumberAsInt(), static_cast<int>(buffer));
  }
  ASSERT_EQ(table.Get("centre").ArrayLen(), 3u);
  for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(table.Get("centre").Get(axis).GetNumberAsDouble(), 0);
  EXPECT_EQ(table.Get("needsCulling").Get<bool>(), buffers.needs_culling);
  EXPECT_EQ(table.Get("meanInvertedRate").GetNumberAsDouble(), buffers.mean_inverted_rate);
  EXPECT_EQ(table.Get("worstInvertedRate").GetNumberAsDouble(), buffers.worst_inverted_rate);
}

TEST(WriteGltf, KeepsBuffersAndTable) {
  const TemporaryFolder folder;
  const Mesh mesh = shapes::box();
  IndexBuffers buffers = turned_orders(mesh.view(), 4);
  for (const char* const name : {"a.glb", "a.gltf"}) {
    for (const bool needs_culling : {false, true}) {
      SCOPED_TRACE(testing::Message() << name << ", needs culling: " << needs_culling);
      buffers.needs_culling = needs_culling;
      ASSERT_EQ(write_gltf(folder.path() / name, mesh.view(), buffers).message, "");
      const tinygltf::Model model = read_back(folder.path() / name);
      expect_drawn_alike(model, mesh.view(), buffers);
      expect_table(model, buffers);
      ASSERT_EQ(model.materials.size(), 1u);
      EXPECT_EQ(model.materials[0].alphaMode, "BLEND");
      EXPECT_EQ(model.materials[0].doubleSided, !needs_culling);
    }
  }
}

TEST(WriteGltf, KeepsColours) {
  const TemporaryFolder folder;
  Mesh mesh = shapes::box();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    mesh.facet_colours.emplace_back(0.0625f * static_cast<float>(i), 0.5f, 0.25f, 0.75f);
  }
  const IndexBuffers buffers = turned_orders(mesh.view(), 2);
  ASSERT_EQ(write_gltf(folder.path() / "facets.glb", mesh.view(), buffers).message, "");
  expect_drawn_alike(read_back(folder.path() / "facets.glb"), mesh.view(), buffers);

  mesh.facet_colours.clear();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.vertex_colours.emplace_back(0.125f * static_cast<float>(i), 1, 0, 0.5f);
  }
  ASSERT_EQ(write_gltf(folder.path() / "vertices.glb", mesh.view(), buffers).message, "");
  expect_drawn_alike(read_back(folder.path() / "vertices.glb"), mesh.view(), buffers);
}

TEST(WriteGltf, StatesTheBoundsOfPositions) {
  const TemporaryFolder folder;
  const Mesh mesh = shapes::box();
  ASSERT_EQ(write_gltf(folder.path() / "a.glb", mesh.view(), turned_orders(mesh.view(), 1)).message, "");
  const tinygltf::Model model = read_back(folder.path() / "a.glb");
  const int positions = model.meshes.at(0).primitives.at(0).attributes.at("POSITION");
  EXPECT_EQ(model.accessors.at(static_cast<std::size_t>(positions)).minValues, (std::vector<double>{-1, -1, -1}));
  EXPECT_EQ(model.accessors.at(static_cast<std::size_t>(positions)).maxValues, (std::vector<double>{1, 1, 1}));
}

TEST(WriteGltf, NamesWhatIsWrongAndLeavesNothing) {
  const TemporaryFolder folder;
  const Mesh empty, mesh = shapes::box();
  EXPECT_EQ(write_gltf(folder.path() / "a.glb", empty.view(), make_index_buffers(empty.view())).fault,
            Fault::empty_mesh);
  const Status status = write_gltf(folder.path() / "none" / "a.glb", mesh.view(), turned_orders(mesh.view(), 1));
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_NE(status.message.find("a.glb"), std::string::npos);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace facetsort
