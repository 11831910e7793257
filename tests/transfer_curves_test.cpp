// Editing transfer functions: taken apart and put together they look as before; corners stop at their neighbours; what was undone can be redone.
// Mirrors app/scene/transfer_curves.h and app/scene/transfer_presets.h.
#include "app/scene/transfer_curves.h"

#include <gmock/gmock.h>

#include <random>

#include "app/scene/transfer_presets.h"
#include "render/base/error.h"

namespace warpscope {
namespace {

/// Corners at whole values, some of them twice: steps.
TransferFunction randomFunction(std::mt19937& random) {
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  std::uniform_int_distribution<int> count(1, 9), advance(0, 4);
  TransferFunction function;
  double value = -10.0;
  for (int i = count(random); i > 0; --i) {
    value += advance(random);
    TransferPoint point{value, {share(random), share(random), share(random)}, share(random)};
    if (!function.points.empty() && advance(random) == 0) point.color = function.points.back().color;
    if (!function.points.empty() && advance(random) == 0) point.alpha = function.points.back().alpha;
    function.points.push_back(point);
  }
  return function;
}

void expectAlike(const TransferFunction& a, const TransferFunction& b, double tolerance = 1e-5) {
  for (double value = -14.0; value < 40.0; value += 0.25)
    for (int channel = 0; channel < 4; ++channel) {
      ASSERT_NEAR(a.at(value)[channel], b.at(value)[channel], tolerance) << "at " << value;
      ASSERT_NEAR(a.below(value)[channel], b.below(value)[channel], tolerance) << "below " << value;
    }
}

TEST(TransferCurves, ApartAndTogetherAgainAFunctionLooksTheSame) {
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    TransferFunction function = randomFunction(random);
    // More than two corners at one value: only the first and the last of them show.
    const TransferCurves curves = curvesOf(function);
    EXPECT_LE(curves.colors.size(), function.points.size());
    const TransferFunction again = functionOf(curves);
    EXPECT_NO_THROW(validate(again));
    expectAlike(again, function);
    expectAlike(functionOf(curvesOf(again)), function, 2e-5);
  }
}

TEST(TransferCurves, CornersOnTheLineAreLeftOut) {
  const glm::vec3 grey(0.5f);
  const TransferCurves curves = curvesOf({{{0.0, grey, 0.0f}, {1.0, grey, 0.25f}, {2.0, grey, 0.5f}, {3.0, grey, 0.5f}, {9.0, grey, 0.5f}}});
  EXPECT_EQ(curves.colors.size(), 1u) << "one colour all over";
  EXPECT_EQ(curves.opacities, (std::vector<OpacityCorner>{{0.0, 0.0f}, {2.0, 0.5f}}));
}

TEST(TransferCurves, AMovedCornerStopsAtItsNeighbours) {
  TransferCurves curves{{{0.0, glm::vec3(0.0f)}, {10.0, glm::vec3(1.0f)}}, {{0.0, 0.0f}, {4.0, 0.5f}, {8.0, 1.0f}}};
  moveOpacity(curves, 1, 99.0, 2.0f);
  EXPECT_EQ(curves.opacities[1], (OpacityCorner{8.0, 1.0f}));
  moveOpacity(curves, 1, -99.0, -1.0f);
  EXPECT_EQ(curves.opacities[1], (OpacityCorner{0.0, 0.0f}));
  moveOpacity(curves, 2, 99.0, 0.5f);
  EXPECT_EQ(curves.opacities[2].value, 99.0) << "the last one has no neighbour there";
  moveColor(curves, 0, 50.0);
  EXPECT_EQ(curves.colors[0].value, 10.0);
}

TEST(TransferCurves, AnAddedCornerChangesNothingAndTheLastOneStays) {
  TransferCurves curves{{{0.0, glm::vec3(0.0f)}, {10.0, glm::vec3(1.0f)}}, {{0.0, 0.0f}, {8.0, 1.0f}}};
  const TransferFunction before = functionOf(curves);
  EXPECT_EQ(addOpacity(curves, 2.0), 1u);
  EXPECT_EQ(addColor(curves, 20.0), 2u);
  EXPECT_EQ(curves.opacities[1].alpha, 0.25f);
  expectAlike(functionOf(curves), before);
  EXPECT_TRUE(removeOpacity(curves, 1));
  EXPECT_TRUE(removeOpacity(curves, 0));
  EXPECT_FALSE(removeOpacity(curves, 0));
  EXPECT_EQ(curves.opacities.size(), 1u);
  EXPECT_TRUE(removeColor(curves, 0) && removeColor(curves, 0));
  EXPECT_FALSE(removeColor(curves, 0));
}

TEST(TransferCurves, ACornerBeyondTheOthersIsABumpAndNoStep) {
  const TransferCurves before{{{0.0, glm::vec3(0.0f)}}, {{4.0, 0.0f}, {8.0, 1.0f}}};
  TransferCurves curves = before;
  const size_t corner = keepBeyond(curves, addOpacity(curves, 2.0), 0.0, 10.0);
  expectAlike(functionOf(curves), functionOf(before));
  moveOpacity(curves, corner, 2.0, 0.5f);
  EXPECT_EQ(curves.opacities, (std::vector<OpacityCorner>{{0.0, 0.0f}, {2.0, 0.5f}, {4.0, 0.0f}, {8.0, 1.0f}}));
  curves = before;
  EXPECT_EQ(keepBeyond(curves, addOpacity(curves, 9.0), 0.0, 10.0), 2u);
  EXPECT_EQ(curves.opacities.back(), (OpacityCorner{10.0, 1.0f}));
  for (const double value : {0.0, 6.0, 10.0}) {  // at an end, between others
    curves = before;
    const size_t added = addOpacity(curves, value);
    const TransferCurves withIt = curves;
    EXPECT_EQ(keepBeyond(curves, added, 0.0, 10.0), added);
    EXPECT_EQ(curves, withIt);
  }
}

TEST(TransferCurves, AWindowIsMovedAndWidenedAboutItsMiddle) {
  const TransferCurves curves{{{0.0, glm::vec3(0.0f)}}, {{10.0, 0.0f}, {20.0, 1.0f}}};
  const TransferCurves changed = windowed(curves, 5.0, 2.0);  // the middle of all corners is 10
  EXPECT_DOUBLE_EQ(changed.colors[0].value, -5.0);
  EXPECT_DOUBLE_EQ(changed.opacities[0].value, 15.0);
  EXPECT_DOUBLE_EQ(changed.opacities[1].value, 35.0);
  EXPECT_EQ(windowed(curves, 0.0, 1.0), curves);
}

TEST(TransferPresets, LieInTheRangeOrInHounsfieldUnits) {
  VoxelStatistics bytes;
  bytes.highest = bytes.rangeUpper = 255.0;
  VoxelStatistics tomography;
  tomography.lowest = tomography.rangeLower = -1024.0;
  tomography.highest = tomography.rangeUpper = 3071.0;
  EXPECT_FALSE(areHounsfield(bytes));
  EXPECT_TRUE(areHounsfield(tomography));
  for (const TransferPreset& preset : transferPresets()) {
    SCOPED_TRACE(preset.name);
    EXPECT_FALSE(preset.summary.empty() || preset.summary.ends_with('.'));
    const TransferFunction function = presetFunction(preset.name, bytes);
    EXPECT_NO_THROW(validate(function));
    EXPECT_GE(function.points.front().value, 0.0);
    EXPECT_LE(function.points.back().value, 255.0);
    EXPECT_NO_THROW(validate(presetFunction(preset.name, tomography)));
  }
  const TransferFunction bone = presetFunction("CT bone", tomography);
  EXPECT_EQ(bone.at(40.0).a, 0.0f) << "muscle";
  EXPECT_GT(bone.at(1200.0).a, 0.5f) << "cortical bone";
  EXPECT_GT(presetFunction("CT soft tissue", tomography).at(50.0).a, 0.1f);
  EXPECT_THROW(presetFunction("CT lung", bytes), UsageError);
}

TransferFunction constant(float alpha) { return {{{0.0, glm::vec3(1.0f), alpha}}}; }

TEST(TransferFunctions, ThoseThatCannotBeAreRefused) {
  EXPECT_THROW(validate(TransferFunction{}), UsageError);
  EXPECT_THROW(validate({{{1.0, glm::vec3(1.0f), 0.5f}, {0.0, glm::vec3(1.0f), 0.5f}}}), UsageError);
  EXPECT_THROW(validate({{{std::nan(""), glm::vec3(1.0f), 0.5f}}}), UsageError);
  EXPECT_THROW(validate(constant(1.5f)), UsageError);
  EXPECT_THROW(validate(constant(std::nanf(""))), UsageError);
  EXPECT_THROW(validate({{{0.0, {-0.1f, 0.0f, 0.0f}, 0.5f}}}), UsageError);
  EXPECT_NO_THROW(validate(constant(1.0f)));
}

}  // namespace
}  // namespace warpscope
