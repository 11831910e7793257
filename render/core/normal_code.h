// The direction of a normal without its sign in 16 bits: octahedral, of the upper half.
// Meyer, Suessmuth, Sussner, Stamminger, Greiner 2010 ("On floating-point normal vectors"); the half: Cigolle et al. 2014 ("hemi-oct").
#pragma once

#include <cstdint>

#include "render/core/numeric.h"

namespace warpscope {

/// 0 stands for no normal.
using NormalCode = uint16_t;

/// Of a vector that is not 0 and finite; its length and sign do not matter. The direction comes back within 0.6 degrees.
WARPSCOPE_HD inline NormalCode encodeNormal(const glm::vec3& normal) {
  const float sum = absOf(normal.x) + absOf(normal.y) + absOf(normal.z);
  if (!(sum > 0.0f)) return 0;
  const float scale = (normal.z < 0.0f ? -1.0f : 1.0f) / sum;
  const float x = normal.x * scale, y = normal.y * scale;
  // The square |x| + |y| <= 1, turned so that it fills one with axes; 255 steps, 1..255 along the first, so that no normal's code is 0.
  const float u = saturated(0.5f + 0.5f * (x + y)), v = saturated(0.5f + 0.5f * (x - y));
  const auto first = static_cast<uint32_t>(u * 254.0f + 1.5f), second = static_cast<uint32_t>(v * 254.0f + 0.5f);
  return static_cast<NormalCode>(first | second << 8);
}

/// A vector of that direction, not of length 1, whose third coordinate is not negative; 0 for no normal.
WARPSCOPE_HD inline glm::vec3 decodeNormal(NormalCode code) {
  const uint32_t first = code & 255u, second = code >> 8;
  if (first == 0) return glm::vec3(0.0f);
  const float u = (static_cast<float>(first) - 1.0f) * (1.0f / 127.0f) - 1.0f, v = static_cast<float>(second) * (1.0f / 127.0f) - 1.0f;
  const float x = 0.5f * (u + v), y = 0.5f * (u - v);
  return {x, y, maxOf(1.0f - absOf(x) - absOf(y), 0.0f)};
}

}  // namespace warpscope
