// A pair of facets asks for one order in some views and for the other in others. Views are grouped so that few pairs
// ask for both within a group; each group gets the order that most of its views ask for, pair by pair. Fixed orders for
// ranges of directions are known from "Depth-Presorted Triangle Lists" (2012), and index buffers that directions share
// from "In-Depth Buffers" (2018).
#include "facetsort/presort/index_buffers.h"

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "facetsort/base/parallel.h"
#include "facetsort/check/verdict.h"
#include "facetsort/facets/facets.h"
#include "facetsort/presort/facet_pairs.h"
#include "facetsort/presort/mend_order.h"
#include "facetsort/presort/view_groups.h"

namespace facetsort {
namespace {

using namespace presort_internal;

constexpr float eye_distance = 3;  // in bounding radii
constexpr double gap_radii = 1e-6;
constexpr int most_views = 2000, fewest_views = 100;
constexpr int sampled_views = 16;
constexpr std::size_t most_seen_pairs = std::size_t{1} << 25;  // over all views
constexpr int pair_views = 256;                                // in which pairs are looked for
constexpr int measured_views = 100;
constexpr std::size_t views_at_once = 32;

// Shares of the work, about as they come out on meshes of some thousand facets.
constexpr double done_with_pairs = 0.15, done_with_views = 0.5, done_with_groups = 0.8, done_with_orders = 0.85;

class Maker {
 public:
  Maker(const MeshView& mesh, const IndexBuffersOptions& options)
      : mesh_(mesh),
        options_(options),
        box_(facet_bounds(mesh)),
        radius_(box_.radius() > 0 ? box_.radius() : 1),
        pair_options_{gap_radii * static_cast<double>(radius_), options.with_culling} {}

  IndexBuffers make() {
    if (!find_pairs_of_views() || !see_pairs()) return {};
    const std::size_t most = std::min(options_.most_buffers, seen_.count());
    if (!options_.max_error) return made_and_measured(most);
    // The least number that is good enough, as if more were never worse.
    std::size_t too_few = 0, enough = 1;
    IndexBuffers best = made_and_measured(enough);
    while (is_bad(best) && enough < most) {
      too_few = enough;
      enough = std::min(2 * enough, most);
      best = made_and_measured(enough);
    }
    while (!stopped_ && !is_bad(best) && enough - too_few > 1) {
      const std::size_t middle = (too_few + enough) / 2;
      IndexBuffers tried = made_and_measured(middle);
      if (is_bad(tried)) {
        too_few = middle;
      } else {
        enough = middle;
        best = std::move(tried);
      }
    }
    return stopped_ ? IndexBuffers{} : best;
  }

 private:
  bool tell(double done) {
    done_ = std::max(done_, done);
    stopped_ = stopped_ || (options_.progress && !options_.progress(done_));
    return !stopped_;
  }
  bool is_bad(const IndexBuffers& buffers) const {
    return !stopped_ && buffers.mean_inverted_rate > *options_.max_error;
  }

  View view_from(const glm::vec3& direction) const {
    return default_view(box_, box_.centre() + direction * (eye_distance * radius_));
  }
  std::vector<View> views_around(int count) const {
    std::vector<View> views;
    for (int i = 0; i < count; ++i) views.push_back(view_from(glm::vec3(fibonacci_direction(i, count))));
    return views;
  }

  bool find_pairs_of_views() {
    std::vector<View> views = views_around(pair_views);
    // Facets of a pixel and more are found in smaller pictures just as well.
    if (mesh_.facet_count() < 16384) {
      for (View& view : views) view.width = view.height = 256;
    }
    PairFinder finder(mesh_, pair_options_);
    for (std::size_t begin = 0; begin < views.size(); begin += views_at_once) {
      finder.add(std::span(views).subspan(begin, std::min(views_at_once, views.size() - begin)));
      const double share = static_cast<double>(begin + views_at_once) / static_cast<double>(views.size());
      if (!tell(done_with_pairs * std::min(share, 1.0))) return false;
    }
    pairs_ = finder.pairs();
    return true;
  }

  // As many views as there is room for.
  bool see_pairs() {
    std::size_t of_samples = 0;
    for (const View& view : views_around(sampled_views))
      of_samples += seen_pairs(mesh_, view, pairs_, pair_options_).size();
    const std::size_t a_view = std::max<std::size_t>(of_samples / sampled_views, 1);
    const auto count = static_cast<int>(std::clamp<std::size_t>(most_seen_pairs / a_view, fewest_views, most_views));
    const std::vector<View> views = views_around(count);
    seen_.pair_count = pairs_.size();
    seen_.pairs.resize(views.size());
    for (std::size_t first = 0; first < views.size(); first += views_at_once) {
      const std::size_t some = std::min(views_at_once, views.size() - first);
      parallel_ranges(some, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = first + begin; i < first + end; ++i) {
          seen_.pairs[i] = seen_pairs(mesh_, views[i], pairs_, pair_options_);
        }
      });
      const double share = static_cast<double>(first + some) / static_cast<double>(views.size());
      if (!tell(done_with_pairs + (done_with_views - done_with_pairs) * share)) return false;
    }
    for (int i = 0; i < count; ++i) seen_.directions.push_back(glm::vec3(fibonacci_direction(i, count)));
    return true;
  }

