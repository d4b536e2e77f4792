// The camera of one picture, from the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <glm/glm.hpp>
#include <optional>

#include "arguments.h"
#include "facetsort/blend/view.h"

namespace facetsort {

struct ViewOptions {
  glm::vec3 eye{0};
  std::optional<glm::vec3> at;  // the centre of the mesh's box
  glm::vec3 up{0, 1, 0};
  float vertical_fov_degrees = 45;
  bool orthographic = false;
  std::optional<float> near_distance;  // 1e-4 bounding radii
  PictureSize size;
};

// --eye (required), --at, --up, --fov, --ortho, --near.
void add_view_options(CLI::App& command, ViewOptions& options);

// The view of a mesh in `bounds`. Throws Failure where nothing can be seen so.
View make_view(const ViewOptions& options, const Box& bounds);

}  // namespace facetsort
