// A picture and another one of it, with what other implementations say of the two.
// Oracles: flip-evaluator 1.7 (PyPI), scikit-image (Gaussian weights, deviation 1.5, population covariance, range 1), from the displayed values
// in double.
#pragma once

#include <cmath>
#include <random>

#include "render/core/color.h"
#include "render/core/image.h"

namespace warpscope {

/// Waves in each channel, 0.1 to 0.9 as displayed; `phase` moves them.
inline Image<glm::vec4> somePicture(double phase, bool hasPatch) {
  Image<glm::vec4> image(96, 64);
  for (uint32_t y = 0; y < image.height(); ++y)
    for (uint32_t x = 0; x < image.width(); ++x) {
      glm::dvec3 shown(0.5 + 0.4 * std::sin(0.21 * x + 0.05 * y + phase), 0.5 + 0.4 * std::cos(0.11 * x - 0.17 * y + phase),
                       0.5 + 0.4 * std::sin(0.07 * x + 0.13 * y + 1.0 + phase));
      if (hasPatch && x >= 40 && x < 56 && y >= 20 && y < 36) shown = {0.95, 0.1, 0.2};
      for (int channel = 0; channel < 3; ++channel) image(x, y)[channel] = linearFromSrgb(static_cast<float>(shown[channel]));
      image(x, y).a = 1.0f;
    }
  return image;
}

/// Pixels that have nothing to do with each other, of any opacity.
inline Image<glm::vec4> noise(uint32_t width, uint32_t height, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Image<glm::vec4> image(width, height);
  for (glm::vec4& pixel : image) {
    const float alpha = unit(random);
    pixel = alpha * glm::vec4(unit(random), unit(random), unit(random), 1.0f);
  }
  return image;
}

/// Of somePicture(0.35, true) against somePicture(0.0, false).
inline constexpr double kOracleFlip = 0.5126898884773254, kOracleSsim = 0.7493304047942934, kOraclePsnrDb = 15.684411175411423;

}  // namespace warpscope
