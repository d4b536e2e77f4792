// results.json and results.csv: the rows as they are, for programs.
#include <charconv>
#include <nlohmann/json.hpp>
#include <string>

#include "facetsort/report/join.h"
#include "facetsort/report/replace_file.h"
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

// The columns of both files; `eye` is the only one that is not a number, a string or null.
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
  text += ",\n \"rows\": " + array_text(comparison.rows, row_json) + "\n}\n";
  return replace_file_content(path, text);
}

Status write_csv(const std::filesystem::path& path, const Comparison& comparison) {
  std::string text;
  const Json columns = row_json(Row{});
  for (const auto& [name, value] : columns.items()) text += join(text.empty() ? "" : ",", name);
  text += "\r\n";
  for (const Row& row : comparison.rows) {
    const Json fields = row_json(row);
    bool first = true;
    for (const Json& field : fields) {
      text += join(first ? "" : ",", csv_field(csv_text(field)));
      first = false;
    }
    text += "\r\n";
  }
  return replace_file_content(path, text);
}

}  // namespace facetsort
