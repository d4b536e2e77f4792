#include "facetsort/mesh/write.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <bit>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

#include "facetsort/mesh/read.h"
#include "mesh/encode.h"
#include "mesh/temporary_folder.h"
#include "support/mesh_files.h"

namespace facetsort {
namespace {

// To the bit: -0 is not 0.
template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_bits(const Mesh& a, const Mesh& b) {
  EXPECT_TRUE(same_bits(a.positions, b.positions));
  EXPECT_TRUE(same_bits(a.triangles, b.triangles));
  EXPECT_TRUE(same_bits(a.facet_colours, b.facet_colours));
  EXPECT_TRUE(same_bits(a.vertex_colours, b.vertex_colours));
}

std::vector<glm::vec4> random_colours(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<glm::vec4> colours(count);
  for (glm::vec4& colour : colours) {
    for (int c = 0; c < 4; ++c) colour[c] = static_cast<float>(random() % 256) / 255.0f;
  }
  return colours;
}

std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(WritePly, ReadAgainIsIdenticalToTheBit) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "out.ply";
  Mesh mesh = dirty_mesh();
  mesh.positions.emplace_back(std::bit_cast<float>(1u), -std::numeric_limits<float>::max(), 1.0000001f);
  for (const bool vertex_colours : {false, true}) {
    for (const bool facet_colours : {false, true}) {
      mesh.vertex_colours = random_colours(vertex_colours ? mesh.positions.size() : 0, 1);
      mesh.facet_colours = random_colours(facet_colours ? mesh.triangles.size() : 0, 2);
      ASSERT_EQ(write_ply(path, mesh.view()).message, "");
      const Result<Mesh> again = read_mesh(path);
      ASSERT_TRUE(again.ok()) << again.status().message;
      expect_same_bits(again.value(), mesh);
    }
  }
  EXPECT_EQ(files_in(folder.path()), 1u) << "a temporary file is left";
}

TEST(WritePly, EveryColourOf8BitsSurvives) {
  const TemporaryFolder folder;
  Mesh mesh;
  for (int n = 0; n < 256; ++n) {
    mesh.positions.emplace_back(n, n * n, 1);
    mesh.vertex_colours.push_back(glm::vec4(static_cast<float>(n) / 255.0f));
  }
  mesh.triangles = {{0, 1, 2}};
  ASSERT_TRUE(write_ply(folder.path() / "out.ply", mesh.view()).ok());
  expect_same_bits(read_mesh(folder.path() / "out.ply").value(), mesh);
}

TEST(WritePly, OtherColoursGoToTheNearest) {
  const TemporaryFolder folder;
  Mesh mesh = dirty_mesh();
  mesh.facet_colours.assign(mesh.triangles.size(), glm::vec4(-1, 2, 0.5f, std::numeric_limits<float>::quiet_NaN()));
  ASSERT_TRUE(write_ply(folder.path() / "out.ply", mesh.view()).ok());
  EXPECT_EQ(read_mesh(folder.path() / "out.ply").value().facet_colours[3], glm::vec4(0, 1, 128 / 255.0f, 0));
}

TEST(WritePly, SourceComesBack) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "out.ply";
  Mesh mesh = dirty_mesh();
  std::vector<std::uint32_t> source;
  for (std::uint32_t f = 0; f < mesh.triangles.size(); ++f) source.push_back(4294967294u - 7 * f);
  for (const bool coloured : {false, true}) {
    mesh.facet_colours = random_colours(coloured ? mesh.triangles.size() : 0, 3);
    ASSERT_TRUE(write_ply(path, mesh.view(), source).ok());
    const auto again = read_ply_source(path);
    ASSERT_TRUE(again.ok()) << again.status().message;
    EXPECT_EQ(again.value(), source);
    expect_same_bits(read_mesh(path).value(), mesh);
  }
  ASSERT_TRUE(write_ply(path, mesh.view()).ok());
  EXPECT_TRUE(read_ply_source(path).value().empty());
}

TEST(WritePly, EveryMeshOfTheCorpusSurvives) {
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> files = mesh_files();
  ASSERT_FALSE(files.empty());
  for (const std::filesystem::path& file : files) {
    SCOPED_TRACE(file.string());
    const Result<Mesh> mesh = read_mesh(file);
    ASSERT_TRUE(mesh.ok()) << mesh.status().message;
    ASSERT_TRUE(write_ply(folder.path() / "out.ply", mesh.value().view()).ok());
    expect_same_bits(read_mesh(folder.path() / "out.ply").value(), mesh.value());
  }
}

TEST(WritePly, RefusesSourcesThatDoNotFit) {
  const TemporaryFolder folder;
  const std::vector<std::uint32_t> source(3);
  const Status status = write_ply(folder.path() / "out.ply", dirty_mesh().view(), source);
  EXPECT_EQ(status.fault, Fault::bad_argument);
  EXPECT_EQ(files_in(folder.path()), 0u);
}

TEST(WritePly, ReportsWhatCannotBeWritten) {
  const TemporaryFolder folder;
  const Mesh mesh = dirty_mesh();
  const std::filesystem::path missing = folder.path() / "nowhere" / "out.ply";
  Status status = write_ply(missing, mesh.view());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, missing.string() + ": cannot be written: No such file or directory");

  status = write_ply(folder.path(), mesh.view());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, folder.path().string() + ": is a directory");

  status = write_ply("/dev/null", mesh.view());
  EXPECT_EQ(status.fault, Fault::cannot_write);
  EXPECT_EQ(status.message, "/dev/null: is not a regular file");
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

TEST(WritePly, ALinkStaysALink) {
  const TemporaryFolder folder;
  const std::filesystem::path target = folder.write("target.ply", "old"), link = folder.path() / "link.ply";
  std::filesystem::create_symlink("target.ply", link);
  ASSERT_TRUE(write_ply(link, dirty_mesh().view()).ok());
  EXPECT_TRUE(std::filesystem::is_symlink(link));
  EXPECT_TRUE(read_mesh(target).ok());
}

// Runs in a child whose files may not grow beyond 4 KiB, as on a full disk.
TEST(WritePly, AFullDiskLeavesTheOldFile) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.write("out.ply", "old");
  Mesh mesh;
  mesh.positions.resize(100000, glm::vec3(1));
  mesh.triangles = {{0, 1, 2}};
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};
    if (setrlimit(RLIMIT_FSIZE, &limit) != 0) _exit(2);
    const Status status = write_ply(path, mesh.view());
    _exit(status.fault == Fault::cannot_write && !status.message.empty() ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(read_file(path), "old");
  EXPECT_EQ(files_in(folder.path()), 1u) << "a temporary file is left";
}

}  // namespace
}  // namespace facetsort
