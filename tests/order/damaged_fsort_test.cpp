// Files that are cut, spoiled or lying, and data that breaks its own rules: each gets one line that says what is wrong
// and where, and none is read beyond its end.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

#include "facetsort/order/presorted_mesh.h"
#include "order/fsort_bytes.h"
#include "order/presorted_samples.h"
#include "support/special_floats.h"

namespace facetsort {
namespace {

constexpr std::uint32_t top = std::numeric_limits<std::uint32_t>::max();

FileContent whole_file() {
  const PresortedData data = crossing_facets();
  const IndexBuffers buffers = two_buffers();
  return content_of(data.view(), &buffers);
}

Status status_of(const FileContent& content) {
  const Result<PresortedMesh> mesh = PresortedMesh::from_bytes(content);
  return mesh.ok() ? Status{} : mesh.status();
}

// What holds of any bytes: a presorted mesh of which everything can be read, or one line.
void expect_mesh_or_line(const FileContent& content) {
  const Result<PresortedMesh> mesh = PresortedMesh::from_bytes(content);
  if (!mesh.ok()) {
    EXPECT_NE(mesh.status().fault, Fault::none);
    EXPECT_FALSE(mesh.status().message.empty());
    EXPECT_EQ(mesh.status().message.find('\n'), std::string::npos);
    return;
  }
  const PresortedView& view = mesh.value().view();
  const std::size_t vertices = view.mesh.vertex_count() + view.made_vertices.size();
  for (const glm::uvec3& triangle : walked_triangles(view, {1, 2, 3, 1})) {
    EXPECT_TRUE(triangle.x < vertices && triangle.y < vertices && triangle.z < vertices);
  }
  // Written and read again, it is the same.
  const FileContent again = content_of(view, mesh.value().index_buffers());
  EXPECT_EQ(status_of(again).message, "");
}

TEST(DamagedFsort, CutAtEveryByte) {
  const FileContent whole = whole_file();
  ASSERT_TRUE(status_of(whole).ok());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const Status status = status_of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)});
    ASSERT_EQ(status.fault, Fault::truncated) << size << ": " << status.message;
  }
}

TEST(DamagedFsort, LongerThanItSays) {
  FileContent content = whole_file();
  content.push_back(std::byte{0});
  EXPECT_EQ(status_of(content).fault, Fault::malformed);
}

TEST(DamagedFsort, EveryFlippedBitIsFound) {
  FileContent content = whole_file();
  for (std::size_t bit = 0; bit < 8 * content.size(); ++bit) {
    content[bit / 8] ^= std::byte{1} << bit % 8;
    ASSERT_FALSE(status_of(content).ok()) << "bit " << bit;
    content[bit / 8] ^= std::byte{1} << bit % 8;
  }
}

TEST(DamagedFsort, FlippedBitsAreFoundWhereverTheyAre) {
  const FileContent whole = whole_file();
  std::mt19937 random(11);
  for (int round = 0; round < 3000; ++round) {
    FileContent content = whole;
    for (std::size_t flips = 2 + random() % 30; flips > 0; --flips) {
      const std::size_t bit = random() % (8 * content.size());
      content[bit / 8] ^= std::byte{1} << bit % 8;
    }
    ASSERT_TRUE(content == whole || !status_of(content).ok()) << "round " << round;
  }
}

// A hostile file has a checksum that fits.
TEST(HostileFsort, EveryFlippedBitGivesAMeshOrALine) {
  FileContent content = whole_file();
  for (std::size_t bit = 0; bit < 8 * content.size(); ++bit) {
    content[bit / 8] ^= std::byte{1} << bit % 8;
    mend_checksum(content);
    expect_mesh_or_line(content);
    content[bit / 8] ^= std::byte{1} << bit % 8;
  }
}

TEST(HostileFsort, ExtremeWordsGiveAMeshOrALine) {
  const FileContent whole = whole_file();
  for (std::size_t offset = 0; offset + 8 <= whole.size(); offset += 4) {
    for (const std::uint64_t word :
         {std::uint64_t{0}, std::uint64_t{1}, std::uint64_t{top}, std::uint64_t{top} - 1, std::uint64_t{1} << 31,
          std::uint64_t{1} << 63, ~std::uint64_t{0}, ~std::uint64_t{63}, ~std::uint64_t{0} / 12}) {
      FileContent content = whole;
      put(content, offset, word);
      mend_checksum(content);
      expect_mesh_or_line(content);
      content = whole;
      put(content, offset, static_cast<std::uint32_t>(word));
      mend_checksum(content);
      expect_mesh_or_line(content);
    }
  }
}

