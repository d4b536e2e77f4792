// Options whose values are more than a number or a word. All throw CLI::ValidationError, which names the option, where
// the text is not what they take.
#pragma once

#include <CLI/CLI.hpp>
#include <glm/glm.hpp>
#include <optional>
#include <string>

#include "facetsort/blend/image.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/order/method.h"

namespace facetsort {

struct PictureSize {
  int width = 512, height = 512;
};

// "X,Y,Z": three finite numbers.
glm::vec3 parse_point(const std::string& option, const std::string& text);
Strategy parse_strategy(const std::string& option, const std::string& text);

// Each variable holds the default until parsed. A count is a whole number from 1 to `most`; one that is 0 before has
// no number as its default.
CLI::Option* add_method_option(CLI::App& command, Method& method);
CLI::Option* add_format_option(CLI::App& command, PixelFormat& format);
CLI::Option* add_size_option(CLI::App& command, PictureSize& size, const std::string& description);
CLI::Option* add_count_option(CLI::App& command, const std::string& name, int& count, int most,
                              const std::string& description);
CLI::Option* add_radii_option(CLI::App& command, float& radii);
// A share of pixels, from 0 to 1.
CLI::Option* add_error_option(CLI::App& command, std::optional<double>& max_error);
// The same.
CLI::Option* add_budget_option(CLI::App& command, double& budget);
// A finite number of at least 1.
CLI::Option* add_growth_option(CLI::App& command, std::optional<double>& max_growth);

// "unsorted, double_sided, ...": every name that parse_strategy knows.
std::string strategy_names();

}  // namespace facetsort
