#include "measure.h"

#include <cmath>
#include <optional>

#include "facetsort/check/picture_verdict.h"
#include "facetsort/check/verdict.h"
#include "facetsort/report/allocations.h"
#include "facetsort/report/summary.h"
#include "facetsort/report/timing.h"
#include "failure.h"

namespace facetsort {
namespace {

// More than this share without an answer, and the measure is not judged.
bool too_many(std::size_t unjudged, std::size_t all) {
  return static_cast<double>(unjudged) > most_unjudged * static_cast<double>(all);
}

double rate(std::size_t part, std::size_t whole) {
  return whole == 0 ? 0 : static_cast<double>(part) / static_cast<double>(whole);
}

Image blank_picture(const View& view, PixelFormat format) {
  const auto pixels = static_cast<std::size_t>(view.width) * static_cast<std::size_t>(view.height);
  return {view.width, view.height, format, std::vector<glm::vec4>(pixels)};
}

// Order, picture and cost; the picture goes to `picture`.
void measure_cost(PreparedStrategy& prepared, const RefereedView& refereed, std::size_t repeats, Row& row,
                  Image& picture) {
  const View& view = refereed.view;
  picture = blank_picture(view, refereed.format);  // its memory is not the strategy's
  Timing first_order;
  {
    const AllocationScope allocations;
    first_order = time_median([&] { prepared.order(view); }, 1);
    row.facets_drawn = prepared.renderer().draw(view, refereed.format, picture).facets_drawn;
    row.peak_bytes = allocations.count().peak_bytes;
  }
  // What takes so long that the first allocations do not show in it is not done again.
  const bool is_slow = first_order.median_ms > 1000 * most_repeating_seconds;
  row.order = is_slow ? first_order : time_median([&] { prepared.order(view); }, repeats);
  StrategyRenderer& renderer = prepared.renderer();
  row.blend = time_median([&] { renderer.draw(view, refereed.format, picture); }, repeats);
  row.passes = renderer.passes();
  row.bytes_per_pixel = renderer.bytes_per_pixel();
  row.prepared_bytes = renderer.prepared_bytes();
  row.pieces = renderer.pieces();
  row.triangles_out = renderer.triangles();
  row.exact = renderer.exact_statistics();
}

void judge(const InputMesh& input, const Image& picture, const RefereedView& refereed, Row& row) {
  const PictureVerdict verdict = judge_picture(input.mesh.view(), refereed.view, refereed.lists, refereed.reference,
                                               picture, {.bounding_radius = input.radius});
  row.covered_pixels = verdict.covered_pixels;
  row.rmse = verdict.rmse;
  row.max_error = verdict.max_error;
  row.unjudged_pixels = verdict.unjudged_pixels;
  if (too_many(row.unjudged_pixels, row.covered_pixels)) return;
  row.wrong_pixels = verdict.wrong_pixels;
  row.wrong_rate = rate(verdict.wrong_pixels, verdict.covered_pixels);
}

void judge_draw_order(const InputMesh& input, const StrategyRenderer& renderer, const RefereedView& refereed,
                      Row& row) {
  row.embree_rays = refereed.hits.rays;
  row.embree_unjudged = refereed.hits.unjudged_rays;
  if (!renderer.draws_in_order()) return;
  const JudgeOptions options{.bounding_radius = input.radius};
  const auto judge_by = [&](const FragmentLists& lists) {
    return judge_drawing(lists, renderer.ranks(refereed.view, lists), options);
  };
  const Verdict verdict = judge_by(refereed.lists);
  row.inverted_pixels = verdict.inverted_pixels;
  row.inverted_rate = rate(verdict.inverted_pixels, verdict.covered_pixels);
  row.worst_backtrack = verdict.worst_backtrack;
  if (too_many(row.embree_unjudged, row.embree_rays)) return;
  row.embree_inverted = judge_by(refereed.hits.lists).inverted_pixels;
}

// Nothing for the strategies that discard fragments on purpose.
std::optional<std::size_t> count_miscovered(StrategyRenderer& renderer, const RefereedView& refereed) {
  if (renderer.discards_fragments()) return std::nullopt;
  Image coverage;
  renderer.draw_coverage(refereed.view, coverage);
  std::size_t miscovered = 0;
  for (std::size_t pixel = 0; pixel < coverage.pixels.size(); ++pixel) {
    miscovered += coverage.pixels[pixel].r != static_cast<float>(refereed.lists.pixel(pixel).size());
  }
  return miscovered;
}

}  // namespace

RefereedView referee_view(const InputMesh& input, const EmbreeReferee& referee, const View& view, PixelFormat format) {
  RefereedView refereed;
  refereed.view = view;
  refereed.format = format;
  refereed.lists = collect_fragments(input.mesh.view(), view);
  blend_lists(input.mesh.view(), view, refereed.lists, format, refereed.reference);
  refereed.hits = require(referee.cast(view));
  return refereed;
}

Agreement compare_referees(const InputMesh& input, const RefereedView& refereed) {
  Image picture;
  blend_lists(input.mesh.view(), refereed.view, refereed.hits.lists, refereed.format, picture);
  Agreement agreement;
  for (std::size_t pixel = 0; pixel < picture.pixels.size(); ++pixel) {
    if (refereed.hits.judged[pixel]) {
      agreement.judged += !refereed.lists.pixel(pixel).empty();
    } else {
      picture.pixels[pixel] = refereed.reference.pixels[pixel];  // not to count
    }
  }
  const PictureVerdict verdict = judge_picture(input.mesh.view(), refereed.view, refereed.lists, refereed.reference,
                                               picture, {.bounding_radius = input.radius});
  agreement.judged -= verdict.unjudged_pixels;
  agreement.agreeing = agreement.judged - verdict.wrong_pixels;
  return agreement;
}

MeasuredStrategy measure_strategy(const InputMesh& input, const Strategy& strategy, const RefereedView& refereed,
                                  std::size_t repeats, PreparedStrategy& prepared) {
  constexpr double long_ms = 300;
  MeasuredStrategy measured;
  Row& row = measured.row;
  row.mesh = input.name;
  row.facets = input.mesh.triangles.size();
  row.eye = refereed.view.eye;
  row.projection = refereed.view.projection == Projection::perspective ? "perspective" : "orthographic";
  row.strategy = strategy.name();
  if (strategy.kind == StrategyKind::facet_sort) row.method = method_name(strategy.method);

  if (!prepared.is_ready()) prepared.prepare(input, strategy, refereed.view);
  row.prepare_ms = prepared.prepare_ms();
  measure_cost(prepared, refereed, repeats, row, measured.picture);
  StrategyRenderer& renderer = prepared.renderer();
  judge(input, measured.picture, refereed, row);
  judge_draw_order(input, renderer, refereed, row);
  row.miscovered_pixels = count_miscovered(renderer, refereed);
  if (prepared.prepare_ms() < long_ms) prepared.release();
  return measured;
}

}  // namespace facetsort
