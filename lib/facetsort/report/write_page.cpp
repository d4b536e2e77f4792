// index.html: which strategy to take, at a glance; then mesh by mesh, why.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/report/difference_image.h"
#include "facetsort/report/exact_measures.h"
#include "facetsort/report/html.h"
#include "facetsort/report/join.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/page_style.h"
#include "facetsort/report/plots.h"
#include "facetsort/report/replace_file.h"
#include "facetsort/report/summary.h"
#include "facetsort/report/write_report.h"

namespace facetsort {
namespace {

using Marks = std::map<std::string, Mark, std::less<>>;

constexpr std::string_view dash = "\xe2\x80\x93";  // en dash
constexpr std::string_view thin = "\xe2\x80\xaf";  // narrow no-break space, between a number and its unit
constexpr std::string_view times_sign = "\xc3\x97";

// ---- Marks: the same for a strategy all over the page ----------------------------------------------------------

// What stands before the colon of a strategy's name.
std::string_view family_of(std::string_view strategy) {
  return strategy.substr(0, strategy.find(':'));
}

// Strategies that people know get a fixed look, so that reports can be compared; any other takes what is free. All
// colours keep a contrast of 3 with white and with near black, and differ in lightness as well as in hue.
struct KnownLook {
  std::string_view strategy;
  std::string_view colour;
  int symbol;
};
constexpr std::array<KnownLook, 11> known_looks{{{"unsorted", "#8a7a6a", 2},
                                                {"separate_culling_pass", "#c97a00", 8},
                                                {"double_sided", "#c9569c", 10},
                                                {"depth_prepass", "#128a6b", 4},
                                                {"depth_write", "#5f9e2f", 1},
                                                {"facet_sort:exact", "#d1442f", 6},
                                                {"facet_sort:exact_tree", "#9c2f5b", 6},
                                                {"facet_sort:presorted", "#e0662a", 6},
                                                {"depth_peeling", "#8d7b1a", 12},
                                                {"dual_depth_peeling", "#a06a2c", 14},
                                                {"reference", "#7a808a", 3}}};
// Members of a family such as facet_sort:… in turn: filled symbols, shades from blue to violet.
constexpr std::array<int, 6> member_symbols{7, 13, 5, 9, 11, 15};
constexpr std::array<std::string_view, 6> member_colours{"#1f78d1", "#7d5ae0", "#1590a8",
                                                         "#4668c4", "#9b59c8", "#3d87a8"};
constexpr std::array<int, 6> free_symbols{15, 11, 9, 5, 13, 7};
constexpr std::array<std::string_view, 4> free_colours{"#b8489a", "#2f8f4e", "#6a7fb0", "#b0603f"};

Marks choose_marks(const std::vector<std::string>& strategies) {
  Marks marks;
  std::size_t members = 0, others = 0;
  for (const std::string& strategy : strategies) {
    const auto known = std::find_if(known_looks.begin(), known_looks.end(),
                                    [&](const KnownLook& look) { return look.strategy == strategy; });
    Mark& mark = marks[strategy];
    if (known != known_looks.end()) {
      mark = {known->symbol, std::string(known->colour)};
    } else if (family_of(strategy) == "facet_sort") {
      mark = {member_symbols[members % member_symbols.size()],
              std::string(member_colours[members % member_colours.size()])};
      ++members;
    } else {
      mark = {free_symbols[others % free_symbols.size()], std::string(free_colours[others % free_colours.size()])};
      ++others;
    }
  }
  return marks;
}

// ---- Small pieces of text ---------------------------------------------------------------------------------------

// Long names may break after the colon and between words.
std::string strategy_html(std::string_view strategy) {
  std::string html;
  for (const char c : html_escape(strategy)) {
    html += c;
    if (c == ':' || c == '_') html += "<wbr>";
  }
  return html;
}

std::string mark_html(const Mark& mark) {
  return join("<svg class=\"mark\" viewBox=\"-1.6 -1.6 3.2 3.2\" aria-hidden=\"true\"><use href=\"#gpPt",
              std::to_string(mark.symbol - 1), "\" fill=\"none\" color=\"", mark.colour, "\" stroke=\"", mark.colour,
              "\" stroke-width=\"0.4\"/></svg>");
}

// Numbers too small or too near to all to be shown begin with < or >.
std::string percent_number(double rate) {
  return html_escape(percent_text(rate));
}
std::string milliseconds_number(double value) {
  return html_escape(milliseconds_text(value));
}
std::string percent(double rate) {
  return join(percent_number(rate), thin, "%");
}
std::string right_enough_bound() {
  return join(right_enough_percent, thin, "%");
}
std::string milliseconds(double value) {
  return join(milliseconds_number(value), thin, "ms");
}

std::string rate_text(const RateSummary& rate) {
  if (rate.mean) return percent(*rate.mean);
  return std::string(rate.not_judged ? "not judged" : dash);
}

// Classes of the heat map; the first bound over a rate is its class. 0 stands alone: no other rate is in its class.
struct RateClass {
  double below;
  std::string_view label;
};
constexpr std::array<RateClass, 6> rate_classes{{{0, "0"},
                                                 {right_enough, "under 0.1 %"},
                                                 {0.01, "under 1 %"},
                                                 {0.1, "under 10 %"},
                                                 {0.5, "under 50 %"},
                                                 {2, "50 % and more"}}};

std::string rate_class(double rate) {
  std::size_t index = 0;
  while (index + 1 < rate_classes.size() && rate > 0 && rate >= rate_classes[index].below) ++index;
  return "rate" + std::to_string(index);
}

std::string section_id(std::size_t mesh) {
  return "mesh-" + std::to_string(mesh + 1);
}

// "a, b and c", each through `text`.
template <typename Items, typename ToText>
std::string listed(const Items& items, const ToText& text) {
  std::string list;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) list += i + 1 == items.size() ? " and " : ", ";
    list += text(items[i]);
  }
  return list;
}

