#include "facetsort/mesh/read.h"

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/importer/BaseImporter.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ios>
#include <limits>
#include <locale>
#include <mutex>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "facetsort/mesh/plain_ply.h"
#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

// How OpenMesh's `stream >> number` reads: whole words by the rules of text.h, whatever the locale. The standard's own
// rules stop at nan, inf and numbers beyond float's range, and OpenMesh reads zeros from there on.
class StrictNumbers : public std::num_get<char> {
 protected:
  iter_type do_get(iter_type in, iter_type end, std::ios_base&, std::ios_base::iostate& state,
                   float& value) const override {
    store(text::parse_float(take_word(in, end, state)), state, value);
    return in;
  }

  // Negative numbers wrap, and mean no vertex then.
  iter_type do_get(iter_type in, iter_type end, std::ios_base&, std::ios_base::iostate& state,
                   unsigned int& value) const override {
    store(text::parse_integer<std::int64_t>(take_word(in, end, state)), state, value);
    return in;
  }

 private:
  static std::string take_word(iter_type& in, const iter_type& end, std::ios_base::iostate& state) {
    std::string word;
    for (; in != end && !text::is_space(*in); ++in) word += *in;
    if (in == end) state |= std::ios_base::eofbit;
    return word;
  }

  template <typename Parsed, typename Value>
  static void store(const Parsed& parsed, std::ios_base::iostate& state, Value& value) {
    value = parsed ? static_cast<Value>(*parsed) : Value{};
    if (!parsed) state |= std::ios_base::failbit;
  }
};

bool is_finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// Takes vertices and faces down as they come: no half-edge mesh is built, which would refuse non-manifold ones.
class Importer : public OpenMesh::IO::BaseImporter {
 public:
  using VertexHandle = OpenMesh::VertexHandle;
  using HalfedgeHandle = OpenMesh::HalfedgeHandle;
  using EdgeHandle = OpenMesh::EdgeHandle;
  using FaceHandle = OpenMesh::FaceHandle;
  using Vec2f = OpenMesh::Vec2f;
  using Vec3f = OpenMesh::Vec3f;
  using Vec3d = OpenMesh::Vec3d;
  using Vec4f = OpenMesh::Vec4f;
  using Vec3uc = OpenMesh::Vec3uc;
  using Vec4uc = OpenMesh::Vec4uc;
  using StatusInfo = OpenMesh::Attributes::StatusInfo;

  Importer(std::size_t vertices, std::size_t faces) : vertices_(vertices) {
    mesh_.positions.reserve(vertices);
    mesh_.triangles.reserve(faces);
  }

  Mesh take_mesh() { return std::move(mesh_); }

  // Where the stream failed.
  ReadError not_a_number() const {
    if (faces_ == 0 && vertices_set_ < vertices_) {
      return {Fault::malformed, "vertex " + std::to_string(vertices_set_) + " has a coordinate that is not a number"};
    }
    return {Fault::malformed, "facet " + std::to_string(faces_) + " has a corner that is not an index"};
  }

  VertexHandle add_vertex() override {
    mesh_.positions.emplace_back(0);
    return VertexHandle(static_cast<int>(mesh_.positions.size() - 1));
  }

  void set_point(VertexHandle vertex, const Vec3f& p) override {
    mesh_.positions[vertex.idx()] = {p[0], p[1], p[2]};
    ++vertices_set_;
  }

  VertexHandle add_vertex(const Vec3f& p) override {
    const VertexHandle vertex = add_vertex();
    set_point(vertex, p);
    return vertex;
  }

  FaceHandle add_face(const VHandles& corners) override {
    for (const VertexHandle corner : corners) check_corner(corner.idx());
    for (std::size_t i = 2; i < corners.size(); ++i) {
      mesh_.triangles.emplace_back(corners[0].idx(), corners[i - 1].idx(), corners[i].idx());
    }
    return FaceHandle(static_cast<int>(faces_++));
  }

  std::size_t n_vertices() const override { return mesh_.positions.size(); }
  std::size_t n_faces() const override { return faces_; }
  std::size_t n_edges() const override { return 0; }

