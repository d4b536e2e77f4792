// facetsort-generate: writes a mesh made by formula as a PLY file. One subcommand a shape of shapes.h.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <numeric>
#include <string>

#include "facetsort/mesh/write.h"
#include "shapes.h"

namespace {

using facetsort::Mesh;
namespace shapes = facetsort::shapes;

constexpr std::size_t most_facets = 100'000'000;  // 2 GB of file
constexpr int most_members = 1'000'000;
constexpr int most_subdivisions = 10;  // 21 million facets

struct Arguments {
  std::filesystem::path output;
  std::size_t facets = 0;
  int p = 2, q = 3;
  int layers = 5;
  float gap = 0.1f;
  int subdivisions = 3;
  int members = 3;
  int triangles = 1000;
  float aspect = 1000;
  std::uint32_t seed = 1;
};

// What a subcommand makes, and what is wrong with its arguments together ("" where nothing is).
struct Shape {
  std::function<Mesh(const Arguments&)> make;
  std::function<std::string(const Arguments&)> complaint = [](const Arguments&) { return std::string(); };
};

// Adds a subcommand; its callback, run when the command line names it, chooses the shape.
CLI::App* add_shape(CLI::App& program, Arguments& arguments, Shape& chosen, const std::string& name,
                    const std::string& description, const std::string& example, Shape shape) {
  CLI::App* command = program.add_subcommand(name, description);
  command->footer("Example:\n  facetsort-generate " + name + " " + example);
  command->add_option("-o,--output", arguments.output, "PLY file to write")->required();
  command->callback([&chosen, shape] { chosen = shape; });
  return command;
}

void add_subdivisions(CLI::App* command, Arguments& arguments) {
  command->add_option("--subdivisions", arguments.subdivisions, "of the icosphere: 20 * 4^N facets")
      ->capture_default_str()
      ->check(CLI::Range(0, most_subdivisions));
}

void add_members(CLI::App* command, Arguments& arguments) {
  command->add_option("--members", arguments.members, "in the ring")
      ->capture_default_str()
      ->check(CLI::Range(3, most_members));
}

void add_shapes(CLI::App& program, Arguments& arguments, Shape& chosen) {
  const auto add = [&](const char* name, const char* description, const char* example, Shape shape) {
    return add_shape(program, arguments, chosen, name, description, example, std::move(shape));
  };

  CLI::App* knot =
      add("torus_knot", "Closed tube around a torus knot: clean, concave, of any size", "--facets 200000 -o knot.ply",
          {[](const Arguments& a) { return shapes::torus_knot(a.facets, a.p, a.q); },
           [](const Arguments& a) {
             return std::gcd(a.p, a.q) == 1 ? std::string() : std::string("--p and --q have a common divisor");
           }});
  knot->add_option("--facets", arguments.facets, "about as many")
      ->required()
      ->check(CLI::Range(shapes::fewest_knot_facets, most_facets));
  knot->add_option("--p", arguments.p, "rounds about the axis z")->capture_default_str()->check(CLI::Range(1, 8));
  knot->add_option("--q", arguments.q, "rounds about the ring")->capture_default_str()->check(CLI::Range(1, 8));

  CLI::App* shells =
      add("nested_shells", "Spheres inside each other, a gap apart", "--layers 5 --gap 0.1 -o shells.ply",
          {[](const Arguments& a) { return shapes::nested_shells(a.layers, a.gap, a.subdivisions); },
           [](const Arguments& a) {
             const bool fits = (a.layers - 1) * double{a.gap} < 1;
             return fits ? std::string() : std::string("the radius of 1 has no room for --layers this --gap apart");
           }});
  shells->add_option("--layers", arguments.layers, "spheres")->capture_default_str()->check(CLI::Range(1, 100'000));
  shells->add_option("--gap", arguments.gap, "between radii")->capture_default_str()->check(CLI::Range(1e-5f, 1.0f));
  add_subdivisions(shells, arguments);

  add_members(add("slab_cycle", "Closed slabs in a ring, each over the next and the last over the first",
                  "--members 3 -o slabs.ply", {[](const Arguments& a) { return shapes::slab_cycle(a.members); }}),
              arguments);
  add_members(add("triangle_cycle", "The same ring of single triangles", "--members 3 -o triangles.ply",
                  {[](const Arguments& a) { return shapes::triangle_cycle(a.members); }}),
              arguments);
  add_subdivisions(add("interpenetrating", "A sphere and a box pushed through each other", "-o pair.ply",
                       {[](const Arguments& a) { return shapes::interpenetrating(a.subdivisions); }}),
                   arguments);

  CLI::App* fan =
      add("sliver_fan", "Long thin triangles around one corner", "--triangles 1000 --aspect 1000 -o fan.ply",
          {[](const Arguments& a) { return shapes::sliver_fan(a.triangles, a.aspect); },
           [](const Arguments& a) {
             const bool fits = a.triangles <= 6 * double{a.aspect};
             return fits ? std::string() : std::string("--triangles above 6 times --aspect go round twice");
           }});
  fan->add_option("--triangles", arguments.triangles, "in the fan")
      ->capture_default_str()
      ->check(CLI::Range(1, 6 * most_members));
  fan->add_option("--aspect", arguments.aspect, "length over width")
      ->capture_default_str()
      ->check(CLI::Range(1.0f, 1e6f));

  add("many_scales", "Tetrahedra of sizes 1e-6 to 1e6, beside and inside each other", "-o scales.ply",
      {[](const Arguments&) { return shapes::many_scales(); }});

  CLI::App* soup = add("soup", "Random triangles in the unit cube", "--facets 1000 --seed 1 -o soup.ply",
                       {[](const Arguments& a) { return shapes::soup(a.facets, a.seed); }});
  soup->add_option("--facets", arguments.facets, "exactly as many")
      ->required()
      ->check(CLI::Range(std::size_t{1}, most_facets));
  soup->add_option("--seed", arguments.seed, "of the random numbers")->capture_default_str();

  add("box", "A box of side 2", "-o box.ply", {[](const Arguments&) { return shapes::box(); }});
  add_subdivisions(add("icosphere", "A sphere of radius 1", "--subdivisions 5 -o sphere.ply",
                       {[](const Arguments& a) { return shapes::icosphere(a.subdivisions); }}),
                   arguments);
}

}  // namespace

int main(int argc, char** argv) {
  constexpr int bad_usage = 2;
  CLI::App program("Writes the meshes made by formula: the extreme cases of facet sorting.", "facetsort-generate");
  program.footer(
      "Example:\n  facetsort-generate torus_knot --facets 200000 -o knot.ply\n\n"
      "facetsort-generate SHAPE --help tells a shape's options.");
  program.require_subcommand(1);
  Arguments arguments;
  Shape shape;
  add_shapes(program, arguments, shape);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return program.exit(error) == 0 ? 0 : bad_usage;
  }

  if (const std::string complaint = shape.complaint(arguments); !complaint.empty()) {
    std::fprintf(stderr, "facetsort-generate: %s\n", complaint.c_str());
    return bad_usage;
  }
  const Mesh mesh = shape.make(arguments);
  if (const facetsort::Status status = facetsort::write_ply(arguments.output, mesh.view()); !status.ok()) {
    std::fprintf(stderr, "facetsort-generate: %s\n", status.message.c_str());
    return bad_usage;
  }
  return 0;
}
