#include "facetsort/report/stability_plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>

#include "facetsort/report/html.h"
#include "facetsort/report/join.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/stability_findings.h"
#include "facetsort/report/summary.h"

namespace facetsort {
namespace {

// Pixels of the picture, from the top: the logarithmic axis, a row a method for exact zeros, a row a referee, the axis.
constexpr double width = 640, left = 64, right = 20, top = 14;
constexpr double place_spacing = 58;  // between places that are no number, left of the numbers
constexpr double decade_height = 36;
constexpr int lowest_decade = -3, highest_decade = 2;  // percent, as powers of ten; 0 is below
constexpr double log_bottom = top + (highest_decade - lowest_decade) * decade_height;
constexpr double zero_top = log_bottom + 12, zero_row = 9, referee_row = 15;
constexpr double tick_clearance = 34;  // between two labels of the axis

// Shapes in a box of side 2 around 0, filled or as strokes.
struct Look {
  std::string_view shape;
  bool filled;
};
constexpr std::array<Look, stability_looks> looks{{{"M-1-1L1 1M-1 1L1-1", false},
                                                   {"M-1 0A1 1 0 0 0 1 0A1 1 0 0 0-1 0Z", true},
                                                   {"M-.9-.9H.9V.9H-.9Z", true},
                                                   {"M0-1.3L1.3 0L0 1.3L-1.3 0Z", true},
                                                   {"M0-1.2L1.2 .9H-1.2Z", true},
                                                   {"M0 1.2L1.2-.9H-1.2Z", true},
                                                   {"M-1.2 0H1.2M0-1.2V1.2", false},
                                                   {"M-1 0A1 1 0 0 0 1 0A1 1 0 0 0-1 0Z", false}}};

std::string number(double value) {
  return fixed_text(value, 1);
}

std::string look_of(std::size_t method) {
  return join("look-", std::to_string(method % stability_looks));
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view text) {
  return join("<text x=\"", number(x), "\" y=\"", number(y), "\" text-anchor=\"", anchor, "\">", html_escape(text),
              "</text>");
}

std::string line(double x1, double y1, double x2, double y2, std::string_view style) {
  return join("<line class=\"", style, "\" x1=\"", number(x1), "\" y1=\"", number(y1), "\" x2=\"", number(x2),
              "\" y2=\"", number(y2), "\"/>");
}

std::string rectangle(double x, double y, double w, double h, std::string_view style) {
  return join("<rect class=\"", style, "\" x=\"", number(x), "\" y=\"", number(y), "\" width=\"", number(w),
              "\" height=\"", number(h), "\"/>");
}

// The text in one line or two, the last word below.
std::string place_label(double x, double y, const std::string& place) {
  const std::size_t space = place.rfind(' ');
  if (space == std::string::npos) return text_at(x, y, "middle", place);
  return text_at(x, y, "middle", place.substr(0, space)) + text_at(x, y + 14, "middle", place.substr(space + 1));
}

// Where everything is along the axis.
class HorizontalAxis {
 public:
  explicit HorizontalAxis(const StabilitySweep& sweep) : sweep_(sweep) {
    lowest_ = std::numeric_limits<double>::infinity();
    highest_ = -lowest_;
    for (const StabilityPoint& point : sweep.points) {
      places_ += !point.place.empty();
      if (!point.place.empty()) continue;
      lowest_ = std::min(lowest_, std::log10(point.value));
      highest_ = std::max(highest_, std::log10(point.value));
    }
    begin_ = left + 16 + place_spacing * static_cast<double>(places_);
    end_ = width - right;
  }

  double at(double logarithm) const {
    if (highest_ <= lowest_) return 0.5 * (begin_ + end_);
    return begin_ + (logarithm - lowest_) / (highest_ - lowest_) * (end_ - begin_);
  }

  double of(std::size_t index) const {
    const StabilityPoint& point = sweep_.points[index];
    if (point.place.empty()) return at(std::log10(point.value));
    const auto before = std::count_if(sweep_.points.begin(), sweep_.points.begin() + static_cast<std::ptrdiff_t>(index),
                                      [](const StabilityPoint& p) { return !p.place.empty(); });
    return left + 28 + place_spacing * static_cast<double>(before);
  }

  bool has_places() const { return places_ > 0; }