std::string count_of(std::size_t count, std::string_view one, std::string_view many) {
  return join(count_text(count), " ", count == 1 ? one : many);
}

// ---- Plots ------------------------------------------------------------------------------------------------------

std::string tooltip(std::string_view name, double rate, double time) {
  return join(name, ": ", percent_text(rate), " %, ", milliseconds_text(time), " ms");
}

Plot overall_plot(const Summary& summary, const Marks& marks) {
  Plot plot;
  plot.description = "Error against run time, one large mark a strategy over all meshes, one small mark a mesh.";
  plot.rate_label = "wrong pixels";
  for (const MeshResults& results : summary.meshes) {
    for (const StrategySummary& strategy : results.strategies) {
      if (!strategy.error()) continue;
      plot.points.push_back(
          {strategy.frame_ms, *strategy.error(),
           tooltip(strategy.strategy + ", " + results.mesh.name, *strategy.error(), strategy.frame_ms),
           marks.at(strategy.strategy), true});
    }
  }
  for (const OverallResults& overall : summary.overall) {
    if (!overall.mean_error) continue;
    plot.points.push_back(
        {overall.geometric_mean_frame_ms, *overall.mean_error,
         tooltip(overall.strategy + ", all meshes", *overall.mean_error, overall.geometric_mean_frame_ms),
         marks.at(overall.strategy), false});
  }
  return plot;
}

Plot mesh_plot(const MeshResults& results, const Marks& marks, RateSummary StrategySummary::*rate,
               const std::string& label) {
  Plot plot;
  plot.description = "Error (" + label + ") against run time on " + results.mesh.name + ", one mark a strategy.";
  plot.rate_label = label;
  for (const StrategySummary& strategy : results.strategies) {
    if (const std::optional<double>& mean = (strategy.*rate).mean) {
      plot.points.push_back({strategy.frame_ms, *mean, tooltip(strategy.strategy, *mean, strategy.frame_ms),
                             marks.at(strategy.strategy), false});
    }
  }
  return plot;
}

// The plots that have something to show, and where each is in the page.
struct PagePlots {
  DrawnPlots drawn;
  std::map<std::string, std::string> by_place;  // "overall"; section id and "-wrong" or "-inverted"

  std::string figure(const std::string& place, std::string_view caption) const {
    const auto found = by_place.find(place);
    if (found == by_place.end()) return "";
    return join("<figure>", found->second, "<figcaption class=\"muted\">", caption, "</figcaption></figure>\n");
  }
};

