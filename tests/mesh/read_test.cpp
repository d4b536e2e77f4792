#include "facetsort/mesh/read.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <locale>
#include <thread>

#include "facetsort/mesh/inspect.h"
#include "mesh/encode.h"
#include "mesh/temporary_folder.h"

namespace facetsort {
namespace {

Mesh read(const std::filesystem::path& path) {
  Result<Mesh> mesh = read_mesh(path);
  EXPECT_TRUE(mesh.ok()) << mesh.status().message;
  return mesh.ok() ? std::move(mesh).value() : Mesh{};
}

Mesh read(const TemporaryFolder& folder, const std::string& name, const std::string& bytes) {
  return read(folder.write(name, bytes));
}

std::vector<glm::vec3> corners(const Mesh& mesh) {
  std::vector<glm::vec3> result;
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) result.push_back(mesh.positions[triangle[i]]);
  }
  return result;
}

// To the bit: -0 is not 0.
bool same_bits(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0;
}

const std::vector<glm::vec3> square{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

// --- every format
// -----------------------------------------------------------------------------------------------------

class EveryFormat : public testing::TestWithParam<Format> {};

TEST_P(EveryFormat, KeepsEveryFacetInTheFilesOrder) {
  const TemporaryFolder folder;
  const Mesh dirty = dirty_mesh();
  const Mesh mesh = read(folder, std::string("dirty") + GetParam().extension, GetParam().encode(dirty));
  EXPECT_TRUE(validate(mesh.view()).ok());
  EXPECT_TRUE(same_bits(corners(mesh), corners(dirty)));
  if (GetParam().is_indexed) {
    EXPECT_TRUE(same_bits(mesh.positions, dirty.positions));
    EXPECT_EQ(mesh.triangles, dirty.triangles);
  }
  EXPECT_TRUE(mesh.facet_colours.empty());
  EXPECT_TRUE(mesh.vertex_colours.empty());
}

TEST_P(EveryFormat, ExtensionInAnyCase) {
  const TemporaryFolder folder;
  std::string extension = GetParam().extension;
  extension[2] = static_cast<char>(extension[2] - 'a' + 'A');
  EXPECT_EQ(read(folder, "dirty" + extension, GetParam().encode(dirty_mesh())).triangles.size(),
            dirty_mesh().triangles.size());
}

TEST_P(EveryFormat, FloatsComeBackToTheBit) {
  Mesh mesh;
  const float values[] = {0.1f,       -0.f,         1e-38f, 1e-45f,   -3.4028235e38f,
                          16777216.f, 0.333333343f, 1e-7f,  123.456f, 1.17549435e-38f};
  for (const float x : values) mesh.positions.emplace_back(x, -x, x);
  for (glm::uint i = 0; i + 2 < mesh.positions.size(); ++i) mesh.triangles.emplace_back(i, i + 1, i + 2);
  const TemporaryFolder folder;
  EXPECT_TRUE(same_bits(corners(read(folder, std::string("values") + GetParam().extension, GetParam().encode(mesh))),
                        corners(mesh)));
}

// The decimal comma of a user's locale is not the files'.
TEST_P(EveryFormat, WhateverTheLocale) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const TemporaryFolder folder;
  const std::filesystem::path path =
      folder.write(std::string("dirty") + GetParam().extension, GetParam().encode(dirty_mesh()));
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const Result<Mesh> mesh = read_mesh(path);
  std::locale::global(before);
  ASSERT_TRUE(mesh.ok()) << mesh.status().message;
  EXPECT_TRUE(same_bits(corners(mesh.value()), corners(dirty_mesh())));
}

TEST_P(EveryFormat, TextWithWindowsLineEnds) {
  if (!GetParam().is_text) return;
  const std::string text = GetParam().encode(dirty_mesh());
  for (const std::string line_end : {"\r\n", "\r"}) {
    std::string other;
    for (const char c : text) c == '\n' ? other += line_end : other += c;
    const TemporaryFolder folder;
    EXPECT_TRUE(
        same_bits(corners(read(folder, std::string("windows") + GetParam().extension, other)), corners(dirty_mesh())));
  }
}

