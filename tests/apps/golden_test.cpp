// Golden pictures, judged by the count of wrong pixels: tests/apps/golden/pictures.txt lists them.
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <ostream>
#include <sstream>

#include "apps/run_program.h"

namespace facetsort {
namespace {

std::filesystem::path golden_folder() { return std::filesystem::path(FACETSORT_SOURCE_DIR) / "tests/apps/golden"; }

struct Golden {
  std::string name;
  std::size_t allowed = 0;
  std::vector<std::string> arguments;
};

void PrintTo(const Golden& golden, std::ostream* out) { *out << golden.name; }

std::vector<Golden> golden_pictures() {
  std::vector<Golden> pictures;
  std::ifstream file(golden_folder() / "pictures.txt");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Golden golden;
    words >> golden.name >> golden.allowed;
    for (std::string word; words >> word;) golden.arguments.push_back(word);
    golden.arguments.front() = std::string(FACETSORT_SOURCE_DIR) + "/" + golden.arguments.front();
    pictures.push_back(golden);
  }
  return pictures;
}

struct Pixels {
  int width = 0, height = 0, channels = 0;
  std::vector<unsigned char> values;
};

Pixels read_pixels(const std::filesystem::path& path) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) throw std::runtime_error("cannot read " + path.string());
  const OIIO::ImageSpec& spec = input->spec();
  Pixels pixels{spec.width, spec.height, spec.nchannels, {}};
  pixels.values.resize(static_cast<std::size_t>(spec.width * spec.height * spec.nchannels));
  if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, pixels.values.data())) {
    throw std::runtime_error(input->geterror());
  }
  return pixels;
}

class GoldenPicture : public testing::TestWithParam<Golden> {};
INSTANTIATE_TEST_SUITE_P(Blend, GoldenPicture, testing::ValuesIn(golden_pictures()),
                         [](const auto& golden) { return golden.param.name; });

TEST_P(GoldenPicture, IsDrawnAgain) {
  const TemporaryFolder folder;
  const std::filesystem::path drawn_path = folder.path() / "drawn.png";
  std::vector<std::string> arguments{"blend"};
  arguments.insert(arguments.end(), GetParam().arguments.begin(), GetParam().arguments.end());
  arguments.insert(arguments.end(), {"-o", drawn_path.string()});
  const Finished finished = run_program(arguments);
  ASSERT_EQ(finished.status, 0) << finished.error;

  const Pixels drawn = read_pixels(drawn_path), golden = read_pixels(golden_folder() / (GetParam().name + ".png"));
  ASSERT_EQ(drawn.width, golden.width);
  ASSERT_EQ(drawn.height, golden.height);
  ASSERT_EQ(drawn.channels, golden.channels);
  std::size_t wrong = 0, lit = 0;
  const auto channels = static_cast<std::size_t>(golden.channels);
  for (std::size_t pixel = 0; pixel < golden.values.size(); pixel += channels) {
    int largest = 0;
    for (std::size_t k = 0; k < channels; ++k) {
      largest = std::max(largest, std::abs(drawn.values[pixel + k] - golden.values[pixel + k]));
    }
    wrong += largest > 1;
    lit += golden.values[pixel] > 20;
  }
  EXPECT_LE(wrong, GetParam().allowed);
  EXPECT_GT(lit, 500u) << "the golden picture shows hardly anything";
}

}  // namespace
}  // namespace facetsort