TEST(HostileFsort, RandomWordsGiveAMeshOrALine) {
  const FileContent whole = whole_file();
  std::mt19937 random(13);
  for (int round = 0; round < 20000; ++round) {
    FileContent content = whole;
    for (std::size_t words = 1 + random() % 4; words > 0; --words) {
      // Small numbers are often in range.
      const auto word = static_cast<std::uint32_t>(random() % 2 == 0 ? random() % 8 : random());
      put(content, random() % (content.size() / 4) * 4, word);
    }
    mend_checksum(content);
    expect_mesh_or_line(content);
  }
}

// --- header and table

struct FileFault {
  std::string name;
  std::function<void(FileContent&)> spoil;
  Fault fault;
  std::string message;
};

template <typename Value>
auto set(std::size_t offset, Value value) {
  return [=](FileContent& content) { put(content, offset, value); };
}

template <typename Value>
auto set_in(const std::string& section, std::size_t field, Value value) {
  return [=](FileContent& content) { put(content, entry_of(content, section) + field, value); };
}

// Of the first element.
template <typename Value>
auto set_element(const std::string& section, std::size_t field, Value value) {
  return [=](FileContent& content) {
    put(content, get<std::uint64_t>(content, entry_of(content, section) + offset_in_entry) + field, value);
  };
}

auto rename_section(const std::string& section, const std::string& name, std::uint32_t flags) {
  return [=](FileContent& content) {
    const std::size_t entry = entry_of(content, section);
    std::memcpy(&content[entry], name.data(), 4);
    put(content, entry + flags_in_entry, flags);
  };
}

TEST(DamagedFsort, EachFaultOfTheHeaderAndTheTableHasItsLine) {
  constexpr std::uint64_t near_end = ~std::uint64_t{63};
  const std::vector<FileFault> faults{
      {"magic", set<std::uint8_t>(0, 'x'), Fault::unsupported_format, "is no .fsort file"},
      {"text_mode", set<std::uint8_t>(6, '\n'), Fault::unsupported_format, "is no .fsort file"},
      {"version_0", set(version_offset, 0u), Fault::unsupported_format,
       "has version 0 of the format, only version 1 can be read"},
      {"version_2", set(version_offset, 2u), Fault::unsupported_format,
       "has version 2 of the format, only version 1 can be read"},
      {"size", set(file_size_offset, ~std::uint64_t{0}), Fault::truncated,
       "truncated: 1612 bytes, its header says 18446744073709551615"},
      {"reserved", set(reserved_offset, 1u), Fault::unsupported_format, "its header uses a reserved field"},
      {"sections", set(section_count_offset, top), Fault::malformed,
       "its header says 4294967295 sections, whose table is longer than the file"},
      {"flags", set_in("CUTS", flags_in_entry, 3u), Fault::unsupported_format,
       "section 9 has flags that are not known"},
      {"alignment", set_in("POSI", offset_in_entry, std::uint64_t{516}), Fault::malformed,
       "section 0 does not begin at a multiple of 64"},
      {"over_the_table", set_in("POSI", offset_in_entry, std::uint64_t{64}), Fault::malformed,
       "section 0 begins before the end of what stands before it"},
      {"over_another", set_in("FACE", offset_in_entry, std::uint64_t{512}), Fault::malformed,
       "section 1 begins before the end of what stands before it"},
      {"beyond_the_end", set_in("BOFD", offset_in_entry, near_end), Fault::malformed,
       "section 14 is not inside the file"},
      {"wraps_around", set_in("BOFD", size_in_entry, ~std::uint64_t{0}), Fault::malformed,
       "section 14 is not inside the file"},
      {"count", set_in("FACE", count_in_entry, std::uint64_t{4}), Fault::size_mismatch,
       "section 1 has 36 bytes for 4 elements of 12"},
      {"count_that_wraps_around", set_in("FACE", count_in_entry, (std::uint64_t{1} << 62) + 3), Fault::size_mismatch,
       "section 1 has 36 bytes for 4611686018427387907 elements of 12"},
      {"part_of_an_element", set_in("FACE", size_in_entry, std::uint64_t{35}), Fault::size_mismatch,
       "section 1 has 35 bytes for 3 elements of 12"},
      {"twice", rename_section("FCOL", "VCOL", 1), Fault::malformed, "section 3 is the second of its kind"},
      {"required", rename_section("BUFS", "WHAT", 1), Fault::unsupported_format,
       "section 11 is required and of a kind that is not known"},
      {"buffers_not_counted", rename_section("BUFS", "WHAT", 0), Fault::malformed,
       "index buffers: the section that counts them is missing"},
      {"culling", set_element("BUFS", 4, 2u), Fault::malformed,
       "index buffers: the section that counts them is not one element, or culling neither 0 nor 1"},
      {"buffer_count", set_element("BUFS", 0, top), Fault::size_mismatch,
       "4294967295 index buffers of 3 facets have 6 facets in all"},
  };
  for (const FileFault& fault : faults) {
    SCOPED_TRACE(fault.name);
    FileContent content = whole_file();
    fault.spoil(content);
    mend_checksum(content);
    const Status status = status_of(content);
    EXPECT_EQ(status.message, fault.message);
    EXPECT_EQ(status.fault, fault.fault);
  }
}

