// Names of strategies: a kind's, then after a colon the method or number that it takes.
#include <algorithm>
#include <charconv>
#include <system_error>

#include "facetsort/blend/strategy.h"

namespace facetsort {
namespace {

// Some are only compared where they are named: another picture, or that of another strategy again.
enum class Listing { always, by_name };
enum class Detail { none, method, rule, number, number_if_any, budget_if_any };

struct NamedKind {
  StrategyKind kind;
  std::string_view name;
  Detail detail = Detail::none;
  Listing listing = Listing::always;
  std::size_t least = 1, most = 0, step = 1;  // of the number
};

// In the order in which reports show them.
constexpr NamedKind kinds[] = {
    {StrategyKind::unsorted, "unsorted"},
    {StrategyKind::double_sided, "double_sided"},
    {StrategyKind::separate_culling_pass, "separate_culling_pass"},
    {StrategyKind::depth_prepass, "depth_prepass"},
    {StrategyKind::depth_write, "depth_write"},
    {StrategyKind::additive, "additive", Detail::none, Listing::by_name},
    {StrategyKind::premultiplied_over, "premultiplied_over", Detail::none, Listing::by_name},
    {StrategyKind::facet_sort, "facet_sort", Detail::method},
    {StrategyKind::draw_order, "draw_order", Detail::rule},
    {StrategyKind::presorted_buffers, "presorted_buffers", Detail::number, Listing::always, 1, Strategy::most_buffers},
    {StrategyKind::depth_peeling, "depth_peeling", Detail::number_if_any, Listing::always, 1, Strategy::most_passes},
    {StrategyKind::dual_depth_peeling, "dual_depth_peeling", Detail::number_if_any, Listing::always, 1,
     Strategy::most_passes},
    {StrategyKind::weighted_blended, "weighted_blended"},
    {StrategyKind::moment_based, "moment_based", Detail::number, Listing::always, 4, 6, 2},
    {StrategyKind::multi_layer, "multi_layer", Detail::number, Listing::always, 1, most_kept_layers},
    {StrategyKind::stochastic, "stochastic", Detail::number, Listing::always, 1, most_depth_samples},
    {StrategyKind::automatic, "auto", Detail::budget_if_any},
    {StrategyKind::reference, "reference"},
};

constexpr std::string_view separator = ":", quantised = ":quantised";

std::optional<std::size_t> number_from_text(const NamedKind& kind, std::string_view text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  const bool is_one_of_them = number >= kind.least && number <= kind.most && (number - kind.least) % kind.step == 0;
  return is_number && is_one_of_them ? std::optional(number) : std::nullopt;
}

// A share: from 0 to 1.
std::optional<double> budget_from_text(std::string_view text) {
  double budget = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), budget);
  const bool is_number = error == std::errc() && end == text.data() + text.size();
  return is_number && budget >= 0 && budget <= 1 ? std::optional(budget) : std::nullopt;
}

// The shortest text that is this number.
std::string text_of(double number) {
  char text[32];
  return {text, std::to_chars(std::begin(text), std::end(text), number).ptr};
}

std::string rule_names() {
  std::string names;
  for (const DrawOrderRule rule : all_draw_order_rules()) {
    if (!names.empty()) names += '|';
    names.append(draw_order_rule_name(rule));
  }
  return names;
}

// A method, its depth keys quantised or not.
std::optional<Strategy> facet_sort_from_text(std::string_view text) {
  Strategy strategy{.kind = StrategyKind::facet_sort};
  if (text.ends_with(quantised)) {
    strategy.precision = Precision::quantised;
    text.remove_suffix(quantised.size());
  }
  const std::optional<Method> method = method_from_name(text);
  if (!method || (is_exact(*method) && strategy.precision == Precision::quantised)) return std::nullopt;
  strategy.method = *method;
  return strategy;
}

}  // namespace

