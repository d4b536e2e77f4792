#include "view_options.h"

#include <string>

#include "failure.h"

namespace facetsort {

void add_view_options(CLI::App& command, ViewOptions& options) {
  const auto add_point = [&command](const std::string& name, auto& point, const std::string& description) {
    return command
        .add_option_function<std::string>(
            name, [name, &point](const std::string& text) { point = parse_point(name, text); }, description)
        ->type_name("X,Y,Z");
  };
  add_point("--eye", options.eye, "Where the mesh is seen from, in its own coordinates")->required();
  add_point("--at", options.at, "The point looked at [the centre of the mesh's box]");
  add_point("--up", options.up, "Up in the picture; 0,0,1 where that is along the view")->default_str("0,1,0");
  command.add_option("--fov", options.vertical_fov_degrees, "Vertical field of view in degrees")
      ->type_name("DEGREES")
      ->capture_default_str();
  command.add_flag("--ortho", options.orthographic,
                   "Orthographic, along the line from --eye to --at, two bounding radii high [perspective]");
  command
      .add_option("--near", options.near_distance,
                  "Distance of the near plane along the view; perspective only [1e-4 bounding radii]")
      ->type_name("D");
}

View make_view(const ViewOptions& options, const Box& bounds) {
  View view =
      default_view(bounds, options.eye, options.orthographic ? Projection::orthographic : Projection::perspective);
  view.at = options.at.value_or(bounds.centre());
  if (!options.at && view.eye == view.at) {
    throw Failure("--eye is at the centre of the mesh's box, which is looked at unless --at says otherwise");
  }
  view.up = options.up;
  view.vertical_fov_degrees = options.vertical_fov_degrees;
  if (options.near_distance) view.near_distance = *options.near_distance;
  view.width = options.size.width;
  view.height = options.size.height;
  require(validate(view));
  return view;
}

}  // namespace facetsort
