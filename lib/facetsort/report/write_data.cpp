// results.json and results.csv of a comparison, stability.json and stability.csv: the rows as they are, for programs.
#include <charconv>
#include <nlohmann/json.hpp>
#include <string>

#include "facetsort/report/exact_measures.h"
#include "facetsort/report/join.h"
#include "facetsort/report/replace_file.h"
#include "facetsort/report/stability.h"
#include "facetsort/report/stability_findings.h"
#include "facetsort/report/write_report.h"

namespace facetsort {
namespace {

using Json = nlohmann::ordered_json;  // keys in the order in which they are written

template <typename T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

// The shortest decimal that reads back as the same float: 0.3, where a plain conversion gives 0.30000001192092896.
double shortest_decimal(float value) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  double decimal = value;
  std::from_chars(buffer, end, decimal);
  return decimal;
}

// The columns of results.csv, and what results.json has too; `eye` is the only one that is not a number, a string or null.
Json row_json(const Row& row) {
  return {{"mesh", row.mesh},
          {"facets", row.facets},
          {"view", row.view},
          {"eye", Json::array({shortest_decimal(row.eye.x), shortest_decimal(row.eye.y), shortest_decimal(row.eye.z)})},
          {"projection", row.projection},
          {"strategy", row.strategy},
          {"method", row.method.empty() ? Json(nullptr) : Json(row.method)},
          {"facets_drawn", row.facets_drawn},
          {"pieces", row.pieces},
          {"triangles_out", row.triangles_out},
          {"passes", row.passes},
          {"bytes_per_pixel", row.bytes_per_pixel},
          {"prepare_ms", row.prepare_ms},
          {"prepared_bytes", row.prepared_bytes},
          {"order_ms", row.order.median_ms},
          {"order_ms_spread", row.order.spread_ms},
          {"blend_ms", row.blend.median_ms},
          {"blend_ms_spread", row.blend.spread_ms},
          {"peak_bytes", row.peak_bytes},
          {"covered_pixels", row.covered_pixels},
          {"wrong_pixels", or_null(row.wrong_pixels)},
          {"wrong_rate", or_null(row.wrong_rate)},
          {"inverted_pixels", or_null(row.inverted_pixels)},
          {"inverted_rate", or_null(row.inverted_rate)},
          {"miscovered_pixels", or_null(row.miscovered_pixels)},
          {"unjudged_pixels", row.unjudged_pixels},
          {"rmse", row.rmse},
          {"max_error", row.max_error},
          {"worst_backtrack", or_null(row.worst_backtrack)},
          {"embree_rays", row.embree_rays},
          {"embree_inverted", or_null(row.embree_inverted)},
          {"embree_unjudged", row.embree_unjudged}};
}

Json whole_row_json(const Row& row) {
  Json json = row_json(row);
  json["exact"] = row.exact ? exact_json<Json>(*row.exact) : Json(nullptr);
  return json;
}

Json value_json(const StabilityPoint& point) {
  return point.place.empty() ? Json(point.value) : Json(nullptr);
}

// The columns of both files: one row a sweep, point and method.
Json stability_row_json(const StabilitySweep& sweep, const StabilityPoint& point, const std::string& method,
                        const MethodErrors& errors, const std::optional<double>& inverted_rate) {
  return {{"sweep", sweep.name},
          {"value", value_json(point)},
          {"place", point.place.empty() ? Json(nullptr) : Json(point.place)},
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

std::vector<Json> stability_rows_json(const Stability& stability) {
  std::vector<Json> rows;
  for (const StabilitySweep& sweep : stability.sweeps) {
    for (const StabilityPoint& point : sweep.points) {
      for (std::size_t m = 0; m < stability.methods.size(); ++m) {
        rows.push_back(
            stability_row_json(sweep, point, stability.methods[m], point.methods[m], point.inverted_rate(m)));
      }
    }
  }
  return rows;
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

Json stability_sweep_json(const StabilitySweep& sweep, const std::vector<std::string>& methods) {
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

// On one line. File names need not be UTF-8, JSON must be: bytes that are not become U+FFFD.
std::string to_text(const Json& value) {
  return value.dump(-1, ' ', false, Json::error_handler_t::replace);
}

// RFC 4180: quoted where a comma, quote or line break makes it needed, quotes doubled.
std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

// null is an empty field; an array is its elements, comma-separated, in one field.
std::string csv_text(const Json& value) {
  if (value.is_null()) return "";
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return to_text(value);
  std::string text;
  for (const Json& element : value) text += join(text.empty() ? "" : ",", csv_text(element));
  return text;
}

// The line of names, and that of values.
std::string csv_names(const Json& row) {
  std::string line;
  for (const auto& [name, value] : row.items()) line += join(line.empty() ? "" : ",", name);
  return line + "\r\n";
}
std::string csv_fields(const Json& row) {
  std::string line;
  bool first = true;
  for (const Json& field : row) {
    line += join(first ? "" : ",", csv_field(csv_text(field)));
    first = false;
  }
  return line + "\r\n";
}

Json mesh_json(const MeshSummary& mesh) {
  return {{"name", mesh.name},
          {"facets", mesh.facets},
          {"mean_layers", mesh.mean_layers},
          {"most_layers", mesh.most_layers},
          {"embree_agreement", or_null(mesh.embree_agreement)}};
}

// One element a line, so that files can be compared by eye and by diff.
template <typename Element, typename ToJson>
std::string array_text(const std::vector<Element>& elements, const ToJson& to_json) {
  std::string text = "[";
  for (const Element& element : elements) text += join(text.size() > 1 ? ",\n  " : "\n  ", to_text(to_json(element)));
  return text + "\n ]";
}

}  // namespace

Status write_json(const std::filesystem::path& path, const Comparison& comparison) {
  std::string text = "{\n \"machine\": " + to_text(comparison.machine);
  text += ",\n \"command\": " + to_text(comparison.command);
  text += ",\n \"date\": " + to_text(comparison.date);
  text += ",\n \"size\": " + to_text(Json::array({comparison.width, comparison.height}));
  text += ",\n \"views\": " + to_text(comparison.views);
  text += ",\n \"meshes\": " + array_text(comparison.meshes, mesh_json);
  text += ",\n \"rows\": " + array_text(comparison.rows, whole_row_json) + "\n}\n";
  return replace_file_content(path, text);
}

Status write_csv(const std::filesystem::path& path, const Comparison& comparison) {
  std::string text = csv_names(row_json(Row{}));
  for (const Row& row : comparison.rows) text += csv_fields(row_json(row));
  return replace_file_content(path, text);
}

Status write_stability_json(const std::filesystem::path& path, const Stability& stability) {
  std::string text = "{\n \"machine\": " + to_text(stability.machine);
  text += ",\n \"command\": " + to_text(stability.command);
  text += ",\n \"date\": " + to_text(stability.date);
  text += ",\n \"size\": " + to_text(Json::array({stability.width, stability.height}));
  text += ",\n \"views\": " + to_text(stability.views);
  text += ",\n \"methods\": " + to_text(stability.methods);
  text += ",\n \"sweeps\": " + array_text(stability.sweeps, [&](const StabilitySweep& sweep) {
            return stability_sweep_json(sweep, stability.methods);
          });
  text += ",\n \"rows\": " + array_text(stability_rows_json(stability), [](const Json& row) { return row; }) + "\n}\n";
  return replace_file_content(path, text);
}

Status write_stability_csv(const std::filesystem::path& path, const Stability& stability) {
  std::string text = csv_names(stability_row_json({}, {}, {}, {}, {}));
  for (const Json& row : stability_rows_json(stability)) text += csv_fields(row);
  return replace_file_content(path, text);
}

}  // namespace facetsort