bool Strategy::draws_in_order() const {
  return kind == StrategyKind::unsorted || kind == StrategyKind::premultiplied_over ||
         kind == StrategyKind::separate_culling_pass || kind == StrategyKind::double_sided ||
         kind == StrategyKind::facet_sort || kind == StrategyKind::presorted_buffers;
}

bool Strategy::discards_fragments() const {
  const bool peels = kind == StrategyKind::depth_peeling || kind == StrategyKind::dual_depth_peeling;
  return kind == StrategyKind::depth_prepass || kind == StrategyKind::depth_write || (peels && number > 0);
}

std::string Strategy::name() const {
  for (const NamedKind& named : kinds) {
    if (named.kind != kind) continue;
    std::string text(named.name);
    const bool has_number = named.detail == Detail::number || (named.detail == Detail::number_if_any && number > 0);
    if (named.detail == Detail::method) text.append(separator).append(method_name(method));
    if (named.detail == Detail::method && precision == Precision::quantised) text.append(quantised);
    if (named.detail == Detail::rule) text.append(separator).append(draw_order_rule_name(rule));
    const bool has_budget = named.detail == Detail::budget_if_any && error_budget > 0;
    if (has_budget) text.append(separator).append(text_of(error_budget));
    if (has_number) text.append(separator).append(std::to_string(number));
    return text;
  }
  return {};
}

std::vector<Strategy> all_strategies() {
  std::vector<Strategy> strategies;
  for (const NamedKind& named : kinds) {
    if (named.detail == Detail::method) {
      for (const Method method : all_methods()) strategies.push_back({.kind = named.kind, .method = method});
    } else if (named.listing == Listing::always && named.detail != Detail::number && named.detail != Detail::rule &&
               named.detail != Detail::budget_if_any) {
      strategies.push_back({.kind = named.kind});
    }
  }
  return strategies;
}

std::vector<std::string> numbered_strategy_names() {
  std::vector<std::string> names;
  for (const NamedKind& named : kinds) {
    if (named.listing == Listing::by_name) names.emplace_back(named.name);
    if (named.detail == Detail::method) names.push_back(std::string(named.name).append(":METHOD").append(quantised));
    if (named.detail == Detail::rule) names.push_back(std::string(named.name).append(separator).append(rule_names()));
    if (named.detail == Detail::budget_if_any) {
      names.emplace_back(named.name);
      names.push_back(std::string(named.name).append(separator).append("0..1"));
    }
    if (named.detail != Detail::number && named.detail != Detail::number_if_any) continue;
    const std::string_view between = named.least + named.step == named.most ? "|" : "..";
    names.push_back(std::string(named.name).append(separator).append(std::to_string(named.least)));
    names.back().append(between).append(std::to_string(named.most));
  }
  return names;
}

std::optional<Strategy> strategy_from_name(std::string_view name) {
  const std::size_t end = std::min(name.find(separator), name.size());
  const auto named = std::find_if(std::begin(kinds), std::end(kinds),
                                  [&](const auto& kind) { return kind.name == name.substr(0, end); });
  if (named == std::end(kinds)) return std::nullopt;
  if (end == name.size()) {
    if (named->detail == Detail::number || named->detail == Detail::rule) return std::nullopt;
    return Strategy{.kind = named->kind};
  }
  const std::string_view detail = name.substr(end + separator.size());
  if (named->detail == Detail::none) return std::nullopt;
  if (named->detail == Detail::method) return facet_sort_from_text(detail);
  if (named->detail == Detail::rule) {
    const std::optional<DrawOrderRule> rule = draw_order_rule_from_name(detail);
    return rule ? std::optional(Strategy{.kind = named->kind, .rule = *rule}) : std::nullopt;
  }
  if (named->detail == Detail::budget_if_any) {
    const std::optional<double> budget = budget_from_text(detail);
    return budget ? std::optional(Strategy{.kind = named->kind, .error_budget = *budget}) : std::nullopt;
  }
  const std::optional<std::size_t> number = number_from_text(*named, detail);
  return number ? std::optional(Strategy{.kind = named->kind, .number = *number}) : std::nullopt;
}

}  // namespace facetsort
