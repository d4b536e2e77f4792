// How methods bear up when one condition of mesh or view is driven to its extremes, and where the referees stop.
// Internal to report and our programs.
#pragma once

#include <cstddef>
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "facetsort/base/status.h"

namespace facetsort {

// What a referee could judge at one value of a sweep, over all views.
struct RefereeReach {
  std::size_t seen = 0;      // pixels (rays) with a fragment
  std::size_t unjudged = 0;  // of those, the ones whose answer rounding leaves open

  // Enough to speak of an error at all: something was seen, and no more than most_unjudged of it is open.
  bool judges() const;
};

// What one method does at one value, over all views. Empty where the referee does not judge there.
struct MethodErrors {
  std::optional<std::size_t> inverted_pixels, wrong_pixels;  // by the per-pixel lists
  std::optional<std::size_t> inverted_rays;                  // by Embree
};

struct StabilityPoint {
  double value = 0;   // above 0 where there is no place
  std::string place;  // "on a vertex", where the condition is no number on the sweep's axis; empty otherwise
  std::size_t facets = 0;
  RefereeReach lists, embree;         // the per-pixel lists, and Embree
  std::vector<MethodErrors> methods;  // one a method of the report

  // Of both referees' inverted shares the larger; empty where neither judges.
  std::optional<double> inverted_rate(std::size_t method) const;
};

struct StabilitySweep {
  std::string name;         // "origin_distance"
  std::string title;        // "Distance from the origin"
  std::string unit;         // of the values, "radii"
  std::string description;  // what is changed and what is kept: plain text, whole sentences
  std::vector<StabilityPoint> points;
  std::size_t mildest = 0;  // the point from which conditions get worse, in both directions
};

struct Stability {
  std::string machine;  // processor, threads, compiler
  std::string command;
  std::string date;  // ISO 8601
  int width = 0, height = 0, views = 0;
  std::vector<std::string> methods;
  std::vector<StabilitySweep> sweeps;
};

// stability.json, stability.csv and stability.html: each is written under a temporary name and renamed. The page needs
// no network, no other file and no other program.
Status write_stability_json(const std::filesystem::path& path, const Stability& stability);
Status write_stability_csv(const std::filesystem::path& path, const Stability& stability);
Status write_stability_page(const std::filesystem::path& path, const Stability& stability);

// For a terminal: a line a sweep, saying where each method breaks and where each referee stops.
void print_stability(std::ostream& out, const Stability& stability);

}  // namespace facetsort