  // A plain PLY has nothing of the rest.
  HalfedgeHandle add_edge(VertexHandle, VertexHandle) override { return HalfedgeHandle(); }
  FaceHandle add_face(HalfedgeHandle) override { return FaceHandle(); }
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec2f>&) override {}
  void add_face_texcoords(FaceHandle, VertexHandle, const std::vector<Vec3f>&) override {}
  void set_face_texindex(FaceHandle, int) override {}
  void set_halfedge(VertexHandle, HalfedgeHandle) override {}
  void set_normal(VertexHandle, const Vec3f&) override {}
  void set_normal(VertexHandle, const Vec3d&) override {}
  void set_normal(FaceHandle, const Vec3f&) override {}
  void set_normal(FaceHandle, const Vec3d&) override {}
  void set_color(VertexHandle, const Vec3uc&) override {}
  void set_color(VertexHandle, const Vec4uc&) override {}
  void set_color(VertexHandle, const Vec3f&) override {}
  void set_color(VertexHandle, const Vec4f&) override {}
  void set_color(EdgeHandle, const Vec3uc&) override {}
  void set_color(EdgeHandle, const Vec4uc&) override {}
  void set_color(EdgeHandle, const Vec3f&) override {}
  void set_color(EdgeHandle, const Vec4f&) override {}
  void set_color(FaceHandle, const Vec3uc&) override {}
  void set_color(FaceHandle, const Vec4uc&) override {}
  void set_color(FaceHandle, const Vec3f&) override {}
  void set_color(FaceHandle, const Vec4f&) override {}
  void set_texcoord(VertexHandle, const Vec2f&) override {}
  void set_texcoord(VertexHandle, const Vec3f&) override {}
  void set_texcoord(HalfedgeHandle, const Vec2f&) override {}
  void set_texcoord(HalfedgeHandle, const Vec3f&) override {}
  void set_status(VertexHandle, const StatusInfo&) override {}
  void set_status(HalfedgeHandle, const StatusInfo&) override {}
  void set_status(EdgeHandle, const StatusInfo&) override {}
  void set_status(FaceHandle, const StatusInfo&) override {}
  void set_next(HalfedgeHandle, HalfedgeHandle) override {}
  void set_face(HalfedgeHandle, FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void add_texture_information(int, std::string) override {}

 private:
  // Vertices come before faces in a plain PLY, so that all of them are there.
  void check_corner(int vertex) const {
    if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh_.positions.size()) {
      throw ReadError{Fault::index_out_of_range, "facet " + std::to_string(faces_) + " names vertex " +
                                                     std::to_string(vertex) + " of " +
                                                     std::to_string(mesh_.positions.size())};
    }
    if (!is_finite(mesh_.positions[vertex])) {
      throw ReadError{Fault::non_finite_position, "facet " + std::to_string(faces_) + " uses vertex " +
                                                      std::to_string(vertex) + ", whose position is not finite"};
    }
  }

  Mesh mesh_;
  std::size_t vertices_, vertices_set_ = 0, faces_ = 0;
};

// OpenMesh switches its error stream off while it reads, and leaves it off where it is interrupted.
class KeepErrorStream {
 public:
  KeepErrorStream() : enabled_(omerr().is_enabled()) {}
  KeepErrorStream(const KeepErrorStream&) = delete;
  KeepErrorStream& operator=(const KeepErrorStream&) = delete;
  ~KeepErrorStream() {
    if (enabled_) omerr().enable();
  }

 private:
  bool enabled_;
};

Mesh read_plain(PlainPly plain) {
  // OpenMesh's handles are int.
  constexpr std::size_t most = std::numeric_limits<int>::max();
  if (plain.faces == 0) throw ReadError{Fault::empty_mesh, "no facet"};
  if (plain.vertices > most || plain.faces > most) {
    throw ReadError{Fault::too_many_facets, std::to_string(plain.faces) + " facets and " +
                                                std::to_string(plain.vertices) + " vertices, at most " +
                                                std::to_string(most) + " of each can be read"};
  }
  Importer importer(plain.vertices, plain.faces);
  std::istringstream stream(std::move(plain.bytes));
  stream.imbue(std::locale(std::locale::classic(), new StrictNumbers));
  // OpenMesh looks at its stream's state almost nowhere: what can't be read must stop it from within.
  stream.exceptions(std::ios_base::failbit | std::ios_base::badbit);
  OpenMesh::IO::Options options;
  // The readers are global objects that keep a file's header in them.
  static std::mutex one_reader;
  const std::lock_guard lock(one_reader);
  const KeepErrorStream keep_error_stream;
  try {
    OpenMesh::IO::IOManager().read(stream, "ply", importer, options);
  } catch (const std::ios_base::failure&) {
    throw importer.not_a_number();
  }
  if (importer.n_faces() != plain.faces) {
    throw ReadError{Fault::truncated, "truncated: " + std::to_string(importer.n_faces()) + " of " +
                                          std::to_string(plain.faces) + " facets read"};
  }
  Mesh mesh = importer.take_mesh();
  mesh.facet_colours = std::move(plain.facet_colours);
  mesh.vertex_colours = std::move(plain.vertex_colours);
  return mesh;
}

PlainPly scan(const std::filesystem::path& path, std::string extension) {
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  const bool is_known = extension == ".ply" || extension == ".obj" || extension == ".off" || extension == ".stl";
  if (!is_known) throw ReadError{Fault::unsupported_format, "is no .ply, .obj, .off or .stl file"};
  const std::string file = read_bytes(path);
  if (file.empty()) throw ReadError{Fault::empty_mesh, "the file is empty"};
  if (extension == ".ply") return scan_ply(file);
  if (extension == ".obj") return scan_obj(file, path.parent_path());
  if (extension == ".off") return scan_off(file);
  return scan_stl(file);
}

// Calls `read`, and turns what it throws into one line that starts with the file's name.
template <typename Value, typename Read>
Result<Value> status_of(const std::filesystem::path& path, const Read& read) {
  try {
    return read();
  } catch (const ReadError& error) {
    return Status{error.fault, path.string() + ": " + error.message};
  } catch (const std::bad_alloc&) {
    return Status{Fault::out_of_memory, path.string() + ": not enough memory to read it"};
  } catch (const std::length_error&) {
    return Status{Fault::out_of_memory, path.string() + ": larger than memory can be"};
  }
}

}  // namespace

Result<std::vector<std::uint32_t>> read_ply_source(const std::filesystem::path& path) {
  return status_of<std::vector<std::uint32_t>>(path, [&] { return scan(path, ".ply").source; });
}

Result<Mesh> read_mesh(const std::filesystem::path& path) {
  return status_of<Mesh>(path, [&] { return read_plain(scan(path, path.extension().string())); });
}

}  // namespace facetsort