Result<PagePlots> draw_page_plots(const Summary& summary, const Marks& marks) {
  std::vector<std::string> places;
  std::vector<Plot> plots;
  const auto add = [&](std::string place, Plot plot) {
    if (plot.points.empty()) return;
    places.push_back(std::move(place));
    plots.push_back(std::move(plot));
  };
  add("overall", overall_plot(summary, marks));
  for (std::size_t i = 0; i < summary.meshes.size(); ++i) {
    add(section_id(i) + "-wrong", mesh_plot(summary.meshes[i], marks, &StrategySummary::wrong, "wrong pixels"));
    add(section_id(i) + "-inverted",
        mesh_plot(summary.meshes[i], marks, &StrategySummary::inverted, "inverted pixels"));
  }
  PagePlots page;
  if (plots.empty()) return page;
  Result<DrawnPlots> drawn = draw_plots(plots);
  if (!drawn.ok()) return drawn.status();
  page.drawn = std::move(drawn).value();
  for (std::size_t i = 0; i < places.size(); ++i) page.by_place[places[i]] = page.drawn.svgs[i];
  return page;
}

std::string legend_html(const std::vector<std::string>& strategies, const Marks& marks) {
  std::string html = "<ul class=\"legend\" aria-label=\"Marks\">\n";
  for (const std::string& strategy : strategies) {
    html += join("<li>", mark_html(marks.at(strategy)), strategy_html(strategy), "</li>\n");
  }
  return html + "</ul>\n";
}

// ---- The head of the page ---------------------------------------------------------------------------------------

std::string header_html(const Comparison& comparison, const Summary& summary) {
  const std::string size = join(std::to_string(comparison.width), times_sign, std::to_string(comparison.height));
  std::string html = join(
      "<header>\n<h1>Which transparency strategy to take</h1>\n<p>",
      count_of(summary.strategies.size(), "strategy", "strategies"), " drew ",
      count_of(summary.meshes.size(), "mesh", "meshes"), " from ",
      count_of(static_cast<std::size_t>(std::max(comparison.views, 0)), "viewpoint", "viewpoints"), " each at ", size,
      " pixels on a software blend target. Every picture was compared with a reference that sorts the "
      "fragments of each pixel by their own depth, and every frame was timed.</p>\n");
  html += join("<p class=\"facts\">", html_escape(comparison.date), " \xc2\xb7 ", html_escape(comparison.machine),
               "<br><code>", html_escape(comparison.command), "</code></p>\n");
  if (comparison.has_stability_page) {
    html += "<p>How far each order can be trusted: <a href=\"stability.html\">where methods break</a>.</p>\n";
  }
  html += "<nav aria-label=\"Meshes\"><ul>\n";
  for (std::size_t i = 0; i < summary.meshes.size(); ++i) {
    html += join("<li><a href=\"#", section_id(i), "\">", html_escape(summary.meshes[i].mesh.name), "</a></li>\n");
  }
  return html + "</ul></nav>\n</header>\n";
}

std::string overall_verdict_html(const Summary& summary) {
  if (!summary.recommendation) {
    return "<div class=\"verdict none\"><p class=\"headline\">No strategy could be judged.</p></div>\n";
  }
  const std::string& name = summary.recommendation->strategy;
  const OverallResults& overall =
      *std::find_if(summary.overall.begin(), summary.overall.end(),
                    [&](const OverallResults& results) { return results.strategy == name; });
  std::string html;
  if (summary.recommendation->is_right_enough) {
    html = join("<div class=\"verdict\"><p class=\"headline\">Take <b>", strategy_html(name), "</b>: under ",
                right_enough_bound(), " wrong pixels on ", count_text(overall.right_meshes), " of ",
                count_of(overall.judged_meshes, "mesh", "meshes"), ", at ", milliseconds(overall.median_frame_ms),
                " a frame (median).</p>\n");
  } else {
    html = join(
        "<div class=\"verdict none\"><p class=\"headline\">No strategy is right on most meshes. The closest is <b>",
        strategy_html(name), "</b>: under ", right_enough_bound(), " wrong pixels on ",
        count_text(overall.right_meshes), " of ", count_text(overall.judged_meshes), ", ", percent(*overall.mean_error),
        " in the mean, at ", milliseconds(overall.median_frame_ms), " a frame (median).</p>\n");
  }
  std::vector<std::size_t> unsolved, better;
  for (std::size_t i = 0; i < summary.meshes.size(); ++i) {
    const auto& recommendation = summary.meshes[i].recommendation;
    if (!recommendation) continue;
    if (!recommendation->is_right_enough) {
      unsolved.push_back(i);
    } else if (recommendation->strategy != name) {
      better.push_back(i);
    }
  }
  const auto link = [&](std::size_t i) {
    return join("<a href=\"#", section_id(i), "\">", html_escape(summary.meshes[i].mesh.name), "</a>");
  };
  if (overall.right_meshes > 0 && !unsolved.empty()) {
    html += join("<p>On ", listed(unsolved, link), " no strategy stays under ", right_enough_bound(), ".</p>\n");
  }
  if (!better.empty()) {
    html += join("<p>Another one is the better choice on ",
                 listed(better,
                        [&](std::size_t i) {
                          return join(link(i), " (", strategy_html(summary.meshes[i].recommendation->strategy), ")");
                        }),
                 ".</p>\n");
  }
  return html + "</div>\n";
}

