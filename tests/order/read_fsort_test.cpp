// FSORT.md suffices to read a .fsort file: a reader written from it, in another language, gives the same orders.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <string>

#include "facetsort/facets/facets.h"
#include "facetsort/order/presorted_mesh.h"
#include "mesh/temporary_folder.h"
#include "order/presorted_samples.h"

namespace facetsort {
namespace {

const std::vector<glm::vec4> eyes{{0, 0, 9, 1},  {0, 0, -9, 1},          {3, 1, 0.5f, 1}, {-3, 1, 0.5f, 1},
                                  {1, 2, 0, 1},  {0, 0, 1, 0},           {0, 0, -1, 0},   {1, 0.25f, -2, 0},
                                  {-1, 1, 0, 0}, {0.25f, 0.25f, 4.5f, 1}};

bool has_python() {
  return std::system("python3 -c 'import zlib' > /dev/null 2>&1") == 0;
}

// Throws where the program fails.
std::string output_of(const std::string& order, const std::filesystem::path& file, const glm::vec4& eye) {
  std::ostringstream command;
  command << "python3 '" << FACETSORT_SOURCE_DIR << "/tests/order/read_fsort.py' " << order << " '" << file.string()
          << "' " << eye.x << ' ' << eye.y << ' ' << eye.z << ' ' << eye.w << " 2>&1";
  FILE* const pipe = popen(command.str().c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("can't run " + command.str());
  std::string output;
  for (int c; (c = std::fgetc(pipe)) != EOF;) output.push_back(static_cast<char>(c));
  const int status = pclose(pipe);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error(command.str() + ": " + output);
  return output;
}

std::string lines_of(std::span<const glm::uvec3> triangles) {
  std::ostringstream lines;
  for (const glm::uvec3& t : triangles) lines << t.x << ' ' << t.y << ' ' << t.z << '\n';
  return lines.str();
}

// The way that presorted_data.h puts it.
std::string lines_of_buffer(const PresortedMesh& mesh, const glm::vec4& eye) {
  const IndexBuffers& buffers = *mesh.index_buffers();
  const glm::vec3 direction = glm::vec3(eye) - facet_bounds(mesh.view().mesh).centre() * eye.w;
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < buffers.directions.size(); ++i) {
    if (glm::dot(buffers.directions[i], direction) > glm::dot(buffers.directions[nearest], direction)) nearest = i;
  }
  const std::size_t facets = mesh.view().mesh.facet_count();
  std::ostringstream lines;
  for (std::size_t i = 0; i < facets; ++i) {
    lines << buffers.facets[buffers.buffer_of_direction[nearest] * facets + i] << '\n';
  }
  return lines.str();
}

TEST(ReadFsort, FarSidesComeFirst) {
  const PresortedData data = crossing_facets();
  EXPECT_EQ(lines_of(walked_triangles(data.view(), {3, 1, 0.5, 1})), "0 1 1\n3 6 5\n0 1 2\n6 4 5\n");
  EXPECT_EQ(lines_of(walked_triangles(data.view(), {3, 1, -0.5, 0})), "0 1 1\n6 4 5\n0 1 2\n3 6 5\n");
}

TEST(ReadFsort, AnotherReaderWalksTheSameTree) {
  if (!has_python()) GTEST_SKIP() << "python3 is not here";
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.fsort";
  for (const PresortedData& data :
       {crossing_facets(), stacked_facets(9, TreeShape::balanced), stacked_facets(9, TreeShape::chain)}) {
    ASSERT_TRUE(write_presorted(path, data.view()).ok());
    const Result<PresortedMesh> mesh = PresortedMesh::open(path);
    ASSERT_TRUE(mesh.ok());
    for (const glm::vec4& eye : eyes) {
      EXPECT_EQ(output_of("tree", path, eye), lines_of(walked_triangles(mesh.value().view(), eye)));
    }
  }
}

TEST(ReadFsort, AnotherReaderTakesTheSameIndexBuffer) {
  if (!has_python()) GTEST_SKIP() << "python3 is not here";
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / "a.fsort";
  const PresortedData data = crossing_facets();
  const IndexBuffers buffers = two_buffers();
  ASSERT_TRUE(write_presorted(path, data.view(), &buffers).ok());
  const Result<PresortedMesh> mesh = PresortedMesh::open(path);
  ASSERT_TRUE(mesh.ok());
  for (const glm::vec4& eye : eyes) EXPECT_EQ(output_of("buffer", path, eye), lines_of_buffer(mesh.value(), eye));
}

}  // namespace
}  // namespace facetsort
