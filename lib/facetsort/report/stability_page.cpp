// stability.html: where each method breaks, at a glance; then condition by condition, how.
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "facetsort/report/html.h"
#include "facetsort/report/join.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/page_style.h"
#include "facetsort/report/replace_file.h"
#include "facetsort/report/stability.h"
#include "facetsort/report/stability_findings.h"
#include "facetsort/report/stability_plot.h"
#include "facetsort/report/summary.h"

namespace facetsort {
namespace {

constexpr std::string_view thin = "\xe2\x80\xaf";  // narrow no-break space, between a number and its unit
constexpr std::string_view dash = "\xe2\x80\x93";  // en dash

// Long names may break between words.
std::string name_html(const std::string& name) {
  std::string html;
  for (const char c : html_escape(name)) html += c == '_' ? std::string("_<wbr>") : std::string(1, c);
  return html;
}

std::string code_html(const std::string& name) {
  return join("<b>", name_html(name), "</b>");
}

// ---- What one method does over all sweeps ------------------------------------------------------------------------

struct MethodTotals {
  std::size_t judged_points = 0, broken_points = 0;
  std::size_t errors = 0;  // inverted and wrong pixels and inverted rays
};

MethodTotals total(const Stability& stability, std::size_t method) {
  MethodTotals totals;
  for (const StabilitySweep& sweep : stability.sweeps) {
    for (const StabilityPoint& point : sweep.points) {
      const std::optional<double> rate = point.inverted_rate(method);
      if (!rate) continue;
      const MethodErrors& errors = point.methods[method];
      ++totals.judged_points;
      totals.broken_points += *rate > right_enough;
      totals.errors +=
          errors.inverted_pixels.value_or(0) + errors.wrong_pixels.value_or(0) + errors.inverted_rays.value_or(0);
    }
  }
  return totals;
}

std::string verdict_html(const Stability& stability) {
  std::vector<MethodTotals> totals;
  for (std::size_t m = 0; m < stability.methods.size(); ++m) totals.push_back(total(stability, m));
  const auto best = std::min_element(totals.begin(), totals.end(), [](const MethodTotals& a, const MethodTotals& b) {
    return std::pair(a.broken_points, a.errors) < std::pair(b.broken_points, b.errors);
  });
  if (best == totals.end() || best->judged_points == 0) {
    return "<div class=\"verdict none\"><p class=\"headline\">Nothing could be judged.</p></div>\n";
  }
  const std::string name = code_html(stability.methods[static_cast<std::size_t>(best - totals.begin())]);
  const std::string points = join(count_text(best->judged_points), " points that a referee can judge");
  if (best->errors == 0) {
    return join("<div class=\"verdict\"><p class=\"headline\">", name,
                " has no inverted and no wrong pixel at any of the ", points, ".</p></div>\n");
  }
  return join("<div class=\"verdict none\"><p class=\"headline\">No method is right throughout. ", name,
              " breaks at the fewest: ", count_text(best->broken_points), " of the ", points, ".</p></div>\n");
}

// Where trouble begins, or a dash.
std::string first_points_html(const std::vector<PointRange>& ranges, const StabilitySweep& sweep) {
  std::string text;
  for (const std::size_t point : first_points(ranges, sweep.mildest)) {
    text += join(text.empty() ? "" : ", ", html_escape(point_text(sweep.points[point])));
  }
  return text.empty() ? std::string(dash) : text;
}

std::string overview_html(const Stability& stability) {
  std::string html =
      "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Where each method breaks\"><table "
      "class=\"overview\">\n"
      "<thead><tr><th scope=\"col\">condition</th>";
  for (std::size_t m = 0; m < stability.methods.size(); ++m) {
    html += join("<th scope=\"col\">", stability_mark(m), name_html(stability.methods[m]), "</th>");
  }
  html += "<th scope=\"col\">lists stop</th><th scope=\"col\">Embree stops</th></tr></thead>\n<tbody>\n";
  for (const StabilitySweep& sweep : stability.sweeps) {
    const SweepFindings findings = find_breaks(sweep, stability.methods.size());
    html += join("<tr><th scope=\"row\"><a href=\"#", sweep.name, "\">", html_escape(sweep.title), "</a> <small>",
                 html_escape(sweep.unit), "</small></th>");
    for (const auto& ranges : findings.broken) {
      html += join(ranges.empty() ? "<td class=\"rate1\">" : "<td class=\"rate4\">", first_points_html(ranges, sweep),
                   "</td>");
    }
    html += join("<td>", first_points_html(findings.lists_stop, sweep), "</td><td>",
                 first_points_html(findings.embree_stop, sweep), "</td></tr>\n");
  }
  return html + "</tbody></table></div>\n";
}

std::string how_to_read_html(const Stability& stability) {
  return join(
      "<details class=\"box\" open><summary>How to read this page</summary>\n<dl>\n"
      "<dt>inverted</dt><dd>Share of the covered pixels (or rays) in which something far was drawn over something "
      "nearer, over ",
      count_text(static_cast<std::size_t>(stability.views)),
      " views. Of the two referees' shares the larger. The lists hold every facet at every pixel; Embree is a second, "
      "independent referee.</dd>\n"
      "<dt>breaks</dt><dd>More than ",
      right_enough_percent, thin,
      "% is inverted. The overview has the mildest such value, a dash where there is none, and two where it gets worse "
      "both ways.</dd>\n"
      "<dt>not judged</dt><dd>Two facets at a pixel are judged when their depths differ by more than the rounding of "
      "the referee's own computation, and by nothing else. A pixel in which some pair is closer is left open; for "
      "Embree so is a ray that passes too near an edge to be told on which side. Facets that coincide, and those that "
      "meet in an edge at that very pixel, are left open too. Where more than ",
      fixed_text(100 * most_unjudged, 0), thin,
      "% of what a referee sees is left open, or nothing is seen, it does not judge: nothing is counted there, and no "
      "zero is claimed.</dd>\n"
      "<dt>0</dt><dd>Exactly none: below the scale each method has a row of its own.</dd>\n"
      "</dl></details>\n");
}

// ---- One sweep ---------------------------------------------------------------------------------------------------

// Colours of the table's cells; 0 stands alone.
std::string_view rate_class(double rate) {
  return rate == 0 ? "rate0" : rate <= right_enough ? "rate1" : rate < 0.1 ? "rate3" : rate < 0.5 ? "rate4" : "rate5";
}

std::string open_html(const RefereeReach& reach) {
  if (reach.seen == 0) return "nothing seen";
  return html_escape(percent_text(static_cast<double>(reach.unjudged) / static_cast<double>(reach.seen)));
}

std::string cells_html(const StabilityPoint& point, std::size_t methods) {
  const bool by_lists = point.lists.judges(), by_embree = point.embree.judges();
  if (!by_lists && !by_embree) {
    return join("<td class=\"rate muted\" colspan=\"", std::to_string(methods), "\">not judged</td>");
  }
  const std::string_view alone = by_lists && by_embree ? ""
                                 : by_lists            ? "<small>lists alone</small>"
                                                       : "<small>Embree alone</small>";
  std::string html;
  for (std::size_t m = 0; m < methods; ++m) {
    const double rate = *point.inverted_rate(m);
    html += join("<td class=\"rate ", rate_class(rate), "\">", html_escape(percent_text(rate)), alone, "</td>");
  }
  return html;
}

std::string table_html(const StabilitySweep& sweep, const std::vector<std::string>& methods) {
  std::string html = join(
      "<details class=\"table\" open><summary>All figures</summary>\n<div class=\"scroll\" tabindex=\"0\" "
      "role=\"region\" aria-label=\"All figures: ",
      html_escape(sweep.title), "\"><table class=\"heat values\">\n<thead><tr><th scope=\"col\">",
      html_escape(sweep.unit), "</th>");
  for (std::size_t m = 0; m < methods.size(); ++m) {
    html += join("<th scope=\"col\">", stability_mark(m), name_html(methods[m]), "<small>inverted, %</small></th>");
  }
  html +=
      "<th scope=\"col\">lists<small>left open, %</small></th><th scope=\"col\">Embree<small>left open, "
      "%</small></th><th scope=\"col\">facets</th></tr></thead>\n<tbody>\n";
  for (const StabilityPoint& point : sweep.points) {
    html += join("<tr><th scope=\"row\">", html_escape(point_text(point)), "</th>", cells_html(point, methods.size()),
                 "<td>", open_html(point.lists), "</td><td>", open_html(point.embree), "</td><td>",
                 count_text(point.facets), "</td></tr>\n");
  }
  return html + "</tbody></table></div></details>\n";
}

std::string legend_html(const std::vector<std::string>& methods) {
  std::string html = "<ul class=\"legend\" aria-label=\"Marks\">\n";
  for (std::size_t m = 0; m < methods.size(); ++m) {
    html += join("<li>", stability_mark(m), name_html(methods[m]), "</li>\n");
  }
  return html + "</ul>\n";
}

std::string sweep_html(const StabilitySweep& sweep, const std::vector<std::string>& methods) {
  return join("<section id=\"", sweep.name, "\">\n<h2>", html_escape(sweep.title), "</h2>\n<p>",
              html_escape(sweep.description), "</p>\n<p class=\"findings\">", findings_text(sweep, methods, code_html),
              "</p>\n", stability_plot(sweep, methods), legend_html(methods), table_html(sweep, methods),
              "<p><a href=\"#overview\">Back to the overview</a></p>\n</section>\n");
}

// ---- The page ----------------------------------------------------------------------------------------------------

constexpr std::string_view extra_style = R"css(
.findings { border-left: 5px solid var(--line); padding-left: 14px; }
.values tbody th { min-width: 96px; }
.overview tbody th { min-width: 132px; white-space: normal; }
td small, .overview th small { display: block; }
.overview small { color: var(--muted); }
.heat td.rate.muted { text-align: center; }
)css";

std::string header_html(const Stability& stability) {
  std::string html = join(
      "<header>\n<h1>Where depth sorting breaks</h1>\n<p>One condition after the other is driven "
      "to its extremes, and every method's order is judged by two referees, in pictures of up to ",
      std::to_string(stability.width), "\xc3\x97", std::to_string(stability.height),
      " pixels.</p>\n<p class=\"facts\">", html_escape(stability.date), " \xc2\xb7 ", html_escape(stability.machine),
      "<br><code>", html_escape(stability.command), "</code></p>\n<nav aria-label=\"Conditions\"><ul>\n");
  for (const StabilitySweep& sweep : stability.sweeps) {
    html += join("<li><a href=\"#", sweep.name, "\">", html_escape(sweep.title), "</a></li>\n");
  }
  return html + "</ul></nav>\n</header>\n";
}

std::string page_html(const Stability& stability) {
  std::string html = join(
      "<!DOCTYPE html>\n<html lang=\"en-GB\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\">\n<title>facetsort: where depth sorting breaks</title>\n<style>",
      page_style, stability_plot_style, extra_style, "</style>\n</head>\n<body>\n", stability_marks(),
      header_html(stability), "<main>\n<section id=\"overview\">\n<h2>All conditions</h2>\n", verdict_html(stability),
      overview_html(stability), how_to_read_html(stability), "</section>\n");
  for (const StabilitySweep& sweep : stability.sweeps) html += sweep_html(sweep, stability.methods);
  return join(html,
              "</main>\n<footer>Made by facetsort stability. The same figures, a row for each condition, value and "
              "method, are in <a href=\"stability.json\">stability.json</a> and <a "
              "href=\"stability.csv\">stability.csv</a>.</footer>\n<script>",
              page_script, "</script>\n</body>\n</html>\n");
}

}  // namespace

Status write_stability_page(const std::filesystem::path& path, const Stability& stability) {
  return replace_file_content(path, page_html(stability));
}

}  // namespace facetsort