std::string how_to_read_html() {
  std::string ramp = "linear-gradient(90deg";
  constexpr int steps = 16;
  for (int i = 0; i <= steps; ++i) {
    const float difference = std::pow(display_step, 1 - static_cast<float>(i) / steps);
    const glm::vec3 colour = 255.0f * difference_colour(difference);
    ramp += join(", rgb(", fixed_text(colour.r, 0), " ", fixed_text(colour.g, 0), " ", fixed_text(colour.b, 0), ")");
  }
  ramp += ")";
  return join(
      "<details class=\"box\" open><summary>How to read this page</summary>\n<dl>\n"
      "<dt>wrong</dt><dd>Share of the covered pixels whose colour differs from the reference by more than one step "
      "of an 8-bit display (1/255) in some channel. Layers at one depth may be drawn either way: a pixel is right if "
      "some order of them gives its colour. Every strategy can be judged so.</dd>\n"
      "<dt>inverted</dt><dd>Share of the covered pixels in which something far was drawn over something nearer. Only "
      "strategies that draw facets in an order can be judged so; ",
      dash,
      " for the rest.</dd>\n"
      "<dt>miscovered</dt><dd>Pixels drawn more or less often than the facets of the mesh cover them: cracks and "
      "double cover.</dd>\n"
      "<dt>unjudged</dt><dd>Pixels that differ and have more orders of layers at one depth than can be tried: they "
      "count neither way. A view with more than ",
      fixed_text(100 * most_unjudged, 0), thin,
      "% of them is not judged at all.</dd>\n"
      "<dt>time</dt><dd>Ordering and blending of one frame, without reading or writing files; medians of repeated "
      "runs, with the distance between their quartiles after the \xc2\xb1. Rates are means, times medians, over "
      "the views.</dd>\n"
      "<dt>\xe2\x98\x85 take this</dt><dd>The fastest strategy with under ",
      right_enough_bound(), " wrong pixels; of those within ", fixed_text(100 * (equal_time - 1), 0), thin,
      "% of its time, the most right. "
      "Where none is that right, the most right one. The reference is what the others are judged by, and not up for "
      "choice.</dd>\n"
      "<dt>difference pictures</dt><dd>The reference in dark grey; pixels that are wrong, coloured by their largest "
      "difference in a channel: 1/255 <span class=\"ramp\" role=\"img\" aria-label=\"from violet over red and orange "
      "to "
      "pale yellow\" style=\"background:",
      ramp,
      "\"></span> 1 (of the range 0 to 1, in linear light; logarithmic).</dd>\n"
      "</dl></details>\n");
}

std::string heat_scale_html() {
  std::string html = "<ul class=\"scale\" aria-label=\"Colours\">\n";
  for (std::size_t i = 0; i < rate_classes.size(); ++i) {
    html += join("<li class=\"rate", std::to_string(i), "\">", rate_classes[i].label, "</li>\n");
  }
  return html + "<li class=\"note muted\">\xe2\x98\x85 the one to take for the mesh</li></ul>\n";
}

