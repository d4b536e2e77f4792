// Files that are cut, spoiled or lying: each gets one line that names the file, the fault and the place, and none gets
// a mesh that it does not hold.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <random>

#include "facetsort/mesh/inspect.h"
#include "facetsort/mesh/read.h"
#include "mesh/encode.h"
#include "mesh/temporary_folder.h"
#include "support/permission.h"
#include "support/special_floats.h"

namespace facetsort {
namespace {

void expect_fault(const std::filesystem::path& path, Fault fault, const std::string& message) {
  const Result<Mesh> mesh = read_mesh(path);
  ASSERT_FALSE(mesh.ok()) << "accepted, expected: " << message;
  EXPECT_EQ(mesh.status().fault, fault) << mesh.status().message;
  EXPECT_EQ(mesh.status().message, path.string() + ": " + message);
}

// What holds of any file: a valid mesh, or one line that starts with the file's name.
void expect_mesh_or_line(const std::filesystem::path& path) {
  const Result<Mesh> mesh = read_mesh(path);
  if (mesh.ok()) {
    const Status status = validate(mesh.value().view());
    EXPECT_TRUE(status.ok()) << status.message;
  } else {
    EXPECT_NE(mesh.status().fault, Fault::none);
    EXPECT_TRUE(mesh.status().message.starts_with(path.string() + ": ")) << mesh.status().message;
    EXPECT_EQ(mesh.status().message.find('\n'), std::string::npos) << mesh.status().message;
  }
}

// --- every format
// -----------------------------------------------------------------------------------------------------

class DamagedFormat : public testing::TestWithParam<Format> {
 protected:
  std::filesystem::path write(const std::string& bytes) const {
    return folder_.write(std::string("bad") + GetParam().extension, bytes);
  }

  TemporaryFolder folder_;
};

TEST_P(DamagedFormat, CutAnywhere) {
  const Mesh dirty = dirty_mesh();
  const std::string whole = GetParam().encode(dirty);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    SCOPED_TRACE("cut at " + std::to_string(size) + " of " + std::to_string(whole.size()));
    const std::filesystem::path path = write(whole.substr(0, size));
    expect_mesh_or_line(path);
    const Result<Mesh> mesh = read_mesh(path);
    if (!GetParam().is_text) {
      ASSERT_FALSE(mesh.ok());
    } else if (GetParam().says_its_size && whole.find('\n', size) + 1 < whole.size()) {
      // Only within a text's last line is there no telling.
      ASSERT_FALSE(mesh.ok());
    } else if (mesh.ok()) {
      ASSERT_LE(mesh.value().triangles.size(), dirty.triangles.size());
      if (GetParam().says_its_size) {
        ASSERT_EQ(mesh.value().triangles.size(), dirty.triangles.size());
      }
    }
  }
}

TEST_P(DamagedFormat, FlippedBytes) {
  const std::string whole = GetParam().encode(dirty_mesh());
  std::mt19937 random(20240607);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes = whole;
    for (std::uint32_t flips = 1 + random() % 4; flips > 0; --flips) {
      bytes[random() % bytes.size()] = static_cast<char>(random());
    }
    expect_mesh_or_line(write(bytes));
  }
}

// Closer to what parsers trip over than random bytes: digits, signs, spaces and keywords in wrong places.
TEST_P(DamagedFormat, SplicedPieces) {
  const std::string whole = GetParam().encode(dirty_mesh());
  const std::string pieces[] = {"-1",   "4294967295", "99999999999999999999",
                                "nan",  "inf",        "1e999",
                                "\n",   " ",          "/",
                                "\\\n", "3 ",         "#",
                                "0",    "\xff",       "e",
                                "f ",   "v ",         "\r"};
  std::mt19937 random(20240608);
  for (int trial = 0; trial < 1000; ++trial) {
    std::string bytes = whole;
    const std::size_t at = random() % bytes.size(), removed = random() % 8;
    bytes.replace(at, removed, pieces[random() % std::size(pieces)]);
    if (random() % 4 == 0) bytes.erase(random() % bytes.size(), 1 + random() % 64);
    expect_mesh_or_line(write(bytes));
  }
}

