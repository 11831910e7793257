// Rays whose samples begin at places of their own: noise instead of the rings that samples at equal depths draw. For host and device.
// Blue noise by void and cluster: Ulichney 1993 ("The void-and-cluster method for dither array generation").
#pragma once

#include <cstdint>
#include <span>

#include "render/core/counters.h"
#include "render/core/host_device.h"
#include "render/march/march_settings.h"

namespace warpscope {

inline constexpr uint32_t kNoiseSide = 64;

/// Row by row kNoiseSide x kNoiseSide numbers in (-1/2, 1/2), each of kNoiseSide^2 equally spaced ones once, such that near neighbours differ; goes on
/// beyond its borders. The same everywhere: clients that decode a frame need the server's. Made when it is first asked for.
std::span<const float> blueNoise();

struct Jitter {
  const float* noise = nullptr;  ///< blueNoise(), or null: none
  float reach = 0.0f;            ///< twice the farthest that a sample is moved, volume units

  /// How far a pixel's samples are moved along its ray.
  WARPSCOPE_HD float shiftOf(uint32_t x, uint32_t y) const {
    if (noise == nullptr) return 0.0f;
    WARPSCOPE_COUNT(movedRays, 1);
    return noise[y % kNoiseSide * kNoiseSide + x % kNoiseSide] * reach;
  }
};

inline bool isJittered(const RenderSettings& settings) { return settings.effects.jitter > 0.0f; }

/// On the host. Samples stay within their steps, but the last: where that step is shorter its sample may lie up to half a whole step behind where the ray leaves the volume, or
/// what is cut off begins.
inline Jitter jitterFor(const RenderSettings& settings) {
  return isJittered(settings) ? Jitter{blueNoise().data(), settings.effects.jitter * settings.step} : Jitter{};
}

}  // namespace warpscope