std::string heat_cell_html(const MeshResults& results, const std::string& strategy,
                           RateSummary StrategySummary::*rate) {
  const StrategySummary* summary = results.find(strategy);
  if (summary == nullptr) return join("<td class=\"rate muted\">", dash, "</td>");
  const RateSummary& shown = summary->*rate;
  if (!shown.mean) return join("<td class=\"rate muted\">", rate_text(shown), "</td>");
  const bool taken = results.recommendation && results.recommendation->strategy == strategy;
  return join("<td class=\"rate ", rate_class(*shown.mean), "\"><span", taken ? " class=\"star\">" : ">",
              percent_number(*shown.mean), "</span></td>");
}

// Strategies down, meshes across.
std::string heat_map_html(const Summary& summary, const Marks& marks, RateSummary StrategySummary::*rate,
                          std::string_view caption) {
  std::string html = join("<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"", caption,
                          "\"><table class=\"heat\">\n<thead><tr><th scope=\"col\">", caption, ", %</th>");
  for (std::size_t i = 0; i < summary.meshes.size(); ++i) {
    html += join("<th scope=\"col\" class=\"mesh\"><a href=\"#", section_id(i), "\">",
                 html_escape(summary.meshes[i].mesh.name), "</a></th>");
  }
  html +=
      "<th scope=\"col\">right on<small>meshes</small></th><th scope=\"col\">time<small>ms, median</small></th>"
      "</tr></thead>\n<tbody>\n";
  for (const OverallResults& overall : summary.overall) {
    const bool taken = summary.recommendation && summary.recommendation->strategy == overall.strategy;
    html += join("<tr", taken ? " class=\"taken\"" : "", "><th scope=\"row\">", mark_html(marks.at(overall.strategy)),
                 strategy_html(overall.strategy), "</th>");
    for (const MeshResults& results : summary.meshes) html += heat_cell_html(results, overall.strategy, rate);
    html += join("<td>", count_text(overall.right_meshes), " of ", count_text(overall.judged_meshes), "</td><td>",
                 milliseconds_number(overall.median_frame_ms), "</td></tr>\n");
  }
  return html + "</tbody></table></div>\n";
}

std::string summary_html(const Summary& summary, const Marks& marks, const PagePlots& plots) {
  return join(
      "<section id=\"summary\">\n<h2>Over all meshes</h2>\n", overall_verdict_html(summary), heat_scale_html(),
      heat_map_html(summary, marks, &StrategySummary::wrong, "wrong pixels"),
      "<details class=\"table\"><summary>The same for inverted pixels</summary>\n",
      heat_map_html(summary, marks, &StrategySummary::inverted, "inverted pixels"), "</details>\n",
      "<h3>Error against run time</h3>\n<div class=\"columns\">\n",
      plots.figure("overall",
                   "Large marks: mean error and geometric mean time over all meshes; small marks: each mesh. Down and "
                   "left is better; in the green band a strategy is right enough; the dashed line is exactly 0."),
      legend_html(summary.strategies, marks), "</div>\n", how_to_read_html(), "</section>\n");
}

// ---- A mesh -----------------------------------------------------------------------------------------------------

std::string mesh_facts_html(const MeshSummary& mesh) {
  std::string html = join("<p class=\"facts\">", count_of(mesh.facets, "facet", "facets"));
  if (mesh.most_layers > 0) {
    html += join(" \xc2\xb7 ", fixed_text(mesh.mean_layers, 1), " layers a pixel on average, ",
                 count_text(mesh.most_layers), " at most \xc2\xb7 Embree, a second referee, ",
                 mesh.embree_agreement ? join("sees the reference's colour in ", percent(*mesh.embree_agreement),
                                              " of the covered pixels")
                                       : "could judge no pixel");
  }
  return html + "</p>\n";
}

// What the one to take is measured against: the fastest of the others.
std::string comparison_html(const MeshResults& results, const StrategySummary& taken) {
  const StrategySummary* fastest = nullptr;
  for (const StrategySummary& strategy : results.strategies) {
    if (strategy.strategy == reference_strategy || !strategy.error()) continue;
    if (fastest == nullptr || strategy.frame_ms < fastest->frame_ms) fastest = &strategy;
  }
  std::string html;
  if (fastest != nullptr && fastest->strategy != taken.strategy && fastest->frame_ms > 0) {
    html = join(" The fastest of all, ", strategy_html(fastest->strategy), ", takes ", milliseconds(fastest->frame_ms),
                " and is ", percent(*fastest->error()), " wrong.");
  }
  if (const StrategySummary* reference = results.find(reference_strategy)) {
    html += join(" Sorting every pixel's fragments (the reference) takes ", milliseconds(reference->frame_ms), ".");
  }
  return html;
}

