#include "arguments.h"

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "facetsort/exact/exact_sorter.h"

namespace facetsort {
namespace {

// The whole text as a number, in any notation but hexadecimal.
template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<float> parse_coordinate(std::string_view text) {
  const std::optional<double> number = parse_number<double>(text);
  if (!number || !std::isfinite(static_cast<float>(*number))) return std::nullopt;
  return static_cast<float>(*number);
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

PictureSize parse_size(const std::string& text) {
  const std::vector<std::string_view> parts = split(text, 'x');
  const std::optional<int> width = parse_number<int>(parts.front()), height = parse_number<int>(parts.back());
  if (parts.size() > 2 || !width || !height || *width < 1 || *height < 1) {
    throw CLI::ValidationError("--size", "'" + text + "' is neither N nor WxH, in whole pixels above 0");
  }
  return {*width, *height};
}

std::string method_names() {
  std::string names;
  for (const Method method : all_methods()) names.append(names.empty() ? "" : ", ").append(method_name(method));
  return names;
}

constexpr std::string_view rgba32f_name = "rgba32f", rgba8_name = "rgba8";

// From 0 to 1.
double parse_share(const std::string& option, const std::string& text) {
  const std::optional<double> number = parse_number<double>(text);
  if (!number || !(*number >= 0 && *number <= 1)) {
    throw CLI::ValidationError(option, "'" + text + "' is not a number from 0 to 1");
  }
  return *number;
}

}  // namespace

glm::vec3 parse_point(const std::string& option, const std::string& text) {
  const std::vector<std::string_view> parts = split(text, ',');
  glm::vec3 point;
  for (int i = 0; i < 3; ++i) {
    const std::optional<float> coordinate =
        parts.size() == 3 ? parse_coordinate(parts[static_cast<std::size_t>(i)]) : std::nullopt;
    if (!coordinate) throw CLI::ValidationError(option, "'" + text + "' is not X,Y,Z, three finite numbers");
    point[i] = *coordinate;
  }
  return point;
}

Strategy parse_strategy(const std::string& option, const std::string& text) {
  if (const std::optional<Strategy> strategy = strategy_from_name(text)) return *strategy;
  throw CLI::ValidationError(option, "no strategy is named '" + text + "'; there are " + strategy_names());
}

CLI::Option* add_method_option(CLI::App& command, Method& method) {
  const auto parse = [&method](const std::string& text) {
    const std::optional<Method> known = method_from_name(text);
    if (!known) {
      throw CLI::ValidationError("--method", "no method is named '" + text + "'; there are " + method_names());
    }
    method = *known;
  };
  return command.add_option_function<std::string>("--method", parse, "How the order is found: " + method_names())
      ->type_name("M")
      ->default_str(std::string(method_name(method)));
}

CLI::Option* add_format_option(CLI::App& command, PixelFormat& format) {
  const auto parse = [&format](const std::string& text) {
    if (text != rgba32f_name && text != rgba8_name) {
      throw CLI::ValidationError("--format", "no pixel format is named '" + text + "'; there are rgba32f, rgba8");
    }
    format = text == rgba8_name ? PixelFormat::rgba8 : PixelFormat::rgba32f;
  };
  return command
      .add_option_function<std::string>("--format", parse,
                                        "Pixels of the blend target: rgba32f, or rgba8, rounded after every blend")
      ->type_name("F")
      ->default_str(std::string(format == PixelFormat::rgba8 ? rgba8_name : rgba32f_name));
}

CLI::Option* add_size_option(CLI::App& command, PictureSize& size, const std::string& description) {
  return command
      .add_option_function<std::string>(
          "--size", [&size](const std::string& text) { size = parse_size(text); }, description)
      ->type_name("N|WxH")
      ->default_str(size.width == size.height ? std::to_string(size.width)
                                              : std::to_string(size.width) + "x" + std::to_string(size.height));
}

CLI::Option* add_count_option(CLI::App& command, const std::string& name, int& count, int most,
                              const std::string& description) {
  const auto parse = [&count, name, most](const std::string& text) {
    const std::optional<int> number = parse_number<int>(text);
    if (!number || *number < 1 || *number > most) {
      throw CLI::ValidationError(name, "'" + text + "' is not a whole number from 1 to " + std::to_string(most));
    }
    count = *number;
  };
  CLI::Option* option = command.add_option_function<std::string>(name, parse, description)->type_name("N");
  return count > 0 ? option->default_str(std::to_string(count)) : option;
}

CLI::Option* add_radii_option(CLI::App& command, float& radii) {
  const auto parse = [&radii](const std::string& text) {
    const std::optional<float> number = parse_coordinate(text);
    if (!number || *number <= 0) throw CLI::ValidationError("--radii", "'" + text + "' is not a number above 0");
    radii = *number;
  };
  return command
      .add_option_function<std::string>("--radii", parse,
                                        "Distance of the eyes from the box's centre, in bounding radii")
      ->type_name("D")
      ->default_str("2.5");
}

CLI::Option* add_growth_option(CLI::App& command, std::optional<double>& max_growth) {
  const auto parse = [&max_growth](const std::string& text) {
    const std::optional<double> number = parse_number<double>(text);
    if (!number || !std::isfinite(*number) || *number < 1) {
      throw CLI::ValidationError("--max-growth", "'" + text + "' is not a number of at least 1");
    }
    max_growth = *number;
  };
  return command
      .add_option_function<std::string>(
          "--max-growth", parse,
          "Of what cuts: most triangles out over facets in; what would take more cuts stays unordered and is counted")
      ->type_name("G")
      ->default_str(std::to_string(std::lround(ExactOptions{}.max_growth)));
}

CLI::Option* add_error_option(CLI::App& command, std::optional<double>& max_error) {
  const auto parse = [&max_error](const std::string& text) { max_error = parse_share("--max-error", text); };
  return command
      .add_option_function<std::string>(
          "--max-error", parse,
          "As few index buffers as have a mean share of inverted pixels of at most this, 0.0001 for "
          "0.01 %: at most --buffers of them, or 1000; exits with 1 where that is not enough")
      ->type_name("E");
}

CLI::Option* add_budget_option(CLI::App& command, double& budget) {
  const auto parse = [&budget](const std::string& text) { budget = parse_share("--budget", text); };
  return command
      .add_option_function<std::string>("--budget", parse,
                                        "Share of a view's pixels that may be wrong: 0.001 for 0.1 %")
      ->type_name("E")
      ->default_str("0");
}

std::string strategy_names() {
  std::string names;
  for (const Strategy& strategy : all_strategies()) names += (names.empty() ? "" : ", ") + strategy.name();
  for (const std::string& name : numbered_strategy_names()) names += ", " + name;
  return names;
}

}  // namespace facetsort
