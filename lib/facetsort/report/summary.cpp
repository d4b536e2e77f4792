#include "facetsort/report/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "facetsort/report/timing.h"

namespace facetsort {
namespace {

using Rows = std::vector<const Row*>;

double mean(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

template <typename Measure>
double median(const Rows& rows, const Measure& measure) {
  std::vector<double> values;
  for (const Row* row : rows) values.push_back(measure(*row));
  return median_and_spread(std::move(values)).median_ms;
}

bool too_many_unjudged(const Row& row) {
  return static_cast<double>(row.unjudged_pixels) > most_unjudged * static_cast<double>(row.covered_pixels);
}

RateSummary summarise_rate(const Rows& rows, std::optional<double> Row::*rate) {
  RateSummary summary;
  std::vector<double> rates;
  for (const Row* row : rows) {
    if (row->*rate) {
      rates.push_back(*(row->*rate));
    } else if (too_many_unjudged(*row)) {
      summary.not_judged = true;
    }
  }
  summary.judged_views = rates.size();
  if (rates.empty()) return summary;
  summary.not_judged = false;
  summary.mean = mean(rates);
  summary.worst = *std::max_element(rates.begin(), rates.end());
  return summary;
}

template <typename T>
void add(std::optional<T>& sum, const std::optional<T>& value) {
  if (value) sum = sum.value_or(T{}) + *value;
}

template <typename T>
void raise(T& largest, const T& value) {
  largest = std::max(largest, value);  // an empty optional is less than any value
}

// Precondition: at least one row, all of one mesh and strategy.
StrategySummary summarise_strategy(const Rows& rows) {
  StrategySummary summary;
  summary.strategy = rows.front()->strategy;
  summary.views = rows.size();
  summary.wrong = summarise_rate(rows, &Row::wrong_rate);
  summary.inverted = summarise_rate(rows, &Row::inverted_rate);
  // Too many unjudged pixels leave both rates empty: one alone is empty where the measure does not apply.
  summary.inverted.not_judged &= !summary.wrong.mean;
  summary.order.median_ms = median(rows, [](const Row& row) { return row.order.median_ms; });
  summary.order.spread_ms = median(rows, [](const Row& row) { return row.order.spread_ms; });
  summary.blend.median_ms = median(rows, [](const Row& row) { return row.blend.median_ms; });
  summary.blend.spread_ms = median(rows, [](const Row& row) { return row.blend.spread_ms; });
  summary.frame_ms = median(rows, [](const Row& row) { return row.order.median_ms + row.blend.median_ms; });
  summary.prepare_ms = median(rows, [](const Row& row) { return row.prepare_ms; });
  for (const Row* row : rows) {
    raise(summary.passes, row->passes);
    raise(summary.bytes_per_pixel, row->bytes_per_pixel);
    raise(summary.facets_drawn, row->facets_drawn);
    raise(summary.pieces, row->pieces);
    raise(summary.triangles_out, row->triangles_out);
    raise(summary.prepared_bytes, row->prepared_bytes);
    raise(summary.peak_bytes, row->peak_bytes);
    raise(summary.max_error, row->max_error);
    raise(summary.worst_backtrack, row->worst_backtrack);
    summary.rmse += row->rmse / static_cast<double>(rows.size());
    summary.covered_pixels += row->covered_pixels;
    summary.unjudged_pixels += row->unjudged_pixels;
    summary.embree_rays += row->embree_rays;
    summary.embree_unjudged += row->embree_unjudged;
    add(summary.miscovered_pixels, row->miscovered_pixels);
    add(summary.embree_inverted, row->embree_inverted);
  }
  return summary;
}

std::optional<Recommendation> recommend(const std::vector<StrategySummary>& strategies) {
  std::vector<const StrategySummary*> judged;
  for (const StrategySummary& strategy : strategies) {
    if (strategy.strategy != reference_strategy && strategy.error()) judged.push_back(&strategy);
  }
  if (judged.empty()) return std::nullopt;
  const auto is_right = [](const StrategySummary* strategy) { return *strategy->error() < right_enough; };
  double fastest = std::numeric_limits<double>::infinity();
  for (const StrategySummary* strategy : judged) {
    if (is_right(strategy)) fastest = std::min(fastest, strategy->frame_ms);
  }
  const bool any_right = std::isfinite(fastest);
  const auto rank = [&](const StrategySummary* strategy) {
    const bool contender = !any_right || (is_right(strategy) && strategy->frame_ms <= equal_time * fastest);
    return std::tuple(!contender, *strategy->error(), strategy->frame_ms);
  };
  const StrategySummary* best =
      *std::min_element(judged.begin(), judged.end(), [&](auto* a, auto* b) { return rank(a) < rank(b); });
  return Recommendation{best->strategy, any_right};
}

OverallResults summarise_overall(const std::string& strategy, const std::vector<MeshResults>& meshes) {
  OverallResults overall;
  overall.strategy = strategy;
  std::vector<double> errors, times;
  double log_time = 0;
  for (const MeshResults& mesh : meshes) {
    const StrategySummary* summary = mesh.find(strategy);
    if (summary == nullptr) continue;
    times.push_back(summary->frame_ms);
    log_time += std::log(std::max(summary->frame_ms, 1e-6));  // a nanosecond: below what the clock resolves
    if (const std::optional<double> error = summary->error()) {
      errors.push_back(*error);
      overall.right_meshes += *error < right_enough;
    }
  }
  overall.judged_meshes = errors.size();
  if (!errors.empty()) overall.mean_error = mean(errors);
  overall.geometric_mean_frame_ms = std::exp(log_time / static_cast<double>(times.size()));
  overall.median_frame_ms = median_and_spread(std::move(times)).median_ms;
  return overall;
}

std::optional<Recommendation> recommend_overall(const std::vector<OverallResults>& overall) {
  const OverallResults* best = nullptr;
  const auto rank = [](const OverallResults& results) {
    return std::tuple(-static_cast<double>(results.right_meshes), *results.mean_error, results.median_frame_ms);
  };
  for (const OverallResults& results : overall) {
    if (results.strategy == reference_strategy || !results.mean_error) continue;
    if (best == nullptr || rank(results) < rank(*best)) best = &results;
  }
  if (best == nullptr) return std::nullopt;
  return Recommendation{best->strategy, 2 * best->right_meshes > best->judged_meshes};
}

std::vector<MeshSummary> meshes_of(const Comparison& comparison) {
  std::vector<MeshSummary> meshes = comparison.meshes;
  for (const Row& row : comparison.rows) {
    const auto same = [&](const MeshSummary& mesh) { return mesh.name == row.mesh; };
    if (std::none_of(meshes.begin(), meshes.end(), same)) {
      MeshSummary& mesh = meshes.emplace_back();
      mesh.name = row.mesh;
      mesh.facets = row.facets;
    }
  }
  return meshes;
}

}  // namespace

const StrategySummary* MeshResults::find(std::string_view strategy) const {
  for (const StrategySummary& summary : strategies) {
    if (summary.strategy == strategy) return &summary;
  }
  return nullptr;
}

Summary summarise(const Comparison& comparison) {
  Summary summary;
  for (const Row& row : comparison.rows) {
    if (std::find(summary.strategies.begin(), summary.strategies.end(), row.strategy) == summary.strategies.end()) {
      summary.strategies.push_back(row.strategy);
    }
  }
  for (const MeshSummary& mesh : meshes_of(comparison)) {
    MeshResults& results = summary.meshes.emplace_back();
    results.mesh = mesh;
    for (const std::string& strategy : summary.strategies) {
      Rows rows;
      for (const Row& row : comparison.rows) {
        if (row.mesh == mesh.name && row.strategy == strategy) rows.push_back(&row);
      }
      if (!rows.empty()) results.strategies.push_back(summarise_strategy(rows));
    }
    results.recommendation = recommend(results.strategies);
  }
  for (const std::string& strategy : summary.strategies) {
    summary.overall.push_back(summarise_overall(strategy, summary.meshes));
  }
  summary.recommendation = recommend_overall(summary.overall);
  return summary;
}

}  // namespace facetsort
