// What of a picture is shown: each content of pictures whose pixels are known.
// Mirrors content.h.
#include "app/picture/content.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "app/picture/heat_map.h"
#include "app/picture/picture.h"
#include "render/base/error.h"
#include "render/march/sample_frame.h"

namespace warpscope {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr Rgba8 kBlack = 0xff000000u, kWhite = 0xffffffffu, kDarkGrey = 0xff303030u;

uint32_t red(Rgba8 color) { return color & 255; }
uint32_t green(Rgba8 color) { return color >> 8 & 255; }
uint32_t blue(Rgba8 color) { return color >> 16 & 255; }

/// Four pixels beside each other: a sample, nothing where there should be something, a guess, nothing where nothing is.
class ContentTest : public ::testing::Test {
 protected:
  ContentTest() {
    image_.color.resize(4, 1);
    image_.samples.resize(4, 1);
    truth_.resize(4, 1);
    image_.color[0] = {0.5f, 0.5f, 0.5f, 1.0f};
    image_.color[1] = {0.0f, 0.0f, 0.0f, 0.0f};
    image_.color[2] = {0.2f, 0.1f, 0.0f, 0.5f};
    image_.color[3] = {0.0f, 0.0f, 0.0f, 0.0f};
    image_.samples[0] = 0;
    image_.samples[1] = kNoSample;
    image_.samples[2] = kFilled;
    image_.samples[3] = kNoSample;
    truth_[0] = {0.25f, 0.25f, 0.25f, 1.0f};
    truth_[1] = {0.8f, 0.8f, 0.8f, 1.0f};
    truth_[2] = {0.2f, 0.1f, 0.0f, 0.5f};
    truth_[3] = {0.0f, 0.0f, 0.0f, 0.0f};

    frame_.camera.eye = {0.0f, 0.0f, 10.0f};
    frame_.camera.width = frame_.camera.height = 1;
    frame_.camera.tanHalfFovY = 0.1f;
    frame_.quantization = quantizationFor(frame_.camera, {glm::vec3(-5.0f), glm::vec3(5.0f)}, 1.0f);
  }

  ContentInputs inputs() const { return {.image = image_, .camera = camera_, .reference = &truth_, .frame = &frame_}; }
  ShownContent shown(PictureContent content, std::optional<float> range = {}) const { return show(content, inputs(), range); }

