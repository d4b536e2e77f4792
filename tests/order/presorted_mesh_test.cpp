#include "facetsort/order/presorted_mesh.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <limits>
#include <thread>

#include "mesh/temporary_folder.h"
#include "order/fsort_bytes.h"
#include "order/presorted_samples.h"
#include "support/permission.h"
#include "support/threads.h"

namespace facetsort {
namespace {

template <typename Element>
void expect_equal(std::span<const Element> a, std::span<const Element> b) {
  ASSERT_EQ(a.size(), b.size());
  const auto a_bytes = std::as_bytes(a), b_bytes = std::as_bytes(b);
  EXPECT_TRUE(std::equal(a_bytes.begin(), a_bytes.end(), b_bytes.begin()));
}

void expect_equal(const PresortedView& a, const PresortedView& b) {
  expect_equal(a.mesh.positions, b.mesh.positions);
  expect_equal(a.mesh.triangles, b.mesh.triangles);
  expect_equal(a.mesh.facet_colours, b.mesh.facet_colours);
  expect_equal(a.mesh.vertex_colours, b.mesh.vertex_colours);
  expect_equal(a.made_vertices, b.made_vertices);
  expect_equal(a.made_positions, b.made_positions);
  expect_equal(a.nodes, b.nodes);
  expect_equal(a.pieces, b.pieces);
  expect_equal(a.triangles, b.triangles);
  expect_equal(a.cuts, b.cuts);
  expect_equal(a.planes, b.planes);
}

void expect_equal(const IndexBuffers* a, const IndexBuffers* b) {
  ASSERT_EQ(a == nullptr, b == nullptr);
  if (a == nullptr) return;
  EXPECT_EQ(a->buffer_count, b->buffer_count);
  EXPECT_EQ(a->facets, b->facets);
  EXPECT_EQ(a->directions, b->directions);
  EXPECT_EQ(a->buffer_of_direction, b->buffer_of_direction);
  EXPECT_EQ(a->needs_culling, b->needs_culling);
  EXPECT_EQ(a->mean_inverted_rate, b->mean_inverted_rate);
  EXPECT_EQ(a->worst_inverted_rate, b->worst_inverted_rate);
}

struct Sample {
  std::string name;
  PresortedData data;
  std::optional<IndexBuffers> buffers;
};

// The mesh of a sample without its tree.
PresortedData mesh_alone(const PresortedData& data) {
  PresortedData mesh;
  mesh.positions = data.positions;
  mesh.facets = data.facets;
  return mesh;
}

std::vector<Sample> samples() {
  PresortedData nan_where_no_facet_is = crossing_facets();
  nan_where_no_facet_is.positions.push_back(glm::vec3(std::numeric_limits<float>::quiet_NaN()));
  nan_where_no_facet_is.vertex_colours.emplace_back(1);
  nan_where_no_facet_is.triangles[2].x = nan_where_no_facet_is.triangles[3].y = 7;
  PresortedData free_plane = stacked_facets(3, TreeShape::balanced);
  free_plane.nodes = {{{0, 1, 5}, 0, 1, 1}, {{6, 7, 8}, 1, 0, 0}, {{3, 4, 5}, 2, 0, 0}};
  PresortedData no_facet;
  no_facet.positions.emplace_back(1.0f);
  no_facet.vertex_colours.emplace_back(1.0f);
  return {{"empty", {}, {}},
          {"no_facet", no_facet, {}},
          {"one_facet", stacked_facets(1, TreeShape::balanced), {}},
          {"one_facet_with_buffers", stacked_facets(1, TreeShape::balanced), rotated_buffers(1, 1)},
          {"no_tree", mesh_alone(crossing_facets()), {}},
          {"buffers_alone", mesh_alone(crossing_facets()), two_buffers()},
          {"crossing", crossing_facets(), {}},
          {"crossing_with_buffers", crossing_facets(), two_buffers()},
          {"unused_vertex", nan_where_no_facet_is, {}},
          {"free_plane", free_plane, {}},
          {"large", stacked_facets(50000, TreeShape::balanced), rotated_buffers(50000, 3)}};
}

TEST(PresortedMesh, RoundTripIsBitEqual) {
  const TemporaryFolder folder;
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    const PresortedView view = sample.data.view();
    const IndexBuffers* const buffers = sample.buffers ? &*sample.buffers : nullptr;
    const FileContent content = content_of(view, buffers);
    EXPECT_EQ(fsort_file_size(view, buffers), content.size());
    const std::filesystem::path path = folder.path() / (sample.name + ".fsort");
    const Status written = write_presorted(path, view, buffers);
    ASSERT_TRUE(written.ok()) << written.message;
    EXPECT_EQ(content_of(path), content);
    for (const auto& mesh : {PresortedMesh::from_bytes(content), PresortedMesh::open(path),
                             PresortedMesh::from_data(sample.data, sample.buffers)}) {
      ASSERT_TRUE(mesh.ok()) << mesh.status().message;
      expect_equal(mesh.value().view(), view);
      expect_equal(mesh.value().index_buffers(), buffers);
      EXPECT_EQ(content_of(mesh.value().view(), mesh.value().index_buffers()), content);
    }
  }
}

TEST(PresortedMesh, SectionsBeginAtCacheLines) {
  const PresortedData data = crossing_facets();
  const IndexBuffers buffers = two_buffers();
  const FileContent content = content_of(data.view(), &buffers);
  const std::size_t count = get<std::uint32_t>(content, section_count_offset);
  EXPECT_EQ(count, 15u);
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(get<std::uint64_t>(content, table_offset + i * entry_size + offset_in_entry) % 64, 0u);
  }
}

