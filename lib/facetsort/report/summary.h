// What the rows of a comparison add up to: one line a (mesh, strategy), one a strategy over all meshes, and which
// strategy to take. Shared by the page and the terminal.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/report/row.h"

namespace facetsort {

// A mesh is drawn right enough when a smaller share of its covered pixels is wrong, in the mean of the views.
inline constexpr double right_enough = 0.001;
inline constexpr std::string_view right_enough_percent = "0.1";
// Times closer than this to the fastest are taken as equal: a repeated run would swap them.
inline constexpr double equal_time = 1.1;
// A view in which more of the covered pixels could not be judged is not judged.
inline constexpr double most_unjudged = 0.05;
// The strategy that the others are judged by: shown, but not up for choice.
inline constexpr std::string_view reference_strategy = "reference";

// An error rate over the views of a mesh.
struct RateSummary {
  std::optional<double> mean, worst;  // of the judged views; empty where none was
  std::size_t judged_views = 0;
  bool not_judged = false;  // empty because too many pixels could not be judged, not because the measure
                            // does not apply to the strategy
};

struct StrategySummary {
  std::string strategy;
  std::size_t views = 0;
  RateSummary wrong, inverted;
  // Medians over the views; the spreads are medians of the views' own.
  Timing order, blend;
  double frame_ms = 0;  // order and blend
  double prepare_ms = 0;
  int passes = 1;
  // The most of any view.
  std::size_t bytes_per_pixel = 0, facets_drawn = 0, pieces = 0, triangles_out = 0, prepared_bytes = 0, peak_bytes = 0;
  double max_error = 0;
  std::optional<double> worst_backtrack;
  double rmse = 0;  // mean of the views
  // Sums over the views.
  std::size_t covered_pixels = 0, unjudged_pixels = 0, embree_rays = 0, embree_unjudged = 0;
  std::optional<std::size_t> miscovered_pixels, embree_inverted;

  // What strategies are ranked by: the mean wrong rate, or the inverted rate where only that was judged.
  std::optional<double> error() const { return wrong.mean ? wrong.mean : inverted.mean; }
};

// Which strategy to take for a mesh: the fastest that is right enough (of those as fast, the most right), or the most
// right one where none is.
struct Recommendation {
  std::string strategy;
  bool is_right_enough = false;
};

struct MeshResults {
  MeshSummary mesh;
  std::vector<StrategySummary> strategies;
  std::optional<Recommendation> recommendation;  // empty where nothing could be judged

  const StrategySummary* find(std::string_view strategy) const;
};

// A strategy over all meshes.
struct OverallResults {
  std::string strategy;
  std::size_t judged_meshes = 0, right_meshes = 0;
  std::optional<double> mean_error;  // of the judged meshes
  double median_frame_ms = 0;
  double geometric_mean_frame_ms = 0;
};

struct Summary {
  std::vector<std::string> strategies;  // in the order in which rows first name them
  std::vector<MeshResults> meshes;      // in the comparison's order
  std::vector<OverallResults> overall;  // one a strategy
  // Right enough on the most meshes; of equals, the most right in the mean. It is right enough over all when it is so
  // on more than half of them.
  std::optional<Recommendation> recommendation;
};

Summary summarise(const Comparison& comparison);

}  // namespace facetsort