std::string mesh_verdict_html(const MeshResults& results) {
  if (!results.recommendation) {
    return "<div class=\"verdict none\"><p class=\"headline\">No strategy could be judged.</p></div>\n";
  }
  const StrategySummary& taken = *results.find(results.recommendation->strategy);
  const std::string measure = taken.wrong.mean ? " wrong" : " inverted";
  const std::string figures =
      join(percent(*taken.error()), measure, " pixels at ", milliseconds(taken.frame_ms), " a frame");
  const std::string why = join("<p>", comparison_html(results, taken), "</p></div>\n");
  if (results.recommendation->is_right_enough) {
    return join("<div class=\"verdict\"><p class=\"headline\">Take <b>", strategy_html(taken.strategy),
                "</b>: ", figures, "; none under ", right_enough_bound(), " is clearly faster.</p>\n", why);
  }
  return join("<div class=\"verdict none\"><p class=\"headline\">No strategy stays under ", right_enough_bound(),
              ". The most right is <b>", strategy_html(taken.strategy), "</b>: ", figures, ".</p>\n", why);
}

std::string image_link_html(const std::string& path, const std::string& description, const Comparison& comparison) {
  const std::string url = url_path(path);
  return join("<a href=\"", url, "\"><img loading=\"lazy\" decoding=\"async\" width=\"",
              std::to_string(comparison.width), "\" height=\"", std::to_string(comparison.height), "\" src=\"", url,
              "\" alt=\"", html_escape(description), "\"></a>");
}

std::string picture_html(const ReportPicture& picture, const MeshResults& results, const Marks& marks,
                         const Comparison& comparison) {
  const StrategySummary* summary = results.find(picture.strategy);
  const bool taken = results.recommendation && results.recommendation->strategy == picture.strategy;
  const auto mark = marks.find(picture.strategy);
  std::string html = join("<figure", taken ? " class=\"taken\">" : ">", "\n");
  html += image_link_html(picture.picture, results.mesh.name + " drawn by " + picture.strategy, comparison);
  if (picture.difference.empty()) {
    html += join("<div class=\"same\" style=\"aspect-ratio:", std::to_string(comparison.width), "/",
                 std::to_string(comparison.height), "\">what the others are compared with</div>");
  } else {
    html += image_link_html(picture.difference, "Where " + picture.strategy + " is wrong on " + results.mesh.name,
                            comparison);
  }
  html += join("<figcaption><strong>", mark == marks.end() ? "" : mark_html(mark->second),
               strategy_html(picture.strategy), "</strong>");
  if (summary != nullptr) {
    html += join("<span>", rate_text(summary->wrong), " wrong</span>");
    if (summary->inverted.mean) html += join("<span>", rate_text(summary->inverted), " inverted</span>");
    html += join("<span>", milliseconds(summary->frame_ms), " a frame</span>");
  }
  return html + "</figcaption></figure>\n";
}

std::string pictures_html(const MeshResults& results, const Marks& marks, const Comparison& comparison) {
  std::string figures;
  for (const ReportPicture& picture : comparison.pictures) {
    if (picture.mesh == results.mesh.name) figures += picture_html(picture, results, marks, comparison);
  }
  if (figures.empty()) return "";
  return join(
      "<h3>Pictures, and where they are wrong</h3>\n<p class=\"muted\">One view; the figures are of all views. Select "
      "a picture for its full size.</p>\n<div class=\"pictures\">\n",
      figures, "</div>\n");
}

template <typename T, typename ToText>
std::string or_dash(const std::optional<T>& value, const ToText& text) {
  return value ? std::string(text(*value)) : std::string(dash);
}

// A mean that not all views could be part of says so.
std::string rate_cell_text(const RateSummary& rate, std::size_t views) {
  if (!rate.mean) return rate_text(rate);
  std::string text = percent_number(*rate.mean);
  if (rate.judged_views < views) {
    text += " (" + std::to_string(rate.judged_views) + " of " + std::to_string(views) + " views)";
  }
  return text;
}

