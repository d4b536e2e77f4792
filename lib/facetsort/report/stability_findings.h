// Where methods break and referees stop, found in a sweep's points. Internal to report.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "facetsort/report/stability.h"

namespace facetsort {

// A point's place, or its value in three digits: "on a vertex", "3.16", "1e-6".
std::string point_text(const StabilityPoint& point);

// Neighbouring points of a sweep, first and last included.
struct PointRange {
  std::size_t first = 0, last = 0;

  bool operator==(const PointRange&) const = default;
};

// Runs of points with a property. Points that nobody judges neither begin, end nor interrupt a run of broken ones.
struct SweepFindings {
  std::vector<std::vector<PointRange>> broken;  // one list a method: more than right_enough of what is seen is inverted
  std::vector<PointRange> lists_stop, embree_stop, nobody_judges;
};
SweepFindings find_breaks(const StabilitySweep& sweep, std::size_t methods);

// The points nearest to the mildest one, on either side of it, that lie in the ranges: where trouble begins. Empty
// where there is none; one point where the mildest is in trouble itself.
std::vector<std::size_t> first_points(const std::vector<PointRange>& ranges, std::size_t mildest);

// "at 1e-30 to 1e-22 and at 1e20 to 1e30", "on a vertex to 0.1"; "at all values" where a range holds every point.
std::string ranges_text(const std::vector<PointRange>& ranges, const StabilitySweep& sweep);

// Says in sentences where each method breaks and where each referee stops. `method_text` gives a method's name as the
// reader is to see it.
std::string findings_text(const StabilitySweep& sweep, const std::vector<std::string>& methods,
                          const std::function<std::string(const std::string&)>& method_text);

}  // namespace facetsort
