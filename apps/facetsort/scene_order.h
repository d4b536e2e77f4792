// facetsort order, of a scene: glTF, each object's facets in draw order.
#pragma once

#include <filesystem>
#include <optional>

#include "facetsort/order/method.h"
#include "verbs.h"
#include "view_options.h"

namespace facetsort {

struct SceneOrderOptions {
  std::filesystem::path input, output;
  ViewOptions view;
  Method method = Method::centroid_distance;
  std::optional<double> max_growth;
};

// Sorts the facets of all blended objects together, writes the scene with each primitive's indices in that order, and
// prints what it took and how many draws each way to order them needs. Throws Failure.
void order_scene(const SceneOrderOptions& options, const CommonOptions& common);

}  // namespace facetsort
