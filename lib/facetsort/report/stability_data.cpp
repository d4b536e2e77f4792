// stability.json and stability.csv: what was counted, for programs.
#include <nlohmann/json.hpp>
#include <string>

#include "facetsort/report/join.h"
#include "facetsort/report/replace_file.h"
#include "facetsort/report/stability.h"
#include "facetsort/report/stability_findings.h"

namespace facetsort {
namespace {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json value_json(const StabilityPoint& point) {
  return point.place.empty() ? Json(point.value) : Json(nullptr);
}

// The columns of both files.
Json row_json(const StabilitySweep& sweep, const StabilityPoint& point, const std::string& method,
              const MethodErrors& errors, const std::optional<double>& inverted_rate) {
  return {{"sweep", sweep.name},
          {"value", value_json(point)},
          {"place", or_null(point.place)},
          {"method", method},
          {"facets", point.facets},
          {"judged", inverted_rate.has_value()},
          {"inverted_rate", or_null(inverted_rate)},
          {"covered_pixels", point.lists.seen},
          {"unjudged_pixels", point.lists.unjudged},
          {"inverted_pixels", or_null(errors.inverted_pixels)},
          {"wrong_pixels", or_null(errors.wrong_pixels)},
          {"embree_rays", point.embree.seen},
          {"embree_unjudged", point.embree.unjudged},
          {"embree_inverted", or_null(errors.inverted_rays)}};
}

// Calls `visit` with each row.
template <typename Visit>
void for_each_row(const Stability& stability, const Visit& visit) {
  for (const StabilitySweep& sweep : stability.sweeps) {
    for (const StabilityPoint& point : sweep.points) {
      for (std::size_t m = 0; m < stability.methods.size(); ++m) {
        visit(row_json(sweep, point, stability.methods[m], point.methods[m], point.inverted_rate(m)));
      }
    }
  }
}

// Where trouble begins, on either side of the mildest point.
Json first_points_json(const std::vector<PointRange>& ranges, const StabilitySweep& sweep) {
  Json points = Json::array();
  for (const std::size_t i : first_points(ranges, sweep.mildest)) {
    const StabilityPoint& point = sweep.points[i];
    points.push_back(point.place.empty() ? Json(point.value) : Json(point.place));
  }
  return points;
}

Json sweep_json(const StabilitySweep& sweep, const std::vector<std::string>& methods) {
  const SweepFindings findings = find_breaks(sweep, methods.size());
  Json breaks = Json::object();
  for (std::size_t m = 0; m < methods.size(); ++m) {
    breaks[methods[m]] = first_points_json(findings.broken[m], sweep);
  }
  return {{"name", sweep.name},
          {"title", sweep.title},
          {"unit", sweep.unit},
          {"description", sweep.description},
          {"breaks_at", breaks},
          {"lists_stop_at", first_points_json(findings.lists_stop, sweep)},
          {"embree_stops_at", first_points_json(findings.embree_stop, sweep)},
          {"findings", findings_text(sweep, methods, [](const std::string& method) { return method; })}};
}

std::string to_text(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// One element a line, so that files can be compared by eye and by diff.
void append_element(std::string& array, const Json& element) {
  array += join(array.size() > 1 ? ",\n  " : "\n  ", to_text(element));
}

// null is an empty field. Names and numbers have nothing to quote.
std::string csv_text(const Json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? value.get<std::string>() : to_text(value);
}

template <typename Fields, typename ToText>
std::string csv_line(const Fields& fields, const ToText& text) {
  std::string line;
  for (const auto& [key, value] : fields.items()) line += join(line.empty() ? "" : ",", text(key, value));
  return line + "\r\n";
}

}  // namespace

Status write_stability_json(const std::filesystem::path& path, const Stability& stability) {
  std::string sweeps = "[", rows = "[";
  for (const StabilitySweep& sweep : stability.sweeps) append_element(sweeps, sweep_json(sweep, stability.methods));
  for_each_row(stability, [&](const Json& row) { append_element(rows, row); });
  return replace_file_content(
      path, join("{\n \"machine\": ", to_text(stability.machine), ",\n \"command\": ", to_text(stability.command),
                 ",\n \"date\": ", to_text(stability.date),
                 ",\n \"size\": ", to_text(Json::array({stability.width, stability.height})),
                 ",\n \"views\": ", to_text(stability.views), ",\n \"methods\": ", to_text(stability.methods),
                 ",\n \"sweeps\": ", sweeps, "\n ],\n \"rows\": ", rows, "\n ]\n}\n"));
}

Status write_stability_csv(const std::filesystem::path& path, const Stability& stability) {
  const Json columns = row_json({}, {}, {}, {}, {});
  std::string text = csv_line(columns, [](const std::string& name, const Json&) { return name; });
  for_each_row(stability, [&](const Json& row) {
    text += csv_line(row, [](const std::string&, const Json& value) { return csv_text(value); });
  });
  return replace_file_content(path, text);
}

}  // namespace facetsort
