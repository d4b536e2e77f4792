// What a mesh or a scene needs for a right picture, and what it can do without: the cheapest strategy that is right, or
// wrong in few enough pixels, why, and how sure that is.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "facetsort/base/status.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/exact/facts.h"
#include "facetsort/mesh/mesh_view.h"
#include "facetsort/scene/scene.h"

namespace facetsort {

enum class Certainty {
  proved,    // for every view
  measured,  // in views around the mesh that PlanOptions states; in others it may be wrong
};

struct PlanOptions {
  // Most of a view's covered pixels that may be wrong (differs_visibly()), as a share. Above 0, strategies are measured
  // that are not always right; they are taken where they stay below half of it in every view.
  double error_budget = 0;
  // Colours are to be added, which needs no order; no material of a scene says so, and budgets are of source-over.
  bool additive = false;
  // To be drawn: what is made once is only made where it saves more than it takes.
  std::size_t frames = 10000;
  // The views in which strategies are timed and measured: views_around() the box.
  int views = 4;
  float radii = 2.5f;
  int width = 256, height = 256;
};

// A strategy that was not chosen, or work that is not done.
struct LeftOut {
  std::string what, why;
};

// What a frame of a strategy takes: the shortest of some, each the mean of views.
struct TimedStrategy {
  Strategy strategy;
  Certainty certainty = Certainty::proved;
  double frame_ms = 0;
  double prepare_ms = 0;   // once
  double worst_wrong = 0;  // share of a view's covered pixels; measured strategies only
};

struct MeshPlan {
  std::string name;  // of an object
  std::size_t facets = 0;
  Strategy strategy;
  Certainty certainty = Certainty::proved;
  std::string reason;
  // Whether separate_culling_pass is right, proved, in the views in which no two parts of the mesh overlap on the
  // screen (see ConvexParts); in others, `strategy` is.
  bool culls_where_apart = false;
  std::vector<LeftOut> left_out;

  // What the reasons rest on; absent where it did not have to be found.
  float lowest_alpha = 1, highest_alpha = 1;      // of what is blended
  std::optional<std::size_t> layers_that_matter;  // the light through so many is below half a display step of 1/255
  std::optional<GeometryFacts> geometry;
  std::vector<TimedStrategy> timed;
  double plan_ms = 0;
};

struct Plan {
  MeshPlan whole;                 // all blended facets together
  std::vector<MeshPlan> objects;  // of a scene, in its order: each alone, nothing timed
  std::size_t blended_objects = 0;
  // Most objects in a group of blended ones whose bounding spheres overlap on the screen, in the worst of the stated
  // views: where it is 1, objects need no common sort in any of them.
  std::size_t most_overlapping = 0;
  double plan_ms = 0;
};

// Cheap proofs first; strategies are timed only where several are right. What is right does not depend on the machine;
// which of the right ones is taken does, as their times do. Parallel in the caller's task arena.
// Preconditions: validate(mesh) is ok, and blended facets come before all others; options.views, width and height are
// above 0, the budget is from 0 to 1.
// `presorted`: what the mesh has been presorted into before, which costs nothing then.
MeshPlan plan_mesh(const MeshView& mesh, const PlanOptions& options = {}, const PresortedInput& presorted = {});

// The same for a scene. Fault: those of merge(). Precondition: validate(scene) is ok.
Result<Plan> plan_scene(const Scene& scene, const PlanOptions& options = {});

}  // namespace facetsort
