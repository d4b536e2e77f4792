// The statistics of the exact order by name, so that JSON, page and terminal show the same. Internal to report and our
// programs.
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "facetsort/exact/exact_sorter.h"

namespace facetsort {

struct ExactCount {
  std::string_view name;
  std::size_t ExactStatistics::*value;
};

struct ExactTime {
  std::string_view name;
  double ExactStatistics::*value_ms;
};

// In the order of the members.
inline constexpr std::array<ExactCount, 18> exact_counts{
    {{"crossing_pairs", &ExactStatistics::crossing_pairs},
     {"crossing_pairs_uncut", &ExactStatistics::crossing_pairs_uncut},
     {"prepared_cuts", &ExactStatistics::prepared_cuts},
     {"prepared_pieces", &ExactStatistics::prepared_pieces},
     {"tree_nodes", &ExactStatistics::tree_nodes},
     {"tree_cuts", &ExactStatistics::tree_cuts},
     {"candidate_pairs", &ExactStatistics::candidate_pairs},
     {"constraints", &ExactStatistics::constraints},
     {"searches", &ExactStatistics::searches},
     {"components", &ExactStatistics::components},
     {"pieces_in_cycles", &ExactStatistics::pieces_in_cycles},
     {"largest_component", &ExactStatistics::largest_component},
     {"rejoined_cuts", &ExactStatistics::rejoined_cuts},
     {"view_cuts", &ExactStatistics::view_cuts},
     {"unordered_pairs", &ExactStatistics::unordered_pairs},
     {"predicate_fallbacks", &ExactStatistics::predicate_fallbacks},
     {"pieces", &ExactStatistics::pieces},
     {"triangles", &ExactStatistics::triangles}}};
inline constexpr std::array<ExactTime, 5> exact_times{{{"prepare", &ExactStatistics::prepare_ms},
                                                       {"project", &ExactStatistics::project_ms},
                                                       {"pairs", &ExactStatistics::pairs_ms},
                                                       {"order", &ExactStatistics::order_ms},
                                                       {"cut", &ExactStatistics::cut_ms}}};

// An object of the counts, and the times in one of its own as `times_ms`. `Json` is a type of nlohmann's library.
template <typename Json>
Json exact_json(const ExactStatistics& statistics) {
  Json json = Json::object(), times = Json::object();
  for (const ExactCount& count : exact_counts) json[std::string(count.name)] = statistics.*count.value;
  for (const ExactTime& time : exact_times) times[std::string(time.name)] = statistics.*time.value_ms;
  json["times_ms"] = times;
  return json;
}

}  // namespace facetsort