TEST_P(DamagedFormat, NonFinitePositionThatAFacetUses) {
  for (const float bad : {nan, infinity, -infinity}) {
    for (int axis = 0; axis < 3; ++axis) {
      Mesh mesh = dirty_mesh();
      mesh.positions[4][axis] = bad;
      const std::size_t vertex = GetParam().is_indexed ? 4 : 8;  // the third corner of facet 2
      expect_fault(write(GetParam().encode(mesh)), Fault::non_finite_position,
                   "facet 2 uses vertex " + std::to_string(vertex) + ", whose position is not finite");
    }
  }
}

TEST_P(DamagedFormat, NonFinitePositionThatNoFacetUses) {
  if (!GetParam().is_indexed) return;
  Mesh mesh = dirty_mesh();
  mesh.positions.emplace_back(nan, infinity, 0);
  const Result<Mesh> read = read_mesh(write(GetParam().encode(mesh)));
  ASSERT_TRUE(read.ok()) << read.status().message;
  EXPECT_EQ(read.value().triangles, mesh.triangles);
}

TEST_P(DamagedFormat, IndexOutOfRange) {
  if (!GetParam().is_indexed) return;
  const bool from_one = std::string(GetParam().extension) == ".obj";
  for (const glm::uint bad : {9u, 900u, 2147483646u}) {
    Mesh mesh = dirty_mesh();
    mesh.triangles[7].y = bad;
    const std::string vertex = std::to_string(from_one ? bad + 1 : bad);
    expect_fault(write(GetParam().encode(mesh)), Fault::index_out_of_range,
                 from_one ? "line 17: facet 7 names vertex " + vertex + " of 9 (the first is 1)"
                          : "facet 7 names vertex " + vertex + " of 9");
  }
}

TEST_P(DamagedFormat, NoFacets) {
  Mesh mesh = dirty_mesh();
  mesh.triangles.clear();
  expect_fault(write(GetParam().encode(mesh)), Fault::empty_mesh, "no facet");
}

TEST_P(DamagedFormat, Empty) {
  expect_fault(write(""), Fault::empty_mesh, "the file is empty");
}

INSTANTIATE_TEST_SUITE_P(Read, DamagedFormat, testing::ValuesIn(formats()),
                         [](const auto& instance) { return std::string(instance.param.name); });

// --- what can't be opened
// ---------------------------------------------------------------------------------------------

TEST(Unreadable, MissingFilesFoldersAndDevices) {
  const TemporaryFolder folder;
  expect_fault(folder.path() / "none.ply", Fault::cannot_read, "cannot be opened: No such file or directory");
  std::filesystem::create_directory(folder.path() / "folder.obj");
  expect_fault(folder.path() / "folder.obj", Fault::cannot_read, "is a directory");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.stl").c_str(), 0600), 0);
  expect_fault(folder.path() / "pipe.stl", Fault::cannot_read, "is not a regular file");
  for (const std::string name : {"mesh.txt", "mesh", "mesh.plyx", "ply", "mesh.om"}) {
    expect_fault(folder.write(name, "ply"), Fault::unsupported_format, "is no .ply, .obj, .off or .stl file");
  }
}

TEST(Unreadable, NoPermission) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("secret.ply", ply_ascii(dirty_mesh()));
  expect_refused_without_permission(folder, path, [](const std::filesystem::path& file) {
    const Result<Mesh> mesh = read_mesh(file);
    return !mesh.ok() && mesh.status().fault == Fault::cannot_read &&
           mesh.status().message == file.string() + ": cannot be opened: Permission denied";
  });
}

// --- what each format can get wrong
// -----------------------------------------------------------------------------------

std::string ply_with(const std::string& elements, const std::string& body, const std::string& format = "ascii") {
  return "ply\nformat " + format + " 1.0\n" + elements + "end_header\n" + body;
}

std::string ply_elements(const std::string& vertices, const std::string& faces) {
  return "element vertex " + vertices + "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         faces + "\nproperty list uchar int vertex_indices\n";
}

const std::string three_vertices = "0 0 0\n1 0 0\n0 1 0\n";