INSTANTIATE_TEST_SUITE_P(Read, EveryFormat, testing::ValuesIn(formats()),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(Read, FromSeveralThreadsAtOnce) {
  const TemporaryFolder folder;
  std::vector<std::filesystem::path> paths;
  for (const Format& format : formats()) {
    paths.push_back(folder.write(std::string(format.name) + format.extension, format.encode(dirty_mesh())));
  }
  const std::vector<glm::vec3> expected = corners(dirty_mesh());
  std::vector<int> wrong(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t) {
      threads.emplace_back([&, t] {
        for (std::size_t i = 0; i < 50 * paths.size(); ++i) {
          const Result<Mesh> mesh = read_mesh(paths[(i + t) % paths.size()]);
          wrong[t] += !mesh.ok() || !same_bits(corners(mesh.value()), expected);
        }
      });
    }
  }
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST(Read, NothingIsPrinted) {
  const TemporaryFolder folder;
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const Format& format : formats()) {
    const std::string bytes = format.encode(dirty_mesh());
    (void)read_mesh(folder.write(std::string("whole") + format.extension, bytes));
    (void)read_mesh(folder.write(std::string("half") + format.extension, bytes.substr(0, bytes.size() / 2)));
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

// --- polygons
// ---------------------------------------------------------------------------------------------------------

const std::vector<glm::uvec3> fans{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}, {1, 1, 2}, {1, 2, 2}, {1, 2, 3}};

TEST(Read, PolygonsBecomeFansInTheirPlace) {
  const TemporaryFolder folder;
  const std::string vertices = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n", faces = "4 0 1 2 3\n3 3 2 1\n5 1 1 2 2 3\n";
  EXPECT_EQ(read(folder, "fan.off", "OFF\n4 3 0\n" + vertices + faces).triangles, fans);
  EXPECT_EQ(read(folder, "fan.ply",
                 "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                 "element face 3\nproperty list uchar int vertex_indices\nend_header\n" +
                     vertices + faces)
                .triangles,
            fans);
  EXPECT_EQ(read(folder, "fan.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2\nf 2 2 3 3 4\n").triangles,
            fans);
  for (const Endian endian : {Endian::little, Endian::big}) {
    std::string bytes = std::string("ply\nformat ") +
                        (endian == Endian::big ? "binary_big_endian" : "binary_little_endian") +
                        " 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                        "element face 3\nproperty list uchar int vertex_indices\nproperty uchar red\n"
                        "property uchar green\nproperty uchar blue\nend_header\n";
    for (const glm::vec3& p : square) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, p[axis], endian);
    }
    unsigned char shade = 0;
    for (const std::vector<int>& face : {std::vector{0, 1, 2, 3}, {3, 2, 1}, {1, 1, 2, 2, 3}}) {
      bytes += static_cast<char>(face.size());
      for (const int corner : face) put(bytes, corner, endian);
      bytes.append(3, static_cast<char>(shade += 51));
    }
    const Mesh mesh = read(folder, "fan.ply", bytes);
    EXPECT_EQ(mesh.triangles, fans);
    ASSERT_EQ(mesh.facet_colours.size(), fans.size());
    for (std::size_t f = 0; f < fans.size(); ++f) {
      const float expected = static_cast<float>(f < 2 ? 51 : f == 2 ? 102 : 153) / 255.0f;
      EXPECT_EQ(mesh.facet_colours[f], glm::vec4(expected, expected, expected, 1));
    }
  }
}

// --- PLY
// --------------------------------------------------------------------------------------------------------------

// Names in both of the format's spellings.
template <typename Value>
struct PlyType;
template <>
struct PlyType<std::int8_t> {
  static constexpr const char* names[] = {"char", "int8"};
};
template <>
struct PlyType<std::uint8_t> {
  static constexpr const char* names[] = {"uchar", "uint8"};
};
template <>
struct PlyType<std::int16_t> {
  static constexpr const char* names[] = {"short", "int16"};
};
template <>
struct PlyType<std::uint16_t> {
  static constexpr const char* names[] = {"ushort", "uint16"};
};
template <>
struct PlyType<std::int32_t> {
  static constexpr const char* names[] = {"int", "int32"};
};
template <>
struct PlyType<std::uint32_t> {
  static constexpr const char* names[] = {"uint", "uint32"};
};
template <>
struct PlyType<float> {
  static constexpr const char* names[] = {"float", "float32"};
};
template <>
struct PlyType<double> {
  static constexpr const char* names[] = {"double", "float64"};
};

