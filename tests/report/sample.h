// A small comparison with every kind of row, and a folder to write it to.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "facetsort/report/row.h"

namespace facetsort::test {

// A fresh folder, removed with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "facetsort-report-XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }

  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

inline std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

inline void write_text(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

inline std::size_t file_count(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

inline std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t place = text.find(part); place != std::string::npos; place = text.find(part, place + 1)) ++count;
  return count;
}

inline Row make_row(const std::string& mesh, int view, const std::string& strategy, double wrong_rate,
                    double blend_ms) {
  Row row;
  row.mesh = mesh;
  row.facets = 1000;
  row.view = view;
  row.eye = {0.3f, -2, 1e-20f};
  row.projection = "perspective";
  row.strategy = strategy;
  row.facets_drawn = row.pieces = row.triangles_out = 1000;
  row.blend = {blend_ms, 0.01};
  row.covered_pixels = 10000;
  row.wrong_rate = wrong_rate;
  row.wrong_pixels = static_cast<std::size_t>(wrong_rate * 10000);
  return row;
}

// Two meshes, two views, a strategy that cannot be judged by order (depth_write) and one that nobody knows.
inline Comparison make_comparison(const std::string& first_mesh = "cup", const std::string& second_mesh = "fan") {
  Comparison comparison;
  comparison.machine = "a machine";
  comparison.command = "facetsort compare cup.ply fan.ply";
  comparison.date = "2026-01-02T03:04:05Z";
  comparison.width = comparison.height = 64;
  comparison.views = 2;
  comparison.meshes = {{first_mesh, 1000, 2.5, 4, 0.9999}, {second_mesh, 1000, 3, 9, 1}};
  for (const std::string& mesh : {first_mesh, second_mesh}) {
    const double hard = mesh == first_mesh ? 1 : 500;
    for (int view = 0; view < 2; ++view) {
      for (const char* strategy : {"unsorted", "depth_write", "facet_sort:centroid_distance", "novel", "reference"}) {
        const std::string name = strategy;
        Row row = make_row(mesh, view, name, 0, 10);
        if (name == "unsorted") row = make_row(mesh, view, name, 0.5 + 0.1 * view, 2);
        if (name == "depth_write") row = make_row(mesh, view, name, 0.9, 1);
        if (name == "facet_sort:centroid_distance") row = make_row(mesh, view, name, 0.0002 * hard * view, 3);
        if (name == "novel") row = make_row(mesh, view, name, 0.0002 * hard, 3.6);
        if (name == "unsorted" || name == "facet_sort:centroid_distance") {
          row.inverted_rate = row.wrong_rate;
          row.inverted_pixels = row.wrong_pixels;
          row.worst_backtrack = 0.25;
        }
        if (name == "facet_sort:centroid_distance") {
          row.method = "centroid_distance";
          row.order = {0.5, 0.001};
        }
        comparison.rows.push_back(row);
      }
    }
    for (const char* strategy : {"unsorted", "reference"}) {
      const std::string name = mesh + "/" + strategy;
      comparison.pictures.push_back(
          {mesh, strategy, name + ".png", name == mesh + "/reference" ? "" : name + "-d.png"});
    }
  }
  return comparison;
}

// The exact order of a mesh of the comparison in a view; `candidate_pairs` tells rows apart.
inline Row make_exact_row(const std::string& mesh, int view, std::size_t candidate_pairs) {
  Row row = make_row(mesh, view, "facet_sort:exact", 0, 4);
  row.method = "exact";
  row.pieces = 1010;
  row.triangles_out = 1030;
  row.exact.emplace();
  row.exact->crossing_pairs = 7;
  row.exact->candidate_pairs = candidate_pairs;
  row.exact->pieces = 1010;
  row.exact->triangles = 1030;
  row.exact->pairs_ms = 0.625;
  return row;
}

}  // namespace facetsort::test