TEST(DamagedPly, Counts) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& vertices, const std::string& faces, Fault fault,
                          const std::string& message) {
    expect_fault(folder.write("a.ply", ply_with(ply_elements(vertices, faces), three_vertices + "3 0 1 2\n3 2 1 0\n")),
                 fault, message);
  };
  expect("3", "3", Fault::truncated, "truncated: 2 of 3 facets read");
  expect("3", "4294967295", Fault::truncated, "truncated: 2 of 4294967295 facets read");
  expect("3", "18446744073709551615", Fault::truncated, "truncated: 2 of 18446744073709551615 facets read");
  expect("3", "1", Fault::malformed, "line 14: the file goes on after its last element");
  expect("2", "2", Fault::malformed, "line 12: facet 0 has 0 corners, fewer than 3");
  expect("4", "2", Fault::malformed, "line 13: vertex 3 has more values than its header says");
  expect("6", "2", Fault::malformed, "line 13: vertex 3 has more values than its header says");
  expect("3", "0", Fault::empty_mesh, "no facet");
  expect("3", "-1", Fault::malformed, "header line 7: a count expected");
  expect("3", "many", Fault::malformed, "header line 7: a count expected");
  expect("18446744073709551616", "1", Fault::malformed, "header line 3: a count expected");
}

TEST(DamagedPly, BinaryCounts) {
  const TemporaryFolder folder;
  const Mesh dirty = dirty_mesh();
  const std::string whole = ply_little_endian(dirty);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string bytes = whole;
    return bytes.replace(bytes.find(from), from.size(), to);
  };
  expect_fault(folder.write("a.ply", with("face 13", "face 14")), Fault::truncated, "truncated: 13 of 14 facets read");
  expect_fault(folder.write("a.ply", with("face 13", "face 4000000000")), Fault::truncated,
               "truncated: 13 of 4000000000 facets read");
  expect_fault(folder.write("a.ply", with("face 13", "face 12")), Fault::malformed,
               "the file goes on after its last element");
  expect_fault(folder.write("a.ply", with("vertex 9", "vertex 4294967296")), Fault::truncated,
               "truncated: 23 of 4294967296 vertices read");
  EXPECT_TRUE(read_mesh(folder.write("a.ply", whole + "\n")).ok()) << "a newline behind the body is harmless";

  // A list longer than the file, in a type that can say so.
  std::string bytes = with("list uchar", "list uint");
  expect_fault(folder.write("a.ply", bytes), Fault::truncated, "truncated: 1 of 13 facets read");
  // An element that takes no room, however many there are.
  EXPECT_TRUE(
      read_mesh(folder.write("a.ply", with("element face", "element nothing 18446744073709551615\nelement face")))
          .ok());
}

TEST(DamagedPly, Header) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, Fault fault, const std::string& message) {
    expect_fault(folder.write("a.ply", text), fault, message);
  };
  const std::string vertex = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n",
                    face = "element face 1\nproperty list uchar int vertex_indices\n",
                    body = three_vertices + "3 0 1 2\n";
  expect("solid\n", Fault::unsupported_format, "no PLY file: it does not start with ply");
  expect("plywood\n", Fault::malformed, "header line 1: ply expected");
  expect("ply\nformat ascii 1.0\nelement vertex 3\n", Fault::truncated, "truncated: no end_header");
  expect("ply\nelement vertex 3\n", Fault::malformed, "header line 2: format expected");
  expect(ply_with(vertex + face, body, "binary"), Fault::unsupported_format, "header line 2: unknown format binary");
  expect(ply_with(vertex + "elephant 3\n" + face, body), Fault::malformed,
         "header line 7: element, property or end_header expected");
  expect(ply_with("property float x\n" + vertex + face, body), Fault::malformed,
         "header line 3: a property before the first element");
  expect(ply_with("element vertex\n", body), Fault::malformed, "header line 3: element NAME COUNT expected");
  expect(ply_with(vertex + "property half w\n" + face, body), Fault::malformed, "header line 7: unknown type half");
  expect(ply_with(vertex + "property float\n" + face, body), Fault::malformed,
         "header line 7: property TYPE NAME or property list TYPE TYPE NAME expected");
  expect(ply_with(vertex + "property float x\n" + face, body), Fault::malformed,
         "header line 7: a second property of that name");
  expect(ply_with(vertex + face + "property list uchar int vertex_index\n", body), Fault::malformed,
         "header line 9: a second property of that name");
  expect(ply_with(vertex + face + vertex, body), Fault::malformed, "header line 9: a second element of that name");
  expect(ply_with(vertex + "element face 1\nproperty list float int vertex_indices\n", body), Fault::malformed,
         "header line 8: a list count that is no integer");
  expect(ply_with(vertex + "element face 1\nproperty list uchar float vertex_indices\n", body), Fault::malformed,
         "header line 8: corners that are no integers");
  expect(ply_with(vertex + "element face 1\nproperty list uchar int tristrips\n", body), Fault::unsupported_format,
         "the faces have no list vertex_indices");
  expect(ply_with("element vertex 3\nproperty float x\nproperty float y\n" + face, body), Fault::malformed,
         "the vertices have no x, y and z");
  expect(ply_with(face, body), Fault::malformed, "no vertex element");
  expect(ply_with(vertex, three_vertices), Fault::empty_mesh, "no facet");
  expect(
      ply_with("element vertex 3\nproperty int x\nproperty int y\nproperty int z\n" + face, body, "binary_big_endian"),
      Fault::unsupported_format, "header line 4: integer coordinates");
}