template <typename Count, typename Index, typename Coordinate>
void expect_types_read() {
  for (const Endian endian : {Endian::little, Endian::big}) {
    for (const int spelling : {0, 1}) {
      const std::string count = PlyType<Count>::names[spelling], index = PlyType<Index>::names[spelling],
                        coordinate = PlyType<Coordinate>::names[spelling];
      SCOPED_TRACE(count + " " + index + " " + coordinate);
      std::string bytes =
          std::string("ply\nformat ") + (endian == Endian::big ? "binary_big_endian" : "binary_little_endian") +
          " 1.0\nelement vertex 4\nproperty " + coordinate + " x\nproperty " + coordinate + " y\nproperty " +
          coordinate + " z\nelement face 2\nproperty list " + count + " " + index + " vertex_index\nend_header\n";
      for (const glm::vec3& p : square) {
        for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<Coordinate>(p[axis] * 0.1f), endian);
      }
      for (const std::vector<int>& face : {std::vector{0, 1, 2, 3}, {3, 2, 1}}) {
        put(bytes, static_cast<Count>(face.size()), endian);
        for (const int corner : face) put(bytes, static_cast<Index>(corner), endian);
      }
      const TemporaryFolder folder;
      const Mesh mesh = read(folder, "types.ply", bytes);
      EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}, {3, 2, 1}}));
      ASSERT_EQ(mesh.positions.size(), 4u);
      EXPECT_EQ(mesh.positions[2], glm::vec3(0.1f, 0.1f, 0));
    }
  }
}

template <typename Count>
void expect_count_type_read() {
  expect_types_read<Count, std::int8_t, float>();
  expect_types_read<Count, std::uint8_t, double>();
  expect_types_read<Count, std::int16_t, float>();
  expect_types_read<Count, std::uint16_t, double>();
  expect_types_read<Count, std::int32_t, float>();
  expect_types_read<Count, std::uint32_t, double>();
}

TEST(ReadPly, EveryTypeInBothByteOrders) {
  expect_count_type_read<std::int8_t>();
  expect_count_type_read<std::uint8_t>();
  expect_count_type_read<std::int16_t>();
  expect_count_type_read<std::uint16_t>();
  expect_count_type_read<std::int32_t>();
  expect_count_type_read<std::uint32_t>();
}

// Elements and properties of no use to us, in every place where they shift what is of use.
const std::string crowded_header =
    "comment element face 99\nobj_info property end_header\n"
    "element material 1\nproperty uchar shininess\nproperty list uchar float weights\n"
    "element face 2\nproperty uchar flags\nproperty list uchar short neighbours\n"
    "property list uchar int vertex_indices\nproperty list uchar float texcoord\nproperty uchar tail\n"
    "element vertex 4\nproperty float confidence\nproperty float z\nproperty float x\n"
    "property list uchar uchar bones\nproperty float y\n"
    "element edge 1\nproperty int vertex1\nproperty list int double more\nend_header\n";

