#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "facetsort/report/difference_image.h"
#include "facetsort/report/image_file.h"
#include "report/sample.h"

namespace facetsort {
namespace {

struct ReadImage {
  int width = 0, height = 0, channels = 0;
  OIIO::TypeDesc type;
  std::vector<float> values;
};

ReadImage read_back(const std::filesystem::path& path) {
  OIIO::ImageSpec as_is;
  as_is.attribute("oiio:UnassociatedAlpha", 1);  // the file's own values, not multiplied by alpha
  const auto input = OIIO::ImageInput::open(path.string(), &as_is);
  if (!input) {
    ADD_FAILURE() << OIIO::geterror();
    return {};
  }
  const OIIO::ImageSpec spec = input->spec();
  ReadImage image{spec.width, spec.height, spec.nchannels, spec.format, {}};
  image.values.resize(spec.image_pixels() * static_cast<std::size_t>(spec.nchannels));
  EXPECT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, image.values.data()));
  return image;
}

Image image_of(int width, int height, std::vector<glm::vec4> pixels) {
  return {width, height, PixelFormat::rgba32f, std::move(pixels)};
}

TEST(WriteImage, ExrKeepsEveryBit) {
  const test::TemporaryFolder folder;
  const Image image = image_of(2, 3,
                               {{0, 0, 0, 1},
                                {0.1f, 1e-30f, 3.5f, 0.5f},
                                {-1, 65504.0f * 4, 1.0f / 3, 0},
                                {0.2f, 0.3f, 0.4f, 0.5f},
                                {1, 1, 1, 1},
                                {0.7f, 0.6f, 0.5f, 0.9f}});
  const Status status = write_image(folder / "a picture.EXR", image);
  ASSERT_TRUE(status.ok()) << status.message;
  const ReadImage read = read_back(folder / "a picture.EXR");
  EXPECT_EQ(read.width, 2);
  EXPECT_EQ(read.height, 3);
  EXPECT_EQ(read.type, OIIO::TypeDesc::FLOAT);
  ASSERT_EQ(read.values.size(), 24u);
  EXPECT_EQ(std::memcmp(read.values.data(), image.pixels.data(), 24 * sizeof(float)), 0);
  EXPECT_EQ(test::file_count(folder.path()), 1u);
}

TEST(WriteImage, PngIsSrgbWithStraightAlpha) {
  const test::TemporaryFolder folder;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Image image = image_of(3, 2,
                               {{0.2158605f, 0, 1, 1},
                                {0.10793025f, 0, 0.5f, 0.5f},
                                {0, 0, 0, 0},
                                {-1, 2, 0.0031308f, 1},
                                {0.5f, 0.5f, 0.5f, 0},
                                {nan, 0, 0, 1}});
  const Status status = write_image(folder / "picture.png", image);
  ASSERT_TRUE(status.ok()) << status.message;
  const ReadImage read = read_back(folder / "picture.png");
  EXPECT_EQ(read.type, OIIO::TypeDesc::UINT8);
  ASSERT_EQ(read.channels, 4);
  std::vector<int> bytes;
  for (const float value : read.values) bytes.push_back(static_cast<int>(std::lround(255 * value)));
  EXPECT_EQ(bytes, (std::vector<int>{128, 0,   255, 255,  // 0.216 linear is the middle of sRGB
                                     128, 0,   255, 128,  // the same colour, half transparent
                                     0,   0,   0,   0,    //
                                     0,   255, 10,  255,  // clamped; the knee of the curve
                                     0,   0,   0,   0,    // without alpha there is no colour
                                     0,   0,   0,   255}));
}

TEST(WriteImage, Refuses) {
  const test::TemporaryFolder folder;
  const Image image = image_of(1, 1, {{0, 0, 0, 1}});
  for (const char* name : {"picture.jpg", "picture", "png"}) {
    const Status status = write_image(folder / name, image);
    EXPECT_EQ(status.fault, Fault::unsupported_format) << name;
    EXPECT_EQ(status.message, (folder / name).string() + ": pictures are written as .exr or .png");
  }
  EXPECT_EQ(write_image(folder / "p.png", {}).fault, Fault::bad_argument);
  EXPECT_EQ(write_image(folder / "p.exr", image_of(2, 1, {{0, 0, 0, 1}})).fault, Fault::bad_argument);
  EXPECT_EQ(test::file_count(folder.path()), 0u);
}