  // Decades, as few as have room; the first and the last value; the places.
  std::string labels(double y) const {
    std::string svg;
    std::vector<double> taken;
    const auto add = [&](double logarithm) {
      const double x = at(logarithm);
      if (std::any_of(taken.begin(), taken.end(), [&](double t) { return std::abs(t - x) < tick_clearance; })) return;
      taken.push_back(x);
      StabilityPoint point;
      point.value = std::pow(10.0, logarithm);
      svg += text_at(x, y, "middle", point_text(point));
    };
    for (std::size_t i = 0; i < sweep_.points.size(); ++i) {
      if (!sweep_.points[i].place.empty()) svg += place_label(of(i), y, sweep_.points[i].place);
    }
    if (places_ < sweep_.points.size()) {
      add(lowest_);
      add(highest_);
      int step = 1;
      while ((highest_ - lowest_) / step * tick_clearance * 1.4 > end_ - begin_) ++step;
      for (auto decade = static_cast<int>(std::ceil(lowest_)); decade <= highest_; ++decade) {
        if (decade % step == 0) add(decade);
      }
    }
    return svg;
  }

 private:
  const StabilitySweep& sweep_;
  std::size_t places_ = 0;
  double lowest_, highest_, begin_, end_;
};

double height_of(double rate) {
  const double decade = std::clamp(std::log10(100 * rate), double{lowest_decade}, double{highest_decade});
  return top + (highest_decade - decade) * decade_height;
}

double zero_height(std::size_t method) {
  return zero_top + zero_row * (static_cast<double>(method) + 0.5);
}

// Grid, the band of what is right enough, and the axis of percent.
std::string vertical_axis(double zero_bottom) {
  std::string svg =
      rectangle(left, height_of(right_enough), width - left, zero_bottom - height_of(right_enough), "enough");
  for (int decade = lowest_decade; decade <= highest_decade; ++decade) {
    const double y = top + (highest_decade - decade) * decade_height;
    const std::string percent = fixed_text(std::pow(10, decade), std::max(0, -decade));
    svg += line(left, y, width, y, "grid") + text_at(left - 8, y + 4, "end", percent + " %");
  }
  return svg + line(left, zero_top - 4, width, zero_top - 4, "zero") +
         line(left, zero_bottom, width, zero_bottom, "zero") +
         text_at(left - 8, 0.5 * (zero_top + zero_bottom) + 4, "end", "0");
}

// Bands over the points that nobody judges, each reaching halfway to its neighbours.
std::string unjudged_bands(const StabilitySweep& sweep, const HorizontalAxis& axis, double bottom) {
  std::string svg;
  for (const PointRange& range : find_breaks(sweep, 0).nobody_judges) {
    const double from = range.first == 0 ? left : 0.5 * (axis.of(range.first - 1) + axis.of(range.first));
    const double to =
        range.last + 1 == sweep.points.size() ? width : 0.5 * (axis.of(range.last) + axis.of(range.last + 1));
    svg += join(rectangle(from, top, to - from, bottom - top, "nobody"), "<text transform=\"translate(",
                number(0.5 * (from + to) + 4), " ", number(0.5 * (top + log_bottom)),
                ") rotate(-90)\" text-anchor=\"middle\">not judged</text>");
  }
  return svg;
}

std::string method_line(const StabilitySweep& sweep, const HorizontalAxis& axis, const std::string& name,
                        std::size_t method) {
  std::string path, marks;
  bool pen_down = false;
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const std::optional<double> rate = sweep.points[i].inverted_rate(method);
    if (!rate) {
      pen_down = false;
      continue;
    }
    const std::string x = number(axis.of(i)), y = number(*rate > 0 ? height_of(*rate) : zero_height(method));
    path += join(pen_down ? "L" : "M", x, " ", y);
    pen_down = true;
    marks +=
        join("<use href=\"#", look_of(method), "\" transform=\"translate(", x, " ", y, ") scale(3.4)\"><title>",
             html_escape(join(name, " at ", point_text(sweep.points[i]), ": ", percent_text(*rate), " % inverted")),
             "</title></use>");
  }
  return join("<g class=\"", look_of(method), "\"><path class=\"course\" d=\"", path, "\"/>", marks, "</g>\n");
}

// A square a point: filled where the referee judges, a cross where it can't.
std::string referee_strip(const StabilitySweep& sweep, const HorizontalAxis& axis, const std::string& name,
                          RefereeReach StabilityPoint::*reach, double y) {
  std::string svg = text_at(left - 8, y + 4, "end", name);
  for (std::size_t i = 0; i < sweep.points.size(); ++i) {
    const RefereeReach& at = sweep.points[i].*reach;
    const double x = axis.of(i);
    const std::string open =
        at.seen == 0 ? "nothing is seen"
                     : percent_text(static_cast<double>(at.unjudged) / static_cast<double>(at.seen)) + " % left open";
    svg += join("<g><title>", html_escape(join(name, " at ", point_text(sweep.points[i]), ": ", open)), "</title>",
                at.judges() ? rectangle(x - 4, y - 4, 8, 8, "judges")
                            : rectangle(x - 4, y - 4, 8, 8, "judges-not") + line(x - 4, y - 4, x + 4, y + 4, "cross") +
                                  line(x - 4, y + 4, x + 4, y - 4, "cross"),
                "</g>");
  }
  return svg + "\n";
}

}  // namespace