TEST(ReadPly, OtherElementsAndPropertiesAreSteppedOver) {
  const std::vector<glm::uvec3> expected{{0, 1, 2}, {3, 2, 1}};
  const TemporaryFolder folder;
  const Mesh from_text = read(folder, "crowded.ply",
                              "ply\nformat ascii 1.0\n" + crowded_header +
                                  "7 2 0.5 0.25\n"
                                  "1 0 3 0 1 2 6 0 0 1 0 1 1 9\n"
                                  "2 2 -1 5 3 3 2 1 0 8\n"
                                  "0.5 0 0 0 0\n\n0.5 0 1 1 77 0\n0.5 0 1 2 7 7 1\n0.5 0 0 0 1\n"
                                  "1 3 0.1 0.2 0.3\n");
  EXPECT_EQ(from_text.triangles, expected);
  EXPECT_EQ(from_text.positions, square);

  for (const Endian endian : {Endian::little, Endian::big}) {
    std::string bytes = std::string("ply\nformat ") +
                        (endian == Endian::big ? "binary_big_endian" : "binary_little_endian") + " 1.0\n" +
                        crowded_header;
    bytes += "\7\2";
    for (const float weight : {0.5f, 0.25f}) put(bytes, weight, endian);
    for (const glm::uvec3& face : expected) {
      bytes += "\1\2";
      for (const int neighbour : {-1, 5}) put(bytes, static_cast<std::int16_t>(neighbour), endian);
      bytes += '\3';
      for (int i = 0; i < 3; ++i) put(bytes, face[i], endian);
      bytes += '\2';
      for (const float coordinate : {0.f, 1.f}) put(bytes, coordinate, endian);
      bytes += '\11';
    }
    unsigned char bones = 0;
    for (const glm::vec3& p : square) {
      put(bytes, 0.5f, endian);
      put(bytes, p.z, endian);
      put(bytes, p.x, endian);
      bytes += static_cast<char>(bones);
      bytes.append(bones++, '\7');
      put(bytes, p.y, endian);
    }
    put(bytes, 1, endian);
    put(bytes, 1, endian);
    put(bytes, 0.1, endian);
    const Mesh mesh = read(folder, "crowded.ply", bytes);
    EXPECT_EQ(mesh.triangles, expected);
    EXPECT_EQ(mesh.positions, square);
  }
}

TEST(ReadPly, HeadersWithOtherLineEnds) {
  const Mesh dirty = dirty_mesh();
  const std::string bytes = ply_little_endian(dirty);
  const std::size_t header_size = bytes.find("end_header\n") + 11;
  for (const std::string line_end : {"\r\n", "\r"}) {
    std::string other;
    for (const char c : bytes.substr(0, header_size)) c == '\n' ? other += line_end : other += c;
    const TemporaryFolder folder;
    EXPECT_TRUE(same_bits(corners(read(folder, "dirty.ply", other + bytes.substr(header_size))), corners(dirty)));
  }
}

// A body that starts with what could be a part of a line's end.
TEST(ReadPly, BodiesThatStartLikeALineEnd) {
  for (const std::uint32_t bits : {0x3f80000au, 0x3f800a0du, 0x3f80000du}) {
    Mesh mesh = dirty_mesh();
    mesh.positions[0].x = std::bit_cast<float>(bits);
    const TemporaryFolder folder;
    EXPECT_TRUE(same_bits(corners(read(folder, "dirty.ply", ply_little_endian(mesh))), corners(mesh)));
  }
}

std::string coloured_ply(const std::string& vertex_properties, const std::string& vertex_colour,
                         const std::string& face_properties, const std::string& face_colour) {
  std::string text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n" + vertex_properties +
                     "property float y\nproperty float z\nelement face 2\n" + face_properties +
                     "property list uchar int vertex_indices\nend_header\n";
  for (int v = 0; v < 3; ++v) text += std::to_string(v) + " " + vertex_colour + " 0 0\n";
  for (int f = 0; f < 2; ++f) text += face_colour + " 3 0 1 2\n";
  return text;
}

std::string colour_properties(const std::string& type, const std::string& prefix = "", bool alpha = false) {
  std::string text;
  for (const char* channel : {"red", "green", "blue"}) text += "property " + type + " " + prefix + channel + "\n";
  return alpha ? text + "property " + type + " alpha\n" : text;
}

