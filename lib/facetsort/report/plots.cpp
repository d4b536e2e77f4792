#include "facetsort/report/plots.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

#include "facetsort/report/html.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/summary.h"

namespace facetsort {
namespace {

constexpr double least_milliseconds = 1e-6;
constexpr double least_percent = 1e-7;
constexpr int width = 500, height = 390;

// A folder that only this user can enter, removed with all it holds.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "facetsort-XXXXXX").string();
    if (!error && mkdtemp(name.data()) != nullptr) path_ = name;
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder() {
    std::error_code error;
    if (!path_.empty()) std::filesystem::remove_all(path_, error);
  }

  // Empty where none could be made.
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

// As gnuplot reads numbers, whatever the locale.
std::string number(double value) {
  std::array<char, 64> buffer;
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::scientific, 9);
  return {buffer.data(), end.ptr};
}

// Inside single quotes gnuplot takes every character as it is, and two quotes as one.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

double plotted_milliseconds(const PlotPoint& point) {
  return std::max(point.milliseconds, least_milliseconds);
}
double plotted_percent(const PlotPoint& point) {
  return std::max(100 * point.rate, least_percent);
}

// As short as the value allows: "0.001", "20".
std::string tick_text(double value) {
  return fixed_text(value, std::max(0, -static_cast<int>(std::floor(std::log10(value) + 1e-9))));
}

// Times with a margin, and 1-2-5 steps while there are few; decades where there are many.
std::string time_axis(const Plot& plot) {
  double low = plotted_milliseconds(plot.points.front()), high = low;
  for (const PlotPoint& point : plot.points) {
    low = std::min(low, plotted_milliseconds(point));
    high = std::max(high, plotted_milliseconds(point));
  }
  const double margin = std::max(1.4, std::sqrt(8 * low / high));  // the axis is never shorter than a factor of 8
  low /= margin;
  high *= margin;
  const bool decades_only = high / low > 1000;
  std::string ticks;
  for (int decade = static_cast<int>(std::floor(std::log10(low))); std::pow(10, decade) <= high; ++decade) {
    for (const double step : {1.0, 2.0, 5.0}) {
      const double value = step * std::pow(10, decade);
      if (value < low || value > high || (decades_only && step > 1)) continue;
      ticks += (ticks.empty() ? "'" : ", '") + tick_text(value) + "' " + number(value);
    }
  }
  return "set xrange [" + number(low) + ":" + number(high) + "]\nset xtics (" + ticks + ")\n";
}

struct PercentAxis {
  int lowest_decade = -2;  // percent, as power of ten
  double zero = 0;         // where 0 is shown
  std::string script;
};

PercentAxis percent_axis(const Plot& plot) {
  PercentAxis axis;
  for (const PlotPoint& point : plot.points) {
    if (point.rate <= 0) continue;
    axis.lowest_decade =
        std::min(axis.lowest_decade, static_cast<int>(std::floor(std::log10(plotted_percent(point)) + 1e-9)));
  }
  const double lowest = std::pow(10, axis.lowest_decade);
  axis.zero = lowest / 4;
  std::string ticks;
  for (int decade = axis.lowest_decade; decade <= 2; ++decade) {
    ticks += (ticks.empty() ? "'" : ", '") + tick_text(std::pow(10, decade)) + " %%' " + number(std::pow(10, decade));
  }
  axis.script = "set yrange [" + number(lowest / 8) + ":200]\nset ytics (" + ticks + ")\n";
  return axis;
}

std::string points_script(const Plot& plot, double zero) {
  std::string data, clauses;
  for (std::size_t i = 0; i < plot.points.size(); ++i) {
    const PlotPoint& point = plot.points[i];
    data += number(plotted_milliseconds(point)) + " " + number(point.rate > 0 ? plotted_percent(point) : zero) + "\n";
    const std::string place = std::to_string(i);
    clauses += (clauses.empty() ? "" : ", ") + ("$points every ::" + place + "::" + place) +
               " using 1:2 with points pointtype " + std::to_string(point.mark.symbol) +
               (point.background ? " pointsize 0.7 linewidth 1 linecolor rgb '#A0"
                                 : " pointsize 1.25 linewidth 2 linecolor rgb '#") +
               point.mark.colour.substr(1) + "' notitle";
  }
  return "$points << EOD\n" + data + "EOD\nplot " + clauses + "\n";
}

// A band marks what is right enough; a line of dashes marks 0.
std::string plot_script(const Plot& plot, const std::string& output) {
  const PercentAxis axis = percent_axis(plot);
  return "reset\nset terminal svg size " + std::to_string(width) + "," + std::to_string(height) +
         " dynamic noenhanced font 'sans-serif,14'\nset output " + quoted(output) +
         "\nset logscale xy\nset border 3 linecolor rgb '#808080'\nset tics nomirror scale 0.6\n"
         "set grid linetype 1 linecolor rgb '#A0808080'\nset lmargin at screen 0.18\nset rmargin at screen 0.975\n"
         "set tmargin at screen 0.97\nset bmargin at screen 0.17\nset xlabel 'order and blend, ms a frame'\nset "
         "ylabel " +
         quoted(plot.rate_label) + " offset 1.8\n" + time_axis(plot) + axis.script +
         "set object 1 rectangle from graph 0, graph 0 to graph 1, first " + number(100 * right_enough) +
         " behind fillcolor rgb '#1a9e77' fillstyle transparent solid 0.13 noborder\n"
         "set arrow 1 from graph 0, first " +
         number(axis.zero) + " to graph 1, first " + number(axis.zero) +
         " nohead back linewidth 1.5 linecolor rgb '#808080' dashtype (6,4)\nset label 1 '0' at graph -0.022, first " +
         number(axis.zero) + " right\n" + points_script(plot, axis.zero);
}

Status run_gnuplot(const std::filesystem::path& script, const std::filesystem::path& messages) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  std::string program = "gnuplot", without_user_settings = "-d", file = script.string();
  char* const arguments[] = {program.data(), without_user_settings.data(), file.data(), nullptr};
  pid_t process = 0;
  const int failure = posix_spawnp(&process, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failure == ENOENT) return {Fault::cannot_write, "gnuplot, which draws the plots, is not on PATH"};
  if (failure != 0) {
    return {Fault::cannot_write, "gnuplot cannot be run: " + std::generic_category().message(failure)};
  }
  int outcome = 0;
  while (waitpid(process, &outcome, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(outcome) && WEXITSTATUS(outcome) == 0) return {};
  // gnuplot shows the line, then points at the place, then says what is wrong: its last line.
  std::string message = read_text(messages);
  message.erase(message.find_last_not_of(" \n") + 1);
  message.erase(0, message.find_last_of('\n') + 1);
  return {Fault::cannot_write, "gnuplot failed" + (message.empty() ? "" : ": " + message)};
}

// Cuts [begin, end) out of `text`, both included, and returns it; empty where they are not there.
std::string cut_out(std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t from = text.find(begin);
  const std::size_t to = from == std::string::npos ? from : text.find(end, from + begin.size());
  if (to == std::string::npos) return "";
  const std::string part = text.substr(from, to + end.size() - from);
  text.erase(from, part.size());
  return part;
}

// gnuplot's document as an element of a page: without what may stand only once in a page, with a description, and
// each point with its tooltip in place of the plot's number.
std::string page_element(std::string document, const Plot& plot, std::string& definitions) {
  std::string shapes = cut_out(document, "<defs>", "</defs>");
  if (definitions.empty()) definitions = std::move(shapes);
  cut_out(document, "<title>Gnuplot", "</title>");
  cut_out(document, "<desc>", "</desc>");
  document.erase(0, document.find('>', document.find("<svg")) + 1);
  for (std::size_t i = 0; i < plot.points.size(); ++i) {
    const std::string name = "gnuplot_plot_" + std::to_string(i + 1);
    cut_out(document, " id=\"" + name, "\"");
    const std::string title = "<title>" + name + "</title>";
    if (const std::size_t place = document.find(title); place != std::string::npos) {
      document.replace(place, title.size(), "<title>" + html_escape(plot.points[i].tooltip) + "</title>");
    }
  }
  cut_out(document, " id=\"gnuplot_canvas", "\"");
  return "<svg class=\"plot\" viewBox=\"0 0 " + std::to_string(width) + " " + std::to_string(height) +
         "\" role=\"img\" aria-label=\"" + html_escape(plot.description) + "\">" + document;
}

}  // namespace

Result<DrawnPlots> draw_plots(std::span<const Plot> plots) {
  const PrivateFolder folder;
  if (folder.path().empty()) return Status{Fault::cannot_write, "the temporary folder cannot be written"};
  const auto output = [&](std::size_t i) { return folder.path() / (std::to_string(i) + ".svg"); };
  {
    std::ofstream script(folder.path() / "script");
    for (std::size_t i = 0; i < plots.size(); ++i) script << plot_script(plots[i], output(i).string());
    script.close();
    if (!script) return Status{Fault::cannot_write, "the temporary folder cannot be written"};
  }
  if (Status status = run_gnuplot(folder.path() / "script", folder.path() / "messages"); !status.ok()) return status;
  DrawnPlots drawn;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    std::string document = read_text(output(i));
    if (document.find("</svg>") == std::string::npos) return Status{Fault::cannot_write, "gnuplot drew no plot"};
    drawn.svgs.push_back(page_element(std::move(document), plots[i], drawn.definitions));
  }
  return drawn;
}

}  // namespace facetsort
