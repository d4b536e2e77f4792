// The library's includes run one way, down the pipeline, and each heavy package stays in the one file that needs it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <regex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/project_files.h"

namespace facetsort {
namespace {

// Path below lib/, as an #include names it, and content.
using Sources = std::map<std::string, std::string>;

// In pipeline order: a folder includes itself and what stands before it.
constexpr std::array library_folders{"base",  "mesh",  "facets",  "order", "exact",  "scene",
                                     "blend", "check", "presort", "plan",  "report", "c"};

// A package and a folder that may include its headers, in a single file of it where `single_file`.
struct PackageHome {
  std::string_view include_prefix;
  std::string_view folder;
  bool single_file;
};
constexpr std::array package_homes{
    PackageHome{"OpenMesh/", "mesh", true},      PackageHome{"boost/", "exact", true},
    PackageHome{"hwy/", "exact", false},         PackageHome{"hwy/", "blend", true},
    PackageHome{"hwy/", "order", false},         PackageHome{"embree3/", "check", true},
    PackageHome{"OpenImageIO/", "report", true}, PackageHome{"nlohmann/", "report", true},
    PackageHome{"tiny_gltf.h", "presort", true}, PackageHome{"tiny_gltf.h", "scene", false},
    PackageHome{"nlohmann/", "scene", true},
};
// Small enough for every folder, and part of what `order` asks for.
constexpr std::array packages_for_all{"glm/", "tbb/"};

struct Include {
  std::string target;
  bool quoted;
};

std::vector<Include> includes_of(const std::string& source) {
  static const std::regex pattern(R"re(^\s*#\s*include\s*(?:"([^"]+)"|<([^>]+)>))re");
  std::vector<Include> includes;
  for (const std::string& line : lines_of(source)) {
    std::smatch match;
    if (line.find("include") == std::string::npos) continue;  // most lines
    if (!std::regex_search(line, match, pattern)) continue;
    includes.push_back({match[1].matched ? match[1].str() : match[2].str(), match[1].matched});
  }
  return includes;
}

// "facetsort/order/sorter.h" is in "order"; "facetsort/facetsort.h" is in none.
std::string folder_of(const std::string& path) {
  const std::size_t begin = path.find('/') + 1, end = path.find('/', begin);
  return end == std::string::npos ? "" : path.substr(begin, end - begin);
}

std::optional<std::size_t> place_of(const std::string& folder) {
  const auto found = std::find(library_folders.begin(), library_folders.end(), folder);
  if (found == library_folders.end()) return std::nullopt;
  return static_cast<std::size_t>(found - library_folders.begin());
}

bool is_header(const std::string& path) {
  return path.ends_with(".h");
}

// A header says so in the comment that it starts with.
bool is_internal(const std::string& source) {
  for (const std::string& line : lines_of(source)) {
    if (!line.starts_with("//")) return false;
    if (line.find("Internal to ") != std::string::npos) return true;
  }
  return false;
}

// Each fault as "FILE: what is wrong".
std::vector<std::string> include_faults(const Sources& sources) {
  std::vector<std::string> faults;
  std::map<std::pair<std::string_view, std::string>, std::set<std::string>> package_users;  // of a package, in a folder
  for (const auto& [file, source] : sources) {
    const auto fault = [&, &file = file](const std::string& what) { faults.push_back(file + ": " + what); };
    const std::string folder = folder_of(file);
    if (folder.empty()) continue;  // facetsort.h, which has a test of its own
    const std::optional<std::size_t> place = place_of(folder);
    if (!place) {
      fault("its folder has no place in the pipeline");
      continue;
    }
    for (const auto& [target, quoted] : includes_of(source)) {
      if (quoted) {
        const auto included = sources.find(target);
        if (included == sources.end()) {
          fault("includes \"" + target + "\", which is no file of the library");
          continue;
        }
        const std::optional<std::size_t> target_place = place_of(folder_of(target));
        if (!target_place || *target_place > *place) fault("includes " + target + ", which comes later");
        if (!is_internal(included->second)) continue;
        if (folder_of(target) != folder) fault("includes " + target + ", which is internal to another folder");
        if (is_header(file) && !is_internal(source)) fault("is public and includes " + target + ", which is internal");
        continue;
      }
      const auto starts_target = [&, &target = target](std::string_view prefix) { return target.starts_with(prefix); };
      const auto home = std::find_if(package_homes.begin(), package_homes.end(),
                                     [&](const PackageHome& package) { return starts_target(package.include_prefix); });
      if (home != package_homes.end()) {
        const bool at_home = std::any_of(package_homes.begin(), package_homes.end(), [&](const PackageHome& package) {
          return starts_target(package.include_prefix) && package.folder == folder;
        });
        if (at_home) package_users[{home->include_prefix, folder}].insert(file);
        if (!at_home) fault("includes <" + target + ">, which belongs in " + std::string(home->folder));
        if (is_header(file) && !is_internal(source)) fault("is a public header and includes <" + target + ">");
      } else if (target.find('/') != std::string::npos && !target.starts_with("sys/") &&
                 std::none_of(packages_for_all.begin(), packages_for_all.end(), starts_target)) {
        fault("includes <" + target + "> of a package that has no place in the library");
      }
    }
  }
  for (const PackageHome& package : package_homes) {
    const std::set<std::string>& users = package_users[{package.include_prefix, std::string(package.folder)}];
    if (!package.single_file || users.size() < 2) continue;
    faults.push_back(*users.rbegin() + ": includes <" + std::string(package.include_prefix) + "...> as does " +
                     *users.begin());
  }
  return faults;
}

// Faults of the header that includes all the others.
std::vector<std::string> umbrella_faults(const Sources& sources, const std::string& umbrella) {
  std::vector<std::string> faults;
  std::set<std::string> included;
  std::size_t last_place = 0;
  for (const auto& [target, quoted] : includes_of(sources.at(umbrella))) {
    const auto found = sources.find(target);
    if (!quoted || found == sources.end()) {
      faults.push_back(target + ": no header of the library");
      continue;
    }
    if (!included.insert(target).second) faults.push_back(target + ": twice");
    if (is_internal(found->second)) faults.push_back(target + ": internal");
    const std::size_t place = place_of(folder_of(target)).value_or(0);
    if (place < last_place) faults.push_back(target + ": out of pipeline order");
    last_place = std::max(last_place, place);
  }
  for (const auto& [file, source] : sources) {
    if (file != umbrella && is_header(file) && !is_internal(source) && !included.contains(file)) {
      faults.push_back(file + ": missing");
    }
  }
  return faults;
}

Sources library_sources() {
  Sources sources;
  for (const std::filesystem::path& file : project_files()) {
    const bool is_source = file.extension() == ".h" || file.extension() == ".cpp" || file.extension() == ".c";
    if (is_source && file.string().starts_with("lib/facetsort/")) {
      sources[file.lexically_relative("lib").string()] = read_project_file(file);
    }
  }
  return sources;
}

using Faults = std::vector<std::string>;

TEST(IncludeDirection, RunsDownThePipeline) {
  EXPECT_EQ(include_faults(library_sources()), Faults{});
}

// A package that nobody includes any more should leave the table, and this test would stop guarding it unnoticed.
TEST(IncludeDirection, EveryPackageWithAHomeIsUsedThere) {
  const Sources sources = library_sources();
  for (const PackageHome& package : package_homes) {
    const bool used = std::any_of(sources.begin(), sources.end(), [&](const auto& file) {
      const std::vector<Include> includes = includes_of(file.second);
      return std::any_of(includes.begin(), includes.end(), [&](const Include& include) {
        return !include.quoted && include.target.starts_with(package.include_prefix);
      });
    });
    EXPECT_TRUE(used) << package.include_prefix;
  }
}

TEST(IncludeDirection, UmbrellaHasEveryPublicHeaderInPipelineOrder) {
  EXPECT_EQ(umbrella_faults(library_sources(), "facetsort/facetsort.h"), Faults{});
}

TEST(IncludeDirection, FindsAnUpwardInclude) {
  const Sources sources{{"facetsort/mesh/mesh.h", "#include \"facetsort/order/sorter.h\"\n"},
                        {"facetsort/order/sorter.h", "#include \"facetsort/mesh/mesh.h\"\n"}};
  EXPECT_EQ(include_faults(sources),
            Faults{"facetsort/mesh/mesh.h: includes facetsort/order/sorter.h, which comes later"});
}

TEST(IncludeDirection, FindsFoldersAndFilesThatAreNotThere) {
  const Sources sources{{"facetsort/extras/extra.h", ""}, {"facetsort/mesh/mesh.h", "#include \"mesh_view.h\"\n"}};
  EXPECT_EQ(include_faults(sources),
            (Faults{"facetsort/extras/extra.h: its folder has no place in the pipeline",
                    "facetsort/mesh/mesh.h: includes \"mesh_view.h\", which is no file of the library"}));
}

TEST(IncludeDirection, FindsPackagesOutsideTheirHome) {
  const Sources sources{
      {"facetsort/order/sorter.cpp", "#include <boost/multiprecision/cpp_int.hpp>\n#include <vector>\n"},
      {"facetsort/facets/facets.cpp", "#include <Eigen/Dense>\n#include <glm/glm.hpp>\n"}};
  EXPECT_EQ(
      include_faults(sources),
      (Faults{"facetsort/facets/facets.cpp: includes <Eigen/Dense> of a package that has no place in the library",
              "facetsort/order/sorter.cpp: includes <boost/multiprecision/cpp_int.hpp>, which belongs in exact"}));
}

TEST(IncludeDirection, FindsPackagesInHeadersAndInSecondFiles) {
  const Sources sources{{"facetsort/check/a.cpp", "# include <embree3/rtcore.h>\n"},
                        {"facetsort/check/b.h", "#include <embree3/rtcore.h>\n"}};
  EXPECT_EQ(include_faults(sources),
            (Faults{"facetsort/check/b.h: is a public header and includes <embree3/rtcore.h>",
                    "facetsort/check/b.h: includes <embree3/...> as does facetsort/check/a.cpp"}));
}

TEST(IncludeDirection, FindsInternalHeadersThatLeak) {
  const std::string internal = "// Tiles.\n// Internal to blend.\n";
  const Sources sources{{"facetsort/blend/tiles.h", internal},
                        {"facetsort/blend/tiles.cpp", "#include \"facetsort/blend/tiles.h\"\n"},
                        {"facetsort/blend/view.h", "#include \"facetsort/blend/tiles.h\"\n"},
                        {"facetsort/check/verdict.cpp", "#include \"facetsort/blend/tiles.h\"\n"}};
  EXPECT_EQ(
      include_faults(sources),
      (Faults{"facetsort/blend/view.h: is public and includes facetsort/blend/tiles.h, which is internal",
              "facetsort/check/verdict.cpp: includes facetsort/blend/tiles.h, which is internal to another folder"}));
}

TEST(IncludeDirection, FindsWhatIsWrongWithAnUmbrella) {
  const Sources sources{{"facetsort/all.h",
                         "#include \"facetsort/order/sorter.h\"\n#include \"facetsort/mesh/mesh.h\"\n"
                         "#include \"facetsort/mesh/mesh.h\"\n#include \"facetsort/mesh/text.h\"\n#include <vector>\n"},
                        {"facetsort/mesh/mesh.h", ""},
                        {"facetsort/mesh/read.h", ""},
                        {"facetsort/mesh/text.h", "// Internal to the readers.\n"},
                        {"facetsort/order/sorter.h", ""}};
  EXPECT_EQ(umbrella_faults(sources, "facetsort/all.h"),
            (Faults{"facetsort/mesh/mesh.h: out of pipeline order", "facetsort/mesh/mesh.h: twice",
                    "facetsort/mesh/mesh.h: out of pipeline order", "facetsort/mesh/text.h: internal",
                    "facetsort/mesh/text.h: out of pipeline order", "vector: no header of the library",
                    "facetsort/mesh/read.h: missing"}));
}

}  // namespace
}  // namespace facetsort