TEST(DamagedPly, Body) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& body, Fault fault, const std::string& message) {
    expect_fault(folder.write("a.ply", ply_with(ply_elements("3", "2"), body)), fault, message);
  };
  expect("0 0 0\n1 zero 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", Fault::malformed,
         "vertex 1 has a coordinate that is not a number");
  expect("0 0 0\n1 0x1p3 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", Fault::malformed,
         "vertex 1 has a coordinate that is not a number");
  expect("0 0 0\n1 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", Fault::malformed,
         "line 11: vertex 1 has fewer values than its header says");
  expect(three_vertices + "3 0 1 2\n3 0 1 2.5\n", Fault::malformed, "facet 1 has a corner that is not an index");
  expect(three_vertices + "3 0 1 2\n3 0 1 99999999999999999999\n", Fault::malformed,
         "facet 1 has a corner that is not an index");
  expect(three_vertices + "3 0 1 2\nthree 0 1 2\n", Fault::malformed, "line 14: facet 1 has a value that is no uchar");
  expect(three_vertices + "3 0 1 2\n-3 0 1 2\n", Fault::malformed, "line 14: facet 1 has a list of negative length");
  expect(three_vertices + "3 0 1 2\n2 0 1\n", Fault::malformed, "line 14: facet 1 has 2 corners, fewer than 3");
  expect(three_vertices + "3 0 1 2\n4 0 1 2\n", Fault::malformed,
         "line 14: facet 1 has fewer values than its header says");
  expect(three_vertices + "3 0 1 2\n3 0 1 2 3\n", Fault::malformed,
         "line 14: facet 1 has more values than its header says");
  expect(three_vertices + "3 0 1 2\n3 0 -1 2\n", Fault::index_out_of_range, "facet 1 names vertex -1 of 3");
  expect(three_vertices + "3 0 1 2\n3 0 1", Fault::truncated, "truncated: 1 of 2 facets read");
}

TEST(DamagedPly, Source) {
  const TemporaryFolder folder;
  const std::string header = ply_elements("3", "1") + "property int source\n";
  for (const std::string bad : {"-1", "x"}) {
    const auto source =
        read_ply_source(folder.write("a.ply", ply_with(header, three_vertices + "3 0 1 2 " + bad + "\n")));
    ASSERT_FALSE(source.ok());
    EXPECT_EQ(source.status().fault, Fault::malformed);
  }
  const std::string whole = ply_with(header, three_vertices + "3 0 1 2 5\n");
  for (std::size_t size = 0; size + 2 < whole.size(); ++size) {
    const auto source = read_ply_source(folder.write("a.ply", whole.substr(0, size)));
    EXPECT_FALSE(source.ok()) << "cut at " << size;
  }
  EXPECT_EQ(read_ply_source(folder.path() / "none.ply").status().fault, Fault::cannot_read);
}

