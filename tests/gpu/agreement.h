// How two frames or pictures of the same thing are compared.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "render/core/ray_sphere.h"
#include "render/march/sample_frame.h"

namespace warpscope {

/// Skips a test, visibly, where there is no GPU.
#define WARPSCOPE_NEEDS_GPU() \
  if (const std::string reason = cuda::whyUnavailable(); !reason.empty()) GTEST_SKIP() << "no GPU here: " << reason

/// The frames' samples, pixel by pixel, are the same but for `allowedShare` of the pixels: what the devices' expm1 and log1p, which correct
/// the last step of a ray, round differently may make a sample count or not, or a colour round to the neighbouring code.
inline void expectSameFrames(const SampleFrame& expected, const SampleFrame& actual, double allowedShare) {
  ASSERT_EQ(expected.quantization, actual.quantization);
  ASSERT_EQ(actual.samples.size(), actual.colors.size());
  const double pixels = static_cast<double>(expected.camera.width) * expected.camera.height;
  const double allowed = std::max(allowedShare * pixels, 0.0);
  // Walk both in order: one that has no partner is a difference, and so is one whose partner lies elsewhere.
  size_t different = 0, i = 0, k = 0;
  const auto distance = [&](size_t a, size_t b) {
    const glm::vec3 eye = expected.camera.eye;
    return std::abs(glm::length(expected.sphere(a).center - eye) - glm::length(actual.sphere(b).center - eye));
  };
  const auto sameRay = [&](size_t a, size_t b) {
    const glm::vec3 x = glm::normalize(expected.sphere(a).center - expected.camera.eye);
    const glm::vec3 y = glm::normalize(actual.sphere(b).center - expected.camera.eye);
    return glm::length(x - y) < 0.5f * pixelEdge(expected.camera);
  };
  while (i < expected.size() && k < actual.size()) {
    if (expected.samples[i] == actual.samples[k]) {
      different += expected.colors[i++] != actual.colors[k++];
    } else if (sameRay(i, k)) {
      different += distance(i, k) > 1e-3f;
      ++i, ++k;
    } else {  // one of them is extra
      ++different;
      if (expected.size() - i > actual.size() - k)
        ++i;
      else
        ++k;
    }
    if (static_cast<double>(different) > allowed + 100.0) break;
  }
  different += expected.size() - i + actual.size() - k;
  EXPECT_LE(static_cast<double>(different), allowed) << "of " << pixels << " pixels; samples: " << expected.size() << " and " << actual.size();
}

}  // namespace warpscope
