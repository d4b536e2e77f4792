#include "subjects.h"

#include <tbb/info.h>

#include <algorithm>
#include <bit>
#include <filesystem>
#include <utility>

#include "facetsort/facets/facets.h"
#include "shapes.h"
#include "support/mesh_files.h"

namespace facetsort::bench {
namespace {

// FNV-1a, a 64-bit word at a time (Fowler, Noll and Vo, 1991).
class Checksum {
 public:
  void add(std::uint64_t word) { hash_ = (hash_ ^ word) * 0x100000001b3u; }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

}  // namespace

Subject::Subject(std::string name, std::function<Mesh()> make)
    : name_(std::move(name)), lazy_(std::make_shared<Lazy>(Lazy{std::move(make), std::nullopt})) {}

const Mesh& Subject::mesh() const {
  if (!lazy_->made) lazy_->made = lazy_->make();
  return *lazy_->made;
}

std::vector<Subject> knots(std::size_t fewest_facets, std::size_t most_facets) {
  std::vector<Subject> subjects;
  for (std::size_t facets = fewest_facets; facets <= most_facets; facets *= 10) {
    subjects.emplace_back("knot_" + std::to_string(facets), [facets] { return shapes::torus_knot(facets); });
  }
  return subjects;
}

std::vector<Subject> shipped_meshes() {
  std::vector<Subject> subjects;
  for (const std::filesystem::path& file : mesh_files()) {
    const std::string name = file.stem().string();
    subjects.emplace_back(name, [name] { return load(name); });
  }
  return subjects;
}

std::vector<View> frames_around(const Mesh& mesh, int size) {
  std::vector<View> views = views_around(facet_bounds(mesh.view()), 16, 2.5f, Projection::perspective);
  for (View& view : views) view.width = view.height = size;
  return views;
}

std::vector<int> thread_counts() {
  const int all = tbb::info::default_concurrency();
  return all > 1 ? std::vector{1, all} : std::vector{1};
}

int other_thread_count(int threads) {
  return threads > 1 ? 1 : std::max(2, tbb::info::default_concurrency());
}

std::uint64_t checksum(const Image& image) {
  Checksum sum;
  for (const glm::vec4& pixel : image.pixels) {
    for (int channel = 0; channel < 4; ++channel) sum.add(std::bit_cast<std::uint32_t>(pixel[channel]));
  }
  return sum.value();
}

std::uint64_t checksum(const FragmentLists& lists) {
  Checksum sum;
  for (const std::uint64_t offset : lists.offsets) sum.add(offset);
  for (const Fragment& fragment : lists.fragments) {
    sum.add(fragment.facet);
    sum.add(std::bit_cast<std::uint32_t>(fragment.depth_error));
    sum.add(std::bit_cast<std::uint64_t>(fragment.depth));
  }
  return sum.value();
}

}  // namespace facetsort::bench
