// facetsort inspect: what a mesh is, and what of it makes transparency hard.
#include "facetsort/mesh/inspect.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "arguments.h"
#include "facetsort/blend/fragment_lists.h"
#include "facetsort/exact/facts.h"
#include "facetsort/report/number_text.h"
#include "input_mesh.h"
#include "output.h"
#include "verbs.h"

namespace facetsort {
namespace {

constexpr int most_views = 10000;

struct InspectOptions {
  std::vector<std::string> meshes;
  int views = 6;
  PictureSize size{256, 256};
  float radii = 2.5f;
};

// Fragments at the pixels that the mesh covers, over all views.
struct Layers {
  std::size_t covered_pixels = 0;
  double mean = 0;
  std::size_t percentile_99_5 = 0;  // 99.5 % of the covered pixels have as many or fewer
  std::size_t most = 0;
};

struct InspectedMesh {
  std::string path;
  MeshFacts facts;
  GeometryFacts geometry;
  Layers layers;
};

Layers count_layers(const InputMesh& input, const InspectOptions& options) {
  std::vector<std::size_t> pixels_with;  // by number of layers
  for (View view : views_around(input.bounds, options.views, options.radii, Projection::perspective)) {
    view.width = options.size.width;
    view.height = options.size.height;
    require(validate(view));
    const FragmentLists lists = collect_fragments(input.mesh.view(), view);
    for (std::size_t pixel = 0; pixel + 1 < lists.offsets.size(); ++pixel) {
      const std::size_t layers = lists.pixel(pixel).size();
      if (layers >= pixels_with.size()) pixels_with.resize(layers + 1);
      ++pixels_with[layers];
    }
  }

  Layers layers;
  std::size_t fragments = 0;
  for (std::size_t count = 1; count < pixels_with.size(); ++count) {
    layers.covered_pixels += pixels_with[count];
    fragments += count * pixels_with[count];
  }
  if (layers.covered_pixels == 0) return layers;
  layers.mean = static_cast<double>(fragments) / static_cast<double>(layers.covered_pixels);
  layers.most = pixels_with.size() - 1;
  for (std::size_t seen = 0; 1000 * seen < 995 * layers.covered_pixels;) seen += pixels_with[++layers.percentile_99_5];
  return layers;
}

InspectedMesh inspect_file(const std::string& path, const InspectOptions& options) {
  const InputMesh input = read_input_mesh(path);
  return {path, inspect(input.mesh.view()), inspect_geometry(input.mesh.view()), count_layers(input, options)};
}

Json point_json(const glm::vec3& point) {
  return Json::array({point.x, point.y, point.z});
}

Json mesh_json(const InspectedMesh& mesh, const InspectOptions& options) {
  const MeshFacts& facts = mesh.facts;
  const GeometryFacts& geometry = mesh.geometry;
  Json first_pair = nullptr;
  if (geometry.intersecting_pairs > 0) first_pair = geometry.first_intersecting;
  return {{"mesh", mesh.path},
          {"facets", facts.facets},
          {"vertices", facts.vertices},
          {"distinct_positions", facts.distinct_positions},
          {"components", facts.components},
          {"closed", facts.closed},
          {"oriented", facts.oriented},
          {"edges", facts.edges},
          {"boundary_edges", facts.boundary_edges},
          {"non_manifold_edges", facts.non_manifold_edges},
          {"misoriented_edges", facts.misoriented_edges},
          {"duplicate_facets", facts.duplicate_facets},
          {"collapsed_facets", facts.collapsed_facets},
          {"degenerate_facets", geometry.degenerate_facets},
          {"intersecting_pairs", geometry.intersecting_pairs},
          {"first_intersecting", first_pair},
          {"convex_closed_components", geometry.convex_closed_components},
          {"convex_closed_facets", geometry.convex_closed_facets},
          {"lowest", point_json(facts.lowest)},
          {"highest", point_json(facts.highest)},
          {"bounding_radius", facts.bounding_radius},
          {"layers",
           {{"views", options.views},
            {"size", {options.size.width, options.size.height}},
            {"radii", options.radii},
            {"covered_pixels", mesh.layers.covered_pixels},
            {"mean", mesh.layers.mean},
            {"percentile_99_5", mesh.layers.percentile_99_5},
            {"most", mesh.layers.most}}}};
}

std::string point_text(const glm::vec3& point) {
  return number_text(static_cast<double>(point.x)) + "," + number_text(static_cast<double>(point.y)) + "," +
         number_text(static_cast<double>(point.z));
}

void print_mesh(const InspectedMesh& mesh) {
  const MeshFacts& facts = mesh.facts;
  const GeometryFacts& geometry = mesh.geometry;
  const auto yes_no = [](bool yes) { return std::string(yes ? "yes" : "no"); };
  std::string pairs = count_text(geometry.intersecting_pairs);
  if (geometry.intersecting_pairs > 0) {
    pairs += " (first: facets " + std::to_string(geometry.first_intersecting[0]) + " and " +
             std::to_string(geometry.first_intersecting[1]) + ")";
  }
  print_facts(
      {{"mesh", mesh.path},
       {"facets", count_text(facts.facets)},
       {"vertices", count_text(facts.vertices) + ", " + count_text(facts.distinct_positions) + " positions in use"},
       {"components", count_text(facts.components)},
       {"closed", yes_no(facts.closed)},
       {"oriented", yes_no(facts.oriented)},
       {"edges", count_text(facts.edges) + ": " + count_text(facts.boundary_edges) + " boundary, " +
                     count_text(facts.non_manifold_edges) + " non-manifold, " + count_text(facts.misoriented_edges) +
                     " misoriented"},
       {"duplicate facets", count_text(facts.duplicate_facets)},
       {"degenerate facets", count_text(geometry.degenerate_facets) + ", " + count_text(facts.collapsed_facets) +
                                 " of them with two equal corners"},
       {"intersecting pairs", pairs},
       {"convex closed parts", count_text(geometry.convex_closed_components) + ", of " +
                                   count_text(geometry.convex_closed_facets) + " facets"},
       {"box", point_text(facts.lowest) + " to " + point_text(facts.highest) + ", bounding radius " +
                   number_text(facts.bounding_radius)},
       {"layers", fixed_text(mesh.layers.mean, 2) + " on average, " + count_text(mesh.layers.percentile_99_5) +
                      " at 99.5 %, " + count_text(mesh.layers.most) + " at most"}});
}

ExitStatus run_inspect(const InspectOptions& options, const CommonOptions& common) {
  std::vector<InspectedMesh> meshes;
  for (const std::string& path : options.meshes) meshes.push_back(inspect_file(path, options));
  if (common.json) {
    Json list = Json::array();
    for (const InspectedMesh& mesh : meshes) list.push_back(mesh_json(mesh, options));
    print_json({{"meshes", list}});
    return ExitStatus::done;
  }
  for (const InspectedMesh& mesh : meshes) {
    print_mesh(mesh);
    print_text("\n");
  }
  print_text("Layers: fragments at a covered pixel, over " + std::to_string(options.views) + " views of " +
             std::to_string(options.size.width) + "x" + std::to_string(options.size.height) + " pixels at " +
             number_text(static_cast<double>(options.radii)) + " bounding radii.\n");
  return ExitStatus::done;
}

}  // namespace

Verb add_inspect(CLI::App& program, const CommonOptions& common) {
  const auto options = std::make_shared<InspectOptions>();
  CLI::App* command = program.add_subcommand(
      "inspect", "What a mesh is: closed, oriented, intersecting, degenerate, how many layers it has");
  command->add_option("MESH", options->meshes, "PLY, OBJ, OFF, STL or presorted .fsort files")
      ->required()
      ->type_name("");
  add_count_option(*command, "--views", options->views, most_views, "Views in which layers are counted");
  add_size_option(*command, options->size, "Pixels of each");
  add_radii_option(*command, options->radii);
  command->footer("Example: facetsort inspect meshes/teapot_1k.ply --json");
  return {command, [options, &common] { return run_inspect(*options, common); }};
}

}  // namespace facetsort
