// What every verb has in common: help, one line a fault, one JSON document.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/run_program.h"
#include "shapes.h"

namespace facetsort {
namespace {

using Arguments = std::vector<std::string>;

void expect_one_line_fault(const Finished& finished, const std::string& said) {
  EXPECT_EQ(finished.status, 2);
  EXPECT_EQ(finished.output, "");
  EXPECT_EQ(finished.error.find('\n'), finished.error.size() - 1) << finished.error;
  EXPECT_NE(finished.error.find(said), std::string::npos) << finished.error;
  EXPECT_EQ(finished.error.rfind("facetsort: ", 0), 0u) << finished.error;
}

class CommandLine : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_.path() / name).string(); }

  TemporaryFolder folder_;
  std::string box_ = write_mesh(folder_, "box.ply", shapes::box());
};

TEST_F(CommandLine, HelpTellsEveryVerbWithAWorkedExampleAndDefaults) {
  const std::pair<std::string, std::vector<std::string>> verbs[] = {
      {"inspect", {"--views N=6", "--size N|WxH=256", "--radii D=2.5"}},
      {"order", {"--method M=centroid_distance", "--max-growth G=64", "[the centre of the mesh's box]"}},
      {"blend", {"--up X,Y,Z=0,1,0", "--fov DEGREES=45", "[perspective]", "--size N|WxH=512", "--format F=rgba32f"}},
      {"check", {"[1e-4 bounding radii]", "--size N|WxH=512"}},
      {"compare", {"--views N=4", "--radii D=2.5", "--repeats N=5", "--format F=rgba32f", "[all]"}},
      {"plan", {"--budget E=0", "--frames N=10000", "--views N=4", "--size N|WxH=256", "--radii D=2.5"}},
      {"stability", {"in [16 - 4096]=192"}}};
  const Finished program = run_program({"--help"});
  EXPECT_EQ(program.status, 0);
  for (const auto& [verb, defaults] : verbs) {
    EXPECT_NE(program.output.find("\n  " + verb + " "), std::string::npos) << verb;
    const Finished finished = run_program({verb, "--help"});
    EXPECT_EQ(finished.status, 0) << finished.error;
    EXPECT_EQ(finished.error, "");
    std::vector<std::string> all{"Example: facetsort " + verb + " ", "--json", "[one a hardware thread]"};
    all.insert(all.end(), defaults.begin(), defaults.end());
    for (const std::string& said : all) {
      EXPECT_NE(finished.output.find(said), std::string::npos) << verb << " does not say " << said;
    }
  }
}

