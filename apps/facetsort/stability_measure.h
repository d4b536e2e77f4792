// One point of a stability sweep: every method in every view, judged by both referees.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/order/method.h"
#include "facetsort/report/stability.h"
#include "stability_sweeps.h"

namespace facetsort {

// What a sweep compares: our methods, and the centroid sort as it is usually written.
struct StabilityMethod {
  std::optional<Method> method;  // empty for the naive sort

  bool operator==(const StabilityMethod&) const = default;
  std::string name() const;
};

inline constexpr std::string_view naive_centroid_name = "naive_centroid";

// The naive sort, then every method that a strategy sorts facets by.
std::vector<StabilityMethod> all_stability_methods();

// Parallel in the caller's task arena; the same for any thread count. Throws Failure where Embree refuses the mesh.
StabilityPoint measure_stability(const SweepScene& scene, const std::vector<StabilityMethod>& methods);

}  // namespace facetsort