TEST(PresortedMesh, BytesAreTheSameForAnyThreadCount) {
  const PresortedData data = stacked_facets(100000, TreeShape::balanced);
  const FileContent one = with_threads(1, [&] { return content_of(data.view()); });
  for (const int threads : {2, 3, 8}) {
    EXPECT_TRUE(with_threads(threads, [&] { return content_of(data.view()); }) == one) << threads;
  }
}

TEST(PresortedMesh, IsReadWhereItLies) {
  const TemporaryFolder folder;
  const PresortedData data = stacked_facets(100000, TreeShape::balanced);
  ASSERT_TRUE(write_presorted(folder.path() / "stack.fsort", data.view()).ok());
  const Result<PresortedMesh> mesh = PresortedMesh::open(folder.path() / "stack.fsort");
  ASSERT_TRUE(mesh.ok());
  // In one block in the order of the file: no array was copied.
  const PresortedView& view = mesh.value().view();
  EXPECT_LT(static_cast<const void*>(view.mesh.positions.data()), static_cast<const void*>(view.nodes.data()));
  const auto distance = reinterpret_cast<const std::byte*>(&view.triangles.back() + 1) -
                        reinterpret_cast<const std::byte*>(view.mesh.positions.data());
  EXPECT_LE(static_cast<std::size_t>(distance), content_of(folder.path() / "stack.fsort").size());
}

TEST(PresortedMesh, CopiesKeepWhatTheyShare) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.fsort";
  const PresortedData data = crossing_facets();
  const IndexBuffers buffers = two_buffers();
  ASSERT_TRUE(write_presorted(path, data.view(), &buffers).ok());
  std::optional<PresortedMesh> copy;
  {
    const Result<PresortedMesh> mesh = PresortedMesh::open(path);
    ASSERT_TRUE(mesh.ok());
    copy = mesh.value();
    EXPECT_EQ(copy->view().nodes.data(), mesh.value().view().nodes.data());
    EXPECT_EQ(copy->index_buffers(), mesh.value().index_buffers());
  }
  // The file that it came from may be replaced, or go.
  const PresortedData other = stacked_facets(2, TreeShape::balanced);
  ASSERT_TRUE(write_presorted(path, other.view()).ok());
  expect_equal(copy->view(), data.view());
  std::filesystem::remove(path);
  expect_equal(copy->view(), data.view());
  expect_equal(copy->index_buffers(), &buffers);
}

TEST(PresortedMesh, IsReadBySeveralThreads) {
  const PresortedData data = stacked_facets(1000, TreeShape::balanced);
  const Result<PresortedMesh> mesh = PresortedMesh::from_data(data);
  ASSERT_TRUE(mesh.ok());
  const auto expected = walked_triangles(data.view(), {0, 0, 500.5, 1});
  std::atomic<int> equal = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&equal, &expected, mine = mesh.value()] {
      equal += walked_triangles(mine.view(), {0, 0, 500.5, 1}) == expected;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(equal, 4);
}

TEST(PresortedMesh, AMillionNodesInOneChain) {
  const PresortedData data = stacked_facets(1000000, TreeShape::chain);
  const Result<PresortedMesh> mesh = PresortedMesh::from_bytes(content_of(data.view()));
  ASSERT_TRUE(mesh.ok()) << mesh.status().message;
  expect_equal(mesh.value().view(), data.view());
  const auto from_above = walked_triangles(mesh.value().view(), {0, 0, 1, 0});
  EXPECT_EQ(from_above, data.facets);
}