TEST(ReadPly, ColoursOfVerticesAndFacets) {
  const TemporaryFolder folder;
  Mesh mesh = read(
      folder, "colour.ply",
      coloured_ply(colour_properties("uchar"), "0 51 255", colour_properties("float", "", true), "0.1 0.25 1 0.3"));
  EXPECT_EQ(mesh.vertex_colours, std::vector<glm::vec4>(3, {0, 51 / 255.0f, 1, 1}));
  EXPECT_EQ(mesh.facet_colours, std::vector<glm::vec4>(2, {0.1f, 0.25f, 1, 0.3f}));

  mesh = read(folder, "colour.ply",
              coloured_ply(colour_properties("ushort", "diffuse_"), "0 13107 65535", colour_properties("int", "", true),
                           "1 2 3 254"));
  EXPECT_EQ(mesh.vertex_colours, std::vector<glm::vec4>(3, {0, 13107 / 65535.0f, 1, 1}));
  EXPECT_EQ(mesh.facet_colours, std::vector<glm::vec4>(2, {1 / 255.0f, 2 / 255.0f, 3 / 255.0f, 254 / 255.0f}));

  mesh = read(folder, "colour.ply", coloured_ply("property uchar red\nproperty uchar alpha\n", "1 2", "", ""));
  EXPECT_TRUE(mesh.vertex_colours.empty());
  EXPECT_TRUE(mesh.facet_colours.empty());

  for (const std::string colour : {"0 0 256", "-1 0 0"}) {
    const Result<Mesh> bad = read_mesh(folder.write("bad.ply", coloured_ply(colour_properties("int"), colour, "", "")));
    ASSERT_FALSE(bad.ok());
    EXPECT_EQ(bad.status().message,
              (folder.path() / "bad.ply").string() + ": line 13: vertex 0 has a colour outside its range");
  }
}

TEST(ReadPly, BinaryColours) {
  for (const Endian endian : {Endian::little, Endian::big}) {
    std::string bytes = std::string("ply\nformat ") +
                        (endian == Endian::big ? "binary_big_endian" : "binary_little_endian") +
                        " 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n" +
                        colour_properties("ushort") + "element face 1\n" + colour_properties("double", "", true) +
                        "property list uchar int vertex_indices\nend_header\n";
    for (std::uint16_t v = 0; v < 3; ++v) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(v), endian);
      for (const int shade : {1, 256, 65535}) put(bytes, static_cast<std::uint16_t>(shade), endian);
    }
    for (const double channel : {0.1, 0.25, 0.5, 1.0}) put(bytes, channel, endian);
    bytes += '\3';
    for (int corner = 0; corner < 3; ++corner) put(bytes, corner, endian);
    const TemporaryFolder folder;
    const Mesh mesh = read(folder, "colour.ply", bytes);
    EXPECT_EQ(mesh.vertex_colours, std::vector<glm::vec4>(3, {1 / 65535.0f, 256 / 65535.0f, 1, 1}));
    EXPECT_EQ(mesh.facet_colours, std::vector<glm::vec4>(1, {0.1f, 0.25f, 0.5f, 1}));
  }
}

TEST(ReadPly, NumbersInTextBeyondFloatsRange) {
  const TemporaryFolder folder;
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty int y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  // The last vertex is not used: it may be anything.
  const Mesh mesh =
      read(folder, "range.ply", header + "+1.5 2 1e-60\n-1e-400 -3 0\n1e-45 0 .5\nnan 0 1e999\n3 0 1 2\n");
  ASSERT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(mesh.positions[0], glm::vec3(1.5f, 2, 0));
  EXPECT_EQ(mesh.positions[1], glm::vec3(-0.f, -3, 0));
  EXPECT_EQ(mesh.positions[2], glm::vec3(std::numeric_limits<float>::denorm_min(), 0, 0.5f));
  EXPECT_TRUE(std::isnan(mesh.positions[3].x));
  EXPECT_EQ(mesh.positions[3].z, std::numeric_limits<float>::infinity());
}

TEST(ReadPly, SourceOfPolygonsIsThatOfTheirTriangles) {
  const TemporaryFolder folder;
  const std::string text =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 2\nproperty uint source\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4294967295 4 0 1 2 3\n7 3 0 1 2\n";
  const auto source = read_ply_source(folder.write("source.ply", text));
  ASSERT_TRUE(source.ok()) << source.status().message;
  EXPECT_EQ(source.value(), (std::vector<std::uint32_t>{4294967295u, 4294967295u, 7u}));
}

// --- OBJ
// --------------------------------------------------------------------------------------------------------------

TEST(ReadObj, IndicesBackwardsForwardsAndWithSlashes) {
  const TemporaryFolder folder;
  const Mesh mesh = read(folder, "slashes.obj",
                         "# f before v\n"
                         "f 4/1/1 3/2/1 2/3/1\n"
                         "v 0 0 0\nvt 0 0\nvn 0 0 1\nv 1 0 0 1.0\n"
                         "v 1 1 0\n  f -3//1 -2//1 -1//1  # the three so far\n"
                         "v 0 1 \\\n 0\n"
                         "g group\no object\ns off\nl 1 2\np 1\n"
                         "f -4/1 -3 \\\n  -2/1/1\n");
  EXPECT_EQ(mesh.positions, square);
  EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{3, 2, 1}, {0, 1, 2}, {0, 1, 2}}));
}