TEST(DamagedObj, Lines) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, Fault fault, const std::string& message) {
    expect_fault(folder.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n" + text), fault, message);
  };
  expect("v 0 0\nf 1 2 4\n", Fault::malformed, "line 5: vertex 4 has 2 of 3 coordinates");
  expect("v 0 0 x\nf 1 2 4\n", Fault::malformed, "line 5: vertex 4 has a coordinate that is not a number");
  expect("v 0 0 0 1 0 -1\n", Fault::malformed, "line 5: a colour that is not a number or is negative");
  expect("v 0 0 0 1 0 256\n", Fault::malformed,
         "colours of vertices: number 3 is neither in 0 to 1 nor in whole numbers to 255");
  expect("f 1 2\n", Fault::malformed, "line 5: facet 1 has 2 corners, fewer than 3");
  expect("f\n", Fault::malformed, "line 5: facet 1 has 0 corners, fewer than 3");
  expect("f 1 2 x\n", Fault::malformed, "line 5: facet 1 has a corner that is no index: x");
  expect("f 1 2 3/x\n", Fault::malformed, "line 5: facet 1 has a corner that is no index: 3/x");
  expect("f 1 2 /1/1\n", Fault::malformed, "line 5: facet 1 has a corner that is no index: /1/1");
  expect("f 1 2 3.5\n", Fault::malformed, "line 5: facet 1 has a corner that is no index: 3.5");
  expect("f 1 2 0\n", Fault::index_out_of_range, "line 5: facet 1 names vertex 0 of 3 (the first is 1)");
  expect("f 1 2 -4\nv 0 0 1\n", Fault::index_out_of_range, "line 5: facet 1 names vertex -4 of 3 (the first is 1)");
  expect("f 1 2 5\nv 0 0 1\n", Fault::index_out_of_range, "line 5: facet 1 names vertex 5 of 4 (the first is 1)");
  expect("f 1 2 9223372036854775807\n", Fault::index_out_of_range,
         "line 5: facet 1 names vertex 9223372036854775807 of 3 (the first is 1)");
  expect("f 1 2 99999999999999999999\n", Fault::malformed,
         "line 5: facet 1 has a corner that is no index: 99999999999999999999");
  expect("v 1 2", Fault::truncated, "line 5: vertex 4 has 2 of 3 coordinates");
  expect("f 1", Fault::truncated, "line 5: facet 1 has 1 corners, fewer than 3");
}

TEST(DamagedObj, MaterialFilesAreNeverFatal) {
  const TemporaryFolder folder;
  const std::filesystem::path path =
      folder.write("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl glass\nf 1 2 3\n");
  const std::string whole = "newmtl glass\nKd 0.5 0.25 1\nd 0.5\n";
  for (std::size_t size = 0; size <= whole.size(); ++size) {
    folder.write("a.mtl", whole.substr(0, size));
    const Result<Mesh> mesh = read_mesh(path);
    ASSERT_TRUE(mesh.ok()) << mesh.status().message;
    for (const glm::vec4& colour : mesh.value().facet_colours) {
      EXPECT_TRUE(glm::all(glm::greaterThanEqual(colour, glm::vec4(0))));
      EXPECT_TRUE(glm::all(glm::lessThanEqual(colour, glm::vec4(1))));
    }
  }
  folder.write("a.mtl", "Kd 1 0 0\nnewmtl glass\nKd nan 0 0\nd -5\nTr\nKd spectral file.rfl 1\nKd\n");
  EXPECT_EQ(read_mesh(path).value().facet_colours, std::vector<glm::vec4>(1, glm::vec4(1)));
}

