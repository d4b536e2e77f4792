// One line of a comparison: (mesh, view, strategy), its error and its cost.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <vector>

#include "facetsort/exact/exact_sorter.h"

namespace facetsort {

// A measured time: the median of repeated runs, and the distance between their quartiles.
struct Timing {
  double median_ms = 0;
  double spread_ms = 0;
};

// Empty optionals are `null` in JSON and empty in CSV: the measure does not apply to the strategy, or too many
// pixels could not be judged.
struct Row {
  std::string mesh;               // file name without its extension
  std::size_t facets = 0;
  int view = 0;                   // position in the view set
  glm::vec3 eye{0};
  std::string projection;         // "perspective" or "orthographic"
  std::string strategy;           // "unsorted", "facet_sort:centroid_distance", ...
  std::string method;             // of facet_sort; empty otherwise
  std::size_t facets_drawn = 0;   // after culling, over all passes
  std::size_t pieces = 0;         // facets in, plus what cuts added
  std::size_t triangles_out = 0;
  int passes = 1;                 // over the geometry
  std::size_t bytes_per_pixel = 0;  // kept beside the picture
  double prepare_ms = 0;          // once a mesh
  std::size_t prepared_bytes = 0;
  Timing order;                   // per frame
  Timing blend;                   // per frame
  std::size_t peak_bytes = 0;     // allocations of order and blend, beyond mesh and picture
  std::size_t covered_pixels = 0;
  std::optional<std::size_t> wrong_pixels;
  std::optional<double> wrong_rate;
  std::optional<std::size_t> inverted_pixels;
  std::optional<double> inverted_rate;
  std::optional<std::size_t> miscovered_pixels;
  std::size_t unjudged_pixels = 0;
  double rmse = 0;
  double max_error = 0;
  std::optional<double> worst_backtrack;   // over R
  std::size_t embree_rays = 0;
  std::optional<std::size_t> embree_inverted;
  std::size_t embree_unjudged = 0;
  std::optional<ExactStatistics> exact;    // of the exact order alone
};

// A picture of a strategy on one mesh, for the report page. Paths are relative to the report's folder.
struct ReportPicture {
  std::string mesh, strategy;
  std::string picture;      // what the strategy draws
  std::string difference;   // where it differs from the reference, and by how much; empty for the reference
};

struct MeshSummary {
  std::string name;
  std::size_t facets = 0;
  double mean_layers = 0;          // fragments over covered pixels, over the views
  std::size_t most_layers = 0;
  // Share of covered pixels in which Embree's own picture equals the reference within 1/255; empty where Embree could
  // judge none of them.
  std::optional<double> embree_agreement;
};

struct Comparison {
  std::string machine;             // processor, threads, compiler
  std::string command;
  std::string date;                // ISO 8601
  int width = 0, height = 0, views = 0;
  bool has_stability_page = false;  // stability.html, beside the page
  std::vector<MeshSummary> meshes;
  std::vector<Row> rows;
  std::vector<ReportPicture> pictures;
};

}  // namespace facetsort