std::string timing_text(const Timing& timing) {
  if (timing.median_ms == 0 && timing.spread_ms == 0) return "0";
  return join(milliseconds_number(timing.median_ms), " <span class=\"muted\">\xc2\xb1", thin,
              milliseconds_number(timing.spread_ms), "</span>");
}

// Errors are small numbers over many decades: three digits and an exponent of ten where they are tiny.
std::string error_text(double value) {
  if (value == 0) return "0";
  if (value >= 0.0005) return fixed_text(value, 4);
  const int exponent = static_cast<int>(std::floor(std::log10(value)));
  return join(fixed_text(value / std::pow(10, exponent), 1), times_sign, "10<sup>", std::to_string(exponent), "</sup>");
}

std::string mesh_table_html(const MeshResults& results, const Marks& marks) {
  static constexpr std::array<std::array<std::string_view, 2>, 21> headings{{{"wrong", "%, mean"},
                                                                             {"wrong", "%, worst view"},
                                                                             {"inverted", "%, mean"},
                                                                             {"inverted", "%, worst view"},
                                                                             {"order", "ms"},
                                                                             {"blend", "ms"},
                                                                             {"prepare", "ms, once"},
                                                                             {"passes", "a frame"},
                                                                             {"kept", "bytes a pixel"},
                                                                             {"facets drawn", "most"},
                                                                             {"pieces", "most"},
                                                                             {"triangles out", "most"},
                                                                             {"prepared", "memory"},
                                                                             {"peak", "memory, a frame"},
                                                                             {"rmse", "linear RGB"},
                                                                             {"largest error", "linear RGB"},
                                                                             {"worst backtrack", "over radius"},
                                                                             {"miscovered", "pixels"},
                                                                             {"unjudged", "pixels"},
                                                                             {"Embree inverted", "rays"},
                                                                             {"Embree unjudged", "rays"}}};
  std::string html = join(
      "<details class=\"table\" open><summary>All figures</summary>\n<div class=\"scroll\" "
      "tabindex=\"0\" role=\"region\" aria-label=\"All figures of ",
      html_escape(results.mesh.name), "\"><table>\n<thead><tr><th scope=\"col\">strategy</th>");
  for (const auto& [name, unit] : headings) html += join("<th scope=\"col\">", name, "<small>", unit, "</small></th>");
  html += "</tr></thead>\n<tbody>\n";
  for (const StrategySummary& strategy : results.strategies) {
    const bool taken = results.recommendation && results.recommendation->strategy == strategy.strategy;
    html += join("<tr", taken ? " class=\"taken\"" : "", "><th scope=\"row\">", mark_html(marks.at(strategy.strategy)),
                 strategy_html(strategy.strategy), taken ? " \xe2\x98\x85" : "", "</th>");
    const std::array<std::string, headings.size()> cells{rate_cell_text(strategy.wrong, strategy.views),
                                                         or_dash(strategy.wrong.worst, percent_number),
                                                         rate_cell_text(strategy.inverted, strategy.views),
                                                         or_dash(strategy.inverted.worst, percent_number),
                                                         timing_text(strategy.order),
                                                         timing_text(strategy.blend),
                                                         milliseconds_number(strategy.prepare_ms),
                                                         std::to_string(strategy.passes),
                                                         count_text(strategy.bytes_per_pixel),
                                                         count_text(strategy.facets_drawn),
                                                         count_text(strategy.pieces),
                                                         count_text(strategy.triangles_out),
                                                         bytes_text(strategy.prepared_bytes),
                                                         bytes_text(strategy.peak_bytes),
                                                         error_text(strategy.rmse),
                                                         error_text(strategy.max_error),
                                                         or_dash(strategy.worst_backtrack, error_text),
                                                         or_dash(strategy.miscovered_pixels, count_text),
                                                         count_text(strategy.unjudged_pixels),
                                                         or_dash(strategy.embree_inverted, count_text),
                                                         count_text(strategy.embree_unjudged)};
    for (const std::string& cell : cells) html += join("<td>", cell, "</td>");
    html += "</tr>\n";
  }
  return html + "</tbody></table></div></details>\n";
}