TEST_F(CommandLine, TellsItsVersion) {
  const Finished finished = run_program({"--version"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_EQ(finished.output.rfind("facetsort ", 0), 0u);
  EXPECT_GT(finished.output.find('.'), std::string("facetsort ").size());
}

TEST_F(CommandLine, TellsBadUsageInOneLine) {
  const std::string out = path("out.u32"), png = path("out.png");
  const Arguments order{"order", box_, "-o", out};
  const auto with = [](Arguments arguments, const Arguments& more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  const struct {
    Arguments arguments;
    const char* said;
  } cases[] = {
      {{}, "inspect, order, presort, blend, check, compare, plan, stability"},
      {{"frobnicate"}, "frobnicate"},
      {order, "--eye"},
      {with(order, {"--eye", "1,2"}), "--eye: '1,2'"},
      {with(order, {"--eye", "1,2,nan"}), "nan"},
      {with(order, {"--eye", "1,2,1e300"}), "1e300"},
      {with(order, {"--eye", "0,0,0"}), "--eye is at the centre"},
      {with(order, {"--eye", "0,0,5", "--at", "0,0,5"}), "the eye is at the point it looks at"},
      {with(order, {"--eye", "0,0,5", "--fov", "wide"}), "--fov"},
      {with(order, {"--eye", "0,0,5", "--near", "0"}), "near"},
      {with(order, {"--eye", "0,0,5", "--method", "alphabetical"}), "alphabetical"},
      {with(order, {"--eye", "0,0,5", "--method", "exact", "--max-growth", "0.9"}), "'0.9' is not a number of at least 1"},
      {with(order, {"--eye", "0,0,5", "--method", "exact", "--max-growth", "nan"}), "--max-growth"},
      {with(order, {"--eye", "0,0,5", "--max-growth", "2"}), "an option of the exact methods"},
      {with(order, {"--eye", "0,0,5", "--threads", "0"}), "--threads"},
      {with(order, {"--eye", "0,0,5", "--sideways"}), "--sideways"},
      {{"order", box_, "--eye", "0,0,5", "-o", path("out.txt")}, ".u32 or .ply"},
      {{"blend", box_, "--eye", "0,0,5", "-o", png, "--strategy", "magic"}, "magic"},
      {{"blend", box_, "--eye", "0,0,5", "-o", png, "--strategy", "unsorted", "--size", "12x"}, "'12x'"},
      {{"blend", box_, "--eye", "0,0,5", "-o", png, "--strategy", "unsorted", "--size", "99999x99999"}, "2^30 pixels"},
      {{"blend", box_, "--eye", "0,0,5", "-o", png, "--strategy", "unsorted", "--format", "rgb"}, "'rgb'"},
      {{"blend", box_, "--eye", "0,0,5", "-o", path("out.gif"), "--strategy", "unsorted"}, ".exr or .png"},
      {{"compare", box_, "--out", path("report"), "--strategies", "unsorted,magic"}, "magic"},
      {{"compare", box_, "--out", path("report"), "--radii", "-1"}, "--radii"},
  };
  for (const auto& [arguments, said] : cases) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    expect_one_line_fault(run_program(arguments), said);
  }
  // Nothing was written, however far each case came.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(CommandLine, TellsBadMeshesInOneLineThatNamesThem) {
  const std::string cut = folder_.write("cut.ply", file_bytes(box_).substr(0, 300)).string();
  const std::string newline = path("two\nlines.ply");
  for (const std::string& mesh : {path("missing.ply"), cut, folder_.path().string(), newline}) {
    SCOPED_TRACE(mesh);
    const std::string name = mesh == newline ? "two?lines.ply" : std::filesystem::path(mesh).filename().string();
    expect_one_line_fault(run_program({"inspect", box_, mesh, "--json"}), name);
  }
  // One bad mesh among several is met before any work is done.
  expect_one_line_fault(run_program({"compare", box_, cut, "--out", path("report")}), "cut.ply");
  EXPECT_FALSE(std::filesystem::exists(path("report")));
}

TEST_F(CommandLine, EyesMayHaveNegativeCoordinates) {
  EXPECT_EQ(run_program({"order", box_, "--eye", "-1,-2,-5", "-o", path("out.u32")}).status, 0);
  EXPECT_EQ(run_program({"order", box_, "--eye", "-.5,2,5e0", "-o", path("out.u32")}).status, 0);
}

TEST_F(CommandLine, FullStandardOutputIsAFault) {
  const Finished finished = run_program({"inspect", box_}, {.standard_output = "/dev/full"});
  EXPECT_EQ(finished.status, 2);
  EXPECT_EQ(finished.error, "facetsort: standard output cannot be written\n");
}

TEST_F(CommandLine, JsonIsOneDocumentAndNothingElse) {
  const std::vector<Arguments> commands{
      {"inspect", box_, "--json"},
      {"order", box_, "--eye", "1,2,5", "-o", path("out.u32"), "--json"},
      {"order", box_, "--eye", "1,2,5", "-o", path("out.u32"), "--method", "exact", "--json"},
      {"blend", box_, "--strategy", "unsorted", "--eye", "1,2,5", "--size", "16", "-o", path("out.png"), "--json"},
      {"check", box_, "--order", path("out.u32"), "--eye", "1,2,5", "--size", "16", "--json"},
      {"compare", box_, "--views", "1", "--size", "16", "--repeats", "1", "--out", path("report"), "--json"}};
  for (const Arguments& command : commands) {
    const Finished finished = run_program(command);
    EXPECT_EQ(finished.status, 0) << finished.error;
    EXPECT_EQ(finished.error, "");
    EXPECT_TRUE(nlohmann::json::parse(finished.output, nullptr, false).is_object()) << finished.output;
  }
}

}  // namespace
}  // namespace facetsort