TEST(DamagedOff, Lines) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, Fault fault, const std::string& message) {
    expect_fault(folder.write("a.off", text), fault, message);
  };
  const std::string body = three_vertices + "3 0 1 2\n";
  expect("PLY\n3 1 0\n" + body, Fault::unsupported_format, "no OFF file: it does not start with OFF");
  expect("4OFF\n3 1 0\n" + body, Fault::unsupported_format, "OFF of another dimension than 3");
  expect("nOFF\n3\n3 1 0\n" + body, Fault::unsupported_format, "OFF of another dimension than 3");
  expect("OFF BINARY\n", Fault::unsupported_format, "binary OFF");
  expect("# nothing\n", Fault::truncated, "truncated: no header");
  expect("OFF\n", Fault::truncated, "truncated: no counts of vertices and facets");
  expect("OFF\n3\n" + body, Fault::malformed, "line 2: no counts of vertices and facets");
  expect("OFF\n3 one 0\n" + body, Fault::malformed, "line 2: no counts of vertices and facets");
  expect("OFF\n3 -1 0\n" + body, Fault::malformed, "line 2: no counts of vertices and facets");
  expect("OFF\n3 2 0\n" + body, Fault::truncated, "truncated: 1 of 2 facets read");
  expect("OFF\n3 18446744073709551615 0\n" + body, Fault::truncated,
         "truncated: 1 of 18446744073709551615 facets read");
  expect("OFF\n9 1 0\n" + three_vertices, Fault::truncated, "truncated: 3 of 9 vertices read");
  expect("OFF\n2 1 0\n" + body, Fault::malformed, "line 5: facet 0 has 0 corners, fewer than 3");
  expect("OFF\n4 1 0\n" + body, Fault::malformed, "line 6: vertex 3 has 4 numbers");
  expect("OFF\n3 1 0\n" + body + "3 0 1 2\n", Fault::malformed, "line 7: the file goes on after its last facet");
  expect("OFF\n3 1 0\n0 0 x\n1 0 0\n0 1 0\n3 0 1 2\n", Fault::malformed,
         "vertex 0 has a coordinate that is not a number");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 z\n", Fault::malformed, "facet 0 has a corner that is not an index");
  expect("OFF\n3 1 0\n" + three_vertices + "x 0 1 2\n", Fault::malformed, "line 6: facet 0 has no count of corners");
  expect("OFF\n3 1 0\n" + three_vertices + "4 0 1 2\n", Fault::malformed, "line 6: facet 0 has 3 of 4 corners");
  expect("OFF\n3 1 0\n" + three_vertices + "2 0 1\n", Fault::malformed, "line 6: facet 0 has 2 corners, fewer than 3");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 -2\n", Fault::index_out_of_range, "facet 0 names vertex -2 of 3");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 2 1 1\n", Fault::malformed,
         "line 6: facet 0 has 2 words behind its corners");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 2 red 0 0\n", Fault::malformed,
         "line 6: a colour that is not a number or is negative");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 2 300 0 0\n", Fault::malformed,
         "colours of facets: number 0 is neither in 0 to 1 nor in whole numbers to 255");
  expect("OFF\n3 1 0\n" + three_vertices + "3 0 1 2 1.5 0 0\n", Fault::malformed,
         "colours of facets: number 0 is neither in 0 to 1 nor in whole numbers to 255");
}

TEST(DamagedStl, Structure) {
  const TemporaryFolder folder;
  const auto expect = [&](const std::string& text, Fault fault, const std::string& message) {
    expect_fault(folder.write("a.stl", text), fault, message);
  };
  const std::string loop = "outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\n",
                    facet = "facet normal 0 0 1\n" + loop + "endfacet\n";
  expect("liquid\n", Fault::malformed, "line 1: solid expected in facet 0");
  expect("solid\n" + facet, Fault::truncated, "truncated: no endsolid after line 8, 1 facets read");
  expect("solid\n" + facet + "vertex 0 0 0\nendsolid\n", Fault::malformed,
         "line 9: facet or endsolid expected in facet 1");
  expect("solid\nfacet normal 0 0 1\nvertex 0 0 0\n", Fault::malformed, "line 3: outer loop expected in facet 0");
  expect("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", Fault::malformed,
         "line 4: three numbers expected in facet 0");
  expect("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\nendsolid\n",
         Fault::malformed, "line 6: a third vertex expected in facet 0");
  expect("solid\nfacet normal 0 0 1\n" + loop + "endsolid\n", Fault::malformed, "line 8: endfacet expected in facet 1");
  expect(
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 zero 0\nvertex 0 0 0\nvertex 0 0 0\nendloop\nendfacet\n"
      "endsolid\n",
      Fault::malformed, "vertex 0 has a coordinate that is not a number");

  std::string binary = stl_binary(dirty_mesh());
  expect(binary.substr(0, binary.size() - 1), Fault::truncated, "truncated: 12 of 13 facets read");
  expect(binary + "12345", Fault::malformed, "5 bytes behind the last of 13 facets");
  binary[83] = '\x7f';
  expect(binary, Fault::truncated, "truncated: 13 of 2130706445 facets read");
  expect(binary.substr(0, 80) + std::string(1, '\0'), Fault::truncated, "truncated: no count of facets");
}

}  // namespace
}  // namespace facetsort
