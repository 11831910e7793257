// Transfer functions in files: what is written reads back, ParaView's colour maps mean here what they mean there, and what is wrong is named with its line.
// Mirrors app/scene/transfer_file.h.
#include "app/scene/transfer_file.h"

#include <gmock/gmock.h>

#include "app/scene/json_document.h"
#include "app/scene/transfer_presets.h"
#include "render/base/error.h"
#include "render/core/color.h"
#include "test_folder.h"

namespace warpscope {
namespace {

using testing::HasSubstr;

class TransferFileTest : public ::testing::Test {
 protected:
  TransferFunction read(const std::string& text) const { return readTransferFile(folder_.write("function.json", text)); }
  std::string refusalOf(const std::string& text) const {
    try {
      read(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  TestFolder folder_;
};

glm::vec3 srgbAt(const TransferFunction& function, double value) {
  const glm::vec4 look = function.at(value);
  return {srgbFromLinear(look.r), srgbFromLinear(look.g), srgbFromLinear(look.b)};
}

void expectNear(const glm::vec3& a, const glm::vec3& b, float tolerance) {
  for (int channel = 0; channel < 3; ++channel) EXPECT_NEAR(a[channel], b[channel], tolerance) << channel;
}

TEST_F(TransferFileTest, WhatIsWrittenReadsBack) {
  VoxelStatistics statistics;
  statistics.lowest = statistics.rangeLower = -3.5;
  statistics.highest = statistics.rangeUpper = 1e6;
  for (const TransferPreset& preset : transferPresets()) {
    SCOPED_TRACE(preset.name);
    const TransferFunction function = presetFunction(preset.name, statistics);
    const TransferFunction own = read(transferText(function)), paraview = read(paraviewText(function, "name"));
    ASSERT_EQ(own.points.size(), function.points.size());
    for (int i = 0; i <= 500; ++i) {
      const double value = std::lerp(-10.0, 1.1e6, i / 500.0);
      expectNear(srgbAt(own, value), srgbAt(function, value), 1e-4f);
      expectNear(srgbAt(paraview, value), srgbAt(function, value), 1.5f / 255.0f);
      EXPECT_NEAR(own.at(value).a, function.at(value).a, 1e-6);
      EXPECT_NEAR(paraview.at(value).a, function.at(value).a, 1e-5);
    }
  }
}

TEST_F(TransferFileTest, ParaViewsColoursAreInterpolatedAsThere) {
  const std::string points = R"("RGBPoints": [0, 0, 0, 0, 10, 1, 0.5, 0])";
  expectNear(srgbAt(read("[{\"ColorSpace\": \"RGB\", " + points + "}]"), 5.0), {0.5f, 0.25f, 0.0f}, 0.004f);
  expectNear(srgbAt(read("[{" + points + "}]"), 5.0), {0.5f, 0.25f, 0.0f}, 0.004f);
  expectNear(srgbAt(read("{" + points + "}"), 5.0), {0.5f, 0.25f, 0.0f}, 0.004f);
  expectNear(srgbAt(read("[{\"ColorSpace\": \"Step\", " + points + "}]"), 9.9), {0.0f, 0.0f, 0.0f}, 0.001f);
  expectNear(srgbAt(read("[{\"ColorSpace\": \"Step\", " + points + "}]"), 10.0), {1.0f, 0.5f, 0.0f}, 0.001f);
  // Red to blue by hue: the short way, through magenta.
  expectNear(srgbAt(read(R"([{"ColorSpace": "HSV", "RGBPoints": [0, 1, 0, 0, 10, 0, 0, 1]}])"), 5.0), {1.0f, 0.0f, 1.0f}, 0.01f);
  // Lab: between black and white lies L* = 50, which is 119 of 255.
  expectNear(srgbAt(read(R"([{"ColorSpace": "Lab", "RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1]}])"), 5.0), glm::vec3(119.0f / 255.0f), 0.01f);
  // Moreland 2009, table of the cool to warm map: 221 221 221 in its middle, 141 176 254 at a quarter.
  const TransferFunction coolWarm = read(R"([{"ColorSpace": "Diverging", "RGBPoints": [0, 0.23137, 0.298039, 0.752941, 1, 0.705882, 0.015686, 0.149020]}])");
  expectNear(srgbAt(coolWarm, 0.5), glm::vec3(221.0f / 255.0f), 0.01f);
  expectNear(srgbAt(coolWarm, 0.25), glm::vec3(141.0f, 176.0f, 254.0f) / 255.0f, 0.02f);
}

TEST_F(TransferFileTest, ParaViewsOpacitiesHaveMiddlesAndSharpness) {
  const std::string colors = R"("RGBPoints": [0, 0, 0, 0, 10, 1, 1, 1])";
  const TransferFunction straight = read("[{" + colors + R"(, "Points": [0, 0, 0.5, 0, 10, 1, 0.5, 0]}])");
  EXPECT_NEAR(straight.at(5.0).a, 0.5f, 1e-6);
  const TransferFunction early = read("[{" + colors + R"(, "Points": [0, 0, 0.2, 0, 10, 1, 0.5, 0]}])");
  EXPECT_NEAR(early.at(2.0).a, 0.5f, 1e-6);
  EXPECT_NEAR(early.at(6.0).a, 0.75f, 1e-6);
  const TransferFunction step = read("[{" + colors + R"(, "Points": [0, 0.1, 0.5, 1, 10, 0.8, 0.5, 0]}])");
  EXPECT_NEAR(step.at(4.99).a, 0.1f, 1e-6);
  EXPECT_NEAR(step.at(5.0).a, 0.8f, 1e-6);
  const TransferFunction none = read("[{" + colors + "}]");
  EXPECT_NEAR(none.at(2.5).a, 0.25f, 1e-6) << "a ramp";
}

TEST_F(TransferFileTest, WhatIsWrongIsNamedWithItsLine) {
  EXPECT_THAT(refusalOf(R"([{"RGBPoints": [0, 0, 0]}])"), HasSubstr("RGBPoints"));
  EXPECT_THAT(refusalOf(R"([{"RGBPoints": [0, 0, 0, 0, 10]}])"), HasSubstr("4 numbers for each corner"));
  EXPECT_THAT(refusalOf("[{\"RGBPoints\": [5, 0, 0, 0,\n 1, 1, 1, 1]}]"), HasSubstr("function.json:2: "));
  EXPECT_THAT(refusalOf(R"([{"ColorSpace": "CMYK", "RGBPoints": [0, 0, 0, 0]}])"), HasSubstr("must be RGB, HSV, Lab, Diverging or Step"));
  EXPECT_THAT(refusalOf(R"([])"), testing::Not(testing::IsEmpty()));
  EXPECT_THAT(refusalOf(R"([7])"), testing::Not(testing::IsEmpty()));
  EXPECT_THAT(refusalOf(R"({"points": [{"value": 1, "color": [1, 1, 1], "alpha": 2}]})"), HasSubstr("alpha"));
  EXPECT_THAT(refusalOf(R"({"points": [], "extra": 1})"), HasSubstr("extra"));
  EXPECT_THAT(refusalOf("nothing"), HasSubstr("function.json"));
}

TEST_F(TransferFileTest, KindsOfFilesAreToldApart) {
  const auto is = [](const std::string& text) { return isTransferFile(JsonDocument(text, "a file")); };
  EXPECT_TRUE(is(R"({"points": []})"));
  EXPECT_TRUE(is(R"([{"RGBPoints": []}])"));
  EXPECT_FALSE(is(R"({"volume": "x", "points": []})"));
  EXPECT_FALSE(is(R"({"rows": []})"));
  EXPECT_FALSE(is("7"));
  EXPECT_FALSE(is("[]"));
  EXPECT_FALSE(is("[1, 2]"));
}

}  // namespace
}  // namespace warpscope
