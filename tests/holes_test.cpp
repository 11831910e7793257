// What counts as a hole, also in identical images and NaN pixels. That techniques leave them open: stability/images_test.cpp.
// Mirrors render/metrics/holes.h.
#include "render/metrics/holes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/base/error.h"

namespace warpscope {
namespace {

WarpedImage warped(uint32_t width, uint32_t height, uint32_t id) {
  return {Image<glm::vec4>(width, height), Image<uint32_t>(width, height, id)};
}

TEST(Holes, OnlyUncoveredPixelsWhereTheReferenceShowsSomething) {
  WarpedImage image = warped(4, 1, kNoSample);
  image.samples(0, 0) = 0;
  image.samples(1, 0) = kNotASample;
  Image<glm::vec4> reference(4, 1, glm::vec4(1.0f));
  reference(3, 0) = glm::vec4(0.0f);  // background
  const HoleCount count = countHoles(image, reference);
  EXPECT_EQ(count.shown, 3u);
  EXPECT_EQ(count.holes, 1u);
  EXPECT_DOUBLE_EQ(count.fraction(), 1.0 / 3.0);
}

TEST(Holes, TheReferenceShowsSomethingFromOne255thOn) {
  const auto holesAt = [](float alpha) { return countHoles(warped(1, 1, kNoSample), {1, 1, glm::vec4(0, 0, 0, alpha)}).holes; };
  EXPECT_EQ(holesAt(1.0f / 255.0f), 1u);
  EXPECT_EQ(holesAt(std::nextafter(1.0f / 255.0f, 0.0f)), 0u);
  EXPECT_EQ(holesAt(1.0f), 1u);
  EXPECT_EQ(holesAt(0.0f), 0u);
}

TEST(Holes, CoveredIsNoHoleEvenIfItsColourIsClear) {
  EXPECT_EQ(countHoles(warped(3, 2, 7), {3, 2, glm::vec4(1.0f)}).holes, 0u);
}

TEST(Holes, NothingShownIsNoHole) {
  const HoleCount count = countHoles(warped(5, 5, kNoSample), {5, 5, glm::vec4(0.0f)});
  EXPECT_EQ(count.shown, 0u);
  EXPECT_EQ(count.fraction(), 0.0);
}

TEST(Holes, RefusesWhatHasNoAnswer) {
  EXPECT_THROW(countHoles(warped(2, 3, 0), {3, 2}), InputError);
  EXPECT_THROW(countHoles(warped(2, 3, 0), {2, 3, glm::vec4(0, 0, 0, std::nanf(""))}), InputError);
}

}  // namespace
}  // namespace warpscope