TEST(DamagedFsort, TheChecksumIsToldApart) {
  FileContent content = whole_file();
  content.back() ^= std::byte{1};
  EXPECT_EQ(status_of(content).message, "is damaged: its bytes do not give the checksum in its header");
}

TEST(Fsort, UnknownOptionalSectionsAreSkipped) {
  FileContent content = whole_file();
  for (const std::string section : {"BUFS", "BFAC", "BDIR", "BOFD"}) rename_section(section, "x" + section, 0)(content);
  mend_checksum(content);
  const Result<PresortedMesh> mesh = PresortedMesh::from_bytes(content);
  ASSERT_TRUE(mesh.ok()) << mesh.status().message;
  EXPECT_EQ(mesh.value().index_buffers(), nullptr);
  EXPECT_EQ(mesh.value().view().nodes.size(), 3u);
}

// --- data

struct DataFault {
  std::string name;
  std::function<void(PresortedData&, IndexBuffers&)> spoil;
  Fault fault;
  std::string message;
};

void expect_faults(const std::vector<DataFault>& faults) {
  for (const DataFault& fault : faults) {
    SCOPED_TRACE(fault.name);
    PresortedData data = crossing_facets();
    IndexBuffers buffers = two_buffers();
    fault.spoil(data, buffers);
    const Status status = validate_presorted(data.view(), &buffers);
    EXPECT_EQ(status.message, fault.message);
    EXPECT_EQ(status.fault, fault.fault);
    EXPECT_EQ(PresortedMesh::from_data(data, buffers).ok(), status.ok());
    std::ostringstream stream;
    EXPECT_EQ(write_presorted(stream, data.view(), &buffers).fault, fault.fault);
    EXPECT_EQ(stream.str().empty(), !status.ok());
  }
}

TEST(ValidatePresorted, EachFaultOfTheMeshHasItsLine) {
  expect_faults({
      {"facet", [](auto& d, auto&) { d.facets[1].z = 6; }, Fault::index_out_of_range, "facet 1 names vertex 6 of 6"},
      {"position", [](auto& d, auto&) { d.positions[5].y = nan; }, Fault::non_finite_position,
       "facet 1 uses vertex 5, whose position is not finite"},
      {"facet_colours", [](auto& d, auto&) { d.facet_colours.pop_back(); }, Fault::size_mismatch,
       "2 facet colours for 3 facets"},
      {"vertex_colours", [](auto& d, auto&) { d.vertex_colours.pop_back(); }, Fault::size_mismatch,
       "5 vertex colours for 6 vertices"},
      {"colours_without_facets", [](auto& d, auto&) { d.facets.clear(); }, Fault::size_mismatch,
       "3 facet colours and 6 vertex colours for 0 facets and 6 vertices"},
  });
}

