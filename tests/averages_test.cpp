// Means over angles and instants.
// Mirrors app/experiment/averages.h.
#include "app/experiment/averages.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace warpscope {
namespace {

TEST(OverAngles, ErrorsAreMeansAndTimesThoseOfTheSlowestView) {
  const std::array<AngleFigures, 3> angles{{{0.1, 0.0, 9.0, 2.0}, {0.2, 0.3, 5.0, 4.0}, {0.6, 0.6, 7.0, 3.0}}};
  const AngleFigures over = overAngles(angles);
  EXPECT_DOUBLE_EQ(over.flip, 0.3);
  EXPECT_DOUBLE_EQ(over.holeFraction, 0.3);
  EXPECT_EQ(over.frameMs, 9.0);
  EXPECT_EQ(over.drawMs, 4.0);
  EXPECT_EQ(overAngles(std::span(angles).first(1)).flip, 0.1);
}

PictureErrors errorsOf(double psnrDb, double flip) {
  PictureErrors errors;
  errors.psnrDb = errors.psnrLinearDb = psnrDb;
  errors.flip = flip;
  errors.ssim = 1.0 - flip;
  errors.flipVisible = flip;
  return errors;
}

TEST(MeanErrors, DecibelsAreAveragedAsSquares) {
  MeanErrors mean;
  mean.add(errorsOf(10.0, 0.1));  // a mean square of 0.1
  mean.add(errorsOf(20.0, 0.3));  // 0.01
  EXPECT_NEAR(mean.mean().psnrDb, 12.596373, 1e-6);  // -10 log10(0.055)
  EXPECT_NEAR(mean.mean().psnrLinearDb, 12.596373, 1e-6);
  EXPECT_DOUBLE_EQ(mean.mean().flip, 0.2);
  EXPECT_DOUBLE_EQ(mean.mean().ssim, 0.8);
  EXPECT_FALSE(mean.mean().flipVisible);
  // A picture that equals the truth counts as one without an error.
  mean = {};
  mean.add(errorsOf(10.0, 0.0));
  mean.add(errorsOf(std::numeric_limits<double>::infinity(), 0.0));
  EXPECT_NEAR(mean.mean().psnrDb, 13.0103, 1e-4);
}

}  // namespace
}  // namespace warpscope
