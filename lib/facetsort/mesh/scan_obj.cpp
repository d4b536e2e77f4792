// Wavefront OBJ: its vertices, faces and materials. Statements of other kinds (curves, lines, points, groups, normals,
// texture coordinates) are passed over.
#include <algorithm>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "facetsort/mesh/plain_ply.h"
#include "facetsort/mesh/text.h"

namespace facetsort {
namespace {

constexpr text::Lines::Syntax obj_syntax{.comment = '#', .continuation = true};

struct Material {
  glm::vec3 diffuse{1};
  std::optional<float> opacity, transparency;
};

using Materials = std::map<std::string, Material, std::less<>>;

// A value of Kd, d or Tr: what can't be understood (Kd may be a spectral curve in another file) is left out.
std::optional<float> material_value(std::string_view word) {
  const std::optional<float> value = text::parse_float(word);
  if (!value || !(*value >= 0)) return std::nullopt;
  return std::min(*value, 1.0f);
}

void read_materials(std::string_view file, Materials& materials) {
  Material* material = nullptr;
  for (text::Lines lines(file, obj_syntax); lines.next();) {
    const std::vector<std::string_view>& words = lines.words();
    if (words[0] == "newmtl") {
      material = &materials[std::string(lines.rest_after(0))];
      *material = {};
    } else if (!material || words.size() < 2) {
      continue;
    } else if (words[0] == "Kd") {
      // One number stands for all three.
      const std::optional<float> red = material_value(words[1]);
      const std::optional<float> green = words.size() > 2 ? material_value(words[2]) : red;
      const std::optional<float> blue = words.size() > 3 ? material_value(words[3]) : red;
      if (red && green && blue) material->diffuse = {*red, *green, *blue};
    } else if (words[0] == "d") {
      // "d -halo 0.5" makes the opacity depend on the view; the number is its base.
      material->opacity = material_value(words.back());
    } else if (words[0] == "Tr") {
      material->transparency = material_value(words.back());
    }
  }
}

// Where a material has both, d counts: some writers take Tr for another name of d.
glm::vec4 material_colour(const Material& material) {
  return {material.diffuse, material.opacity.value_or(1 - material.transparency.value_or(0))};
}

// A material file that is missing or can't be read is no fault of the mesh: its materials stay undefined.
bool read_material_file(const std::filesystem::path& folder, std::string name, Materials& materials) {
  for (int attempt = 0; attempt < 2; ++attempt) {
    std::error_code error;
    if (std::filesystem::is_regular_file(folder / name, error)) {
      try {
        read_materials(read_bytes(folder / name), materials);
        return true;
      } catch (const ReadError&) {
        return false;
      }
    }
    // Written on Windows, perhaps.
    std::replace(name.begin(), name.end(), '\\', '/');
  }
  return false;
}

// One name with spaces in it, quoted or not, or else several names.
void read_material_library(const std::filesystem::path& folder, const text::Lines& lines, Materials& materials) {
  std::string_view name = lines.rest_after(0);
  if (name.size() > 1 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  if (name.empty() || read_material_file(folder, std::string(name), materials)) return;
  for (std::size_t i = 1; i < lines.words().size(); ++i) {
    read_material_file(folder, std::string(lines.words()[i]), materials);
  }
}

class Scanner {
 public:
  Scanner(std::string_view file, const std::filesystem::path& folder) : lines_(file, obj_syntax), folder_(folder) {}

  PlainPly scan() {
    while (lines_.next()) {
      const std::string_view keyword = lines_.words()[0];
      if (keyword == "v") {
        scan_vertex();
      } else if (keyword == "f") {
        scan_face();
      } else if (keyword == "usemtl") {
        use_material(lines_.rest_after(0));
      } else if (keyword == "mtllib") {
        read_material_library(folder_, lines_, materials_);
      }
    }
    check_references_to_later_vertices();

    PlainPly result = plain_.finish();
    scale_to_unit(vertex_colours_, "colours of vertices");
    if (!vertex_colours_.empty()) vertex_colours_.resize(result.vertices, glm::vec4(1));
    result.vertex_colours = std::move(vertex_colours_);
    result.facet_colours = facet_colours();
    return result;
  }

 private:
  // Of a face that names vertices which the file had not listed by then, its largest index.
  struct LaterReference {
    std::size_t line, face, index;
  };

  std::string at_line(std::size_t line) const { return "line " + std::to_string(line) + ": "; }

  // x y z [w], or x y z r g b [a].
  void scan_vertex() {
    const std::vector<std::string_view>& words = lines_.words();
    if (words.size() < 4) {
      throw ReadError{lines_.is_cut() ? Fault::truncated : Fault::malformed,
                      at_line(lines_.number()) + "vertex " + std::to_string(plain_.vertex_count() + 1) + " has " +
                          std::to_string(words.size() - 1) + " of 3 coordinates"};
    }
    for (std::size_t i = 1; i < 4; ++i) {
      if (text::parse_float(words[i])) continue;
      throw ReadError{Fault::malformed, at_line(lines_.number()) + "vertex " +
                                            std::to_string(plain_.vertex_count() + 1) +
                                            " has a coordinate that is not a number"};
    }
    if (words.size() == 7 || words.size() == 8) {
      const std::optional<glm::vec4> colour = parse_colour(std::span(words).subspan(4));
      if (!colour) {
        throw ReadError{Fault::malformed, at_line(lines_.number()) + "a colour that is not a number or is negative"};
      }
      vertex_colours_.resize(plain_.vertex_count(), no_colour);
      vertex_colours_.push_back(*colour);
    }
    plain_.add_vertex(words[1], words[2], words[3]);
  }

  // Corners are v, v/vt, v//vn or v/vt/vn.
  void scan_face() {
    const std::vector<std::string_view>& words = lines_.words();
    const std::size_t face = plain_.face_count(), corners = words.size() - 1;
    if (corners < 3) {
      throw ReadError{lines_.is_cut() ? Fault::truncated : Fault::malformed,
                      at_line(lines_.number()) + "facet " + std::to_string(face) + " has " + std::to_string(corners) +
                          " corners, fewer than 3"};
    }
    plain_.begin_face(corners);
    std::size_t largest = 0;
    for (std::size_t i = 1; i <= corners; ++i) {
      const std::size_t vertex = resolve(words[i], face);
      largest = std::max(largest, vertex);
      plain_.add_corner(vertex);
    }
    if (largest >= plain_.vertex_count()) later_references_.push_back({lines_.number(), face, largest + 1});
    material_of_facet_.insert(material_of_facet_.end(), corners - 2, material_);
  }

  // The vertex, from 0, that one corner names.
  std::size_t resolve(std::string_view corner, std::size_t face) const {
    const std::size_t slash = corner.find('/');
    const std::optional<std::int64_t> index = text::parse_integer<std::int64_t>(corner.substr(0, slash));
    const bool is_rest_indices = slash == corner.npos || corner.find_first_not_of("0123456789-/", slash) == corner.npos;
    if (!index || !is_rest_indices) {
      throw ReadError{Fault::malformed, at_line(lines_.number()) + "facet " + std::to_string(face) +
                                            " has a corner that is no index: " + std::string(corner.substr(0, 40))};
    }
    // From 1, or backwards from the last vertex so far.
    const auto listed = static_cast<std::int64_t>(plain_.vertex_count());
    if (*index == 0 || *index < -listed) throw_out_of_range(lines_.number(), face, *index);
    return static_cast<std::size_t>(*index > 0 ? *index - 1 : listed + *index);
  }

  [[noreturn]] void throw_out_of_range(std::size_t line, std::size_t face, std::int64_t index) const {
    throw ReadError{Fault::index_out_of_range, at_line(line) + "facet " + std::to_string(face) + " names vertex " +
                                                   std::to_string(index) + " of " +
                                                   std::to_string(plain_.vertex_count()) + " (the first is 1)"};
  }

  void check_references_to_later_vertices() const {
    for (const LaterReference& reference : later_references_) {
      if (reference.index <= plain_.vertex_count()) continue;
      throw_out_of_range(reference.line, reference.face, static_cast<std::int64_t>(reference.index));
    }
  }

  void use_material(std::string_view name) {
    const auto [entry, is_new] = material_numbers_.try_emplace(std::string(name), material_names_.size());
    if (is_new) material_names_.push_back(entry->first);
    material_ = entry->second;
  }

  // Looked up at the end: some files name their library behind the first use. Facets without a material, or with one
  // that no library defines, are opaque white beside others that have one.
  std::vector<glm::vec4> facet_colours() const {
    std::vector<glm::vec4> colour_of_material(material_names_.size(), glm::vec4(1));
    bool any_defined = false;
    for (std::size_t m = 0; m < material_names_.size(); ++m) {
      const auto material = materials_.find(material_names_[m]);
      if (material == materials_.end()) continue;
      colour_of_material[m] = material_colour(material->second);
      any_defined = true;
    }
    std::vector<glm::vec4> colours;
    if (!any_defined) return colours;
    colours.reserve(material_of_facet_.size());
    for (const std::size_t m : material_of_facet_) {
      colours.push_back(m == no_material ? glm::vec4(1) : colour_of_material[m]);
    }
    return colours;
  }

  static constexpr std::size_t no_material = std::numeric_limits<std::size_t>::max();

  text::Lines lines_;
  const std::filesystem::path& folder_;
  PlainText plain_;
  Materials materials_;
  std::map<std::string, std::size_t> material_numbers_;
  std::vector<std::string> material_names_;
  std::size_t material_ = no_material;
  std::vector<std::size_t> material_of_facet_;
  std::vector<glm::vec4> vertex_colours_;
  std::vector<LaterReference> later_references_;
};

}  // namespace

PlainPly scan_obj(std::string_view file, const std::filesystem::path& folder) {
  return Scanner(file, folder).scan();
}

}  // namespace facetsort