TEST(ValidatePresorted, EachFaultOfTheTreeHasItsLine) {
  expect_faults({
      {"made_positions", [](auto& d, auto&) { d.made_positions.clear(); }, Fault::size_mismatch,
       "0 positions for 1 made vertices"},
      {"made_position", [](auto& d, auto&) { d.made_positions[0].z = -infinity; }, Fault::non_finite_position,
       "made vertex 0: its position is not finite"},
      {"made_facet", [](auto& d, auto&) { d.made_vertices[0].facet = 3; }, Fault::index_out_of_range,
       "made vertex 0 is in facet 3 of 3"},
      {"barycentric", [](auto& d, auto&) { d.made_vertices[0].barycentric.y = nan; }, Fault::malformed,
       "made vertex 0: its barycentric coordinates are not finite"},
      {"root", [](auto& d, auto&) { d.nodes[0].back_nodes = 0; }, Fault::malformed,
       "node 0, the root, counts 2 nodes of 3"},
      {"root_that_wraps_around", [](auto& d, auto&) { d.nodes[0].front_nodes = top, d.nodes[0].back_nodes = 3; },
       Fault::malformed, "node 0, the root, counts 4294967299 nodes of 3"},
      {"child", [](auto& d, auto&) { d.nodes[1].back_nodes = 1; }, Fault::malformed,
       "node 0: the nodes on its sides are not those that it counts"},
      {"children", [](auto& d, auto&) { d.nodes[0].front_nodes = 2, d.nodes[0].back_nodes = 0; }, Fault::malformed,
       "node 0: the nodes on its sides are not those that it counts"},
      {"grandchild",
       [](auto& d, auto&) {
         d.nodes[0].front_nodes = 2, d.nodes[0].back_nodes = 0, d.nodes[1].front_nodes = 1, d.nodes[2].back_nodes = top;
       },
       Fault::malformed, "node 1: the nodes on its sides are not those that it counts"},
      {"plane", [](auto& d, auto&) { d.nodes[2].plane.y = 6; }, Fault::index_out_of_range,
       "node 2 names a vertex that is not among the mesh's 6, or whose position is not finite"},
      {"plane_twice", [](auto& d, auto&) { d.nodes[2].plane.y = 3; }, Fault::malformed,
       "node 2: its plane names a vertex twice"},
      {"piece_facet", [](auto& d, auto&) { d.pieces[3].facet = 3; }, Fault::index_out_of_range,
       "piece 3 is of facet 3 of 3"},
      {"no_triangle", [](auto& d, auto&) { d.pieces[1].triangle_count = 0; }, Fault::malformed,
       "piece 1 has no triangle"},
      {"pieces_in_nodes", [](auto& d, auto&) { d.nodes[1].piece_count = 3; }, Fault::size_mismatch,
       "nodes count 5 pieces of 4"},
      {"triangles", [](auto& d, auto&) { d.pieces[2].triangle_count = top; }, Fault::size_mismatch,
       "pieces count 4294967298 triangles of 4"},
      {"cuts", [](auto& d, auto&) { d.cuts.pop_back(); }, Fault::size_mismatch, "pieces count 3 cuts of 2"},
      {"uncovered", [](auto& d, auto&) { d.pieces[0].facet = 1; }, Fault::malformed, "facet 2 has no piece"},
      {"no_pieces",
       [](auto& d, auto&) {
         d.pieces.clear(), d.triangles.clear(), d.cuts.clear();
         for (PresortedNode& node : d.nodes) node.piece_count = 0;
       },
       Fault::malformed, "facet 0 has no piece"},
      {"triangle", [](auto& d, auto&) { d.triangles[3].x = 7; }, Fault::index_out_of_range,
       "triangle 3 names a vertex that is not among the 6 and 1 made, or whose position is not finite"},
      {"triangle_top", [](auto& d, auto&) { d.triangles[1].z = top; }, Fault::index_out_of_range,
       "triangle 1 names a vertex that is not among the 6 and 1 made, or whose position is not finite"},
      {"cut_plane", [](auto& d, auto&) { d.cuts[1].plane = 5; }, Fault::index_out_of_range,
       "cut 1 is along plane 5 of 5"},
      {"side", [](auto& d, auto&) { d.cuts[2].side = 0; }, Fault::malformed, "cut 2: its side is 0, neither 1 nor -1"},
      {"plane_vertex", [](auto& d, auto&) { d.planes[0].third = 6; }, Fault::index_out_of_range,
       "plane 3 names a vertex or a facet that is not there, or a vertex whose position is not finite"},
      {"join_end", [](auto& d, auto&) { d.planes[1].edge_end = 6; }, Fault::index_out_of_range,
       "plane 4 names a vertex or a facet that is not there, or a vertex whose position is not finite"},
      {"join_facet", [](auto& d, auto&) { d.planes[1].facet = 3; }, Fault::index_out_of_range,
       "plane 4 names a vertex or a facet that is not there, or a vertex whose position is not finite"},
      {"facet_without_a_join", [](auto& d, auto&) { d.planes[0].facet = 0; }, Fault::index_out_of_range,
       "plane 3 names a vertex or a facet that is not there, or a vertex whose position is not finite"},
  });
}