  WarpedImage image_;
  Image<glm::vec4> truth_;
  SampleFrame frame_;
  Camera camera_;
};

TEST_F(ContentTest, ThePictureIsWhatAScreenShows) {
  const ShownContent content = shown(PictureContent::picture);
  const Image<Rgba8> screen = toScreen(image_, glm::vec3(0.0f));
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(content.picture[i], screen[i]);
  EXPECT_FALSE(content.hasRamp);
}

TEST_F(ContentTest, DifferencesAreOrangeWhereThePictureIsBrighterAndBlueWhereItIsDarker) {
  const ShownContent content = shown(PictureContent::difference);
  EXPECT_GT(red(content.picture[0]), blue(content.picture[0]));
  EXPECT_GT(blue(content.picture[1]), red(content.picture[1]));
  EXPECT_EQ(content.picture[2], kBlack);
  EXPECT_EQ(content.picture[3], kBlack);
  EXPECT_EQ(content.low, -content.high);
  // As displayed: 0.5 is 0.735 in sRGB, 0.25 is 0.537; the ramp's end is 0.5.
  EXPECT_EQ(content.picture[0], differenceColor((srgbFromLinear(0.5f) - srgbFromLinear(0.25f)) / 0.5f));
}

TEST_F(ContentTest, ARangeIsWhereTheRampEnds) {
  const float difference = srgbFromLinear(0.5f) - srgbFromLinear(0.25f);
  EXPECT_EQ(shown(PictureContent::difference, difference).picture[0], differenceColor(1.0f));
  EXPECT_EQ(shown(PictureContent::difference, 4.0f * difference).picture[0], differenceColor(0.25f));
  EXPECT_EQ(shown(PictureContent::absoluteDifference, difference).picture[0], kWhite);
  EXPECT_EQ(shown(PictureContent::opacity, 0.5f).picture[2], kWhite);
}

TEST_F(ContentTest, AbsoluteDifferencesAreThoseOfEachColour) {
  truth_[2] = {0.2f, 0.0f, 0.0f, 0.5f};  // too much green in the picture
  const Rgba8 color = shown(PictureContent::absoluteDifference).picture[2];
  EXPECT_EQ(red(color), 0u);
  EXPECT_EQ(green(color), quantizeUnorm8(2.0f * srgbFromLinear(0.1f)));
  EXPECT_EQ(blue(color), 0u);
}

TEST_F(ContentTest, TheBackgroundCountsWhereItShowsThrough) {
  ContentInputs white = inputs();
  white.background = glm::vec3(1.0f);
  EXPECT_EQ(show(PictureContent::difference, white).picture[3], kBlack);  // both show it
  EXPECT_GT(red(show(PictureContent::difference, white).picture[1]), 0u);  // the white behind the hole is brighter than what should be there
}

TEST_F(ContentTest, FlipIsLargestWhereSomethingIsMissingAndNothingWhereAllIsRight) {
  const ShownContent content = shown(PictureContent::flip);
  EXPECT_NE(content.picture[1], heatColor(0.0f));
  EXPECT_EQ(content.high, 0.5f);
  truth_ = image_.color;
  EXPECT_EQ(shown(PictureContent::flip).picture[1], heatColor(0.0f));
}

TEST_F(ContentTest, HolesAreWhereSomethingShouldBe) {
  ContentInputs marked = inputs();
  marked.marks = {.uncovered = 0x0000ffu, .filled = 0x00ff00u};
  const Image<Rgba8> picture = show(PictureContent::holes, marked).picture;
  EXPECT_EQ(picture[1], 0xff0000ffu);
  EXPECT_EQ(picture[2], 0xff00ff00u);
  EXPECT_EQ(picture[3], kBlack);
  EXPECT_EQ(red(picture[0]), green(picture[0]));  // the picture itself, dimmed
  EXPECT_LT(red(picture[0]), red(toScreen(image_, glm::vec3(0.0f))[0]));
  EXPECT_NE(shown(PictureContent::holes).picture[1], kBlack);  // without marks as well
}

TEST_F(ContentTest, DepthAndRadiusAreThoseOfTheSampleInThePixel) {
  for (const auto& [behind, radius] : {std::pair(6.0f, 1.0f), std::pair(2.0f, 0.5f)}) {
    frame_.samples.push_back(packSample(0, 0, behind, radius, frame_.quantization));
    frame_.colors.push_back(kWhite);
  }
  image_.samples[3] = 1;
  camera_.eye = {0.0f, 0.0f, 20.0f};
  const SampleGrid grid = frame_.grid();
  const float near = glm::length(unpackSample(frame_.samples[1], grid).center - camera_.eye), far = glm::length(unpackSample(frame_.samples[0], grid).center - camera_.eye);
  ASSERT_LT(near, far);

  const ShownContent depth = shown(PictureContent::depth);
  EXPECT_FLOAT_EQ(depth.low, near);
  EXPECT_FLOAT_EQ(depth.high, far);
  EXPECT_EQ(depth.picture[0], heatColor(1.0f));
  EXPECT_EQ(depth.picture[3], heatColor(0.0f));
  EXPECT_EQ(depth.picture[1], kDarkGrey);  // nothing is known of holes and guesses
  EXPECT_EQ(depth.picture[2], kDarkGrey);

  const ShownContent radius = shown(PictureContent::radius);
  EXPECT_EQ(radius.low, 0.0f);
  EXPECT_EQ(radius.picture[0], heatColor(1.0f));
  EXPECT_NEAR(red(radius.picture[3]), red(heatColor(0.5f)), 4);
}

TEST_F(ContentTest, AgeIsHowManyFramesBackAPixelIs) {
  image_.samples[0] = kNotASample;
  image_.samples[1] = kOfEarlierFrame;
  image_.samples[2] = kOfEarlierFrame + 6;
  image_.samples[3] = kFilled;
  const ShownContent shown = show(PictureContent::age, inputs());
  EXPECT_TRUE(shown.hasRamp);
  EXPECT_EQ(shown.picture[0], rampColor(PictureContent::age, 0.0f));
  EXPECT_EQ(shown.picture[1], rampColor(PictureContent::age, 1.0f / 7.0f));
  EXPECT_EQ(shown.picture[2], rampColor(PictureContent::age, 1.0f));
  EXPECT_NE(shown.picture[3], shown.picture[0]) << "a guess is of no frame";
}

TEST_F(ContentTest, WhatCannotBeShownIsRefused) {
  EXPECT_THAT([&] { shown(PictureContent::depth); }, ThrowsMessage<InputError>(HasSubstr("no pixel of the picture says which sample")));
  ContentInputs alone = inputs();
  alone.frame = nullptr;
  EXPECT_THROW(show(PictureContent::depth, alone), InputError);
  alone.reference = nullptr;
  EXPECT_THROW(show(PictureContent::flip, alone), InputError);
  EXPECT_NO_THROW(show(PictureContent::opacity, alone));
  const Image<glm::vec4> other(3, 1);
  alone.reference = &other;
  EXPECT_THROW(show(PictureContent::difference, alone), InputError);
  for (const float range : {0.0f, -1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
    EXPECT_THROW(shown(PictureContent::opacity, range), InputError) << range;
  truth_[3].r = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(shown(PictureContent::holes), InputError);
}

TEST(Contents, TheListIsInTheOrderOfItsValues) {
  for (const ContentDescriptor& row : pictureContents()) {
    EXPECT_EQ(&describe(row.value), &row);
    EXPECT_FALSE(row.name.empty() || row.label.empty() || row.help.empty());
    EXPECT_NE(row.help.back(), '.');
  }
}

TEST(Contents, TheDifferencesRampIsBlackInTheMiddleAndClampsAtItsEnds) {
  EXPECT_EQ(differenceColor(0.0f), kBlack);
  EXPECT_EQ(differenceColor(std::numeric_limits<float>::quiet_NaN()), kBlack);
  EXPECT_EQ(differenceColor(7.0f), differenceColor(1.0f));
  EXPECT_EQ(differenceColor(-7.0f), differenceColor(-1.0f));
}

}  // namespace
}  // namespace warpscope