TEST(ReadObj, VertexColours) {
  const TemporaryFolder folder;
  Mesh mesh = read(folder, "colour.obj", "v 0 0 0 0.5 0.25 1\nv 1 0 0\nv 0 1 0 0 0 0 0.5\nv 1 1 1\nf 1 2 3\n");
  EXPECT_EQ(mesh.vertex_colours,
            (std::vector<glm::vec4>{{0.5f, 0.25f, 1, 1}, {1, 1, 1, 1}, {0, 0, 0, 0.5f}, {1, 1, 1, 1}}));
  mesh = read(folder, "colour.obj", "v 0 0 0 51 0 255\nv 1 0 0 1 2 3\nv 0 1 0 0 0 0\nf 1 2 3\n");
  EXPECT_EQ(mesh.vertex_colours,
            (std::vector<glm::vec4>{{0.2f, 0, 1, 1}, {1 / 255.0f, 2 / 255.0f, 3 / 255.0f, 1}, {0, 0, 0, 1}}));
}

const std::string triangle_obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(ReadObj, OpacityAndTransparencyAreOpposites) {
  const TemporaryFolder folder;
  folder.write("glass.mtl",
               "newmtl opaque\nKd 0.1 0.2 0.3\n"
               "newmtl d\nKd 1 0 0\nd 0.25\n"
               "newmtl Tr\nTr 0.25\nKd 0 1 0\n"
               "newmtl both\nd 0.5\nTr 1\nKd 0 0 1\n"
               "newmtl halo\nd -halo 0.125\nKd 0.5\n"
               "newmtl bright\nKd 4 0 1\n"
               "newmtl plain\nNs 10\nillum 2\n");
  const Mesh mesh = read(folder, "glass.obj",
                         "mtllib glass.mtl\n" + triangle_obj +
                             "f 1 2 3\nusemtl d\nf 1 2 3\nf 2 2 2\nusemtl Tr\nf 1 2 3\nusemtl both\nf 1 2 3 1\n"
                             "usemtl halo\nf 1 2 3\nusemtl bright\nf 1 2 3\nusemtl plain\nf 1 2 3\n"
                             "usemtl opaque\nf 1 2 3\nusemtl unknown\nf 1 2 3\n");
  EXPECT_EQ(mesh.facet_colours, (std::vector<glm::vec4>{{1, 1, 1, 1},
                                                        {1, 0, 0, 0.25f},
                                                        {1, 0, 0, 0.25f},
                                                        {0, 1, 0, 0.75f},
                                                        {0, 0, 1, 0.5f},
                                                        {0, 0, 1, 0.5f},
                                                        {0.5f, 0.5f, 0.5f, 0.125f},
                                                        {1, 0, 1, 1},
                                                        {1, 1, 1, 1},
                                                        {0.1f, 0.2f, 0.3f, 1},
                                                        {1, 1, 1, 1}}));
}

TEST(ReadObj, LibrariesUnderAnyName) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "sub folder");
  folder.write("sub folder/my glass.mtl", "newmtl red glass\nKd 1 0 0\nd 0.5\n");
  folder.write("second.mtl", "newmtl blue\nKd 0 0 1\n");
  for (const std::string library : {"mtllib sub folder/my glass.mtl\nmtllib second.mtl\n",
                                    "mtllib \"sub folder/my glass.mtl\"\r\nmtllib second.mtl\n",
                                    "mtllib sub folder\\my glass.mtl\nmtllib missing.mtl second.mtl\n"}) {
    SCOPED_TRACE(library);
    const std::string faces = triangle_obj + "usemtl red glass\nf 1 2 3\nusemtl blue\nf 3 2 1\n";
    const std::vector<glm::vec4> expected{{1, 0, 0, 0.5f}, {0, 0, 1, 1}};
    EXPECT_EQ(read(folder, "a.obj", library + faces).facet_colours, expected);
    EXPECT_EQ(read(folder, "a.obj", faces + library).facet_colours, expected);
  }
}