  // By depth along the mean direction of a group, mended where its views ask for something else.
  std::vector<std::uint32_t> order_of(std::span<const std::uint32_t> groups, std::uint32_t group) const {
    glm::dvec3 direction(0);
    for (std::size_t view = 0; view < seen_.count(); ++view) {
      if (groups[view] == group) direction += glm::dvec3(seen_.directions[view]);
    }
    std::vector<double> nearness(mesh_.facet_count());
    for (std::size_t facet = 0; facet < nearness.size(); ++facet) {
      glm::dvec3 corners(0);
      for (int i = 0; i < 3; ++i) corners += glm::dvec3(mesh_.corner(facet, i) - box_.centre());
      nearness[facet] = glm::dot(direction, corners);
    }
    std::vector<std::uint32_t> order(mesh_.facet_count());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::uint32_t a, std::uint32_t b) { return nearness[a] < nearness[b]; });

    const std::vector<std::int64_t> votes = group_votes(seen_, groups, group);
    std::vector<Wish> wishes;
    for (std::size_t i = 0; i < votes.size(); ++i) {
      if (votes[i] > 0) wishes.push_back({pairs_[i].second, pairs_[i].first, votes[i]});
      if (votes[i] < 0) wishes.push_back({pairs_[i].first, pairs_[i].second, -votes[i]});
    }
    mend_order(wishes, order);
    return order;
  }

  IndexBuffers made_and_measured(std::size_t count) {
    std::vector<std::uint32_t> groups = group_views(seen_, count);
    if (!tell(done_with_groups)) return {};
    // Groups that nobody is left in get no buffer.
    std::vector<std::uint32_t> used = groups;
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (std::uint32_t& group : groups) {
      group = static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), group) - used.begin());
    }
    IndexBuffers buffers;
    buffers.buffer_count = used.size();
    buffers.facets.resize(used.size() * mesh_.facet_count());
    parallel_ranges(used.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::vector<std::uint32_t> order = order_of(groups, static_cast<std::uint32_t>(i));
        std::copy(order.begin(), order.end(),
                  buffers.facets.begin() + static_cast<std::ptrdiff_t>(i * mesh_.facet_count()));
      }
    });
    buffers.directions = seen_.directions;
    buffers.buffer_of_direction = std::move(groups);
    buffers.needs_culling = options_.with_culling;
    if (!tell(done_with_orders)) return {};
    measure(buffers);
    return stopped_ ? IndexBuffers{} : buffers;
  }

  void measure(IndexBuffers& buffers) {
    std::vector<double> rates(measured_views);
    for (std::size_t first = 0; first < rates.size(); first += views_at_once) {
      const std::size_t some = std::min(views_at_once, rates.size() - first);
      parallel_ranges(some, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = first + begin; i < first + end; ++i) {
          // The axes of the directions that orders were made for, exchanged: none comes twice.
          const glm::dvec3 d = fibonacci_direction(static_cast<int>(i), measured_views);
          const glm::vec3 direction(d.y, d.z, d.x);
          rates[i] = inverted_rate(mesh_, view_from(direction), buffers);
        }
      });
      const double share = static_cast<double>(first + some) / static_cast<double>(rates.size());
      if (!tell(done_with_orders + (1 - done_with_orders) * share)) return;
    }
    buffers.mean_inverted_rate = std::accumulate(rates.begin(), rates.end(), 0.0) / measured_views;
    buffers.worst_inverted_rate = *std::max_element(rates.begin(), rates.end());
  }

  const MeshView mesh_;
  const IndexBuffersOptions& options_;
  const Box box_;
  const float radius_;
  const PairOptions pair_options_;
  std::vector<FacetPair> pairs_;
  SeenViews seen_;
  double done_ = 0;
  bool stopped_ = false;
};

}  // namespace

double inverted_rate(const MeshView& mesh, const View& view, const IndexBuffers& buffers) {
  FragmentLists lists = collect_fragments(mesh, view);
  if (buffers.needs_culling) lists = without_back_faces(mesh, view, lists);
  const Box box = facet_bounds(mesh);
  const std::span<const std::uint32_t> order = buffers.buffer(nearest_buffer(buffers, view.eye - box.centre()));
  std::vector<std::uint32_t> ranks(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) ranks[order[i]] = static_cast<std::uint32_t>(i);
  const double radius = box.radius() > 0 ? static_cast<double>(box.radius()) : 1;
  const Verdict verdict = judge_order(lists, ranks, {.bounding_radius = radius, .gap_radii = gap_radii});
  if (verdict.covered_pixels == 0) return 0;
  return static_cast<double>(verdict.inverted_pixels) / static_cast<double>(verdict.covered_pixels);
}

IndexBuffers make_index_buffers(const MeshView& mesh, const IndexBuffersOptions& options) {
  assert(options.most_buffers > 0);
  if (mesh.facet_count() == 0) {
    IndexBuffers buffers{.buffer_count = 1, .facets = {}, .directions = {{0, 0, 1}}, .buffer_of_direction = {0}};
    buffers.needs_culling = options.with_culling;
    return buffers;
  }
  return Maker(mesh, options).make();
}

}  // namespace facetsort
