// facetsort order: the draw order of a mesh for one view, as a file.
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "arguments.h"
#include "facetsort/order/sorter.h"
#include "facetsort/report/number_text.h"
#include "facetsort/report/timing.h"
#include "input_mesh.h"
#include "order_file.h"
#include "output.h"
#include "verbs.h"
#include "view_options.h"

namespace facetsort {
namespace {

// Sorts timed after the first, which allocates.
constexpr std::size_t timed_sorts = 5;

struct OrderOptions {
  std::string mesh, output;
  ViewOptions view;
  Method method = Method::centroid_distance;
};

ExitStatus run_order(const OrderOptions& options, const CommonOptions& common) {
  require_output_file(options.output, {".u32", ".ply"});
  const InputMesh input = read_input_mesh(options.mesh);
  const View view = make_view(options.view, input.bounds);
  const SortView eye{view.homogeneous_eye(), view.forward()};

  std::optional<Sorter> sorter;
  const Timing prepare = time_median([&] { sorter.emplace(input.mesh.view(), options.method); }, 1, 0);
  sorter->sort(eye);
  std::span<const std::uint32_t> order;
  const Timing sort = time_median([&] { order = sorter->sort(eye); }, timed_sorts, 0);
  write_order(options.output, input.mesh, order);

  if (common.json) {
    print_json({{"mesh", options.mesh},
                {"facets", order.size()},
                {"method", method_name(options.method)},
                {"prepare_ms", prepare.median_ms},
                {"order_ms", sort.median_ms},
                {"order_ms_spread", sort.spread_ms},
                {"output", options.output}});
  } else {
    print_facts({{"facets", count_text(order.size())},
                 {"method", std::string(method_name(options.method))},
                 {"order", milliseconds_text(sort.median_ms) + " ms a frame, " + milliseconds_text(prepare.median_ms) +
                               " ms once a mesh"},
                 {"output", options.output}});
  }
  return ExitStatus::done;
}

}  // namespace

Verb add_order(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<OrderOptions>();
  CLI::App* command = program.add_subcommand("order", "The draw order of a mesh's facets for one view, farthest first");
  command->add_option("MESH", options->mesh, "PLY, OBJ, OFF or STL file")->required()->type_name("");
  add_view_options(*command, options->view);
  add_method_option(*command, options->method);
  command
      ->add_option("-o,--output", options->output,
                   "OUT.u32: little-endian 32-bit facet ids; OUT.ply: the triangles in draw order, each with its "
                   "facet id as `source`")
      ->required()
      ->type_name("OUT");
  command->footer("Example: facetsort order meshes/teapot_1k.ply --eye 30,20,40 -o teapot.u32");
  return {command, [options, &common] { return run_order(*options, common); }};
}

}  // namespace facetsort
