// One sample of the rendered volume: where a ray met something, how large that is, and its colour, in 64 + 32 bits.
// The layout after Zellmann 2020 (position and radius quantised to 64 bits, RGBA8 beside); the bits and the radius code are ours.
//
//   bits  0..17  x      position quantised in the frame's bounds: 0 is the lower bound, 2^18 - 1 the upper one, both exact
//   bits 18..35  y
//   bits 36..53  z
//   bits 54..63  radius code: 0 means "no sample"; else exponent (4 bits) and mantissa (6 bits) of (radius / radiusUnit)
//
// A radius code c >= 1 stands for radiusUnit * 2^(e - 15) * (1 + m / 64) with e = c >> 6, m = c & 63: logarithmic to 1.6 %, 16
// octaves that end just below 2 * radiusUnit, exact in float on every machine. Radii are rounded down, so that a sphere that just
// fits into its pixel still does; below the range they become the smallest code.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

#include "render/core/box.h"
#include "render/core/color.h"

namespace warpscope {

using PackedSample = uint64_t;

inline constexpr uint32_t kPositionBits = 18;
inline constexpr uint32_t kPositionMax = (1u << kPositionBits) - 1;
inline constexpr uint32_t kRadiusCodeMax = 1023;
inline constexpr uint32_t kRadiusShift = 3 * kPositionBits;
inline constexpr PackedSample kPositionMask = (PackedSample{1} << kRadiusShift) - 1;

/// Stands where an image of sample ids has no sample.
inline constexpr uint32_t kNoSample = 0xffffffffu;

/// What a frame says once about how its samples are quantised. Units: volume space.
struct SampleQuantization {
  Box bounds;               ///< finite; an axis may have zero extent
  float radiusUnit = 1.0f;  ///< a power of two; radii from radiusUnit / 32768 to just below 2 * radiusUnit can be told apart

  bool operator==(const SampleQuantization&) const = default;
};

struct Sphere {
  glm::vec3 center;
  float radius;
};

WARPSCOPE_HD inline uint32_t quantizeCoordinate(float value, float lower, float upper) {
  const float extent = upper - lower;
  if (!(extent > 0.0f)) return 0;  // nothing to tell apart on a flat axis
  const float unit = (value - lower) / extent;
  if (!(unit > 0.0f)) return 0;
  return static_cast<uint32_t>(glm::min(unit, 1.0f) * static_cast<float>(kPositionMax) + 0.5f);
}

WARPSCOPE_HD inline float dequantizeCoordinate(uint32_t code, float lower, float upper) {
  // A blend of the ends instead of lower + code * step: exact at both.
  const float unit = static_cast<float>(code) / static_cast<float>(kPositionMax);
  return lower * (1.0f - unit) + upper * unit;
}

/// The code of `radius`, at least 1: the largest code whose radius is not greater (the smallest code below the range).
WARPSCOPE_HD inline uint32_t encodeRadius(float radius, float radiusUnit) {
  const float relative = radius / radiusUnit;
  if (!(relative > 0.0f)) return 1;
  if (relative >= 2.0f) return kRadiusCodeMax;  // infinity too, which has no exponent
  int exponent = 0;
  const float fraction = std::frexp(relative, &exponent);  // relative = fraction * 2^exponent, fraction in [0.5, 1)
  const int biased = exponent - 1 + 15;
  if (biased < 0) return 1;
  const uint32_t mantissa = static_cast<uint32_t>(fraction * 128.0f) - 64u;
  const uint32_t code = static_cast<uint32_t>(biased) << 6 | mantissa;
  return code == 0 ? 1 : code;
}

/// 0 for code 0.
WARPSCOPE_HD inline float decodeRadius(uint32_t code, float radiusUnit) {
  if (code == 0) return 0.0f;
  const float mantissa = 1.0f + static_cast<float>(code & 63) / 64.0f;
  return radiusUnit * std::ldexp(mantissa, static_cast<int>(code >> 6) - 15);
}

/// The bits of the position; those of the radius are 0.
WARPSCOPE_HD inline PackedSample packPosition(const glm::vec3& position, const Box& bounds) {
  const uint64_t x = quantizeCoordinate(position.x, bounds.lower.x, bounds.upper.x);
  const uint64_t y = quantizeCoordinate(position.y, bounds.lower.y, bounds.upper.y);
  const uint64_t z = quantizeCoordinate(position.z, bounds.lower.z, bounds.upper.z);
  return x | y << 18 | z << 36;
}

WARPSCOPE_HD inline PackedSample packSample(const glm::vec3& position, float radius, const SampleQuantization& q) {
  return packPosition(position, q.bounds) | static_cast<uint64_t>(encodeRadius(radius, q.radiusUnit)) << kRadiusShift;
}

WARPSCOPE_HD inline uint32_t radiusCode(PackedSample sample) { return static_cast<uint32_t>(sample >> kRadiusShift); }

WARPSCOPE_HD inline glm::vec3 unpackPosition(PackedSample sample, const Box& bounds) {
  return {dequantizeCoordinate(static_cast<uint32_t>(sample) & kPositionMax, bounds.lower.x, bounds.upper.x),
          dequantizeCoordinate(static_cast<uint32_t>(sample >> 18) & kPositionMax, bounds.lower.y, bounds.upper.y),
          dequantizeCoordinate(static_cast<uint32_t>(sample >> 36) & kPositionMax, bounds.lower.z, bounds.upper.z)};
}

WARPSCOPE_HD inline Sphere unpackSample(PackedSample sample, const SampleQuantization& q) {
  return {unpackPosition(sample, q.bounds), decodeRadius(radiusCode(sample), q.radiusUnit)};
}

/// The power of two that lets `largestRadius` be told apart from half of it. 1 if it is not a positive finite number.
inline float radiusUnitFor(float largestRadius) {
  if (!(largestRadius > 0.0f) || !std::isfinite(largestRadius)) return 1.0f;
  int exponent = 0;
  std::frexp(largestRadius, &exponent);
  return std::ldexp(1.0f, exponent - 1);
}

}  // namespace warpscope
