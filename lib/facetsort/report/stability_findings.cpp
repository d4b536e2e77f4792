#include "facetsort/report/stability_findings.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "facetsort/report/join.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/summary.h"

namespace facetsort {
namespace {

double share(std::size_t part, std::size_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

enum class Presence { no, yes, open };

// Maximal runs of yes; open points are passed over.
template <typename PresenceOf>
std::vector<PointRange> find_ranges(const StabilitySweep& sweep, const PresenceOf& presence_of) {
  std::vector<PointRange> ranges;
  bool in_range = false;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const Presence presence = presence_of(sweep.points[i]);
    if (presence == Presence::open) continue;
    if (presence == Presence::yes) {
      if (in_range) {
        ranges.back().last = i;
      } else {
        ranges.push_back({i, i});
      }
    }
    in_range = presence == Presence::yes;
  }
  return ranges;
}

// "a, b and c".
std::string listed(const std::vector<std::string>& items) {
  std::string list;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) list += i + 1 == items.size() ? " and " : ", ";
    list += items[i];
  }
  return list;
}

bool is_spotless(const StabilitySweep& sweep, std::size_t method) {
  return std::all_of(sweep.points.begin(), sweep.points.end(),
                     [&](const StabilityPoint& point) { return point.inverted_rate(method).value_or(0) == 0; });
}

// Methods that break in the same places share a sentence.
std::string broken_text(const StabilitySweep& sweep, const SweepFindings& findings,
                        const std::vector<std::string>& methods,
                        const std::function<std::string(const std::string&)>& method_text) {
  std::vector<std::pair<std::string, std::vector<std::string>>> groups;  // where, who
  std::vector<std::string> right, spotless;
  for (std::size_t m = 0; m < methods.size(); ++m) {
    if (findings.broken[m].empty()) {
      (is_spotless(sweep, m) ? spotless : right).push_back(method_text(methods[m]));
      continue;
    }
    const std::string where = ranges_text(findings.broken[m], sweep);
    const auto group = std::find_if(groups.begin(), groups.end(), [&](const auto& g) { return g.first == where; });
    if (group == groups.end()) {
      groups.emplace_back(where, std::vector<std::string>{method_text(methods[m])});
    } else {
      group->second.push_back(method_text(methods[m]));
    }
  }
  std::string text;
  for (const auto& [where, who] : groups) {
    text += join(text.empty() ? "" : " ", listed(who), who.size() == 1 ? " breaks " : " break ", where, ".");
  }
  if (!right.empty()) {
    text += join(text.empty() ? "" : " ", listed(right), right.size() == 1 ? " stays" : " stay", " under ",
                 right_enough_percent, " % wherever a referee judges.");
  }
  if (!spotless.empty()) {
    text += join(text.empty() ? "" : " ", listed(spotless), spotless.size() == 1 ? " inverts" : " invert",
                 " nothing wherever a referee judges.");
  }
  return text;
}

std::string referees_text(const StabilitySweep& sweep, const SweepFindings& findings) {
  const std::vector<PointRange>&lists = findings.lists_stop, &embree = findings.embree_stop;
  if (lists.empty() && embree.empty()) return "Both referees judge throughout.";
  if (lists == embree) {
    return join("Neither referee can judge ", ranges_text(lists, sweep), ": nothing is said there.");
  }
  std::string text = lists.empty() ? "The per-pixel lists judge throughout"
                                   : join("The per-pixel lists cannot judge ", ranges_text(lists, sweep));
  text +=
      embree.empty() ? "; Embree judges throughout." : join("; Embree cannot judge ", ranges_text(embree, sweep), ".");
  if (!findings.nobody_judges.empty()) {
    text += join(" Where neither can, ", ranges_text(findings.nobody_judges, sweep), ", nothing is said.");
  }
  return text;
}

}  // namespace

bool RefereeReach::judges() const {
  return seen > 0 && share(unjudged, seen) <= most_unjudged;
}

std::optional<double> StabilityPoint::inverted_rate(std::size_t method) const {
  std::optional<double> rate;
  if (methods[method].inverted_pixels) rate = share(*methods[method].inverted_pixels, lists.seen);
  if (methods[method].inverted_rays) {
    rate = std::max(rate.value_or(0), share(*methods[method].inverted_rays, embree.seen));
  }
  return rate;
}

std::string point_text(const StabilityPoint& point) {
  if (!point.place.empty()) return point.place;
  if (point.value == 0) return "0";
  // Three digits, without zeros that say nothing; an exponent where there would be many zeros.
  const int exponent = static_cast<int>(std::floor(std::log10(point.value) + 1e-9));
  const bool plain = exponent >= -2 && exponent <= 3;
  std::string digits =
      fixed_text(plain ? point.value : point.value / std::pow(10, exponent), plain ? std::max(0, 2 - exponent) : 2);
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  return plain ? digits : join(digits, "e", std::to_string(exponent));
}

SweepFindings find_breaks(const StabilitySweep& sweep, std::size_t methods) {
  SweepFindings findings;
  for (std::size_t m = 0; m < methods; ++m) {
    findings.broken.push_back(find_ranges(sweep, [m](const StabilityPoint& point) {
      const std::optional<double> rate = point.inverted_rate(m);
      return !rate ? Presence::open : *rate > right_enough ? Presence::yes : Presence::no;
    }));
  }
  const auto stops = [&](const auto& judges) {
    return find_ranges(sweep,
                       [&](const StabilityPoint& point) { return judges(point) ? Presence::no : Presence::yes; });
  };
  findings.lists_stop = stops([](const StabilityPoint& point) { return point.lists.judges(); });
  findings.embree_stop = stops([](const StabilityPoint& point) { return point.embree.judges(); });
  findings.nobody_judges =
      stops([](const StabilityPoint& point) { return point.lists.judges() || point.embree.judges(); });
  return findings;
}

std::vector<std::size_t> first_points(const std::vector<PointRange>& ranges, std::size_t mildest) {
  std::optional<std::size_t> below, above;
  for (const PointRange& range : ranges) {
    if (range.first <= mildest && mildest <= range.last) return {mildest};
    if (range.last < mildest) below = range.last;
    if (range.first > mildest && !above) above = range.first;
  }
  std::vector<std::size_t> points;
  if (below) points.push_back(*below);
  if (above) points.push_back(*above);
  return points;
}

std::string ranges_text(const std::vector<PointRange>& ranges, const StabilitySweep& sweep) {
  std::vector<std::string> texts;
  for (const PointRange& range : ranges) {
    if (range.first == 0 && range.last + 1 == sweep.points.size()) return "at all values";
    const StabilityPoint& first = sweep.points[range.first];
    texts.push_back(join(first.place.empty() ? "at " : "", point_text(first)));
    if (range.first != range.last) texts.back() += join(" to ", point_text(sweep.points[range.last]));
  }
  return listed(texts);
}

std::string findings_text(const StabilitySweep& sweep, const std::vector<std::string>& methods,
                          const std::function<std::string(const std::string&)>& method_text) {
  const SweepFindings findings = find_breaks(sweep, methods.size());
  const bool any_judged = std::any_of(sweep.points.begin(), sweep.points.end(), [](const StabilityPoint& point) {
    return point.lists.judges() || point.embree.judges();
  });
  if (!any_judged) return "No referee can judge anywhere here.";
  return join(broken_text(sweep, findings, methods, method_text), " ", referees_text(sweep, findings));
}

}  // namespace facetsort
