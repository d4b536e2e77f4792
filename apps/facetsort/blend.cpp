// facetsort blend: one picture of a mesh, by one strategy.
#include <memory>
#include <string>

#include "arguments.h"
#include "facetsort/blend/strategy.h"
#include "facetsort/report/image_file.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/timing.h"
#include "input_mesh.h"
#include "output.h"
#include "prepared_strategy.h"
#include "verbs.h"
#include "view_options.h"

namespace facetsort {
namespace {

// Frames timed after the first, which allocates.
constexpr std::size_t timed_frames = 5;

struct BlendOptions {
  std::string mesh, output;
  ViewOptions view;
  Strategy strategy;
  PixelFormat format = PixelFormat::rgba32f;
};

ExitStatus run_blend(const BlendOptions& options, const CommonOptions& common) {
  require_output_file(options.output, {".exr", ".png"});
  const InputMesh input = read_input_scene(options.mesh);
  const View view = make_view(options.view, input.bounds);

  PreparedStrategy prepared;
  prepared.prepare(input, options.strategy, view);
  Image image;
  prepared.order(view);
  StrategyRenderer& renderer = prepared.renderer();
  const DrawStatistics statistics = renderer.draw(view, options.format, image);
  const Timing order = time_median([&] { prepared.order(view); }, timed_frames);
  const Timing blend = time_median([&] { renderer.draw(view, options.format, image); }, timed_frames);
  require(write_image(options.output, image));

  if (common.json) {
    print_json({{"mesh", options.mesh},
                {"facets", input.mesh.triangles.size()},
                {"strategy", options.strategy.name()},
                {"size", {view.width, view.height}},
                {"passes", renderer.passes()},
                {"bytes_per_pixel", renderer.bytes_per_pixel()},
                {"facets_drawn", statistics.facets_drawn},
                {"order_ms", order.median_ms},
                {"order_ms_spread", order.spread_ms},
                {"blend_ms", blend.median_ms},
                {"blend_ms_spread", blend.spread_ms},
                {"output", options.output}});
  } else {
    print_facts({{"strategy", options.strategy.name()},
                 {"passes", std::to_string(renderer.passes())},
                 {"memory", std::to_string(renderer.bytes_per_pixel()) + " bytes a pixel beside the picture"},
                 {"facets drawn", count_text(statistics.facets_drawn)},
                 {"order", milliseconds_text(order.median_ms) + " ms a frame"},
                 {"blend", milliseconds_text(blend.median_ms) + " ms a frame"},
                 {"output", options.output}});
  }
  return ExitStatus::done;
}

}  // namespace

Verb add_blend(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<BlendOptions>();
  CLI::App* command = program.add_subcommand("blend", "A picture of a self-transparent mesh, by one strategy");
  command->add_option("MESH", options->mesh, "PLY, OBJ, OFF, STL or presorted .fsort file; or a scene: a glTF file, or a folder")
      ->required()
      ->type_name("");
  command
      ->add_option_function<std::string>(
          "--strategy", [options](const std::string& text) { options->strategy = parse_strategy("--strategy", text); },
          "How the picture is made: " + strategy_names())
      ->required()
      ->type_name("S");
  add_view_options(*command, options->view);
  add_size_option(*command, options->view.size, "Pixels of the picture");
  add_format_option(*command, options->format);
  command
      ->add_option("-o,--output", options->output,
                   "IMAGE.exr: linear, premultiplied, 32-bit float; IMAGE.png: sRGB, straight alpha, 8 bits")
      ->required()
      ->type_name("IMAGE");
  command->footer("Example: facetsort blend meshes/teapot_1k.ply --strategy facet_sort --eye 30,20,40 -o teapot.png");
  return {command, [options, &common] { return run_blend(*options, common); }};
}

}  // namespace facetsort
