// Mesh files as bytes, made here and not by the library: each format that read_mesh takes, and the small dirty mesh
// that every format must keep whole.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "facetsort/mesh/mesh.h"

namespace facetsort {

enum class Endian { little, big };

template <typename T>
void put(std::string& bytes, T value, Endian endian) {
  static_assert(std::is_arithmetic_v<T>);
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if ((endian == Endian::little) != (std::endian::native == std::endian::little)) std::reverse(raw, raw + sizeof raw);
  bytes.append(raw, sizeof raw);
}

// The shortest decimal that gives the same float again is not needed: nine digits always do.
inline std::string decimal(float value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", static_cast<double>(value));
  return text;
}

inline std::string decimals(const glm::vec3& p) {
  return decimal(p.x) + " " + decimal(p.y) + " " + decimal(p.z);
}

inline std::string indices(const glm::uvec3& triangle, unsigned first) {
  return std::to_string(triangle.x + first) + " " + std::to_string(triangle.y + first) + " " +
         std::to_string(triangle.z + first);
}

// Facets that a half-edge mesh refuses: three on an edge, duplicates in both windings, a repeated corner, two corners
// at one place, all corners in a line; each between whole ones, so that a lost one shifts the rest.
inline Mesh dirty_mesh() {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0.1f, -1, 0.3333333f}, {1e-30f, 3e8f, -0.f},
                    {1, 0, 0}, {2, 0, 0}, {7, 7, 7}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {1, 0, 4},  // three facets on the edge 0 1
                    {0, 1, 2}, {2, 1, 0}, {1, 2, 0},  // duplicates of the first: same, flipped, rotated
                    {5, 4, 3}, {2, 2, 3},             // a repeated corner
                    {3, 4, 0}, {4, 4, 4},             // one corner three times
                    {1, 6, 2},                        // corners at one place
                    {0, 1, 7},                        // in a line
                    {8, 5, 2}};
  return mesh;
}

inline std::string ply_header(const Mesh& mesh, const std::string& format) {
  return "ply\nformat " + format + " 1.0\ncomment made for a test\nelement vertex " +
         std::to_string(mesh.positions.size()) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
         std::to_string(mesh.triangles.size()) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

inline std::string ply_ascii(const Mesh& mesh) {
  std::string text = ply_header(mesh, "ascii");
  for (const glm::vec3& p : mesh.positions) text += decimals(p) + "\n";
  for (const glm::uvec3& t : mesh.triangles) text += "3 " + indices(t, 0) + "\n";
  return text;
}

inline std::string ply_binary(const Mesh& mesh, Endian endian) {
  std::string bytes = ply_header(mesh, endian == Endian::big ? "binary_big_endian" : "binary_little_endian");
  for (const glm::vec3& p : mesh.positions) {
    for (int axis = 0; axis < 3; ++axis) put(bytes, p[axis], endian);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    bytes += '\3';
    for (int i = 0; i < 3; ++i) put(bytes, t[i], endian);
  }
  return bytes;
}

inline std::string ply_little_endian(const Mesh& mesh) {
  return ply_binary(mesh, Endian::little);
}
inline std::string ply_big_endian(const Mesh& mesh) {
  return ply_binary(mesh, Endian::big);
}

inline std::string off(const Mesh& mesh) {
  std::string text =
      "OFF\n" + std::to_string(mesh.positions.size()) + " " + std::to_string(mesh.triangles.size()) + " 0\n";
  for (const glm::vec3& p : mesh.positions) text += decimals(p) + "\n";
  for (const glm::uvec3& t : mesh.triangles) text += "3 " + indices(t, 0) + "\n";
  return text;
}

inline std::string obj(const Mesh& mesh) {
  std::string text;
  for (const glm::vec3& p : mesh.positions) text += "v " + decimals(p) + "\n";
  for (const glm::uvec3& t : mesh.triangles) text += "f " + indices(t, 1) + "\n";
  return text;
}

inline std::string stl_ascii(const Mesh& mesh) {
  std::string text = "solid made for a test\n";
  for (const glm::uvec3& t : mesh.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (int i = 0; i < 3; ++i) text += "      vertex " + decimals(mesh.positions[t[i]]) + "\n";
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid made for a test\n";
}

// Starts with "solid", as many binary files do.
inline std::string stl_binary(const Mesh& mesh) {
  std::string bytes = "solid, and yet binary";
  bytes.resize(80, ' ');
  put(bytes, static_cast<std::uint32_t>(mesh.triangles.size()), Endian::little);
  for (const glm::uvec3& t : mesh.triangles) {
    bytes.append(12, '\0');
    for (int i = 0; i < 3; ++i) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, mesh.positions[t[i]][axis], Endian::little);
    }
    bytes.append(2, '\0');
  }
  return bytes;
}

struct Format {
  const char* name;
  const char* extension;
  std::string (*encode)(const Mesh&);
  bool is_indexed;  // facets share listed vertices
  bool is_text;
  bool says_its_size;  // so that a short file can't pass for a whole one
};

inline const std::vector<Format>& formats() {
  static const std::vector<Format> all{{"ply_ascii", ".ply", ply_ascii, true, true, true},
                                       {"ply_little_endian", ".ply", ply_little_endian, true, false, true},
                                       {"ply_big_endian", ".ply", ply_big_endian, true, false, true},
                                       {"off", ".off", off, true, true, true},
                                       {"obj", ".obj", obj, true, true, false},
                                       {"stl_ascii", ".stl", stl_ascii, false, true, true},
                                       {"stl_binary", ".stl", stl_binary, false, false, true}};
  return all;
}

}  // namespace facetsort