// Every eye is in such a plane: what order it gives is of no use, but it is an order.
TEST(PresortedMesh, PlanesThroughALineDoNoHarm) {
  PresortedData data = stacked_facets(7, TreeShape::balanced);
  for (glm::vec3& position : data.positions) position.y = 0;
  const Result<PresortedMesh> mesh = PresortedMesh::from_data(data);
  ASSERT_TRUE(mesh.ok()) << mesh.status().message;
  for (const glm::dvec4 eye : {glm::dvec4(0, 0, 1, 0), glm::dvec4(5, 6, 7, 1), glm::dvec4(0, 0, 3, 1)}) {
    std::vector<glm::uvec3> walked = walked_triangles(mesh.value().view(), eye);
    std::sort(walked.begin(), walked.end(), [](const glm::uvec3& a, const glm::uvec3& b) { return a.x < b.x; });
    EXPECT_EQ(walked, data.facets);
  }
}

void expect_no_file(const std::filesystem::path& path, Fault fault, const std::string& what) {
  const Result<PresortedMesh> mesh = PresortedMesh::open(path);
  ASSERT_FALSE(mesh.ok());
  EXPECT_EQ(mesh.status().fault, fault);
  EXPECT_EQ(mesh.status().message, path.string() + ": " + what);
}

TEST(PresortedMesh, WhatIsNoRegularFile) {
  const TemporaryFolder folder;
  expect_no_file(folder.path(), Fault::cannot_read, "is a directory");
  expect_no_file(folder.path() / "none.fsort", Fault::cannot_read, "cannot be opened: No such file or directory");
  ASSERT_EQ(mkfifo((folder.path() / "pipe.fsort").c_str(), 0600), 0);
  expect_no_file(folder.path() / "pipe.fsort", Fault::cannot_read, "is not a regular file");
  expect_no_file(folder.write("empty.fsort", ""), Fault::truncated, "truncated: 0 bytes, the header alone has 32");
  expect_no_file(folder.write("mesh.fsort", "ply\nformat ascii 1.0\n"), Fault::unsupported_format, "is no .fsort file");
}

TEST(PresortedMesh, NoPermission) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("secret.fsort", "");
  expect_refused_without_permission(folder, path, [](const std::filesystem::path& file) {
    const Result<PresortedMesh> mesh = PresortedMesh::open(file);
    return !mesh.ok() && mesh.status().fault == Fault::cannot_read &&
           mesh.status().message == file.string() + ": cannot be opened: Permission denied";
  });
}

std::size_t file_count(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(WritePresorted, SaysWhereItCannotWrite) {
  const TemporaryFolder folder;
  const PresortedData data = crossing_facets();
  const std::filesystem::path missing = folder.path() / "none" / "a.fsort";
  Status status = write_presorted(missing, data.view());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, missing.string() + ": cannot be written: No such file or directory");
  status = write_presorted(folder.path(), data.view());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, folder.path().string() + ": is a directory");
  std::ostringstream closed;
  closed.setstate(std::ios::badbit);
  EXPECT_EQ(write_presorted(closed, data.view()).fault, Fault::cannot_write);
}

TEST(WritePresorted, AFailureLeavesTheOldFileAndNothingElse) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.fsort";
  const PresortedData data = crossing_facets();
  ASSERT_TRUE(write_presorted(path, data.view()).ok());
  const FileContent old = content_of(path);
  PresortedData wrong = data;
  wrong.nodes[0].front_nodes = 7;
  Status status = write_presorted(path, wrong.view());
  EXPECT_EQ(status.fault, Fault::malformed);
  EXPECT_EQ(status.message, path.string() + ": node 0, the root, counts 9 nodes of 3");
  EXPECT_EQ(content_of(path), old);

  // The system refuses to write beyond this size, as it does on a full disk.
  const PresortedData large = stacked_facets(1000, TreeShape::balanced);
  rlimit unlimited{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &unlimited), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit limited{1000, unlimited.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limited), 0);
  status = write_presorted(path, large.view());
  setrlimit(RLIMIT_FSIZE, &unlimited);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, path.string() + ": cannot be written: File too large");
  EXPECT_EQ(content_of(path), old);
  EXPECT_EQ(file_count(folder.path()), 1u);
}

}  // namespace
}  // namespace facetsort
