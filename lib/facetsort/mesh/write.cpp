#include "facetsort/mesh/write.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <new>
#include <string>
#include <system_error>
#include <utility>

namespace facetsort {
namespace {

// A file that is there only when it is complete: written under another name in the same folder, then renamed.
class NewFile {
 public:
  explicit NewFile(const std::filesystem::path& path) : path_(path) {
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path_, error);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) {
      // A rename would put a file in the place of a device.
      fail(std::filesystem::is_directory(status) ? "is a directory" : "is not a regular file");
      return;
    }
    // A link stays, and the file that it leads to is replaced.
    if (std::filesystem::is_symlink(path_, error)) path_ = std::filesystem::weakly_canonical(path_, error);
    // "x": never over a file that is there, so that two writers never share one.
    constexpr int most_names = 1000;
    for (int i = 0; i < most_names && !file_; ++i) {
      temporary_ = path_.parent_path() / (".facetsort-" + std::to_string(i) + ".tmp");
      file_ = std::fopen(temporary_.c_str(), "wbx");
      if (!file_ && errno != EEXIST) break;
    }
    if (!file_) fail_with(errno);
  }
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;
  ~NewFile() { discard(); }

  void write(const std::string& bytes) {
    if (file_ && std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail_with(errno);
  }

  // Ok when the file stands under its own name.
  Status finish() {
    if (!file_) return status_;
    // What the buffer holds is written here at the latest, and a full disk shows.
    if (std::fclose(std::exchange(file_, nullptr)) != 0) {
      fail_with(errno);
    } else if (std::error_code error; std::filesystem::rename(temporary_, path_, error), error) {
      fail("cannot be written: " + error.message());
    } else {
      temporary_.clear();
    }
    return status_;
  }

 private:
  void fail_with(int error) { fail("cannot be written: " + std::generic_category().message(error)); }

  void fail(const std::string& what) {
    status_ = {Fault::cannot_write, path_.string() + ": " + what};
    discard();
  }

  void discard() {
    if (file_) std::fclose(std::exchange(file_, nullptr));
    std::error_code ignored;
    if (!temporary_.empty()) std::filesystem::remove(temporary_, ignored);
    temporary_.clear();
  }

  std::filesystem::path path_, temporary_;
  std::FILE* file_ = nullptr;
  Status status_;
};

void put(std::string& bytes, std::uint32_t value) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>(value >> shift & 0xff);
}

void put(std::string& bytes, float value) {
  put(bytes, std::bit_cast<std::uint32_t>(value));
}

void put_colour(std::string& bytes, const glm::vec4& colour) {
  for (int c = 0; c < 4; ++c) {
    // Written so that NaN becomes 0.
    const float clamped = colour[c] > 0 ? std::min(colour[c], 1.0f) : 0.0f;
    bytes += static_cast<char>(std::lround(clamped * 255));
  }
}

std::string header(const MeshView& mesh, bool has_source) {
  const std::string colour = "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\n";
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  text += "element vertex " + std::to_string(mesh.vertex_count()) + "\n";
  text += "property float x\nproperty float y\nproperty float z\n";
  if (!mesh.vertex_colours.empty()) text += colour;
  text += "element face " + std::to_string(mesh.facet_count()) + "\n";
  text += "property list uchar uint vertex_indices\n";
  if (!mesh.facet_colours.empty()) text += colour;
  if (has_source) text += "property uint source\n";
  return text + "end_header\n";
}

// Calls put_element(bytes, i) for each element and writes what has gathered now and then.
template <typename PutElement>
void write_elements(NewFile& file, std::size_t count, const PutElement& put_element) {
  constexpr std::size_t flush_size = std::size_t{1} << 18;
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) {
    put_element(bytes, i);
    if (bytes.size() >= flush_size || i + 1 == count) {
      file.write(bytes);
      bytes.clear();
    }
  }
}

}  // namespace

Status write_ply(const std::filesystem::path& path, const MeshView& mesh, std::span<const std::uint32_t> source) {
  if (!source.empty() && source.size() != mesh.facet_count()) {
    return {Fault::bad_argument, path.string() + ": " + std::to_string(source.size()) + " source ids for " +
                                     std::to_string(mesh.facet_count()) + " facets"};
  }
  try {
    NewFile file(path);
    file.write(header(mesh, !source.empty()));
    write_elements(file, mesh.vertex_count(), [&](std::string& bytes, std::size_t v) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, mesh.positions[v][axis]);
      if (!mesh.vertex_colours.empty()) put_colour(bytes, mesh.vertex_colours[v]);
    });
    write_elements(file, mesh.facet_count(), [&](std::string& bytes, std::size_t f) {
      bytes += '\3';
      for (int i = 0; i < 3; ++i) put(bytes, mesh.triangles[f][i]);
      if (!mesh.facet_colours.empty()) put_colour(bytes, mesh.facet_colours[f]);
      if (!source.empty()) put(bytes, source[f]);
    });
    return file.finish();
  } catch (const std::bad_alloc&) {
    return {Fault::out_of_memory, path.string() + ": not enough memory to write it"};
  }
}

}  // namespace facetsort
