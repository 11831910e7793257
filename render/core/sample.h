// One sample of the rendered volume: where a ray met something, how large that is, and its colour, in 64 + 32 bits.
// After Zellmann 2020, whose samples are positions and radii quantised to 64 bits, RGBA8 beside. Deviation: a sample is a pixel and a depth
// along that pixel's ray, so that it lies on the ray whatever the eye's place, where a position's steps may be coarser than a pixel.
//
//   bits  0..13  column of the pixel
//   bits 14..27  row
//   bits 28..53  depth code: forward depth behind the frame's near plane, in steps of depthStep
//   bits 54..63  radius code: 0 means "no sample"; else exponent (4 bits) and mantissa (6 bits) of (radius / radiusUnit)
//
// Column and row as one number rise in the order of a picture's pixels.
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
#include "render/core/numeric.h"
#include "render/core/pixel_grid.h"

namespace warpscope {

using PackedSample = uint64_t;

inline constexpr uint32_t kPixelBits = 14;  ///< of a column, and of a row
inline constexpr uint32_t kDepthBits = 26;
inline constexpr uint32_t kDepthCodeMax = (1u << kDepthBits) - 1;
inline constexpr uint32_t kRadiusCodeMax = 1023;
inline constexpr uint32_t kDepthShift = 2 * kPixelBits;
inline constexpr uint32_t kRadiusShift = kDepthShift + kDepthBits;
inline constexpr uint32_t kPixelKeyMask = (1u << kDepthShift) - 1;
/// Pixel and depth.
inline constexpr PackedSample kPositionMask = (PackedSample{1} << kRadiusShift) - 1;

/// Stands where an image of sample ids has no sample.
inline constexpr uint32_t kNoSample = 0xffffffffu;

/// What a frame says once about how its samples are quantised. Units: volume space.
struct SampleQuantization {
  Box bounds;               ///< finite; an axis may have zero extent. No position lies outside
  float radiusUnit = 1.0f;  ///< a power of two; radii from radiusUnit / 32768 to just below 2 * radiusUnit can be told apart
  float nearDepth = 0.0f;   ///< forward depth at which codes begin; finite, 0 or more
  float depthStep = 1.0f;   ///< forward depth between two codes; finite, more than 0