// Colours differ in lightness as well as in hue and have a contrast of 3 with their background.
const char* const stability_plot_style = R"css(
.look-0 { color: #c8402c; } .look-1 { color: #1f6fc4; } .look-2 { color: #7a55d6; } .look-3 { color: #0f8566; }
.look-4 { color: #b87000; } .look-5 { color: #c04d92; } .look-6 { color: #6b7280; } .look-7 { color: #111317; }
@media (prefers-color-scheme: dark) {
  .look-0 { color: #f0735f; } .look-1 { color: #5aa5f0; } .look-2 { color: #a88cf5; } .look-3 { color: #35c39a; }
  .look-4 { color: #e5a03a; } .look-5 { color: #ea86c0; } .look-6 { color: #9aa1ad; } .look-7 { color: #f3f4f6; }
}
.sweep { display: block; width: 100%; height: auto; max-width: 900px; font-size: 12px; }
.sweep text { fill: var(--muted); }
.sweep .grid { stroke: var(--line); }
.sweep .zero { stroke: var(--muted); stroke-dasharray: 6 4; }
.sweep .enough { fill: var(--good); opacity: 0.11; }
.sweep .nobody { fill: var(--muted); opacity: 0.2; }
.sweep .course { fill: none; stroke: currentColor; stroke-width: 1.5; opacity: 0.75; }
.sweep .judges { fill: var(--good); }
.sweep .judges-not { fill: none; stroke: var(--bad); }
.sweep .cross { stroke: var(--bad); stroke-width: 1.5; }
.sweep-scroll { overflow-x: auto; }
@media (max-width: 760px) { .sweep { min-width: 560px; } }
)css";

std::string stability_marks() {
  std::string svg = "<svg class=\"hidden\" aria-hidden=\"true\"><defs>";
  for (std::size_t i = 0; i < looks.size(); ++i) {
    svg += join("<path id=\"", look_of(i), "\" d=\"", looks[i].shape, "\" fill=\"",
                looks[i].filled ? "currentColor" : "none", "\" stroke=\"currentColor\" stroke-width=\"0.6\"/>");
  }
  return svg + "</defs></svg>\n";
}

std::string stability_mark(std::size_t method) {
  return join("<svg class=\"mark ", look_of(method),
              "\" viewBox=\"-1.8 -1.8 3.6 3.6\" aria-hidden=\"true\"><use href=\"#", look_of(method), "\"/></svg>");
}

std::string stability_plot(const StabilitySweep& sweep, const std::vector<std::string>& methods) {
  const HorizontalAxis axis(sweep);
  const double zero_bottom = zero_top + zero_row * static_cast<double>(methods.size()) + 4;
  const double lists_row = zero_bottom + referee_row, embree_row = lists_row + referee_row;
  const double labels = embree_row + 22;
  const double title = labels + (axis.has_places() ? 34 : 20), height = title + 8;
  std::string svg = join("<div class=\"sweep-scroll\"><svg class=\"sweep\" viewBox=\"0 0 ", number(width), " ",
                         number(height), "\" role=\"img\" aria-label=\"",
                         html_escape(join("Inverted share against ", sweep.title, ", one line a method.")), "\">\n");
  svg += vertical_axis(zero_bottom) + unjudged_bands(sweep, axis, zero_bottom) + "\n";
  for (std::size_t m = 0; m < methods.size(); ++m) svg += method_line(sweep, axis, methods[m], m);
  svg += referee_strip(sweep, axis, "lists", &StabilityPoint::lists, lists_row);
  svg += referee_strip(sweep, axis, "Embree", &StabilityPoint::embree, embree_row);
  svg += axis.labels(labels);
  return svg + text_at(0.5 * (left + width), title, "middle", join(sweep.title, ", ", sweep.unit)) + "</svg></div>\n";
}

}  // namespace facetsort
