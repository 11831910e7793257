// How much of each light, and of ambient light, arrives at places of a regular grid through the matter before it; read between them. For host and device.
// Shadows as a volume of attenuation: Behrens, Ratering 1998 ("Adding shadows to a texture-based volume renderer"); local ambient occlusion: Hernell,
// Ljung, Ynnerman 2010. Here places are found out by marches of their own, not by sweeps, so that errors do not add up from place to place.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/core/ray.h"
#include "render/effects/effects.h"
#include "render/volume/voxel_access.h"

namespace warpscope {

/// What is read at samples. The memory is another's.
struct LightVolume {
  /// Values are shares of light, 0..1, in steps of 2^-15: off by 2^-16 at most. As powers of two, so that all of a light is exactly 1.
  static constexpr float kWhole = 32768.0f;
  /// The most memory; where a grid would take more, its places are farther apart. For 2048^3 voxels and five values a place, every 7th voxel.
  static constexpr size_t kMostBytes = size_t{1} << 28;

  const uint16_t* values = nullptr;  ///< x fastest; of each place `channels` values
  glm::ivec3 dims{0};                ///< places
  AxisEnds ends[3] = {};             ///< of dims
  float edge = 1.0f;                 ///< voxels from place to place
  float perVoxel = 1.0f;             ///< 1 / edge
  int channels = 0;                  ///< 0: there is none
  int ofLight[Lights::kMost] = {-1, -1, -1, -1};  ///< the channel of each prepared light, or none
  int ofAmbient = -1;
  float shadowStrength = 0.0f;
  float occlusionStrength = 0.0f;
  float radius = 0.0f;               ///< of ambient occlusion, units of volume space

  size_t places() const { return static_cast<size_t>(dims.x) * static_cast<size_t>(dims.y) * static_cast<size_t>(dims.z); }

  /// What is read at voxel coordinates `place`: trilinear; beyond the outermost places it is theirs.
  WARPSCOPE_HD float at(int channel, const float (&place)[3]) const {
    int index[3];
    float weight[3];
    for (int axis = 0; axis < 3; ++axis) axisCell(place[axis] * perVoxel, ends[axis], index[axis], weight[axis]);
    const size_t stride = static_cast<size_t>(channels), row = stride * static_cast<size_t>(dims.x), plane = row * static_cast<size_t>(dims.y);
    const size_t dx = dims.x > 1 ? stride : 0, dy = dims.y > 1 ? row : 0, dz = dims.z > 1 ? plane : 0;
    const uint16_t* const first = values + (static_cast<size_t>(index[2]) * plane + static_cast<size_t>(index[1]) * row +
                                            static_cast<size_t>(index[0]) * stride + static_cast<size_t>(channel));
    float corner[8];
    for (int i = 0; i < 8; ++i) corner[i] = static_cast<float>(first[(i & 1 ? dx : 0) + (i & 2 ? dy : 0) + (i & 4 ? dz : 0)]);
    return trilinear(corner, weight[0], weight[1], weight[2]) * (1.0f / kWhole);
  }
  /// Of `share` in [0, 1].
  WARPSCOPE_HD static uint16_t valueOf(float share) { return static_cast<uint16_t>(truncated(mulAdd(share, kWhole, 0.5f))); }
  /// By how much light of that share is multiplied: 1 - strength * (1 - share).
  WARPSCOPE_HD static float factorOf(float share, float strength) { return mulAdd(strength, share - 1.0f, 1.0f); }
};

/// A grid over `dims` voxels without memory: its places, as far apart as asked, or farther where kMostBytes want it.
LightVolume lightVolumeLayout(const glm::uvec3& dims, int channels, float edge);

}  // namespace warpscope