  bool operator==(const SampleQuantization&) const = default;
};

/// True if the quantisation is what its members say.
bool isUsable(const SampleQuantization& quantization);

/// How samples of what lies in `bounds` are quantised, seen by a camera that isUsable(): about 2^18 steps of depth lie within the bounds. That is
/// finer than heuristics find depths, and finer codes would be more bytes on the wire; the format has room for 2^26.
SampleQuantization quantizationFor(const Camera& camera, const Box& bounds, float radiusUnit);

/// What unpacking takes: made once for a frame, plain data, for host and device.
struct SampleGrid {
  PixelGrid pixels;
  Box bounds;
  float depthStep = 1.0f;
  float radiusUnit = 1.0f;
};

/// The grid of a frame's camera and quantisation. Host only.
inline SampleGrid makeSampleGrid(const Camera& camera, const SampleQuantization& quantization) {
  return {makePixelGrid(camera, quantization.nearDepth), quantization.bounds, quantization.depthStep, quantization.radiusUnit};
}

struct Sphere {
  glm::vec3 center;
  float radius;
};

/// What a depth comes back off by, beyond half a step, relative to itself: a rounding each of its number of steps, of
/// the half that is added and of what the code stands for.
inline constexpr double kDepthCodeError = 3.001 * 0x1p-24;
/// What a radius within the codes' range comes back smaller by, relative to itself.
inline constexpr double kRadiusCodeError = 1.0 / 64;

/// The code nearest to the forward depth `behind` behind the near plane: within half a step of it, and kDepthCodeError.
/// 0 for less and NaN; depths beyond the codes get one of the last. Of the codes below 2^22 each comes back from
/// decodeDepth().
/// `Number`: float, or a vector of them; the code is a whole number that has a sign, or a vector of them.
template <class Number>
WARPSCOPE_HD inline auto signedDepthCode(const Number& behind, const Number& depthStep) {
  const Number whole(0x1p23f);           // from here on floats have no halves
  const Number largest(0x1p26f - 4.0f);  // of the floats that are codes
  const Number steps = minOf(maxOf(behind / depthStep, Number(0.0f)), largest);
  return truncated(selected(steps < whole, steps + 0.5f, steps));
}
WARPSCOPE_HD inline uint32_t encodeDepth(float behind, float depthStep) { return static_cast<uint32_t>(signedDepthCode(behind, depthStep)); }

/// In units of volume space.
WARPSCOPE_HD inline float decodeDepth(uint32_t code, float depthStep) {
  return static_cast<float>(static_cast<int32_t>(code)) * depthStep;
}

/// The code of `radius`, at least 1: the largest code whose radius is not greater, by less than kRadiusCodeError (the
/// smallest code below the range).
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

WARPSCOPE_HD inline uint32_t columnOf(PackedSample sample) { return static_cast<uint32_t>(sample) & ((1u << kPixelBits) - 1); }
WARPSCOPE_HD inline uint32_t rowOf(PackedSample sample) { return static_cast<uint32_t>(sample) >> kPixelBits & ((1u << kPixelBits) - 1); }
/// Row and column as one number: of two pixels, the one that comes first in the picture has the smaller.
WARPSCOPE_HD inline uint32_t pixelKey(PackedSample sample) { return static_cast<uint32_t>(sample) & kPixelKeyMask; }
WARPSCOPE_HD inline uint32_t pixelKey(uint32_t column, uint32_t row) { return row << kPixelBits | column; }
WARPSCOPE_HD inline uint32_t depthCode(PackedSample sample) { return static_cast<uint32_t>(sample >> kDepthShift) & kDepthCodeMax; }
WARPSCOPE_HD inline uint32_t radiusCode(PackedSample sample) { return static_cast<uint32_t>(sample >> kRadiusShift); }

/// Codes within their ranges, a pixel of at most 2^14 columns and rows.
WARPSCOPE_HD inline PackedSample packCodes(uint32_t column, uint32_t row, uint32_t depth, uint32_t radius) {
  return pixelKey(column, row) | static_cast<uint64_t>(depth) << kDepthShift | static_cast<uint64_t>(radius) << kRadiusShift;
}

/// The same sample with another radius; its code at most kRadiusCodeMax.
WARPSCOPE_HD inline PackedSample withRadiusCode(PackedSample sample, uint32_t radius) {
  return (sample & kPositionMask) | static_cast<uint64_t>(radius) << kRadiusShift;
}

/// A sample in a pixel, at the forward depth `behind` behind the near plane.
WARPSCOPE_HD inline PackedSample packSample(uint32_t column, uint32_t row, float behind, float radius, const SampleQuantization& q) {
  return packCodes(column, row, encodeDepth(behind, q.depthStep), encodeRadius(radius, q.radiusUnit));
}

/// On the ray of the sample's pixel, as precise as PixelGrid::at says; but never outside the bounds, whatever the bits and the grid are: what
/// quantisation has put a half step outside lies on the border.
WARPSCOPE_HD inline glm::vec3 unpackPosition(PackedSample sample, const SampleGrid& grid) {
  const glm::vec3 position = grid.pixels.at(columnOf(sample), rowOf(sample), decodeDepth(depthCode(sample), grid.depthStep));
  const auto inside = [&](int axis) { return minOf(maxOf(position[axis], grid.bounds.lower[axis]), grid.bounds.upper[axis]); };
  return {inside(0), inside(1), inside(2)};
}

WARPSCOPE_HD inline Sphere unpackSample(PackedSample sample, const SampleGrid& grid) {
  return {unpackPosition(sample, grid), decodeRadius(radiusCode(sample), grid.radiusUnit)};
}

/// The power of two that lets `largestRadius` be told apart from half of it. 1 if it is not a positive finite number.
inline float radiusUnitFor(float largestRadius) {
  if (!(largestRadius > 0.0f) || !std::isfinite(largestRadius)) return 1.0f;
  int exponent = 0;
  std::frexp(largestRadius, &exponent);
  return std::ldexp(1.0f, exponent - 1);
}

}  // namespace warpscope
