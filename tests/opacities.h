// Opacities that are hard on logarithms and powers, for tests of formulas that stand for a length of matter.
// Borders are those of render/core/exact_math.h.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace warpscope {

/// Opacities of every magnitude from both ends of (0, 1), `random` of each kind, the ends' neighbours, and where the
/// reduction of the argument changes.
inline std::vector<float> opacities(int random, std::mt19937& generator) {
  constexpr float kLeast = std::numeric_limits<float>::denorm_min(), kGreatest = 1.0f - 0x1p-24f;
  std::vector<float> all{kLeast,         std::numeric_limits<float>::min(), 1e-8f, 0.25f, 0.5f, 0.75f, kGreatest,
                         254.0f / 255.0f};
  for (const float border :
       {0.292893219f, 0.646446609f, 0.5f, 0.823223305f, 0x1p-24f, 0x1p-29f, 0x1p-30f, 0x1p-53f, 0x1p-54f})
    for (const float toward : {0.0f, 1.0f}) all.push_back(std::nextafter(border, toward));
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < random; ++i) {
    all.push_back(std::exp2(-149.0f * unit(generator)));
    all.push_back(1.0f - std::exp2(-24.0f * unit(generator)));
    all.push_back(unit(generator));
  }
  for (float& alpha : all) alpha = std::clamp(alpha, kLeast, kGreatest);
  return all;
}

}  // namespace warpscope
