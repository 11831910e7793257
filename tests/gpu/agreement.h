// How two frames or pictures of the same thing are compared.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "render/core/ray_sphere.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Skips a test, visibly, where there is no GPU.
#define WARPSCOPE_NEEDS_GPU() \
  if (const std::string reason = cuda::whyUnavailable(); !reason.empty()) GTEST_SKIP() << "no GPU here: " << reason

/// The frames' samples, colours and planes are the same, bit for bit.
inline void expectSameFrames(const SampleFrame& expected, const SampleFrame& actual) {
  ASSERT_EQ(expected.quantization, actual.quantization);
  ASSERT_EQ(actual.samples.size(), actual.colors.size());
  ASSERT_EQ(expected.size(), actual.size());
  size_t differentSamples = 0, differentColors = 0;
  for (size_t i = 0; i < expected.size(); ++i) {
    differentSamples += expected.samples[i] != actual.samples[i];
    differentColors += expected.colors[i] != actual.colors[i];
  }
  EXPECT_EQ(differentSamples, 0u) << "of " << expected.size();
  EXPECT_EQ(differentColors, 0u) << "of " << expected.size();
  EXPECT_TRUE(expected.planes == actual.planes);
  const FrameSegments& a = expected.segments;
  const FrameSegments& b = actual.segments;
  ASSERT_EQ(a.size(), b.size());
  EXPECT_TRUE(a.rays == b.rays);
  EXPECT_TRUE(a.depths == b.depths);
  EXPECT_TRUE(a.colors == b.colors);
  EXPECT_TRUE(a.normals == b.normals);
}

}  // namespace warpscope