TEST(WriteImage, UnwritableIsAFaultThatKeepsWhatIsThere) {
  const test::TemporaryFolder folder;
  for (const char* name : {"picture.png", "picture.exr"}) {
    const std::filesystem::path in_the_way = folder / name;
    std::filesystem::create_directories(in_the_way / "inside");
    const Image image = image_of(1, 1, {{0, 0, 0, 1}});
    EXPECT_EQ(write_image(in_the_way, image).fault, Fault::cannot_write);
    EXPECT_TRUE(std::filesystem::exists(in_the_way / "inside"));
    const Status status = write_image(folder / "missing" / name, image);
    EXPECT_EQ(status.fault, Fault::cannot_write);
    EXPECT_EQ(status.message.rfind((folder / "missing" / name).string() + ": ", 0), 0u) << status.message;
    EXPECT_EQ(status.message.find('\n'), std::string::npos);
  }
  EXPECT_EQ(test::file_count(folder.path()), 2u);
}

float luminance(const glm::vec4& linear) {
  return glm::dot(glm::vec3(linear), glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

TEST(DifferenceImage, RightPixelsAreDarkGrey) {
  const Image reference = image_of(3, 1, {{0, 0, 0, 1}, {1, 1, 1, 1}, {0.2f, 0.5f, 0.1f, 1}});
  const Image picture = difference_image(reference, reference);
  for (const glm::vec4& pixel : picture.pixels) {
    EXPECT_EQ(pixel.r, pixel.g);
    EXPECT_EQ(pixel.r, pixel.b);
    EXPECT_EQ(pixel.a, 1);
    EXPECT_LT(pixel.r, 0.07f);
  }
  EXPECT_GT(picture.pixels[1].r, picture.pixels[0].r) << "the reference is to be seen";
}

TEST(DifferenceImage, WrongPixelsStandOutFromAnyGreyAndTheMoreTheWorse) {
  const glm::vec4 white{1, 1, 1, 1};
  const float brightest = luminance(difference_image(image_of(1, 1, {white}), image_of(1, 1, {white})).pixels[0]);
  float last = brightest;
  for (const float difference : {1.1f / 255, 2.0f / 255, 0.05f, 0.2f, 0.5f, 1.0f}) {
    const Image wrong = image_of(1, 1, {{1 - difference, 1, 1, 1}});
    const float shown = luminance(difference_image(wrong, image_of(1, 1, {white})).pixels[0]);
    EXPECT_GT(shown, last) << difference;
    last = shown;
  }
  EXPECT_GT(luminance(difference_image(image_of(1, 1, {{1 - 1.1f / 255, 1, 1, 1}}), image_of(1, 1, {white})).pixels[0]),
            1.2f * brightest);
}

TEST(DifferenceImage, OneStepOfEightBitsIsRightTwoAreWrong) {
  for (int n = 0; n < 254; ++n) {
    const Image reference = image_of(1, 1, {{0, 0, static_cast<float>(n) / 255, 1}});
    const Image one = image_of(1, 1, {{0, 0, static_cast<float>(n + 1) / 255, 1}});
    const Image two = image_of(1, 1, {{0, 0, static_cast<float>(n + 2) / 255, 1}});
    EXPECT_EQ(difference_image(one, reference).pixels[0].r, difference_image(one, reference).pixels[0].g) << n;
    EXPECT_NE(difference_image(two, reference).pixels[0].r, difference_image(two, reference).pixels[0].g) << n;
  }
}

TEST(DifferenceImage, AlphaCountsAndNotANumberIsWrong) {
  const Image reference = image_of(2, 1, {{0, 0, 0, 1}, {0, 0, 0, 1}});
  const Image image = image_of(2, 1, {{0, 0, 0, 0.5f}, {0, std::numeric_limits<float>::quiet_NaN(), 0, 1}});
  const Image picture = difference_image(image, reference);
  EXPECT_GT(luminance(picture.pixels[0]), 0.07f);
  EXPECT_GT(luminance(picture.pixels[1]), 0.5f);
}

}  // namespace
}  // namespace facetsort