// Words of a name with underscores.
std::string words_html(std::string_view name) {
  std::string text = html_escape(name);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

// What the exact orders had to do in each view, in the manner of a solver's log; nothing where none was run.
std::string exact_table_html(const MeshResults& results, const Comparison& comparison) {
  std::string rows;
  for (const Row& row : comparison.rows) {
    if (row.mesh != results.mesh.name || !row.exact) continue;
    rows += join("<tr><th scope=\"row\">", html_escape(row.strategy), ", view ", std::to_string(row.view + 1), "</th>");
    for (const ExactCount& count : exact_counts) rows += join("<td>", count_text((*row.exact).*count.value), "</td>");
    for (const ExactTime& time : exact_times) {
      rows += join("<td>", milliseconds_number((*row.exact).*time.value_ms), "</td>");
    }
    rows += "</tr>\n";
  }
  if (rows.empty()) return "";
  std::string html = join(
      "<details class=\"table\"><summary>What the exact orders had to do</summary>\n<div class=\"scroll\" "
      "tabindex=\"0\" role=\"region\" aria-label=\"The exact orders of ",
      html_escape(results.mesh.name), "\"><table>\n<thead><tr><th scope=\"col\">strategy and view</th>");
  for (const ExactCount& count : exact_counts) html += join("<th scope=\"col\">", words_html(count.name), "</th>");
  for (const ExactTime& time : exact_times) {
    html += join("<th scope=\"col\">", words_html(time.name), "<small>ms</small></th>");
  }
  return join(html, "</tr></thead>\n<tbody>\n", rows, "</tbody></table></div></details>\n");
}

std::string mesh_html(std::size_t index, const MeshResults& results, const Marks& marks, const PagePlots& plots,
                      const Comparison& comparison) {
  std::vector<std::string> strategies;
  for (const StrategySummary& strategy : results.strategies) strategies.push_back(strategy.strategy);
  return join("<section id=\"", section_id(index), "\">\n<h2>", html_escape(results.mesh.name), "</h2>\n",
              mesh_facts_html(results.mesh), mesh_verdict_html(results), pictures_html(results, marks, comparison),
              "<h3>Error against run time</h3>\n<div class=\"columns\">\n",
              plots.figure(section_id(index) + "-wrong", "Wrong pixels, mean of the views."),
              plots.figure(section_id(index) + "-inverted",
                           "Inverted pixels, mean of the views; only strategies that draw in an order."),
              "</div>\n", legend_html(strategies, marks), mesh_table_html(results, marks),
              exact_table_html(results, comparison), "<p><a href=\"#summary\">Back to the summary</a></p>\n</section>\n");
}

std::string page_html(const Comparison& comparison, const Summary& summary, const Marks& marks,
                      const PagePlots& plots) {
  std::string html = join(
      "<!DOCTYPE html>\n<html lang=\"en-GB\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>facetsort: which transparency strategy to "
      "take</title>\n<style>",
      page_style, "</style>\n</head>\n<body>\n", "<svg class=\"hidden\" aria-hidden=\"true\">", plots.drawn.definitions,
      "</svg>\n", header_html(comparison, summary), "<main>\n", summary_html(summary, marks, plots));
  for (std::size_t i = 0; i < summary.meshes.size(); ++i) {
    html += mesh_html(i, summary.meshes[i], marks, plots, comparison);
  }
  return html +
         join(
             "</main>\n<footer>Made by facetsort compare. The same figures, a row for each mesh, view and strategy, "
             "are in <a href=\"results.json\">results.json</a> and <a href=\"results.csv\">results.csv</a>.</footer>\n"
             "<script>",
             page_script, "</script>\n</body>\n</html>\n");
}

}  // namespace

Status write_page(const std::filesystem::path& path, const Comparison& comparison) {
  const Summary summary = summarise(comparison);
  if (summary.meshes.empty()) return {Fault::bad_argument, path.string() + ": a comparison without rows has no page"};
  const Marks marks = choose_marks(summary.strategies);
  const Result<PagePlots> plots = draw_page_plots(summary, marks);
  if (!plots.ok()) return {plots.status().fault, path.string() + ": " + plots.status().message};
  return replace_file_content(path, page_html(comparison, summary, marks, plots.value()));
}

}  // namespace facetsort