TEST(ReadObj, MissingMaterialsLeaveNoColours) {
  const TemporaryFolder folder;
  for (const std::string library : {"mtllib missing.mtl\n", "mtllib\n", "mtllib .\n", ""}) {
    const Mesh mesh = read(folder, "a.obj", library + triangle_obj + "usemtl glass\nf 1 2 3\n");
    EXPECT_EQ(mesh.triangles.size(), 1u);
    EXPECT_TRUE(mesh.facet_colours.empty());
  }
}

// --- OFF
// --------------------------------------------------------------------------------------------------------------

TEST(ReadOff, CommentsCountsAndColours) {
  const TemporaryFolder folder;
  const std::vector<glm::uvec3> expected{{0, 1, 2}, {3, 2, 1}};
  for (const std::string header :
       {"OFF\n4 2 5\n", "OFF 4 2 5\n", "# first\nOFF # 9 9 9\n\n# second\n4 2\n", "4 2 0\n"}) {
    SCOPED_TRACE(header);
    const Mesh mesh = read(folder, "a.off",
                           header + "0 0 0 # a corner\n\n1\t0  0\n1 1 0\n0 1 0\n3 0 1 2 255 0 51\n3  3 2 1\t# none\n");
    EXPECT_EQ(mesh.positions, square);
    EXPECT_EQ(mesh.triangles, expected);
    EXPECT_EQ(mesh.facet_colours, (std::vector<glm::vec4>{{1, 0, 51 / 255.0f, 1}, {1, 1, 1, 1}}));
    EXPECT_TRUE(mesh.vertex_colours.empty());
  }
}

TEST(ReadOff, ColoursInEitherRange) {
  const TemporaryFolder folder;
  const Mesh mesh =
      read(folder, "a.off", "COFF\n3 1 0\n0 0 0 1 0 1 1\n1 0 0 0.5 0.25 0 0.1\n0 1 0\n4 0 1 2 2 0.5 0.5 0 0.5\n");
  EXPECT_EQ(mesh.vertex_colours, (std::vector<glm::vec4>{{1, 0, 1, 1}, {0.5f, 0.25f, 0, 0.1f}, {1, 1, 1, 1}}));
  EXPECT_EQ(mesh.facet_colours, std::vector<glm::vec4>(2, {0.5f, 0.5f, 0, 0.5f}));
}

TEST(ReadOff, NormalsTextureCoordinatesAndColourMaps) {
  const TemporaryFolder folder;
  const Mesh mesh = read(folder, "a.off",
                         "STCNOFF\n3 1 0\n0 0 0 0 0 1 255 0 0 0.1 0.2\n1 0 0 0 0 1 0 255 0 0 0\n"
                         "1 1 0 0 0 1 0 0 255 1 1\n3 0 1 2 7\n");
  EXPECT_EQ(mesh.positions, (std::vector<glm::vec3>{square[0], square[1], square[2]}));
  EXPECT_EQ(mesh.vertex_colours, (std::vector<glm::vec4>{{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}));
  EXPECT_TRUE(mesh.facet_colours.empty());
}

// --- STL
// --------------------------------------------------------------------------------------------------------------

TEST(ReadStl, SeveralSolidsInAnyCase) {
  const TemporaryFolder folder;
  const std::string facet =
      "FACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 0 0 0\nvertex 1 0 0\nVertex 1 1 0\nENDLOOP\nENDFACET\n";
  const Mesh mesh =
      read(folder, "a.stl",
           "SOLID first facet\n" + facet + facet + "ENDSOLID\nsolid\nendsolid\nsolid\n" + facet + "endsolid third\n");
  EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}));
}

TEST(ReadStl, BinaryWithAnyHeader) {
  const TemporaryFolder folder;
  for (const std::string header : {"solid", "SOLID x", "made elsewhere", ""}) {
    std::string bytes = stl_binary(dirty_mesh());
    std::string other = header;
    other.resize(80, '\0');
    bytes.replace(0, 80, other);
    EXPECT_TRUE(same_bits(corners(read(folder, "a.stl", bytes)), corners(dirty_mesh())));
  }
}

}  // namespace
}  // namespace facetsort
