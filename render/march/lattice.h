// Where along a ray the volume is sampled: one lattice per ray, computed by index, never by adding up steps.
// Sample i stands for the step [i*dt, min((i+1)*dt, length)] behind the entry point and lies in its middle.
#pragma once

#include <cmath>

#include "render/core/box.h"
#include "render/core/numeric.h"

namespace warpscope {

/// What RayLattice::t is off by, relative to the far end t0 + length: at most 2 roundings of the index (none below
/// 2^23) and one of the sum; of the last sample those of its step, of the difference and of the sum.
inline constexpr double kLatticeError = 3.001 * 0x1p-24;
/// What the last step's length is off by, relative to itself; all others are dt.
inline constexpr double kLatticeStepError = 1.001 * 0x1p-24;

struct RayLattice {
  float t0 = 0.0f;      ///< where the ray enters, distance from its beginning
  float length = 0.0f;  ///< of the part inside, >= 0
  float dt = 1.0f;      ///< step, > 0
  int count = 0;        ///< number of samples; the last step may be shorter than dt

  /// The last step's is what is left, in double: rounded indices beyond 2^24 would make it negative.
  WARPSCOPE_HD float stepLength(int i) const {
    return i + 1 < count ? dt : static_cast<float>(static_cast<double>(length) - static_cast<double>(count - 1) * dt);
  }
  /// As t(), for a sample that is not the last.
  WARPSCOPE_HD float tOfWholeStep(int i) const { return mulAdd(static_cast<float>(i) + 0.5f, dt, t0); }
  /// Where step i begins and the one in front of it ends, for i up to count; as precise as t().
  WARPSCOPE_HD float border(int i) const { return i < count ? mulAdd(static_cast<float>(i), dt, t0) : t0 + length; }
  /// The first sample that lies at `behind` or behind it, as of whole steps; count if there is none. So parts of a ray that follow each other share its samples out.
  WARPSCOPE_HD int firstFrom(float behind) const {
    if (!(behind < t0 + length)) return count;
    const float steps = std::ceil((behind - t0) / dt - 0.5f);
    if (!(steps > 0.0f)) return 0;
    return steps < static_cast<float>(count) ? static_cast<int>(steps) : count;
  }
  WARPSCOPE_HD float t(int i) const {
    return i + 1 < count ? tOfWholeStep(i) : t0 + (length - 0.5f * stepLength(i));
  }
};

/// The most samples that a ray takes; a step so small that a volume would need more is refused before its march (requireMarchable).
inline constexpr int kMaxSamplesPerRay = 1 << 30;

/// The lattice over a ray's part inside a box; empty for a miss or an interval without extent. It has exactly as many
/// steps as cover the length, which is tFar - tNear in float: up to 2^29 of them a quotient of floats that is no whole
/// number stays apart from it in double.
WARPSCOPE_HD inline RayLattice makeLattice(const RayInterval& interval, float dt) {
  RayLattice lattice;
  lattice.dt = dt;
  lattice.t0 = interval.isMiss() ? 0.0f : interval.tNear;
  lattice.length = interval.isMiss() ? 0.0f : interval.tFar - interval.tNear;
  // In double: the quotient of floats could round up to one step of no length too many.
  const double steps = std::ceil(static_cast<double>(lattice.length) / static_cast<double>(dt));
  const double atMost = steps < kMaxSamplesPerRay ? steps : kMaxSamplesPerRay;
  lattice.count = steps >= 1.0 ? static_cast<int>(atMost) : 0;
  return lattice;
}

}  // namespace warpscope
