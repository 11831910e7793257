// Where samples and borders of segments lie along the ray of a pixel, as one integer each: for host and device.
#pragma once

#include <cstdint>

#include "render/core/pixel_grid.h"
#include "render/core/sample.h"
#include "render/effects/jitter.h"
#include "render/march/lattice.h"

namespace warpscope {

/// What a sample's integer means.
enum class Placement : uint8_t {
  steps,      ///< index on the ray's lattice
  halfSteps,  ///< the same in half steps: midpoints of two places on the lattice
  depth,      ///< the depth code itself
};
inline constexpr uint32_t kPlacements = 3;  ///< of samples
/// Of segments: steps begin and end at places that are index on the ray's lattice; the last one at its far end.
inline constexpr auto kBorders = static_cast<Placement>(kPlacements);

/// Bits of a step that fine units are smaller.
inline constexpr int kStepFineBits = 4;
WARPSCOPE_HD constexpr int fineBitsOf(Placement placement) { return placement == Placement::depth ? 0 : placement == Placement::halfSteps ? kStepFineBits - 1 : kStepFineBits; }

WARPSCOPE_HD inline int32_t fineOfPlace(int32_t place, int32_t origin, int bits) {
  return static_cast<int32_t>((static_cast<uint32_t>(place) << bits) + static_cast<uint32_t>(origin));
}
WARPSCOPE_HD inline int32_t placeOfFine(int32_t fine, int32_t origin, int bits) {
  const uint32_t half = bits > 0 ? 1u << (bits - 1) : 0u;
  return static_cast<int32_t>(static_cast<uint32_t>(fine) - static_cast<uint32_t>(origin) + half) >> bits;
}

WARPSCOPE_HD inline int clampedPlace(float value, int largest) {
  if (!(value > 0.0f)) return 0;  // NaN too
  return value < static_cast<float>(largest) ? static_cast<int>(value) : largest;
}

/// A ray's lattice, jitter included, as the marcher has it.
struct PixelPath {
  float cosine = 1.0f, t0 = 0.0f, length = 0.0f;
  int32_t count = 0;
  int32_t origin = 0;  ///< of places, in fine units
};

/// `inside`: the ray's part in the frame's bounds. `shift`: what jitter moves its samples by.
WARPSCOPE_HD inline PixelPath pathInside(const RayInterval& inside, float cosine, float step, float shift) {
  const RayLattice lattice = makeLattice(inside, step);
  const float finePerUnit = static_cast<float>(1 << kStepFineBits) / step;
  return {cosine, lattice.t0 + shift, lattice.length, lattice.count, clampedPlace(lattice.t0 * finePerUnit + 0.5f, 1 << 24)};
}

/// What the rays of a frame share. Plain data; Jitter's noise is where the processor reads it.
struct PathGrid {
  PixelGrid grid;
  Box bounds;
  Jitter jitter;
  float step = 1.0f, depthStep = 1.0f;
  Placement placement = Placement::depth;

  WARPSCOPE_HD PixelPath path(uint32_t column, uint32_t row) const {
    if (placement == Placement::depth) return {};
    const PixelRay pixel = grid.ray(column, row);
    const RayInterval inside = intersectBox(reciprocalOf(pixel.ray.origin, pixel.ray.direction), bounds, 0.0f, INFINITY);
    return pathInside(inside, pixel.cosine, step, jitter.shiftOf(column, row));
  }
};

/// The integer whose place is nearest to a depth code: `halves` of steps, or steps.
WARPSCOPE_HD inline int32_t placeOnPath(const PixelPath& path, uint32_t depthCode, float step, float depthStep, bool isHalf) {
  const float perStep = (isHalf ? 2.0f : 1.0f) / step;
  const float offset = isHalf ? -0.5f : 0.0f;  // a half step is rounded to; a step's middle lies between integers
  const float t = decodeDepth(depthCode, depthStep) / path.cosine;
  const int last = maxOf(minOf(path.count, kMaxSamplesPerRay / 2) - 1, 0);
  return clampedPlace((t - path.t0) * perStep + offset, isHalf ? 2 * last : last);
}

/// The same of a border.
WARPSCOPE_HD inline int32_t borderOnPath(const PixelPath& path, uint32_t depthCode, float step, float depthStep) {
  const float t = decodeDepth(depthCode, depthStep) / path.cosine;
  const int last = minOf(path.count, kMaxSamplesPerRay / 2);
  // The last border may be less than a step behind the one before it.
  const float behind = t - path.t0, part = 0.5f * (static_cast<float>(last - 1) * step + path.length);
  const int place = clampedPlace(behind * (1.0f / step) + 0.5f, last);
  return behind > part ? last : minOf(place, maxOf(last - 1, 0));
}

/// As RayLattice::t on a machine that fuses multiplication and addition, on every machine.
WARPSCOPE_HD inline float latticeDepth(const RayLattice& lattice, int i) {
  const float inside = std::fma(static_cast<float>(i) + 0.5f, lattice.dt, lattice.t0);
  const float last = lattice.t0 + (lattice.length - 0.5f * lattice.stepLength(i));
  return i + 1 < lattice.count ? inside : last;
}

/// Where a place is, distance along the ray. Any integer will do.
WARPSCOPE_HD inline float stepDepth(const RayLattice& lattice, int i, int last) { return latticeDepth(lattice, glm::clamp(i, 0, last)); }
WARPSCOPE_HD inline float halfStepDepth(const RayLattice& lattice, int halves, int last) {
  const int first = glm::clamp(halves >> 1, 0, last), second = glm::clamp(first + (halves & 1), 0, last);
  return 0.5f * (latticeDepth(lattice, first) + latticeDepth(lattice, second));
}
WARPSCOPE_HD inline float borderDepth(const RayLattice& lattice, int i, int last) {
  const float inside = std::fma(static_cast<float>(glm::clamp(i, 0, last)), lattice.dt, lattice.t0);
  return i > last ? lattice.t0 + lattice.length : inside;
}

/// The depth code of a place, of any placement.
WARPSCOPE_HD inline uint32_t depthCodeOnPath(const PixelPath& path, int32_t place, float step, float depthStep, Placement placement) {
  if (placement == Placement::depth) return static_cast<uint32_t>(place) & kDepthCodeMax;
  const RayLattice lattice{path.t0, path.length, step, path.count};
  const int last = maxOf(lattice.count - 1, 0);
  const float depth = placement == kBorders ? borderDepth(lattice, place, last) : placement == Placement::halfSteps ? halfStepDepth(lattice, place, last) : stepDepth(lattice, place, last);
  return encodeDepth(depth * path.cosine, depthStep);
}

}  // namespace warpscope