// Vertices that no facet uses may be anywhere, but then nothing else may use them either.
TEST(ValidatePresorted, TheTreeUsesNoVertexThatIsNowhere) {
  const auto with_infinite_vertex = [](const auto& use) {
    return [use](PresortedData& d, IndexBuffers&) {
      d.positions.emplace_back(infinity);
      d.vertex_colours.clear();
      for (glm::uvec3& triangle : d.triangles) {
        for (int i = 0; i < 3; ++i) triangle[i] += triangle[i] == 6 ? 1 : 0;
      }
      use(d);
    };
  };
  expect_faults({
      {"none", with_infinite_vertex([](auto&) {}), Fault::none, ""},
      {"node", with_infinite_vertex([](auto& d) { d.nodes[1].plane.x = 6; }), Fault::index_out_of_range,
       "node 1 names a vertex that is not among the mesh's 7, or whose position is not finite"},
      {"triangle", with_infinite_vertex([](auto& d) { d.triangles[2].x = 6; }), Fault::index_out_of_range,
       "triangle 2 names a vertex that is not among the 7 and 1 made, or whose position is not finite"},
      {"plane", with_infinite_vertex([](auto& d) { d.planes[1].edge_end = 6; }), Fault::index_out_of_range,
       "plane 4 names a vertex or a facet that is not there, or a vertex whose position is not finite"},
  });
}

TEST(ValidatePresorted, EachFaultOfTheIndexBuffersHasItsLine) {
  expect_faults({
      {"facets", [](auto&, auto& b) { b.facets.pop_back(); }, Fault::size_mismatch,
       "2 index buffers of 3 facets have 5 facets in all"},
      {"no_permutation", [](auto&, auto& b) { b.facets[4] = 2; }, Fault::malformed, "buffer 1 has facet 2 twice"},
      {"facet", [](auto&, auto& b) { b.facets[1] = 3; }, Fault::index_out_of_range, "buffer 0 has facet 3 of 3"},
      {"no_directions", [](auto&, auto& b) { b.directions.clear(), b.buffer_of_direction.clear(); },
       Fault::size_mismatch, "index buffers: 0 choices for 0 directions"},
      {"directions", [](auto&, auto& b) { b.directions.pop_back(); }, Fault::size_mismatch,
       "index buffers: 3 choices for 2 directions"},
      {"length", [](auto&, auto& b) { b.directions[1] *= 1.01f; }, Fault::malformed, "direction 1 is no unit vector"},
      {"nan", [](auto&, auto& b) { b.directions[2].x = nan; }, Fault::malformed, "direction 2 is no unit vector"},
      {"buffer", [](auto&, auto& b) { b.buffer_of_direction[0] = 2; }, Fault::index_out_of_range,
       "direction 0 takes buffer 2 of 2"},
      {"mean", [](auto&, auto& b) { b.mean_inverted_rate = nan; }, Fault::malformed,
       "index buffers: a rate of inverted pixels is not in 0 to 1"},
      {"worst", [](auto&, auto& b) { b.worst_inverted_rate = 1.5; }, Fault::malformed,
       "index buffers: a rate of inverted pixels is not in 0 to 1"},
  });
}

// In a mesh so large that blocks of it are judged apart, the first fault is told whichever is found first.
TEST(ValidatePresorted, TheFirstOfManyFaultsIsTold) {
  PresortedData data = stacked_facets(100000, TreeShape::balanced);
  for (const std::size_t piece : {40001, 70000, 99999}) data.pieces[piece].facet = top;
  EXPECT_EQ(validate_presorted(data.view()).message, "piece 40001 is of facet 4294967295 of 100000");
}

}  // namespace
}  // namespace facetsort
