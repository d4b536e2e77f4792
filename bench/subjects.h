// What benchmarks run on (meshes, views and thread counts) and what they compare their results by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "facetsort/blend/fragment_lists.h"
#include "facetsort/blend/image.h"
#include "facetsort/blend/view.h"
#include "facetsort/mesh/mesh.h"

namespace facetsort::bench {

// A mesh by name, read or made when it is first asked for. Copies share it.
class Subject {
 public:
  Subject(std::string name, std::function<Mesh()> make);

  const std::string& name() const { return name_; }
  const Mesh& mesh() const;

 private:
  struct Lazy {
    std::function<Mesh()> make;
    std::optional<Mesh> made;
  };
  std::string name_;
  std::shared_ptr<Lazy> lazy_;
};

// Torus knots, each about ten times as large as the one before.
std::vector<Subject> knots(std::size_t fewest_facets, std::size_t most_facets);
// Those of meshes/ and of the folders in FACETSORT_MESH_PATH, by name.
std::vector<Subject> shipped_meshes();

// Eyes on a Fibonacci sphere at 2.5 bounding radii: a frame takes the next, so that no frame sorts what is sorted.
std::vector<View> frames_around(const Mesh& mesh, int size);

// One thread, and all that the machine has where that is more.
std::vector<int> thread_counts();
// A thread count that what was computed with `threads` is computed with again: the results must be equal.
int other_thread_count(int threads);

// Of the bits of every channel; of every fragment of every pixel.
std::uint64_t checksum(const Image& image);
std::uint64_t checksum(const FragmentLists& lists);

}  // namespace facetsort::bench
