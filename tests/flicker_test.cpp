// A technique flickers where it changes otherwise than the ground truth, and not where it is merely wrong.
// Mirrors render/metrics/flicker.h.
#include "render/metrics/flicker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/base/error.h"
#include "render/core/color.h"

namespace warpscope {
namespace {

constexpr glm::vec3 kBlack(0.0f);

/// Waves that have moved by `shift` pixels, `lighter` by so much as displayed.
Image<glm::vec4> waves(double shift, double lighter = 0.0) {
  Image<glm::vec4> image(70, 50);
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      const double shown = 0.4 + 0.3 * std::sin(0.3 * (x + shift)) * std::cos(0.2 * y) + lighter;
      image(x, y) = glm::vec4(glm::vec3(linearFromSrgb(static_cast<float>(shown))), 1.0f);
    }
  return image;
}

TEST(Flicker, ThereIsNoneBeforeTheSecondView) {
  FlickerMeter meter(kBlack);
  EXPECT_FALSE(meter.mean());
  meter.add(waves(0.0), waves(1.0));
  EXPECT_FALSE(meter.mean());
  EXPECT_TRUE(meter.lastMap().empty());
}

TEST(Flicker, EqualSequencesHaveNone) {
  FlickerMeter meter(kBlack);
  for (const double shift : {0.0, 3.0, 10.0, 2.0}) meter.add(waves(shift), waves(shift));
  EXPECT_EQ(meter.mean(), 0.0);
  EXPECT_EQ(meter.lastMap().size(), 3500u);
}

TEST(Flicker, WhatStandsStillHasNoneHoweverWrongItIs) {
  FlickerMeter meter(kBlack);
  for (int view = 0; view < 3; ++view) meter.add(waves(8.0), waves(0.0));
  EXPECT_EQ(meter.mean(), 0.0);
}

TEST(Flicker, AConstantErrorHasNone) {
  FlickerMeter meter(kBlack);
  for (const double shift : {0.0, 1.0, 2.5}) meter.add(waves(shift, 0.1), waves(shift));
  EXPECT_NEAR(meter.mean().value(), 0.0, 2e-3);  // 1e-7 of a difference is some 1e-4 of FLIP: its powers are steep at 0
}

TEST(Flicker, ATechniqueThatAlternatesFlickersTheMoreTheMoreItDoes) {
  double before = 0.0;
  for (const double lighter : {0.02, 0.1, 0.2}) {
    FlickerMeter meter(kBlack);
    for (int view = 0; view < 4; ++view) meter.add(waves(view, view % 2 == 0 ? 0.0 : lighter), waves(view));
    EXPECT_GT(meter.mean().value(), before + 0.01);
    before = *meter.mean();
  }
}

TEST(Flicker, IsFlipOfTheChangesAveragedOverThePath) {
  FlickerMeter meter(kBlack, 40.0f);
  const double shifts[] = {0.0, 2.0, 3.0};
  for (const double shift : shifts) meter.add(waves(0.9 * shift), waves(shift));
  double sum = 0.0;
  for (int step = 1; step < 3; ++step) {
    const auto change = [&](double factor) {
      const Image<glm::vec4> from = waves(factor * shifts[step - 1]), to = waves(factor * shifts[step]);
      Image<glm::vec4> picture(70, 50, glm::vec4(1.0f));
      for (size_t i = 0; i < picture.size(); ++i)
        for (int channel = 0; channel < 3; ++channel)
          picture[i][channel] = linearFromSrgb(0.5f + 0.5f * (srgbFromLinear(to[i][channel]) - srgbFromLinear(from[i][channel])));
      return picture;
    };
    sum += flip(change(0.9), change(1.0), kBlack, 40.0f).mean;
  }
  EXPECT_NEAR(meter.mean().value(), sum / 2.0, 1e-4);
  EXPECT_GT(sum, 0.02);
}

TEST(Flicker, WhatCannotBeComparedIsRefusedAndDoesNotCount) {
  EXPECT_THROW(FlickerMeter(kBlack, 0.0f), InputError);
  FlickerMeter meter(kBlack);
  meter.add(waves(0.0), waves(0.0));
  const Image<glm::vec4> other(7, 5, glm::vec4(1.0f));
  EXPECT_THROW(meter.add(other, other), InputError);
  EXPECT_THROW(meter.add(waves(0.0), other), InputError);
  Image<glm::vec4> broken = waves(1.0);
  broken(3, 3).b = std::numeric_limits<float>::infinity();
  EXPECT_THROW(meter.add(broken, waves(1.0)), InputError);
  EXPECT_FALSE(meter.mean());
  meter.add(waves(1.0), waves(1.0));
  EXPECT_EQ(meter.mean(), 0.0);
}

}  // namespace
}  // namespace warpscope
